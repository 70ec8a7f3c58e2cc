//! Pictures whose pixels are values: written in colours with a colour bar, or as they are.

use std::path::{Path, PathBuf};

use amray::appearance::{Picture, TransferFunction, color_bar};
use amray::render::ValueImage;
use amray_formats::FormatError;
use amray_formats::output::check_writable;
use amray_formats::picture::{PictureFormat, write_array, write_png};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::appearance::AppearanceArguments;
use crate::data::DataArguments;

/// Around the values, and where there is none.
const BACKGROUND: [u8; 4] = [255; 4];
/// A bar less high than this has no room for its numbers.
const MIN_BAR: usize = 128;

/// How values are written.
#[derive(Debug, Args)]
pub(crate) struct ValuePictureArguments {
    /// Where to write it: .png, or the values as .npy [default: a name after the data's, .png]
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(image_path))]
    output: Option<PathBuf>,
    #[command(flatten)]
    appearance: AppearanceArguments,
    /// Leave out the colour bar
    #[arg(long)]
    no_color_bar: bool,
}

/// A file that can be written.
pub(crate) struct Output {
    pub(crate) path: PathBuf,
    format: PictureFormat,
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

impl ValuePictureArguments {
    /// Where the picture of `data` goes. What cannot be written is better known before the work than after it.
    pub(crate) fn output(&self, data: &DataArguments, kind: impl std::fmt::Display) -> anyhow::Result<Output> {
        let path = self.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}_{kind}.png", data.stem())));
        let format = PictureFormat::of(&path)?;
        check_writable(&path)?;
        Ok(Output { path, format })
    }

    /// Writes values of `data`; `place` tells where errors are, `title` is on the colour bar.
    pub(crate) fn write(
        &self,
        output: &Output,
        image: &ValueImage,
        data: &DataArguments,
        place: &str,
        title: &str,
    ) -> anyhow::Result<()> {
        if output.format == PictureFormat::Npy {
            let [width, height] = image.size.map(|side| side as u64);
            return Ok(write_array(&output.path, &[height, width], &image.values)?);
        }
        let function = self.appearance.colors(data, place, &image.values)?;
        write_colored(&output.path, image, &function, (!self.no_color_bar).then_some(title))
    }
}

/// Writes a .png, with a colour bar if it has a title.
fn write_colored(
    path: &Path,
    image: &ValueImage,
    function: &TransferFunction,
    bar: Option<&str>,
) -> anyhow::Result<()> {
    let [width, height] = image.size;
    let mut picture =
        Picture::from_pixels(width, height, colored(image, function)).expect("an image has its size's values");
    if let Some(title) = bar {
        picture = picture.beside(&color_bar(function, title, height.max(MIN_BAR), BACKGROUND), BACKGROUND);
    }
    Ok(write_png(path, [picture.width(), picture.height()], picture.pixels())?)
}

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

/// The lowest and the highest value; none where no value is finite.
pub(crate) fn range(image: &ValueImage) -> [Option<f64>; 2] {
    let finite = || image.values.iter().copied().filter(|value| value.is_finite());
    [finite().reduce(f64::min), finite().reduce(f64::max)]
}
