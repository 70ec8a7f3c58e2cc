//! `amray sample`: values at given points.

use std::fmt::Write;
use std::path::PathBuf;

use amray_formats::output::{OutputFile, check_writable};
use amray_formats::picture::{PictureFormat, write_array};
use amray_formats::points::read_points;
use clap::Args;
use serde_json::json;

use crate::data::VolumeArguments;
use crate::print;
use crate::progress::with_spinner;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    volume: VolumeArguments,
    /// World positions: x,y,z a line (.csv), or a NumPy array of shape (n, 3) (.npy)
    #[arg(long, value_name = "FILE")]
    points: PathBuf,
    /// Where to write the values: .npy (n float64) or text, a value a line [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object: the values (null where there is none), or where they were written
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if let Some(path) = &arguments.output {
        check_writable(path)?;
    }
    let positions = read_points(&arguments.points)?;
    let opened = arguments.volume.open()?;
    let values = with_spinner("sampling", || opened.volume.sample(&positions));
    match &arguments.output {
        Some(path) if PictureFormat::of(path).is_ok_and(|format| format == PictureFormat::Npy) => {
            write_array(path, &[values.len() as u64], &values)?;
        }
        Some(path) => OutputFile::write(path, |file| std::io::Write::write_all(file, text(&values).as_bytes()))?,
        None if arguments.json => print(&format!("{}\n", json!({ "values": values })))?,
        None => print(&text(&values))?,
    }
    if let (Some(path), true) = (&arguments.output, arguments.json) {
        print(&format!("{}\n", json!({ "output": path, "values": values.len() })))?;
    }
    Ok(())
}

/// A value a line, with the digits that tell it from its neighbours.
fn text(values: &[f64]) -> String {
    values.iter().fold(String::new(), |mut text, value| {
        writeln!(text, "{value}").expect("writing to a string cannot fail");
        text
    })
}
