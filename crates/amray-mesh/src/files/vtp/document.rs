//! The XML of a VTK file: which arrays there are, and where.

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::super::error::Problem;
use super::super::number::{ByteOrder, NumberType};
use super::super::text::shown;

/// A file of type PolyData.
#[derive(Debug)]
pub(super) struct Document<'a> {
    pub(super) storage: Storage,
    pub(super) pieces: Vec<Piece>,
    /// What follows the XML: the arrays' common store.
    pub(super) appended: Appended<'a>,
}

/// How binary arrays are stored, all alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Storage {
    pub(super) byte_order: ByteOrder,
    /// The type of lengths before the data.
    pub(super) length: NumberType,
    pub(super) compressor: Option<Compressor>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
}

/// The bytes at the end of a file.
#[derive(Clone, Copy, Debug)]
pub(super) enum Appended<'a> {
    None,
    Raw(&'a [u8]),
    Base64(&'a [u8]),
}

/// A part of the surface with points of its own.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) points: u64,
    pub(super) polys: u64,
    pub(super) strips: u64,
    /// The name of the active scalars.
    pub(super) scalars: String,
    /// The name of the active normals.
    pub(super) normals: String,
    pub(super) arrays: Vec<DataArray>,
}

/// An array that has not been decoded.
#[derive(Debug)]
pub(super) struct DataArray {
    pub(super) section: Section,
    pub(super) name: String,
    pub(super) number: NumberType,
    pub(super) components: u64,
    pub(super) format: Format,
    /// What is written between its tags.
    pub(super) text: String,
}

/// What an array belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Section {
    Points,
    Polys,
    Strips,
    PointData,
    Other,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    Text,
    Base64,
    /// In the appended data, from this byte or character on.
    Appended(u64),
}

/// Where the parser is.
#[derive(Debug)]
struct Parser {
    storage: Option<Storage>,
    pieces: Vec<Piece>,
    section: Section,
    /// The array that is open, where it is one to be read.
    array: Option<DataArray>,
    /// How many elements are open inside of an array, itself included.
    depth: usize,
}

/// The place of the first `needle`, which is not empty.
pub(super) fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    bytes.windows(needle.len()).position(|window| window == needle)
}

impl<'a> Document<'a> {
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, Problem> {
        // What is appended may be any bytes: it is no XML.
        let (xml, appended) = match find(bytes, b"<AppendedData") {
            Some(start) => {
                let tag = bytes[start..].iter().position(|&byte| byte == b'>').map(|end| start + end + 1);
                bytes.split_at(tag.ok_or_else(|| Problem::new("AppendedData", "the file ends here, expected >"))?)
            }
            None => (bytes, &[][..]),
        };
        let xml = std::str::from_utf8(xml)
            .map_err(|error| Problem::new(format!("byte {}", error.valid_up_to()), "the XML is not in UTF-8"))?;
        let mut reader = Reader::from_str(xml);
        let mut parser = Parser { storage: None, pieces: Vec::new(), section: Section::Other, array: None, depth: 0 };
        let mut encoding = Appended::None;
        loop {
            let position = reader.buffer_position();
            let at = |problem: String| Problem::new(format!("byte {position}"), problem);
            match reader.read_event().map_err(|error| at(error.to_string()))? {
                Event::Start(element) if element.name().as_ref() == "AppendedData" => {
                    encoding = appended_data(&element, appended).map_err(at)?;
                }
                Event::Start(element) => parser.start(&element, false).map_err(at)?,
                Event::Empty(element) => parser.start(&element, true).map_err(at)?,
                Event::Text(text) if parser.depth == 1 => parser.text(&text),
                Event::End(element) => parser.end(element.name().as_ref()),
                Event::Eof => break,
                _ => {}
            }
        }
        let storage = parser.storage.ok_or_else(|| Problem::new("end of file", "there is no element VTKFile"))?;
        Ok(Self { storage, pieces: parser.pieces, appended: encoding })
    }
}

impl Parser {
    fn start(&mut self, element: &BytesStart<'_>, is_empty: bool) -> Result<(), String> {
        if self.depth > 0 {
            self.depth += usize::from(!is_empty);
            return Ok(());
        }
        match element.name().as_ref() {
            "VTKFile" => self.storage = Some(Storage::parse(element)?),
            "Piece" => self.pieces.push(Piece::parse(element)?),
            "Points" => self.section = Section::Points,
            "Polys" => self.section = Section::Polys,
            "Strips" => self.section = Section::Strips,
            "PointData" => {
                self.section = Section::PointData;
                if let Some(piece) = self.pieces.last_mut() {
                    piece.scalars = attribute(element, "Scalars")?.unwrap_or_default();
                    piece.normals = attribute(element, "Normals")?.unwrap_or_default();
                }
            }
            "DataArray" => {
                self.array = DataArray::parse(element, self.section)?;
                self.depth = 1;
                if is_empty {
                    self.end("DataArray");
                }
            }
            "CellData" | "Verts" | "Lines" | "FieldData" => self.section = Section::Other,
            _ => {}
        }
        Ok(())
    }

