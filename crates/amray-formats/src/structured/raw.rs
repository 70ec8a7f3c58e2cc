//! Raw volumes: samples and nothing else.

use std::path::Path;

use super::samples::{Encoding, Fastest, Samples};
use super::{StructuredVolume, checked_size, length};
use crate::FormatError;
use crate::mapped_file::open_regular;
use crate::number::{ByteOrder, NumberType};

/// What must be known of a raw volume, whose file does not say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawLayout {
    /// Samples along x, which is stored fastest, y and z.
    pub size: [u64; 3],
    /// The samples' type.
    pub number_type: NumberType,
    /// Which byte of a sample comes first.
    pub byte_order: ByteOrder,
}

/// Samples are one apart, and the first one is at the world's origin.
pub(super) fn open(path: &Path, layout: &RawLayout) -> Result<StructuredVolume, FormatError> {
    let RawLayout { size, number_type: number, byte_order: order } = *layout;
    let size = checked_size(path, "raw volume", size)?;
    let found = length(&open_regular(path)?, path)?;
    let expected = size.iter().product::<usize>() as u64 * number.bytes() as u64;
    if found != expected {
        let ([x, y, z], name) = (size, number.name());
        let problem = format!("{found} bytes, expected {expected} for {x} x {y} x {z} samples of type {name}");
        return Err(FormatError::malformed(path, "raw volume", problem));
    }
    let samples = Samples {
        path: path.into(),
        offset: 0,
        encoding: Encoding::Raw,
        number,
        order,
        scaling: None,
        size,
        fastest: Fastest::X,
    };
    let (spacing, origin) = ([1.0; 3], [0.0; 3]);
    Ok(StructuredVolume { format: "raw volume", samples, spacing, origin, warnings: Vec::new() })
}
