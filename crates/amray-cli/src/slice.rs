//! `amray slice`: the reconstruction on a plane, with a colour bar.

use std::path::PathBuf;

use amray::render::{Axis, Slice};
use clap::Args;
use serde::Serialize;

use crate::data::VolumeArguments;
use crate::progress::with_spinner;
use crate::value_picture::{ValuePictureArguments, range};
use crate::{number, print, print_json};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    volume: VolumeArguments,
    /// The axis that the slice is perpendicular to: x, y or z
    #[arg(long, value_name = "AXIS")]
    axis: Axis,
    /// Where on the axis, in world units [default: the middle of the domain]
    #[arg(long, value_name = "X", value_parser = number::finite, allow_hyphen_values = true)]
    at: Option<f64>,
    /// Pixels of the slice's longer side; the pixels are square
    #[arg(long, value_name = "PIXELS", default_value = "1024", value_parser = clap::value_parser!(u16).range(1..=16_384))]
    size: u16,
    #[command(flatten)]
    picture: ValuePictureArguments,
    /// Print one JSON object: where the slice is, its size and values
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    output: PathBuf,
    axis: String,
    at: f64,
    /// Of the slice, without the colour bar.
    size: [usize; 2],
    /// Over the slice's pixels; null where no value is finite.
    min: Option<f64>,
    max: Option<f64>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let axis = arguments.axis;
    let data = &arguments.volume.data();
    let output = arguments.picture.output(data, axis)?;
    let opened = arguments.volume.open()?;
    let volume = &opened.volume;
    let [low, high] = volume.hierarchy().bounds().map(|corner| corner[axis as usize]);
    let slice = Slice { axis, at: arguments.at.unwrap_or((low + high) / 2.0) };
    if !(low..=high).contains(&slice.at) {
        let domain = format!("the domain, which reaches from {low} to {high} on the {axis} axis");
        return Err(data.error(format!("--at {} misses {domain}", slice.at)));
    }
    let size = slice.fitting_size(volume, arguments.size.into());
    let image = with_spinner("slicing", || slice.sample(volume, size));
    arguments.picture.write(&output, &image, data, "on the slice", &opened.title)?;
    if !arguments.json {
        return Ok(print(&format!("{}\n", output.path.display()))?);
    }
    let [min, max] = range(&image);
    let report = Report { output: output.path, axis: axis.to_string(), at: slice.at, size: image.size, min, max };
    print_json(&report)
}
