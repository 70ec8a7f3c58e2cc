//! NIfTI-1 volumes in one file: `.nii` and `.nii.gz` (the data format's `nifti1.h`).

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::samples::{Encoding, Fastest, Samples};
use super::{StructuredVolume, checked_size};
use crate::FormatError;
use crate::mapped_file::{open_regular, start_of};
use crate::number::{ByteOrder, NumberType};

/// The header's length, which is also its first number.
const HEADER: usize = 348;
/// What a header of both data and header in one file ends with.
const MAGIC: &[u8] = b"n+1\0";

/// Whether the file at `path`, which begins with `start`, is a NIfTI-1 file, perhaps compressed.
pub(super) fn recognises(path: &Path, start: &[u8]) -> Result<bool, FormatError> {
    if !is_compressed(start) {
        return Ok(Header::of(start).is_some());
    }
    // What cannot be decompressed is no volume.
    Ok(decompressed_start(path)?.is_some_and(|start| Header::of(&start).is_some()))
}

/// Opens a file that [`recognises`] knows.
pub(super) fn open(path: &Path) -> Result<StructuredVolume, FormatError> {
    let broken = |problem: String| FormatError::malformed(path, "NIfTI header", problem);
    let mut bytes = start_of(path, HEADER as u64)?;
    let compressed = is_compressed(&bytes);
    if compressed {
        bytes = decompressed_start(path)?.unwrap_or_default();
    }
    let header = Header::of(&bytes).ok_or_else(|| broken("not that of a NIfTI-1 file".into()))?;

    let code = header.short(70);
    let number = number_type(code).ok_or_else(|| broken(format!("datatype {code}, expected integers or floats")))?;
    let offset = header.float(108);
    if !(HEADER as f64..=1e9).contains(&offset) || offset.fract() != 0.0 {
        return Err(broken(format!("vox_offset {offset}, expected a number of bytes from {HEADER} on")));
    }
    let samples = Samples {
        path: path.into(),
        offset: offset as u64,
        encoding: if compressed { Encoding::Gzip } else { Encoding::Raw },
        number,
        order: header.order,
        scaling: header.scaling(),
        size: checked_size(path, "NIfTI header", header.size().map_err(broken)?)?,
        fastest: Fastest::X,
    };
    let samples = samples.checked()?;
    let spacing = [1, 2, 3].map(|axis| header.float(76 + 4 * axis).abs());
    let (origin, warnings) = match header.origin(spacing) {
        Some(origin) => (origin, Vec::new()),
        None => {
            let turned = "its axes are turned against the scanner's: the volume is placed at the origin, along its own";
            ([0.0; 3], vec![turned.to_owned()])
        }
    };
    StructuredVolume { format: "NIfTI", samples, spacing, origin, warnings }.checked()
}

fn is_compressed(start: &[u8]) -> bool {
    start.starts_with(&[0x1f, 0x8b])
}

/// The header of a compressed file, as far as it can be decompressed; `None` where it cannot at all.
fn decompressed_start(path: &Path) -> Result<Option<Vec<u8>>, FormatError> {
    let mut start = Vec::new();
    let decoder = MultiGzDecoder::new(std::io::BufReader::new(open_regular(path)?));
    let read = decoder.take(HEADER as u64).read_to_end(&mut start);
    Ok(read.is_ok().then_some(start))
}

/// A header's bytes, and the order of its numbers. Places are bytes from its start.
struct Header<'a> {
    bytes: &'a [u8],
    order: ByteOrder,
}

impl<'a> Header<'a> {
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let bytes = bytes.get(..HEADER).filter(|bytes| bytes.ends_with(MAGIC))?;
        let (low, high) = ((HEADER as u32).to_le_bytes(), (HEADER as u32).to_be_bytes());
        let order = match [bytes.starts_with(&low), bytes.starts_with(&high)] {
            [true, _] => ByteOrder::Little,
            [_, true] => ByteOrder::Big,
            _ => return None,
        };
        Some(Self { bytes, order })
    }

    fn number(&self, number: NumberType, place: usize) -> f64 {
        number.value(self.order, &self.bytes[place..place + number.bytes()])
    }

    fn short(&self, place: usize) -> i64 {
        self.number(NumberType::I16, place) as i64
    }

    fn float(&self, place: usize) -> f64 {
        self.number(NumberType::F32, place)
    }

    /// Slope and intercept; none where the slope is 0, or not a number as NiBabel writes it.
    fn scaling(&self) -> Option<[f64; 2]> {
        let scaling = [self.float(112), self.float(116)];
        let used = scaling[0] != 0.0 && scaling.iter().all(|number| number.is_finite());
        (used && scaling != [1.0, 0.0]).then_some(scaling)
    }

    /// Samples per axis; further axes may only be one long.
    fn size(&self) -> Result<[u64; 3], String> {
        let axes = self.short(40);
        let lengths: Vec<i64> = (1..=7).map(|axis| self.short(40 + 2 * axis)).collect();
        let stated = match axes {
            3..=7 => &lengths[..axes as usize],
            _ => return Err(format!("{axes} axes, expected 3")),
        };
        match *stated {
            [x, y, z, ref rest @ ..] if rest.iter().all(|&length| length == 1) => {
                Ok([x, y, z].map(|length| length.try_into().unwrap_or(0)))
            }
            _ => Err(format!("axes of {stated:?} samples, expected one volume of three axes")),
        }
    }

    /// The first sample's position in the scanner, where the volume's axes point along the scanner's.
    fn origin(&self, spacing: [f64; 3]) -> Option<[f64; 3]> {
        /// Matrices are rounded to single precision.
        const ROUNDING: f64 = 1e-5;
        if self.short(254) > 0 {
            let row = |axis: usize| [0, 4, 8, 12].map(|place| self.float(280 + 16 * axis + place));
            let along = (0..3).all(|axis| {
                (0..3).all(|other| {
                    let expected = if axis == other { spacing[axis] } else { 0.0 };
                    (row(axis)[other] - expected).abs() <= ROUNDING * spacing[axis].max(spacing[other])
                })
            });
            return along.then(|| [0, 1, 2].map(|axis| row(axis)[3]));
        }
        if self.short(252) > 0 {
            // A quaternion's vector part, and whether z is mirrored.
            let unturned = [256, 260, 264].iter().all(|&place| self.float(place).abs() <= ROUNDING);
            return (unturned && self.float(76) >= 0.0).then(|| [268, 272, 276].map(|place| self.float(place)));
        }
        Some([0.0; 3])
    }
}

fn number_type(code: i64) -> Option<NumberType> {
    Some(match code {
        2 => NumberType::U8,
        4 => NumberType::I16,
        8 => NumberType::I32,
        16 => NumberType::F32,
        64 => NumberType::F64,
        256 => NumberType::I8,
        512 => NumberType::U16,
        768 => NumberType::U32,
        1024 => NumberType::I64,
        1280 => NumberType::U64,
        _ => return None,
    })
}
