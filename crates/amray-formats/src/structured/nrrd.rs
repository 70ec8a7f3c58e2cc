//! NRRD volumes: `.nrrd`, and `.nhdr` with the samples in a file beside (Teem's *Definition of NRRD File Format*).

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use super::samples::{Encoding, Fastest, Samples};
use super::{StructuredVolume, checked_size};
use crate::FormatError;
use crate::mapped_file::open_regular;
use crate::number::{ByteOrder, NumberType};
use crate::relative_path::path_below;

/// Headers are a few hundred bytes long; a damaged one must not fill the memory.
const LONGEST_HEADER: u64 = 1 << 20;

pub(super) fn open(path: &Path) -> Result<StructuredVolume, FormatError> {
    let header = Header::read(path)?;
    if header.get(&["dimension"]) != Some("3") {
        let found = header.get(&["dimension"]).unwrap_or("missing");
        return Err(header.malformed("dimension", format!("{found:?}, expected 3")));
    }
    let size = checked_size(path, "sizes", header.required("sizes", triple)?)?;
    let number = header.required("type", number_type)?;
    let encoding = header.required("encoding", |text| match text.to_lowercase().as_str() {
        "raw" => Some(Encoding::Raw),
        "gzip" | "gz" => Some(Encoding::GzipFromOffset),
        "ascii" | "text" | "txt" => Some(Encoding::Text),
        _ => None,
    })?;
    let order = match header.get(&["endian"]) {
        None if number.bytes() == 1 || encoding == Encoding::Text => ByteOrder::Little,
        _ => header.required("endian", |text| match text.to_lowercase().as_str() {
            "little" => Some(ByteOrder::Little),
            "big" => Some(ByteOrder::Big),
            _ => None,
        })?,
    };
    let (path, offset) = header.place(&encoding)?;
    let (spacing, origin) = header.grid()?;
    let samples = Samples { path, offset, encoding, number, order, scaling: None, size, fastest: Fastest::X };
    let samples = samples.checked()?;
    StructuredVolume { format: "NRRD", samples, spacing, origin, warnings: Vec::new() }.checked()
}

/// The fields of a header.
struct Header {
    path: PathBuf,
    /// Names in lower case, and what stands behind the colon.
    fields: Vec<(String, String)>,
    /// Its length in bytes.
    length: u64,
}

impl Header {
    /// Reads all lines up to the first empty one, or the end of a detached header.
    fn read(path: &Path) -> Result<Self, FormatError> {
        let mut reader = BufReader::new(open_regular(path)?.take(LONGEST_HEADER));
        let mut header = Self { path: path.into(), fields: Vec::new(), length: 0 };
        let mut line = Vec::new();
        for number in 1.. {
            line.clear();
            reader.read_until(b'\n', &mut line).map_err(FormatError::io(path, "read"))?;
            header.length += line.len() as u64;
            if header.length == LONGEST_HEADER {
                let problem = format!("no empty line in {LONGEST_HEADER} bytes, expected one behind the header");
                return Err(header.malformed("header", problem));
            }
            let text = String::from_utf8_lossy(&line);
            let text = text.trim();
            if text.is_empty() {
                break;
            }
            // The magic, comments, and keys with values that mean nothing to the format.
            if number == 1 || text.starts_with('#') || text.contains(":=") {
                continue;
            }
            let Some((name, value)) = text.split_once(':') else {
                let shown: String = text.chars().take(40).collect();
                return Err(header.malformed(&format!("line {number}"), format!("{shown:?}, expected `field: value`")));
            };
            header.fields.push((name.trim().to_lowercase(), value.trim().to_owned()));
        }
        Ok(header)
    }

    fn malformed(&self, place: &str, problem: String) -> FormatError {
        FormatError::malformed(&self.path, place, problem)
    }

    /// What a field says; some have two names.
    fn get(&self, names: &[&str]) -> Option<&str> {
        let found = self.fields.iter().find(|(name, _)| names.contains(&name.as_str()));
        found.map(|(_, value)| value.as_str())
    }

