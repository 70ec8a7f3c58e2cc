//! VTK PolyData (`.vtp`): an XML document of pieces with arrays, which are text, base64, or bytes at the file's end.
//!
//! Read are the points, the polygons and strips, the points' normals, and their colours: three or four bytes a point,
//! as the active scalars or under a name such as `RGB`.

mod array;
mod document;
mod stream;
mod surface;

use super::error::Problem;
use crate::MeshDescription;
use document::Document;
use surface::Surface;

/// The document's element begins within so many bytes.
const BEGINNING: usize = 4096;

pub(super) fn recognises(bytes: &[u8]) -> bool {
    let beginning = &bytes[..bytes.len().min(BEGINNING)];
    let text = beginning.strip_prefix(b"\xef\xbb\xbf").unwrap_or(beginning).trim_ascii_start();
    text.starts_with(b"<") && document::find(text, b"<VTKFile").is_some()
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshDescription, Problem> {
    let document = Document::parse(bytes)?;
    let mut surface = Surface::default();
    for (number, piece) in document.pieces.iter().enumerate() {
        surface
            .add(piece, &document)
            .map_err(|(array, problem)| Problem::new(format!("piece {}, {array}", number + 1), problem))?;
    }
    Ok(surface.mesh())
}

#[cfg(test)]
mod tests;
