//! The header of a PLY file: its elements and their properties.

use amray_encoding::{ByteOrder, NumberType, shown};

use super::super::error::Problem;
use super::super::text::lines;

const PROPERTY: &str = "a property such as float x or list uchar int vertex_indices";

/// What a file says about itself.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Its own length.
    pub(super) bytes: usize,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Text,
    Binary(ByteOrder),
}

/// Rows of the same kind.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// A column.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the number, or of a list's numbers.
    pub(super) number: NumberType,
    /// The type of the length, of a list.
    pub(super) length: Option<NumberType>,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Problem> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut lines = lines(bytes, false);
        lines.next();
        for (number, line) in lines {
            let malformed = |expected: &str| Problem::at_line(number, format!("{}, expected {expected}", shown(&line)));
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match (words.as_slice(), elements.last_mut()) {
                ([] | ["comment" | "obj_info", ..], _) => {}
                (["format", name, "1.0"], _) if Encoding::named(name).is_some() => encoding = Encoding::named(name),
                (["format", ..], _) => {
                    return Err(malformed("format ascii, binary_little_endian or binary_big_endian, and 1.0"));
                }
                (["element", name, count], _) => {
                    let count = count.parse().map_err(|_| malformed("a count"))?;
                    elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
                }
                (["property", words @ ..], Some(element)) => {
                    element.properties.push(Property::parse(words).ok_or_else(|| malformed(PROPERTY))?);
                }
                (["end_header"], _) => {
                    let encoding = encoding.ok_or_else(|| malformed("a line format before it"))?;
                    return Ok(Self { encoding, elements, bytes: length_of_lines(bytes, number) });
                }
                _ => return Err(malformed("a line of a header such as element vertex 8")),
            }
        }
        Err(Problem::new("header", "the file ends here, expected end_header"))
    }
}

/// How many bytes the first lines take.
fn length_of_lines(bytes: &[u8], count: usize) -> usize {
    bytes.split_inclusive(|&byte| byte == b'\n').take(count).map(<[u8]>::len).sum()
}

impl Encoding {
    fn named(name: &str) -> Option<Self> {
        match name {
            "ascii" => Some(Self::Text),
            "binary_little_endian" => Some(Self::Binary(ByteOrder::Little)),
            "binary_big_endian" => Some(Self::Binary(ByteOrder::Big)),
            _ => None,
        }
    }
}

impl Property {
    fn parse(words: &[&str]) -> Option<Self> {
        match words {
            ["list", length, number, name] => {
                let length = Some(number_type(length)?);
                Some(Self { name: (*name).into(), number: number_type(number)?, length })
            }
            [number, name] => Some(Self { name: (*name).into(), number: number_type(number)?, length: None }),
            _ => None,
        }
    }
}

/// A type by either of its names.
fn number_type(name: &str) -> Option<NumberType> {
    match name {
        "char" | "int8" => Some(NumberType::I8),
        "uchar" | "uint8" => Some(NumberType::U8),
        "short" | "int16" => Some(NumberType::I16),
        "ushort" | "uint16" => Some(NumberType::U16),
        "int" | "int32" => Some(NumberType::I32),
        "uint" | "uint32" => Some(NumberType::U32),
        "float" | "float32" => Some(NumberType::F32),
        "double" | "float64" => Some(NumberType::F64),
        _ => None,
    }
}
