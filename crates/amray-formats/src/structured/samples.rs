//! Where a volume's samples lie in their file, and reading them slice by slice.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use amray::hierarchy::{Voxel, VoxelType};
use amray_encoding::vtk::{ArrayLocation, ArrayPlace};
use flate2::read::MultiGzDecoder;

use super::transposed::Transposed;
use crate::FormatError;
use crate::mapped_file::open_regular;
use crate::number::{ByteOrder, NumberType, voxel_type};

/// Bytes that are read at a time: a whole number of samples of any type.
const CHUNK: usize = 1 << 20;
/// No number is written with more characters; a damaged file must not fill the memory.
const LONGEST_NUMBER: usize = 64;

/// The samples of a volume in a file.
#[derive(Clone, Debug)]
pub(super) struct Samples {
    pub(super) path: PathBuf,
    /// The first sample's place in bytes: of the file, or of what it decompresses to.
    pub(super) offset: u64,
    pub(super) encoding: Encoding,
    pub(super) number: NumberType,
    pub(super) order: ByteOrder,
    /// A sample's value is the first of these times the stored number, plus the second.
    pub(super) scaling: Option<[f64; 2]>,
    /// Samples per axis.
    pub(super) size: [usize; 3],
    pub(super) fastest: Fastest,
}

/// How samples are stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Numbers one after the other.
    Raw,
    /// The same, compressed; what comes before the samples is compressed with them.
    Gzip,
    /// The same, and what comes before them is not compressed.
    GzipFromOffset,
    /// Decimal numbers between blanks or commas.
    Text,
    /// An array in one of VTK's XML files.
    Vtk(ArrayLocation),
}

/// The axis along which neighbouring samples are neighbours in the file. Files are read from front to back, so this
/// decides how slices come out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fastest {
    /// x, then y, then z.
    X,
    /// z, then y, then x; stored [raw](Encoding::Raw).
    Z,
}

impl Encoding {
    fn is_text(&self) -> bool {
        matches!(self, Self::Text | Self::Vtk(ArrayLocation { place: ArrayPlace::Text, .. }))
    }
}

impl Samples {
    /// The samples, if the file is large enough to hold them.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is not.
    pub(super) fn checked(self) -> Result<Self, FormatError> {
        let length = open_regular(&self.path)?.metadata().map_err(FormatError::io(&self.path, "read"))?.len();
        let count = self.size.iter().map(|&samples| samples as u64).product::<u64>();
        let needed = match self.encoding {
            Encoding::Raw => count * self.number.bytes() as u64,
            // What is compressed is found to be too short when it is read.
            Encoding::Gzip | Encoding::GzipFromOffset | Encoding::Vtk(_) => 0,
            // A digit each, and something between them.
            Encoding::Text => 2 * count - 1,
        };
        let available = length.saturating_sub(self.offset);
        if needed <= available {
            return Ok(self);
        }
        let (place, [x, y, z]) = (format!("byte {}", self.offset), self.size);
        let problem = format!("{available} bytes from there on, expected {needed} for {x} x {y} x {z} samples");
        Err(FormatError::malformed(&self.path, place, problem))
    }

    /// The smaller of amray's number types that holds every value.
    pub(super) fn voxel_type(&self) -> VoxelType {
        if self.scaling.is_some() { VoxelType::F64 } else { voxel_type(self.number) }
    }

    /// Samples per slice across z.
    pub(super) fn slice(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// The file, from the first sample on.
    fn open(&self) -> Result<Box<dyn Read + Send>, FormatError> {
        let failed = FormatError::io(&self.path, "read");
        let mut file = open_regular(&self.path)?;
        if self.encoding == Encoding::Gzip {
            let mut decoder = MultiGzDecoder::new(BufReader::new(file));
            let skipped = io::copy(&mut (&mut decoder).take(self.offset), &mut io::sink()).map_err(&failed)?;
            return match skipped == self.offset {
                true => Ok(Box::new(decoder)),
                false => Err(failed(io::ErrorKind::UnexpectedEof.into())),
            };
        }
        file.seek(SeekFrom::Start(self.offset)).map_err(&failed)?;
        Ok(match &self.encoding {
            Encoding::GzipFromOffset => Box::new(MultiGzDecoder::new(BufReader::new(file))),
            Encoding::Vtk(ArrayLocation { start, end, place }) => {
                let array = file.take(end.map_or(u64::MAX, |end| end - start));
                match place {
                    ArrayPlace::Text => Box::new(array),
                    ArrayPlace::Binary(encoding) => {
                        let bytes = self.size.iter().map(|&samples| samples as u128).product::<u128>();
                        let bytes = bytes * self.number.bytes() as u128;
                        let array = encoding.open(BufReader::new(array), bytes);
                        Box::new(array.map_err(|error| truncated(&self.path, error))?)
                    }
                }
            }
            Encoding::Raw | Encoding::Gzip | Encoding::Text => Box::new(file),
        })
    }
}

/// Reads a volume slice by slice, from the lowest z on.
pub struct SliceReader<'a> {
    samples: &'a Samples,
    input: Input,
    /// Slices that have not been read.
    left: usize,
}