    /// Text of an array itself, not of what is written about it inside.
    fn text(&mut self, text: &str) {
        self.array.iter_mut().for_each(|array| array.text.push_str(text));
    }

    fn end(&mut self, name: &str) {
        if self.depth > 0 {
            self.depth -= 1;
            if self.depth == 0
                && let Some(piece) = self.pieces.last_mut()
            {
                piece.arrays.extend(self.array.take());
            }
        } else if name == "Piece" {
            self.section = Section::Other;
        }
    }
}

impl Storage {
    fn parse(element: &BytesStart<'_>) -> Result<Self, String> {
        let kind = attribute(element, "type")?.unwrap_or_default();
        if kind != "PolyData" {
            return Err(format!("the file's type is {}, expected PolyData", shown(&kind)));
        }
        let byte_order = match attribute(element, "byte_order")?.as_deref() {
            Some("BigEndian") => ByteOrder::Big,
            Some("LittleEndian") | None => ByteOrder::Little,
            Some(other) => return Err(format!("byte_order {}, expected LittleEndian or BigEndian", shown(other))),
        };
        let length = match attribute(element, "header_type")?.as_deref() {
            Some("UInt64") => NumberType::U64,
            Some("UInt32") | None => NumberType::U32,
            Some(other) => return Err(format!("header_type {}, expected UInt32 or UInt64", shown(other))),
        };
        let compressor = match attribute(element, "compressor")?.as_deref() {
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some("") | None => None,
            Some(other) => {
                let expected = "vtkZLibDataCompressor, vtkLZ4DataCompressor or none";
                return Err(format!("the compressor {} is not known, expected {expected}", shown(other)));
            }
        };
        Ok(Self { byte_order, length, compressor })
    }
}

impl Piece {
    fn parse(element: &BytesStart<'_>) -> Result<Self, String> {
        let count = |name| Ok::<_, String>(number(element, name)?.unwrap_or(0));
        Ok(Self {
            points: count("NumberOfPoints")?,
            polys: count("NumberOfPolys")?,
            strips: count("NumberOfStrips")?,
            scalars: String::new(),
            normals: String::new(),
            arrays: Vec::new(),
        })
    }
}

impl DataArray {
    /// None where it is none to be read.
    fn parse(element: &BytesStart<'_>, section: Section) -> Result<Option<Self>, String> {
        let kind = attribute(element, "type")?.unwrap_or_default();
        let Some(number_type) = number_type(&kind).filter(|_| section != Section::Other) else { return Ok(None) };
        let format = match attribute(element, "format")?.as_deref() {
            Some("ascii") | None => Format::Text,
            Some("binary") => Format::Base64,
            Some("appended") => {
                Format::Appended(number(element, "offset")?.ok_or("an appended DataArray has no offset")?)
            }
            Some(other) => return Err(format!("format {}, expected ascii, binary or appended", shown(other))),
        };
        Ok(Some(Self {
            section,
            name: attribute(element, "Name")?.unwrap_or_default(),
            number: number_type,
            components: number(element, "NumberOfComponents")?.unwrap_or(1),
            format,
            text: String::new(),
        }))
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

/// The store behind the tag `AppendedData`: it begins after an underscore.
fn appended_data<'a>(element: &BytesStart<'_>, bytes: &'a [u8]) -> Result<Appended<'a>, String> {
    let start = bytes.iter().position(|&byte| byte == b'_').ok_or("AppendedData without its underscore")?;
    let data = &bytes[start + 1..];
    match attribute(element, "encoding")?.as_deref() {
        Some("raw") => Ok(Appended::Raw(data)),
        Some("base64") | None => Ok(Appended::Base64(data)),
        Some(other) => Err(format!("AppendedData with encoding {}, expected raw or base64", shown(other))),
    }
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Result<Option<String>, String> {
    let attribute = element.try_get_attribute(name).map_err(|error| error.to_string())?;
    let value = |attribute: quick_xml::events::attributes::Attribute<'_>| {
        attribute.normalized_value(XmlVersion::Implicit1_0).map(String::from).map_err(|error| error.to_string())
    };
    attribute.map(value).transpose()
}

fn number(element: &BytesStart<'_>, name: &str) -> Result<Option<u64>, String> {
    let number = |text: String| text.trim().parse().map_err(|_| format!("{name} {}, expected a count", shown(&text)));
    attribute(element, name)?.map(number).transpose()
}
