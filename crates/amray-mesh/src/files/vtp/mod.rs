//! VTK PolyData (`.vtp`): an XML document of pieces with arrays, which are text, base64, or bytes at the file's end.
//!
//! Read are the points, the polygons and strips, the points' normals, and their colours: three or four bytes a point,
//! as the active scalars or under a name such as `RGB`.

mod piece;
mod surface;

use amray_encoding::vtk::{Document, VtkError};

use super::error::Problem;
use crate::MeshDescription;
use piece::Piece;
use surface::Surface;

/// The type of data that is read.
const KIND: &str = "PolyData";

pub(super) fn recognises(bytes: &[u8]) -> bool {
    Document::kind_of(bytes).is_some()
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshDescription, Problem> {
    let document = Document::parse(bytes)?;
    let mut surface = Surface::default();
    for (number, piece) in document.data(KIND)?.children_named("Piece").enumerate() {
        surface
            .add(&Piece::of(piece, &document)?, &document)
            .map_err(|(array, problem)| Problem::new(format!("piece {}, {array}", number + 1), problem))?;
    }
    Ok(surface.mesh())
}

impl From<VtkError> for Problem {
    fn from(VtkError { place, problem }: VtkError) -> Self {
        Self::new(place, problem)
    }
}

#[cfg(test)]
mod tests;
