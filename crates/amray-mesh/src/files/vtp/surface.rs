//! From the arrays of pieces to one mesh.

use amray_encoding::NumberType;
use amray_encoding::vtk::{DataArray, Document};

use super::super::number::vertex_numbers;
use super::super::polygon::{fan, strip};
use super::piece::{Piece, Section};
use crate::MeshDescription;

/// Names under which programs write colours, in small letters.
const COLOR_NAMES: [&str; 6] = ["rgb", "rgba", "color", "colors", "colour", "colours"];

/// The pieces so far.
#[derive(Debug, Default)]
pub(super) struct Surface {
    mesh: MeshDescription,
}

/// What is wrong, in words, and with what.
type ArrayProblem = (String, String);

impl Surface {
    /// Adds a piece.
    ///
    /// # Errors
    /// What is wrong with which array.
    pub(super) fn add(&mut self, piece: &Piece, document: &Document<'_>) -> Result<(), ArrayProblem> {
        let points = u128::from(piece.points);
        if points == 0 {
            return Ok(());
        }
        let mesh = &mut self.mesh;
        let before = mesh.vertices.len();
        let positions = piece.array("Points", |section, array| section == Section::Points && array.components == 3)?;
        let positions = values(Section::Points, positions, document, 3 * points)?;
        mesh.vertices.extend(positions.as_chunks::<3>().0);
        // Where only some pieces have normals or colours, the others have what counts as none.
        if let Some(array) = piece.normals() {
            let normals = mesh.normals.get_or_insert_default();
            normals.resize(before, [0.0; 3]);
            normals.extend(values(Section::PointData, array, document, 3 * points)?.as_chunks::<3>().0);
        }
        if let Some(array) = piece.colors() {
            let values = values(Section::PointData, array, document, u128::from(array.components) * points)?;
            let colors = mesh.colors.get_or_insert_default();
            colors.resize(before, [1.0; 4]);
            colors.extend(values.chunks_exact(array.components as usize).map(|color| {
                let component = |place: usize| color.get(place).map_or(1.0, |&value| (value / 255.0) as f32);
                [0, 1, 2, 3].map(component)
            }));
        }
        mesh.normals.iter_mut().for_each(|normals| normals.resize(mesh.vertices.len(), [0.0; 3]));
        mesh.colors.iter_mut().for_each(|colors| colors.resize(mesh.vertices.len(), [1.0; 4]));

        for_each_cell(piece, document, Section::Polys, piece.polys, before, |corners| {
            mesh.triangles.extend(fan(corners));
        })?;
        for_each_cell(piece, document, Section::Strips, piece.strips, before, |corners| {
            mesh.triangles.extend(strip(corners));
        })
    }

    pub(super) fn mesh(self) -> MeshDescription {
        self.mesh
    }
}

impl Piece {
    fn array(&self, name: &str, is: impl Fn(Section, &DataArray) -> bool) -> Result<&DataArray, ArrayProblem> {
        let found = self.arrays.iter().find(|(section, array)| is(*section, array));
        found.map(|(_, array)| array).ok_or_else(|| (name.into(), "there is no such array".into()))
    }

    /// The arrays of values at points.
    fn point_data(&self) -> impl Iterator<Item = &DataArray> {
        self.arrays.iter().filter(|(section, _)| *section == Section::PointData).map(|(_, array)| array)
    }

    fn normals(&self) -> Option<&DataArray> {
        let name = if self.normals.is_empty() { "Normals" } else { &self.normals };
        self.point_data().find(|array| array.components == 3 && array.name == *name)
    }

    fn colors(&self) -> Option<&DataArray> {
        let are_colors =
            |array: &&DataArray| array.number == NumberType::U8 && (array.components == 3 || array.components == 4);
        let colors = || self.point_data().filter(are_colors);
        let has_name = |array: &&DataArray| COLOR_NAMES.contains(&array.name.to_lowercase().as_str());
        colors().find(|array| array.name == self.scalars).or_else(|| colors().find(has_name))
    }
}

fn values(
    section: Section,
    array: &DataArray,
    document: &Document<'_>,
    expected: u128,
) -> Result<Vec<f64>, ArrayProblem> {
    let described = || match section {
        Section::Points => "Points".into(),
        section => format!("{section:?}, array {:?}", array.name),
    };
    array.values(document, expected, |value| value).map_err(|problem| (described(), problem))
}

/// Shows `meet` the corners of each cell, as indices of the mesh. The points of the piece begin at `first`.
fn for_each_cell(
    piece: &Piece,
    document: &Document<'_>,
    section: Section,
    cells: u64,
    first: usize,
    mut meet: impl FnMut(&[u32]),
) -> Result<(), ArrayProblem> {
    if cells == 0 {
        return Ok(());
    }
    let place = |name: &str| format!("{section:?}, array {name:?}");
    let array = |name| piece.array(&place(name), |other, array| other == section && array.name == name);
    let of_offsets = |problem| (place("offsets"), problem);
    let offsets = values(section, array("offsets")?, document, u128::from(cells))?;
    // The last corner's end is the number of all.
    let ends =
        vertex_numbers(&offsets).map_err(|problem| of_offsets(problem.replace("the number of a vertex", "an end")))?;
    let corners = values(section, array("connectivity")?, document, u128::from(ends.last().copied().unwrap_or(0)))?;
    let mut corners = vertex_numbers(&corners).map_err(|problem| (place("connectivity"), problem))?;
    for corner in &mut corners {
        let mesh_corner = u64::from(*corner) + first as u64;
        *corner = u32::try_from(mesh_corner)
            .ok()
            .filter(|_| u64::from(*corner) < piece.points)
            .ok_or_else(|| (place("connectivity"), format!("{corner}, expected one of {} points", piece.points)))?;
    }
    let mut start = 0;
    for end in ends {
        let cell = corners.get(start..end as usize);
        meet(cell.ok_or_else(|| of_offsets(format!("{end} after {start}, expected no smaller number")))?);
        start = end as usize;
    }
    Ok(())
}
