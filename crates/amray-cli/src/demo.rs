//! `amray demo`: a demo data set and a picture of it.

use std::path::{Path, PathBuf};

use amray_formats::demo::Demo;
use clap::{Args, Parser};

use crate::progress::with_progress;
use crate::{number, print};

const NAME: &str = "amray-demo";

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Levels of refinement
    #[arg(long, value_name = "N", default_value_t = Demo::default().levels)]
    levels: usize,
    /// Cells of level 0 per side
    #[arg(long, value_name = "CELLS", default_value_t = Demo::default().base)]
    base: usize,
    /// Cells per cell of the next coarser level and axis: 2 or 4
    #[arg(long, value_name = "RATIO", default_value_t = Demo::default().ratio)]
    ratio: usize,
    /// Cells per side of the largest brick
    #[arg(long, value_name = "CELLS", default_value_t = Demo::default().brick)]
    brick: usize,
    /// Refine where neighbouring cells differ by more: half of it refines about twice as much
    #[arg(long, value_name = "DIFFERENCE", default_value_t = Demo::default().threshold, value_parser = number::positive)]
    threshold: f64,
    /// Keep the data set, as amray-demo.hdf5
    #[arg(long)]
    keep: bool,
    /// Keep the data set, as FILE; the picture goes beside it
    #[arg(short, long, value_name = "FILE.hdf5")]
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
    with_progress("making data", |progress| demo.write(&data, progress))?;
    if kept {
        print(&format!("data:    {}\n", absolute(&data).display()))?;
    }
    print("picture: ")?;
    // The picture is what anyone gets with no flags at all.
    let picture = absolute(&picture);
    let command = crate::Arguments::try_parse_from([
        "amray".as_ref(),
        "render".as_ref(),
        data.as_os_str(),
        "--output".as_ref(),
        picture.as_os_str(),
    ])?;
    crate::run(command)
}

/// The path as it can be opened from anywhere.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}
