//! From a PLY file's numbers to vertices and triangles.

use super::super::number::{full_color, vertex_numbers};
use super::super::polygon::{fan, strip};
use super::header::Element;
use crate::MeshDescription;

/// What was read so far.
#[derive(Debug, Default)]
pub(super) struct Surface {
    description: MeshDescription,
}

/// Where the numbers of an element go.
#[derive(Debug)]
pub(super) enum Sink<'a> {
    Vertices(Vertices<'a>),
    /// The property with the numbers of vertices.
    Faces {
        description: &'a mut MeshDescription,
        indices: usize,
    },
    Strips {
        description: &'a mut MeshDescription,
        indices: usize,
    },
    Nowhere,
}

/// Vertices, row by row.
#[derive(Debug)]
pub(super) struct Vertices<'a> {
    description: &'a mut MeshDescription,
    /// Of each property.
    roles: Vec<Role>,
    position: [f64; 3],
    normal: [f64; 3],
    color: [f32; 4],
}

/// What a property of a vertex is.
#[derive(Clone, Copy, Debug)]
enum Role {
    Position(usize),
    Normal(usize),
    /// The component, and the number that stands for all of it.
    Color(usize, f64),
    Other,
}

impl Surface {
    /// Where the numbers of an element go.
    ///
    /// # Errors
    /// What is wrong with the element, in words.
    pub(super) fn sink(&mut self, element: &Element) -> Result<Sink<'_>, String> {
        let description = &mut self.description;
        let indices = || {
            let is_indices = |name: &str| name == "vertex_indices" || name == "vertex_index";
            element.properties.iter().position(|column| column.length.is_some() && is_indices(&column.name))
        };
        Ok(match element.name.as_str() {
            "vertex" => Sink::Vertices(Vertices::new(description, element)?),
            "face" => indices().map_or(Sink::Nowhere, |indices| Sink::Faces { description, indices }),
            "tristrips" => indices().map_or(Sink::Nowhere, |indices| Sink::Strips { description, indices }),
            _ => Sink::Nowhere,
        })
    }

    pub(super) fn mesh(self) -> MeshDescription {
        self.description
    }
}

impl<'a> Vertices<'a> {
    fn new(description: &'a mut MeshDescription, element: &Element) -> Result<Self, String> {
        let has = |name: &str| element.properties.iter().any(|column| column.length.is_none() && column.name == name);
        if let Some(missing) = ["x", "y", "z"].into_iter().find(|name| !has(name)) {
            return Err(format!("there is no property {missing}, expected x, y and z"));
        }
        let has_normals = ["nx", "ny", "nz"].into_iter().all(has);
        let has_colors = ["red", "green", "blue"].into_iter().all(has);
        let role = |name: &str, full: f64| match name {
            "x" => Role::Position(0),
            "y" => Role::Position(1),
            "z" => Role::Position(2),
            "nx" if has_normals => Role::Normal(0),
            "ny" if has_normals => Role::Normal(1),
            "nz" if has_normals => Role::Normal(2),
            "red" if has_colors => Role::Color(0, full),
            "green" if has_colors => Role::Color(1, full),
            "blue" if has_colors => Role::Color(2, full),
            "alpha" if has_colors => Role::Color(3, full),
            _ => Role::Other,
        };
        let roles = element.properties.iter().map(|column| role(&column.name, full_color(column.number))).collect();
        // A second list of vertices takes the place of the first.
        description.normals = has_normals.then(Vec::new);
        description.colors = has_colors.then(Vec::new);
        description.vertices.clear();
        Ok(Self { description, roles, position: [0.0; 3], normal: [0.0; 3], color: [1.0; 4] })
    }
}

impl Sink<'_> {
    /// Takes the number of a property.
    pub(super) fn number(&mut self, property: usize, number: f64) {
        let Self::Vertices(vertices) = self else { return };
        match vertices.roles[property] {
            Role::Position(axis) => vertices.position[axis] = number,
            Role::Normal(axis) => vertices.normal[axis] = number,
            Role::Color(component, full) => vertices.color[component] = (number / full) as f32,
            Role::Other => {}
        }
    }

    /// Takes the list of a property.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn list(&mut self, property: usize, list: &[f64]) -> Result<(), String> {
        match self {
            Self::Faces { description, indices } if *indices == property => {
                description.triangles.extend(fan(&vertex_numbers(list)?));
            }
            Self::Strips { description, indices } if *indices == property => {
                // -1 begins the next strip.
                for part in list.split(|&number| number == -1.0) {
                    description.triangles.extend(strip(&vertex_numbers(part)?));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// All properties of a row are there.
    pub(super) fn end_row(&mut self) {
        let Self::Vertices(vertices) = self else { return };
        let description = &mut *vertices.description;
        description.vertices.push(vertices.position);
        description.normals.iter_mut().for_each(|normals| normals.push(vertices.normal));
        description.colors.iter_mut().for_each(|colors| colors.push(vertices.color));
    }
}
