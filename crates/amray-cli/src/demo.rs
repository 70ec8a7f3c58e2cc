//! `amray demo`: a demo data set and a picture of it.

use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;

use amray_formats::demo::Demo;
use amray_formats::output::check_writable;
use amray_formats::picture::PictureFormat;
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::data::absolute;
use crate::progress::with_progress;
use crate::{print, render};

const NAME: &str = "amray-demo";

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Levels of refinement
    #[arg(long, value_name = "N", default_value_t = Demo::default().levels, value_parser = parameter(|levels| Demo { levels, ..Demo::default() }))]
    levels: usize,
    /// Cells of level 0 per side
    #[arg(long, value_name = "CELLS", default_value_t = Demo::default().base, value_parser = parameter(|base| Demo { base, ..Demo::default() }))]
    base: usize,
    /// Cells per cell of the next coarser level and axis: 2 or 4
    #[arg(long, value_name = "RATIO", default_value_t = Demo::default().ratio, value_parser = parameter(|ratio| Demo { ratio, ..Demo::default() }))]
    ratio: usize,
    /// Cells per side of the largest brick
    #[arg(long, value_name = "CELLS", default_value_t = Demo::default().brick, value_parser = parameter(|brick| Demo { brick, ..Demo::default() }))]
    brick: usize,
    /// Refine where neighbouring cells differ by more: half of it refines about twice as much
    #[arg(long, value_name = "DIFFERENCE", default_value_t = Demo::default().threshold, value_parser = parameter(|threshold| Demo { threshold, ..Demo::default() }))]
    threshold: f64,
    /// Keep the data set, as amray-demo.hdf5
    #[arg(long)]
    keep: bool,
    /// Keep the data set, as FILE; the picture goes beside it
    #[arg(short, long, value_name = "FILE.hdf5", value_parser = PathBufValueParser::new().try_map(data_path))]
    output: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { levels, base, ratio, brick, threshold, .. } = *arguments;
    let demo = Demo { levels, base, ratio, brick, threshold };
    // Data that nobody wants to keep need not even be beside the picture.
    let scratch = tempfile::tempdir()?;
    let (data, kept) = match &arguments.output {
        Some(path) => (path.clone(), true),
        None if arguments.keep => (PathBuf::from(format!("{NAME}.hdf5")), true),
        None => (scratch.path().join(format!("{NAME}.hdf5")), false),
    };
    let picture = match &arguments.output {
        Some(path) => path.with_extension("png"),
        None => PathBuf::from(format!("{NAME}.png")),
    };
    // What cannot be written is better known before the work than after it.
    check_writable(&data)?;
    check_writable(&picture)?;
    with_progress("making data", |progress| demo.write(&data, progress))?;
    let data = absolute(&data);
    if kept {
        print(&format!("data:    {}\n", data.display()))?;
    }
    // The picture is what anyone gets with no flags at all.
    let report = render::picture(&render::Arguments::new(data, absolute(&picture)))?;
    Ok(print(&format!("picture: {}\n", report.output.display()))?)
}

/// A parser of one parameter, which must be in its range while the others are as they are without flags.
fn parameter<T: FromStr<Err: Display> + Copy>(demo: fn(T) -> Demo) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let value = text.parse().map_err(|error: T::Err| error.to_string())?;
        demo(value).check().map(|()| value).map_err(|error| error.to_string())
    }
}

/// A name that the picture, which goes beside the data set, cannot have too.
fn data_path(path: PathBuf) -> Result<PathBuf, String> {
    match PictureFormat::of(&path) {
        Ok(_) => Err("this is where the data set goes, expected a name such as demo.hdf5".into()),
        Err(_) => Ok(path),
    }
}
