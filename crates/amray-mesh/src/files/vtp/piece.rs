//! A part of the surface with points of its own.

use amray_encoding::vtk::{DataArray, Document, Element, VtkError};

/// A piece and its arrays, which have not been decoded.
#[derive(Debug)]
pub(super) struct Piece {
    pub(super) points: u64,
    pub(super) polys: u64,
    pub(super) strips: u64,
    /// The name of the active scalars.
    pub(super) scalars: String,
    /// The name of the active normals.
    pub(super) normals: String,
    pub(super) arrays: Vec<(Section, DataArray)>,
}

/// What an array belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Section {
    Points,
    Polys,
    Strips,
    PointData,
}

impl Piece {
    pub(super) fn of(element: &Element, document: &Document<'_>) -> Result<Self, VtkError> {
        let count = |name| Ok::<_, VtkError>(element.number(name)?.unwrap_or(0));
        let mut arrays = Vec::new();
        let point_data = element.children_named("PointData").next();
        for child in element.children() {
            let Some(section) = Section::of(child) else { continue };
            for array in child.children() {
                arrays.extend(DataArray::of(array, document)?.map(|array| (section, array)));
            }
        }
        let active = |name| point_data.and_then(|data| data.attribute(name)).unwrap_or_default().to_owned();
        Ok(Self {
            points: count("NumberOfPoints")?,
            polys: count("NumberOfPolys")?,
            strips: count("NumberOfStrips")?,
            scalars: active("Scalars"),
            normals: active("Normals"),
            arrays,
        })
    }
}

impl Section {
    fn of(element: &Element) -> Option<Self> {
        match element.name() {
            "Points" => Some(Self::Points),
            "Polys" => Some(Self::Polys),
            "Strips" => Some(Self::Strips),
            "PointData" => Some(Self::PointData),
            _ => None,
        }
    }
}
