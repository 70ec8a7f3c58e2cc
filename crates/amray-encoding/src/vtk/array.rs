//! The arrays of a file: what they are, where they are, and their numbers.

use std::borrow::Cow;
use std::io::{self, Read};
use std::ops::Range;

use super::storage::Encoding;
use super::{Document, Element, VtkError};
use crate::{ByteOrder, NumberType, shown};

/// Bytes that are decoded at a time: a whole number of numbers of any type.
const CHUNK: usize = 1 << 16;

/// An array that has not been decoded.
#[derive(Clone, Debug)]
pub struct DataArray {
    /// Its name; empty where it has none.
    pub name: String,
    /// The type of its numbers.
    pub number: NumberType,
    /// Numbers per cell or point.
    pub components: u64,
    place: Place,
}

#[derive(Clone, Debug)]
enum Place {
    /// Decimal numbers between the array's tags.
    Text(Vec<Range<usize>>),
    /// Between the array's tags.
    Base64(Vec<Range<usize>>),
    /// From this byte of the file on.
    Appended(usize),
}

/// Where in its file an array is, and how it is stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArrayLocation {
    /// The first byte.
    pub start: u64,
    /// The first byte that is no longer the array's, where that is known.
    pub end: Option<u64>,
    /// How it is stored.
    pub place: ArrayPlace,
}

/// How an array is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrayPlace {
    /// Decimal numbers between blanks.
    Text,
    /// Bytes behind what says how many.
    Binary(Encoding),
}

impl DataArray {
    /// The array that the element is; `None` where it is none of numbers.
    ///
    /// # Errors
    /// [`VtkError`] where its attributes are damaged, or it lies outside of the file.
    pub fn of(element: &Element, document: &Document<'_>) -> Result<Option<Self>, VtkError> {
        let number = element.attribute("type").and_then(number_type).filter(|_| element.name() == "DataArray");
        let Some(number) = number else { return Ok(None) };
        let place = match element.attribute("format") {
            Some("ascii") | None => Place::Text(element.text.clone()),
            Some("binary") => Place::Base64(element.text.clone()),
            Some("appended") => {
                let offset: u64 =
                    element.number("offset")?.ok_or_else(|| element.error("an appended DataArray has no offset"))?;
                let appended = document.appended.ok_or_else(|| element.error("there is no AppendedData"))?;
                let size = document.bytes.len() - appended.start;
                let inside = usize::try_from(offset).ok().filter(|&offset| offset < size);
                let outside = || element.error(format!("the array is at byte {offset} of {size} appended ones"));
                Place::Appended(appended.start + inside.ok_or_else(outside)?)
            }
            Some(other) => {
                let expected = "expected ascii, binary or appended";
                return Err(element.error(format!("format {}, {expected}", shown(other))));
            }
        };
        let name = element.attribute("Name").unwrap_or_default().to_owned();
        let components = element.number("NumberOfComponents")?.unwrap_or(1);
        Ok(Some(Self { name, number, components, place }))
    }

