//! `amray slice`: the reconstruction on a plane, with a colour bar.

use std::path::PathBuf;

use amray::appearance::{Picture, TransferFunction, color_bar};
use amray::render::{Axis, Slice, ValueImage};
use amray_formats::FormatError;
use amray_formats::output::check_writable;
use amray_formats::picture::{PictureFormat, write_array, write_png};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;

use crate::appearance::AppearanceArguments;
use crate::data::VolumeArguments;
use crate::progress::with_spinner;
use crate::{number, print};

/// Around the slice, and where there is no value.
const BACKGROUND: [u8; 4] = [255; 4];

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
    /// Where to write it: .png, or the values as .npy [default: the data's name, the axis and .png]
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(image_path))]
    output: Option<PathBuf>,
    /// Pixels of the slice's longer side; the pixels are square
    #[arg(long, value_name = "PIXELS", default_value = "1024", value_parser = clap::value_parser!(u16).range(1..=16_384))]
    size: u16,
    #[command(flatten)]
    appearance: AppearanceArguments,
    /// Leave out the colour bar
    #[arg(long)]
    no_color_bar: bool,
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

/// A name whose ending is that of a picture or of values.
fn image_path(path: PathBuf) -> Result<PathBuf, FormatError> {
    match PictureFormat::of(&path)? {
        PictureFormat::Png | PictureFormat::Npy => Ok(path),
        PictureFormat::Exr => {
            let (found, expected) = ("ending .exr".into(), ".png or, for the values, .npy".into());
            Err(FormatError::Unrecognised { path, found, expected })
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let axis = arguments.axis;
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("{}_{axis}.png", arguments.volume.data.stem())));
    let format = PictureFormat::of(&output)?;
    check_writable(&output)?;
    let volume = arguments.volume.open()?.volume;
    let [low, high] = volume.hierarchy().bounds().map(|corner| corner[axis as usize]);
    let slice = Slice { axis, at: arguments.at.unwrap_or((low + high) / 2.0) };
    if !(low..=high).contains(&slice.at) {
        let domain = format!("the domain, which reaches from {low} to {high} on the {axis} axis");
        return Err(arguments.volume.data.error(format!("--at {} misses {domain}", slice.at)));
    }
    let size = slice.fitting_size(&volume, arguments.size.into());
    let image = with_spinner("slicing", || slice.sample(&volume, size));
    let [width, height] = image.size;
    if format == PictureFormat::Npy {
        write_array(&output, &[height as u64, width as u64], &image.values)?;
    } else {
        let function = arguments.appearance.colors(&arguments.volume.data, &image.values)?;
        let mut picture =
            Picture::from_pixels(width, height, colored(&image, &function)).expect("an image has its size's values");
        if !arguments.no_color_bar {
            let bar = color_bar(&function, volume.field().name(), height.max(MIN_BAR), BACKGROUND);
            picture = picture.beside(&bar, BACKGROUND);
        }
        write_png(&output, [picture.width(), picture.height()], picture.pixels())?;
    }
    if !arguments.json {
        return Ok(print(&format!("{}\n", output.display()))?);
    }
    let finite = || image.values.iter().copied().filter(|value| value.is_finite());
    let report = Report {
        output,
        axis: axis.to_string(),
        at: slice.at,
        size: image.size,
        min: finite().reduce(f64::min),
        max: finite().reduce(f64::max),
    };
    Ok(print(&(serde_json::to_string(&report)? + "\n"))?)
}

/// A bar less high than this has no room for its numbers.
const MIN_BAR: usize = 128;

fn colored(image: &ValueImage, function: &TransferFunction) -> Vec<[u8; 4]> {
    let colors = function.prepared(1.0);
    let color = |&value: &f64| {
        if !value.is_finite() {
            return BACKGROUND;
        }
        let [red, green, blue] = colors.sample(value).color.map(|channel| (channel * 255.0).round() as u8);
        [red, green, blue, u8::MAX]
    };
    image.values.iter().map(color).collect()
}
