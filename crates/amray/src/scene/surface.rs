//! Surfaces in a scene, beside and inside volumes.

use amray_mesh::Mesh;

use super::Material;
use crate::Volume;
use crate::appearance::TransferFunction;

/// A surface.
#[derive(Clone, Debug)]
pub struct Surface<'a> {
    /// Where it is.
    pub shape: Shape<'a>,
    /// Its colour.
    pub paint: Paint<'a>,
    /// From 0, not there, to 1, nothing behind it is seen.
    pub opacity: f32,
    /// How it reflects light; without one it shows its colours as they are.
    pub material: Option<Material>,
    /// Whether it dims light that goes through it.
    pub casts_shadows: bool,
}

/// Where a surface is.
#[derive(Clone, Copy, Debug)]
pub enum Shape<'a> {
    /// Where the scene's volume has this value, to the reconstruction; faces over which values jump from one side of it
    /// to the other belong to it.
    Isosurface(f64),
    /// A plane, as far as the domain goes.
    Slice {
        /// A point on it, in world units.
        point: [f64; 3],
        /// Across it: of any length but 0.
        normal: [f64; 3],
    },
    /// Triangles, inside or outside of the volume.
    Mesh(&'a Mesh),
}

/// What colour a surface has.
#[derive(Clone, Debug)]
pub enum Paint<'a> {
    /// A mesh's own colours and opacities, white where it has none; other shapes are white.
    Own,
    /// The same all over: red, green and blue.
    Plain([f32; 3]),
    /// The colours that a transfer function gives to a field's values there; nothing where there is no value.
    Field(&'a Volume, TransferFunction),
}

impl<'a> Surface<'a> {
    /// An opaque isosurface that reflects light.
    pub fn isosurface(value: f64, paint: Paint<'a>) -> Self {
        Self {
            shape: Shape::Isosurface(value),
            paint,
            opacity: 1.0,
            material: Some(Material::default()),
            casts_shadows: true,
        }
    }

    /// A mesh in its own colours that reflects light.
    pub fn mesh(mesh: &'a Mesh) -> Self {
        Self {
            shape: Shape::Mesh(mesh),
            paint: Paint::Own,
            opacity: 1.0,
            material: Some(Material::default()),
            casts_shadows: true,
        }
    }

    /// An opaque slice that shows colours as they are.
    pub fn slice(point: [f64; 3], normal: [f64; 3], paint: Paint<'a>) -> Self {
        Self { shape: Shape::Slice { point, normal }, paint, opacity: 1.0, material: None, casts_shadows: true }
    }
}