    fn required<T>(&self, name: &str, parse: impl Fn(&str) -> Option<T>) -> Result<T, FormatError> {
        let text = self.get(&[name]).ok_or_else(|| self.malformed("header", format!("no field {name}")))?;
        parse(text).ok_or_else(|| self.malformed(name, format!("{text:?} is not known")))
    }

    fn optional<T>(&self, names: &[&str], parse: impl Fn(&str) -> Option<T>) -> Result<Option<T>, FormatError> {
        self.get(names)
            .map(|text| {
                let expected = "expected three finite numbers, or vectors (x,y,z)";
                parse(text).ok_or_else(|| self.malformed(names[0], format!("{text:?}, {expected}")))
            })
            .transpose()
    }

    /// The file that holds the samples, and how many of its bytes come before them.
    fn place(&self, encoding: &Encoding) -> Result<(PathBuf, u64), FormatError> {
        if let Some(lines) = self.get(&["line skip", "lineskip"]).filter(|&lines| lines != "0") {
            return Err(self.malformed("line skip", format!("{lines:?}, expected 0")));
        }
        let bytes = self.get(&["byte skip", "byteskip"]).unwrap_or("0");
        let skipped: u32 = match bytes.parse() {
            Ok(0) => 0,
            Ok(skipped) if *encoding == Encoding::Raw => skipped,
            _ => return Err(self.malformed("byte skip", format!("{bytes:?}, expected 0, or a count of bytes if raw"))),
        };
        let skipped = u64::from(skipped);
        let Some(name) = self.get(&["data file", "datafile"]) else {
            return Ok((self.path.clone(), self.length + skipped));
        };
        let below = path_below(name.strip_prefix("./").unwrap_or(name)).ok_or_else(|| {
            self.malformed("data file", format!("{name:?}, expected a file in the header's directory or below"))
        })?;
        let directory = self.path.parent().unwrap_or(Path::new(""));
        let file = directory.join(below);
        if !file.is_file() {
            return Err(self.malformed("data file", format!("{name:?} is no file in the header's directory")));
        }
        Ok((file, skipped))
    }

    /// Spacing, and the first sample's position.
    fn grid(&self) -> Result<([f64; 3], [f64; 3]), FormatError> {
        let origin = self.optional(&["space origin"], vector)?.unwrap_or_default();
        if let Some(directions) = self.optional(&["space directions"], directions)? {
            let aligned = (0..3).all(|axis| (0..3).all(|other| axis == other || directions[axis][other] == 0.0));
            let spacing = [0, 1, 2].map(|axis| directions[axis][axis]);
            if !aligned || spacing.iter().any(|&width| width <= 0.0) {
                let expected = "expected each axis to point along x, y or z, in this order and upwards";
                return Err(self.malformed("space directions", format!("{directions:?}, {expected}")));
            }
            return Ok((spacing, origin));
        }
        Ok((self.optional(&["spacings"], triple)?.unwrap_or([1.0; 3]), origin))
    }
}

/// Three numbers between blanks.
fn triple<T: std::str::FromStr>(text: &str) -> Option<[T; 3]> {
    let numbers: Option<Vec<T>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    numbers?.try_into().ok()
}

/// `(x,y,z)` of finite numbers.
fn vector(text: &str) -> Option<[f64; 3]> {
    let inside = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let numbers: Option<Vec<f64>> = inside.split(',').map(|word| word.trim().parse().ok()).collect();
    numbers?.try_into().ok().filter(|numbers: &[f64; 3]| numbers.iter().all(|number| number.is_finite()))
}

/// Three vectors.
fn directions(text: &str) -> Option<[[f64; 3]; 3]> {
    let vectors: Option<Vec<[f64; 3]>> = text.split_inclusive(')').map(vector).collect();
    vectors?.try_into().ok()
}

/// Every name that the format's definition lists, but `block`.
fn number_type(name: &str) -> Option<NumberType> {
    Some(match name.to_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => NumberType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => NumberType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => NumberType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => NumberType::U16,
        "int" | "signed int" | "int32" | "int32_t" => NumberType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => NumberType::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => NumberType::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => NumberType::U64,
        "float" => NumberType::F32,
        "double" => NumberType::F64,
        _ => return None,
    })
}
