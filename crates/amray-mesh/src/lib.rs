//! Triangle meshes: what they are in memory, and where rays meet them.
//!
//! A [`MeshDescription`] is plain vertices and triangles, from a [file](files::open) or made by a program.
//! [`Mesh::new`] checks it and builds a tree of boxes over its triangles; then the mesh answers rays: the
//! [nearest hit](Mesh::nearest), [all hits](Mesh::hits), [what gets through](Mesh::transmittance).
//!
//! ```
//! use amray_mesh::{Mesh, MeshDescription, Ray};
//!
//! let sphere = Mesh::new(MeshDescription::sphere([0.0; 3], 1.0, 64))?;
//! let ray = Ray { origin: [0.1, 0.2, 5.0], direction: [0.0, 0.0, -2.0], from: 0.0, to: f64::INFINITY };
//! let hit = sphere.nearest(&ray).unwrap();
//! assert!((hit.t - 2.0).abs() < 0.05);
//! assert!(hit.normal[2] > 0.9);
//!
//! let mut hits = Vec::new();
//! sphere.hits(&ray, &mut hits);
//! assert_eq!(hits.len(), 2);
//! # Ok::<(), amray_mesh::MeshError>(())
//! ```

mod error;
pub mod files;
mod frame;
mod local_ray;
mod mesh;
mod query;
mod ray;
mod sphere;
mod tree;
mod triangle;

pub use error::MeshError;
pub use mesh::{Mesh, MeshDescription};
pub use ray::{Hit, Ray};
