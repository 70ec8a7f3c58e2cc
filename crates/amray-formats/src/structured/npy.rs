//! NumPy arrays: `.npy`, as `numpy.save` writes them (NumPy Enhancement Proposal 1).
//!
//! The indices of an array are z, y, x, whatever its order in memory: arrays that are equal in NumPy are equal volumes.

use std::path::Path;

use super::samples::{Encoding, Fastest, Samples};
use super::{StructuredVolume, checked_size};
use crate::FormatError;
use crate::mapped_file::start_of;
use crate::number::{ByteOrder, NumberType};

/// A header is a line of Python; a damaged one must not fill the memory.
const LONGEST_HEADER: usize = 1 << 16;
/// The magic string, two bytes of version, and the header's length in two bytes (version 1) or four.
const MAGIC: usize = 8;

/// Samples are one apart, and the first one is at the world's origin.
pub(super) fn open(path: &Path) -> Result<StructuredVolume, FormatError> {
    let broken = |problem: &str| FormatError::malformed(path, "NumPy header", problem);
    let longest = MAGIC + size_of::<u32>() + LONGEST_HEADER;
    let start = start_of(path, longest as u64)?;
    let (text, offset) = header(&start).map_err(|problem| broken(&problem))?;

    let wrong = |expected: &str| broken(&format!("{}, expected {expected}", text.trim_end()));
    let (number, order) = value(&text, "descr")
        .and_then(number_type)
        .ok_or_else(|| wrong("a descr that is one of integers or floats"))?;
    let fastest = match value(&text, "fortran_order") {
        Some(order) if order.starts_with("False") => Fastest::X,
        Some(order) if order.starts_with("True") => Fastest::Z,
        _ => return Err(wrong("a fortran_order that is True or False")),
    };
    let [depth, height, width] =
        value(&text, "shape").and_then(three_counts).ok_or_else(|| wrong("a shape of three axes (z, y, x)"))?;

    let size = checked_size(path, "NumPy header", [width, height, depth])?;
    let samples =
        Samples { path: path.into(), offset, encoding: Encoding::Raw, number, order, scaling: None, size, fastest };
    let samples = samples.checked()?;
    let (spacing, origin) = ([1.0; 3], [0.0; 3]);
    Ok(StructuredVolume { format: "NumPy array", samples, spacing, origin, warnings: Vec::new() })
}

/// The header's text, and where the samples begin.
fn header(start: &[u8]) -> Result<(String, u64), String> {
    let (length, first) = match *start {
        [_, _, _, _, _, _, 1, _, a, b, ..] => (u32::from(u16::from_le_bytes([a, b])), MAGIC + 2),
        [_, _, _, _, _, _, 2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]), MAGIC + 4),
        _ => return Err("no length, expected version 1, 2 or 3".into()),
    };
    let length = length as usize;
    if length > LONGEST_HEADER {
        return Err(format!("{length} bytes long, expected at most {LONGEST_HEADER}"));
    }
    let text = start.get(first..first + length).ok_or("the file ends in it")?;
    // Messages show it, in one line.
    let text = String::from_utf8_lossy(text).replace(char::is_control, " ");
    Ok((text, (first + length) as u64))
}

/// What follows a key of the dictionary that a header is.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    ["'", "\""].iter().find_map(|quote| {
        let (_, rest) = header.split_once(&format!("{quote}{key}{quote}"))?;
        Some(rest.trim_start().strip_prefix(':')?.trim_start())
    })
}

/// A type such as `'<f4'`: byte order, kind, bytes.
fn number_type(descriptor: &str) -> Option<(NumberType, ByteOrder)> {
    let quoted = descriptor.strip_prefix(['\'', '"'])?;
    let (name, _) = quoted.split_once(['\'', '"'])?;
    let number = match name.get(1..)? {
        "i1" => NumberType::I8,
        "u1" => NumberType::U8,
        "i2" => NumberType::I16,
        "u2" => NumberType::U16,
        "i4" => NumberType::I32,
        "u4" => NumberType::U32,
        "i8" => NumberType::I64,
        "u8" => NumberType::U64,
        "f4" => NumberType::F32,
        "f8" => NumberType::F64,
        _ => return None,
    };
    match name.get(..1)? {
        "<" | "|" => Some((number, ByteOrder::Little)),
        ">" => Some((number, ByteOrder::Big)),
        _ => None,
    }
}

/// `(3, 4, 5)`, and nothing shorter or longer.
fn three_counts(shape: &str) -> Option<[u64; 3]> {
    let (inside, _) = shape.strip_prefix('(')?.split_once(')')?;
    let counts: Option<Vec<u64>> = inside.split(',').map(|word| word.trim().parse().ok()).collect();
    counts?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_dictionaries() {
        let text = "{'descr': '>u2', 'fortran_order': False, 'shape': (3, 40, 5), }  \n";
        assert_eq!(number_type(value(text, "descr").unwrap()), Some((NumberType::U16, ByteOrder::Big)));
        assert_eq!(three_counts(value(text, "shape").unwrap()), Some([3, 40, 5]));
        assert!(value(text, "fortran_order").unwrap().starts_with("False"));
        assert_eq!(value(text, "version"), None);
        for shape in ["(3, 4)", "(1, 2, 3, 4)", "(1, 2, -3)", "1, 2, 3", "(1, 2, 3", "()"] {
            assert_eq!(three_counts(shape), None, "{shape}");
        }
        for descriptor in ["'<c8'", "[('a', '<f4')]", "'<f2'", "'f4'", "'|S3'", "'é4'", "''", "'"] {
            assert_eq!(number_type(descriptor), None, "{descriptor}");
        }
    }
}
