//! Writing pictures: PNG for the eye, EXR and NPY with the linear values as composited.

use std::io::{self, Write};
use std::path::Path;

use exr::prelude::{Encoding, Image, SpecificChannels, WritableImage};
use npyz::WriterBuilder;

use crate::FormatError;
use crate::output::OutputFile;

/// The picture formats, by the ending of the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// 8 bits per channel.
    Png,
    /// OpenEXR, 32-bit float.
    Exr,
    /// NumPy's array format.
    Npy,
}

impl PictureFormat {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] lists the endings that are known.
    pub fn of(path: &Path) -> Result<Self, FormatError> {
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            Some("npy") => Ok(Self::Npy),
            other => Err(FormatError::Unrecognised {
                path: path.into(),
                found: other.map_or("no ending".into(), |ending| format!("ending .{ending}")),
                expected: ".png, .exr or .npy".into(),
            }),
        }
    }
}

/// Writes straight 8-bit RGBA as PNG; without an alpha channel where every pixel is opaque.
///
/// # Errors
/// [`FormatError::Io`] where the file cannot be written.
pub fn write_png(path: &Path, size: [usize; 2], pixels: &[[u8; 4]]) -> Result<(), FormatError> {
    let opaque = pixels.iter().all(|pixel| pixel[3] == u8::MAX);
    OutputFile::write(path, |file| {
        let [width, height] = size.map(|pixels| u32::try_from(pixels).map_err(io::Error::other));
        let mut encoder = png::Encoder::new(file, width?, height?);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
        let mut writer = encoder.write_header()?;
        if opaque {
            let rgb: Vec<u8> = pixels.iter().flat_map(|&[red, green, blue, _]| [red, green, blue]).collect();
            writer.write_image_data(&rgb)?;
        } else {
            writer.write_image_data(pixels.as_flattened())?;
        }
        writer.finish()?;
        Ok(())
    })
}

/// Writes linear premultiplied float RGBA as OpenEXR.
///
/// # Errors
/// [`FormatError::Io`] where the file cannot be written.
pub fn write_exr(path: &Path, size: [usize; 2], pixels: &[[f32; 4]]) -> Result<(), FormatError> {
    let pixel = |place: exr::math::Vec2<usize>| {
        let [red, green, blue, alpha] = pixels[place.y() * size[0] + place.x()];
        (red, green, blue, alpha)
    };
    let mut image = Image::from_channels((size[0], size[1]), SpecificChannels::rgba(pixel));
    image.layer_data.encoding = Encoding::SMALL_LOSSLESS;
    OutputFile::write(path, |file| {
        // The encoder goes back to fill in a table, so the picture is put together in memory.
        let mut encoded = io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut encoded).map_err(io::Error::other)?;
        file.write_all(encoded.get_ref())
    })
}

/// Writes linear premultiplied float RGBA as a NumPy array of shape (height, width, 4), 32-bit float.
///
/// # Errors
/// [`FormatError::Io`] where the file cannot be written.
pub fn write_npy(path: &Path, size: [usize; 2], pixels: &[[f32; 4]]) -> Result<(), FormatError> {
    write_array(path, &[size[1] as u64, size[0] as u64, 4], pixels.as_flattened())
}

/// Writes numbers as a NumPy array of the given shape, the last axis fastest.
///
/// # Errors
/// [`FormatError::Io`] where the file cannot be written or the numbers do not fill the shape.
pub fn write_array<T: npyz::AutoSerialize + Copy>(
    path: &Path,
    shape: &[u64],
    numbers: &[T],
) -> Result<(), FormatError> {
    OutputFile::write(path, |file| {
        let mut writer = npyz::WriteOptions::new().default_dtype().shape(shape).writer(file).begin_nd()?;
        writer.extend(numbers.iter().copied())?;
        writer.finish()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: [[f32; 4]; 2] = [[0.25, 0.5, 0.125, 0.75], [0.0; 4]];

    #[test]
    fn endings_choose_the_format() {
        assert_eq!(PictureFormat::of(Path::new("a/b.PNG")).unwrap(), PictureFormat::Png);
        let error = PictureFormat::of(Path::new("b.jpg")).unwrap_err().to_string();
        assert_eq!(error, "b.jpg: ending .jpg, expected .png, .exr or .npy");
    }

    #[test]
    fn png_round_trips() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.png");
        write_png(&path, [2, 1], &[[1, 2, 3, 255], [4, 5, 6, 7]]).unwrap();
        let mut reader =
            png::Decoder::new(io::BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!(bytes, [1, 2, 3, 255, 4, 5, 6, 7]);
    }

    #[test]
    fn npy_round_trips() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.npy");
        write_npy(&path, [2, 1], &PIXELS).unwrap();
        let read = npyz::NpyFile::new(std::fs::File::open(&path).unwrap()).unwrap();
        assert_eq!(read.shape(), [1, 2, 4]);
        assert_eq!(read.into_vec::<f32>().unwrap(), PIXELS.as_flattened());
    }

    #[test]
    fn exr_round_trips() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr");
        write_exr(&path, [2, 1], &PIXELS).unwrap();
        let read = exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| vec![[0f32; 4]; size.width() * size.height()],
            |pixels, place, (red, green, blue, alpha): (f32, f32, f32, f32)| {
                pixels[place.x()] = [red, green, blue, alpha];
            },
        );
        assert_eq!(read.unwrap().layer_data.channel_data.pixels, PIXELS);
    }
}
