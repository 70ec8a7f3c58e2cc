//! What can be wrong with the description of a mesh.

use thiserror::Error;

/// A mesh that cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshError {
    /// A vertex that is nowhere.
    #[error("vertex {vertex} is at ({}, {}, {}), expected finite numbers", position[0], position[1], position[2])]
    VertexNotFinite {
        /// Its place in the list of vertices.
        vertex: usize,
        /// What was given.
        position: [f64; 3],
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {index}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// Its place in the list of triangles.
        triangle: usize,
        /// The vertex it refers to.
        index: u32,
        /// How many there are.
        vertices: usize,
    },
    /// Not one colour per vertex.
    #[error("there are {colors} colours for {vertices} vertices, expected one per vertex")]
    ColorCount {
        /// How many colours were given.
        colors: usize,
        /// How many vertices were given.
        vertices: usize,
    },
    /// Not one normal per vertex.
    #[error("there are {normals} normals for {vertices} vertices, expected one per vertex")]
    NormalCount {
        /// How many normals were given.
        normals: usize,
        /// How many vertices were given.
        vertices: usize,
    },
    /// A colour that cannot be shown.
    #[error("the colour of vertex {vertex} is {color:?}, expected finite numbers and an alpha from 0 to 1")]
    Color {
        /// The vertex.
        vertex: usize,
        /// What was given.
        color: [f32; 4],
    },
    /// More triangles than can be numbered.
    #[error("there are {triangles} triangles, expected at most {most}")]
    TooManyTriangles {
        /// How many were given.
        triangles: usize,
        /// How many there may be.
        most: usize,
    },
}
