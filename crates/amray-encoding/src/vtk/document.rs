//! From the bytes of a file to its elements.

use memchr::memmem;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::VtkError;
use super::element::Element;
use super::storage::Storage;
use crate::{ByteOrder, shown};

/// The element `VTKFile` begins within so many bytes.
const BEGINNING: usize = 4096;
/// VTK's elements are no more than eight deep.
const DEEPEST: usize = 32;

/// A VTK file: its elements, and the bytes that their arrays are in.
#[derive(Debug)]
pub struct Document<'a> {
    pub(super) bytes: &'a [u8],
    file: Element,
    pub(super) storage: Storage,
    /// What follows the XML: the arrays' common store.
    pub(super) appended: Option<Appended>,
}

/// The bytes at the end of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Appended {
    /// Where in the file they begin.
    pub(super) start: usize,
    pub(super) is_base64: bool,
}

impl<'a> Document<'a> {
    /// The type of data, such as `PolyData`, that a file holds whose beginning is given; `None` where it is no VTK file.
    pub fn kind_of(beginning: &[u8]) -> Option<String> {
        let beginning = &beginning[..beginning.len().min(BEGINNING)];
        let text = beginning.strip_prefix(b"\xef\xbb\xbf").unwrap_or(beginning).trim_ascii_start();
        if !text.starts_with(b"<") {
            return None;
        }
        let tag = &text[memmem::find(text, b"<VTKFile")?..];
        let tag = &tag[..=memchr::memchr(b'>', tag)?];
        // The rest of the file is not looked at, so whatever is wrong with it is not, either.
        let element = match Reader::from_str(std::str::from_utf8(tag).ok()?).read_event() {
            Ok(Event::Start(element) | Event::Empty(element)) => Element::of(&element, 0).ok()?,
            _ => return None,
        };
        Some(element.attribute("type").unwrap_or_default().to_owned())
    }

    /// Reads the elements of a whole file. Arrays stay where they are.
    ///
    /// # Errors
    /// [`VtkError`] where the XML is damaged, or arrays are stored in a way that is not known.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, VtkError> {
        // What is appended may be any bytes: it is no XML.
        let end = match memmem::find(bytes, b"<AppendedData") {
            Some(start) => {
                let tag = memchr::memchr(b'>', &bytes[start..]).map(|end| start + end + 1);
                tag.ok_or_else(|| VtkError::new("AppendedData", "the file ends here, expected >"))?
            }
            None => bytes.len(),
        };
        let xml = std::str::from_utf8(&bytes[..end])
            .map_err(|error| VtkError::new(format!("byte {}", error.valid_up_to()), "the XML is not in UTF-8"))?;
        let top = elements(xml)?;
        let nothing = || VtkError::new("end of file", "there is no element VTKFile");
        let file = top.children.into_iter().find(|element| element.name == "VTKFile").ok_or_else(nothing)?;
        let storage = Storage::of(&file).map_err(|problem| file.error(problem))?;
        let appended = file.children_named("AppendedData").next();
        let appended = appended.map(|element| Appended::after(element, bytes, end)).transpose()?;
        Ok(Self { bytes, file, storage, appended })
    }

    /// The type of data, such as `PolyData`.
    pub fn kind(&self) -> &str {
        self.file.attribute("type").unwrap_or_default()
    }

    /// The byte order of binary arrays.
    pub fn byte_order(&self) -> ByteOrder {
        self.storage.byte_order
    }

    /// The element `VTKFile`.
    pub fn file(&self) -> &Element {
        &self.file
    }

    /// The element that holds the data.
    ///
    /// # Errors
    /// [`VtkError`] where there is none, or the data are of another than the `expected` type.
    pub fn data(&self, expected: &str) -> Result<&Element, VtkError> {
        if self.kind() != expected {
            return Err(self.file.error(format!("the file's type is {}, expected {expected}", shown(self.kind()))));
        }
        self.file.child(expected)
    }
}

impl Appended {
    /// The store behind the tag `AppendedData`, which ends at `end`: it begins after an underscore.
    fn after(element: &Element, bytes: &[u8], end: usize) -> Result<Self, VtkError> {
        let underscore = memchr::memchr(b'_', &bytes[end..]);
        let start = end + 1 + underscore.ok_or_else(|| element.error("no underscore follows"))?;
        let is_base64 = match element.attribute("encoding") {
            Some("raw") => false,
            Some("base64") | None => true,
            Some(other) => return Err(element.error(format!("encoding {}, expected raw or base64", shown(other)))),
        };
        Ok(Self { start, is_base64 })
    }
}

/// An element without a name around all elements of the XML.
fn elements(xml: &str) -> Result<Element, VtkError> {
    let mut reader = Reader::from_str(xml);
    // The elements that are open, the outermost first.
    let mut open = vec![Element::default()];
    loop {
        let position = reader.buffer_position();
        let at = |problem: String| VtkError::new(format!("byte {position}"), problem);
        match reader.read_event().map_err(|error| at(error.to_string()))? {
            Event::Start(_) if open.len() > DEEPEST => return Err(at("elements are nested too deep".into())),
            Event::Start(element) => open.push(Element::of(&element, position).map_err(at)?),
            Event::Empty(element) => {
                let element = Element::of(&element, position).map_err(at)?;
                open.last_mut().expect("the outermost stays open").children.push(element);
            }
            Event::Text(text) if !text.trim_ascii().is_empty() => {
                let range = position as usize..reader.buffer_position() as usize;
                open.last_mut().expect("the outermost stays open").text.push(range);
            }
            // The XML may break off before its appended data: so may the elements around them.
            Event::End(_) => close(&mut open),
            Event::Eof => {
                while open.len() > 1 {
                    close(&mut open);
                }
                return Ok(open.swap_remove(0));
            }
            _ => {}
        }
    }
}

/// Gives the innermost of the open elements to the one around it.
fn close(open: &mut Vec<Element>) {
    if open.len() > 1 {
        let element = open.pop().expect("more than one is open");
        open.last_mut().expect("the outermost stays open").children.push(element);
    }
}

impl Element {
    fn of(element: &BytesStart<'_>, position: u64) -> Result<Self, String> {
        let attribute = |attribute: Result<quick_xml::events::attributes::Attribute<'_>, _>| {
            let attribute = attribute.map_err(|error: quick_xml::events::attributes::AttrError| error.to_string())?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| error.to_string())?;
            Ok::<_, String>((attribute.key.as_ref().to_owned(), value.to_string()))
        };
        let attributes = element.attributes().map(attribute).collect::<Result<_, _>>()?;
        Ok(Self { name: element.name().as_ref().to_owned(), position, attributes, ..Self::default() })
    }
}