    /// The numbers of the array, of which there are `expected`, each through `from`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn values<T>(
        &self,
        document: &Document<'_>,
        expected: u128,
        from: impl Fn(f64) -> T,
    ) -> Result<Vec<T>, String> {
        let stored = match &self.place {
            Place::Text(parts) => return written_out(document.bytes, parts, expected, from),
            Place::Base64(parts) => joined(document.bytes, parts),
            Place::Appended(start) => Cow::Borrowed(&document.bytes[*start..]),
        };
        self.binary(document, &stored, expected, from).map_err(|error| in_words(&error))
    }

    fn binary<T>(
        &self,
        document: &Document<'_>,
        stored: &[u8],
        expected: u128,
        from: impl Fn(f64) -> T,
    ) -> io::Result<Vec<T>> {
        let number_bytes = self.number.bytes();
        let mut left = expected.saturating_mul(number_bytes as u128);
        let mut reader = self.encoding(document).open(stored, left)?;
        let mut values = Vec::new();
        let mut bytes = vec![0; CHUNK.min(usize::try_from(left).unwrap_or(CHUNK))];
        while left > 0 {
            bytes.truncate(usize::try_from(left).unwrap_or(CHUNK));
            reader.read_exact(&mut bytes)?;
            self.number.decode(document.storage.byte_order, &bytes, &from, &mut values);
            left -= bytes.len() as u128;
        }
        Ok(values)
    }

    fn encoding(&self, document: &Document<'_>) -> Encoding {
        let is_base64 = match self.place {
            Place::Appended(_) => document.appended.is_some_and(|appended| appended.is_base64),
            Place::Text(_) | Place::Base64(_) => true,
        };
        Encoding { storage: document.storage, is_base64 }
    }

    /// The bytes of the file that are the array's `expected` numbers as this machine has them, if there are such.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn in_place(&self, document: &Document<'_>, expected: u128) -> Result<Option<Range<usize>>, String> {
        let Place::Appended(start) = self.place else { return Ok(None) };
        let Encoding { storage, is_base64 } = self.encoding(document);
        if is_base64 || storage.compressor.is_some() || storage.byte_order != ByteOrder::NATIVE {
            return Ok(None);
        }
        let bytes = expected.saturating_mul(self.number.bytes() as u128);
        // Reads and checks what is before the numbers.
        self.encoding(document).open(&document.bytes[start..], bytes).map_err(|error| in_words(&error))?;
        let first = start + storage.length.bytes();
        let end = usize::try_from(bytes).ok().and_then(|bytes| first.checked_add(bytes));
        let end = end.filter(|&end| end <= document.bytes.len());
        end.map(|end| Some(first..end)).ok_or_else(|| in_words(&io::ErrorKind::UnexpectedEof.into()))
    }

    /// Where in the file the array is.
    ///
    /// # Errors
    /// What is wrong, in words: numbers between tags may be interrupted by other elements.
    pub fn location(&self, document: &Document<'_>) -> Result<ArrayLocation, String> {
        let binary = ArrayPlace::Binary(self.encoding(document));
        let (place, parts) = match &self.place {
            Place::Appended(start) => return Ok(ArrayLocation { start: *start as u64, end: None, place: binary }),
            Place::Text(parts) => (ArrayPlace::Text, parts),
            Place::Base64(parts) => (binary, parts),
        };
        match &parts[..] {
            [part] => Ok(ArrayLocation { start: part.start as u64, end: Some(part.end as u64), place }),
            parts => Err(format!("its numbers are in {} parts, expected 1", parts.len())),
        }
    }
}

/// Decimal numbers in parts of the bytes, of which there are `expected`.
fn written_out<T>(
    bytes: &[u8],
    parts: &[Range<usize>],
    expected: u128,
    from: impl Fn(f64) -> T,
) -> Result<Vec<T>, String> {
    // The XML was read as UTF-8.
    let texts = parts.iter().map(|part| str::from_utf8(&bytes[part.clone()]).unwrap_or_default());
    let number = |word: &str| word.parse().map_err(|_| format!("{}, expected a number", shown(word)));
    let words = texts.flat_map(str::split_ascii_whitespace);
    let values: Vec<T> = words.map(|word| number(word).map(&from)).collect::<Result<_, _>>()?;
    match values.len() as u128 == expected {
        true => Ok(values),
        false => Err(format!("there are {} numbers, expected {expected}", values.len())),
    }
}

/// What is wrong with an array that cannot be read.
fn in_words(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => "the file ends before the array does".into(),
        _ => error.to_string(),
    }
}

/// Parts of the bytes, one after the other.
fn joined<'a>(bytes: &'a [u8], parts: &[Range<usize>]) -> Cow<'a, [u8]> {
    match parts {
        [part] => Cow::Borrowed(&bytes[part.clone()]),
        parts => Cow::Owned(parts.iter().flat_map(|part| &bytes[part.clone()]).copied().collect()),
    }
}

fn number_type(name: &str) -> Option<NumberType> {
    match name {
        "Int8" => Some(NumberType::I8),
        "UInt8" => Some(NumberType::U8),
        "Int16" => Some(NumberType::I16),
        "UInt16" => Some(NumberType::U16),
        "Int32" => Some(NumberType::I32),
        "UInt32" => Some(NumberType::U32),
        "Int64" => Some(NumberType::I64),
        "UInt64" => Some(NumberType::U64),
        "Float32" => Some(NumberType::F32),
        "Float64" => Some(NumberType::F64),
        _ => None,
    }
}
