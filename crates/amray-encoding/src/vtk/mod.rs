//! VTK's XML files: elements whose arrays are text, base64 or bytes behind the XML, compressed in blocks or not.
//!
//! The format is that of the chapter *VTK File Formats* of VTK's documentation, and of what VTK's writers make.

mod array;
mod base64;
mod document;
mod element;
mod storage;

use std::borrow::Cow;

use thiserror::Error;

pub use array::{ArrayLocation, ArrayPlace, DataArray};
pub use document::Document;
pub use element::Element;
pub use storage::{ArrayReader, Encoding};

/// Text as it stands in attributes and between tags.
pub fn escaped(text: &str) -> Cow<'_, str> {
    quick_xml::escape::escape(text)
}

/// What is wrong with a file, and where in it.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{place}: {problem}")]
pub struct VtkError {
    /// An element, an array, a byte.
    pub place: String,
    /// What was found and what was expected.
    pub problem: String,
}

impl VtkError {
    pub(crate) fn new(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { place: place.into(), problem: problem.into() }
    }
}
