//! `amray project`: what the field amounts to along each ray of a picture, as values.

use std::path::PathBuf;

use amray::render::{Reduction, project};
use clap::Args;
use serde::Serialize;

use crate::data::VolumeArguments;
use crate::progress::with_progress;
use crate::sampling::LayoutArguments;
use crate::value_picture::{ValuePictureArguments, range};
use crate::view::ViewArguments;
use crate::{number, print, print_json};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    volume: VolumeArguments,
    /// What becomes of the values along a ray: integral (over the length in world units: the column density), average,
    /// maximum or minimum
    #[arg(long, value_name = "REDUCTION", default_value = "integral")]
    reduction: Reduction,
    /// Pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1024x1024", value_parser = number::size)]
    size: [usize; 2],
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    layout: LayoutArguments,
    #[command(flatten)]
    picture: ValuePictureArguments,
    /// Print one JSON object: the size and the values' range
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    output: PathBuf,
    reduction: String,
    /// Without the colour bar.
    size: [usize; 2],
    /// Over the pixels; null where no ray meets a value.
    min: Option<f64>,
    max: Option<f64>,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { reduction, size, .. } = *arguments;
    let data = &arguments.volume.data();
    let output = arguments.picture.output(data, reduction)?;
    let opened = arguments.volume.open()?;
    let volume = &opened.volume;
    let camera = arguments.view.camera(volume, size, 1.0)?;
    let layout = arguments.layout.layout(volume, 1, arguments.volume.memory());
    let image = with_progress("projecting", |progress| project(volume, &camera, size, reduction, layout, progress));
    let title = format!("{} ({reduction})", opened.title);
    arguments.picture.write(&output, &image, data, "in the projection", &title)?;
    if !arguments.json {
        return Ok(print(&format!("{}\n", output.path.display()))?);
    }
    let [min, max] = range(&image);
    let report = Report { output: output.path, reduction: reduction.to_string(), size, min, max };
    print_json(&report)
}