enum Input {
    Numbers(Box<dyn Read + Send>),
    Text(BufReader<Box<dyn Read + Send>>),
    Transposed(Transposed),
}

impl<'a> SliceReader<'a> {
    /// `memory` is how many bytes the reader may keep; it needs them only where slices lie scattered in the file.
    pub(super) fn new(samples: &'a Samples, memory: u64) -> Result<Self, FormatError> {
        let input = match samples.fastest {
            Fastest::Z => Input::Transposed(Transposed::new(samples, memory)),
            Fastest::X if samples.encoding.is_text() => Input::Text(BufReader::new(samples.open()?)),
            Fastest::X => Input::Numbers(samples.open()?),
        };
        Ok(Self { samples, input, left: samples.size[2] })
    }

    /// Puts the values of the next `count` slices into `values`, x fastest, instead of what is there.
    ///
    /// # Errors
    /// [`FormatError`] where the file ends too early, is damaged or cannot be read. What is compressed proves to be whole
    /// with the last slice.
    ///
    /// # Panics
    /// Where there are not as many slices left.
    pub fn read<T: Voxel>(&mut self, count: usize, values: &mut Vec<T>) -> Result<(), FormatError> {
        let samples = self.samples;
        self.left = self.left.checked_sub(count).expect("no more slices are read than there are");
        values.clear();
        values.reserve_exact(count * samples.slice());
        match &mut self.input {
            Input::Numbers(file) => {
                let numbers = read_numbers(file, samples, count, values);
                if self.left == 0 { numbers.and_then(|()| file.read(&mut [0]).map(drop)) } else { numbers }
            }
            Input::Text(file) => read_text(file, count * samples.slice(), values),
            Input::Transposed(transposed) => transposed.read(samples, count, values),
        }
        .map_err(|error| truncated(&samples.path, error))?;
        if let Some([slope, intercept]) = samples.scaling {
            values.iter_mut().for_each(|value| *value = T::from_f64(slope * value.to_f64() + intercept));
        }
        Ok(())
    }
}

fn truncated(path: &Path, error: io::Error) -> FormatError {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => {
            FormatError::malformed(path, "samples", "the file ends before the last of them")
        }
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
            FormatError::malformed(path, "samples", error.to_string())
        }
        _ => FormatError::io(path, "read")(error),
    }
}

fn read_numbers<T: Voxel>(
    file: &mut impl Read,
    samples: &Samples,
    slices: usize,
    values: &mut Vec<T>,
) -> io::Result<()> {
    let mut left = slices * samples.slice() * samples.number.bytes();
    let mut bytes = vec![0; left.min(CHUNK)];
    while left > 0 {
        bytes.truncate(left);
        file.read_exact(&mut bytes)?;
        samples.number.decode(samples.order, &bytes, T::from_f64, values);
        left -= bytes.len();
    }
    Ok(())
}

fn read_text<T: Voxel>(file: &mut impl BufRead, count: usize, values: &mut Vec<T>) -> io::Result<()> {
    let mut word = Vec::new();
    for _ in 0..count {
        next_word(file, &mut word)?;
        let text = String::from_utf8_lossy(&word);
        let number: f64 = text.parse().map_err(|_| {
            let message = format!("{text:?} is no number (sample {} of these slices)", values.len());
            io::Error::new(io::ErrorKind::InvalidData, message)
        })?;
        values.push(T::from_f64(number));
    }
    Ok(())
}

/// The next word between blanks and commas.
fn next_word(file: &mut impl BufRead, word: &mut Vec<u8>) -> io::Result<()> {
    word.clear();
    loop {
        let buffer = file.fill_buf()?;
        let Some(&byte) = buffer.first() else {
            return if word.is_empty() { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(()) };
        };
        file.consume(1);
        match byte.is_ascii_whitespace() || byte == b',' {
            true if word.is_empty() => {}
            true => return Ok(()),
            false if word.len() == LONGEST_NUMBER => {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "a word too long for a number"));
            }
            false => word.push(byte),
        }
    }
}
