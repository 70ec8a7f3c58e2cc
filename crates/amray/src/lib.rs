//! amray shows adaptive-mesh-refinement (AMR) simulation data directly, on CPUs, without resampling it.
//!
//! It implements Wald, Brownlee, Usher, Knoll, *CPU Volume Rendering of Adaptive Mesh Refinement Data* (SIGGRAPH Asia
//! 2017 Symposium on Visualization). Data goes one way through the modules: a [`hierarchy::Hierarchy`] of bricks and a
//! [`hierarchy::Field`] over it become, with an [`index::Index`] and a [`reconstruction::Method`], a [`Volume`]; a
//! [`scene::Scene`] adds how it looks ([`appearance`]) and from where; [`render::render`] makes a [`render::Film`] of
//! it.
//!
//! ```
//! use std::sync::Arc;
//!
//! use amray::Volume;
//! use amray::appearance::{ColorMap, Opacity, OpacityPoint, Scale, TransferFunction};
//! use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
//! use amray::index::Index;
//! use amray::reconstruction::Method;
//! use amray::render::{RenderOptions, render};
//! use amray::scene::{Camera, Scene, Viewpoint};
//!
//! // A cube of 8^3 cells, its middle refined by 2.
//! let coarse = LevelDescription {
//!     ratio: [1; 3],
//!     cell_size: [0.125; 3],
//!     domain: IndexBox::new([0; 3], [8; 3]),
//!     bricks: vec![IndexBox::new([0; 3], [8; 3])],
//! };
//! let fine = LevelDescription {
//!     ratio: [2; 3],
//!     cell_size: [0.0625; 3],
//!     domain: IndexBox::new([0; 3], [16; 3]),
//!     bricks: vec![IndexBox::new([4; 3], [12; 3])],
//! };
//! let hierarchy = Arc::new(Hierarchy::new([0.0; 3], vec![coarse, fine])?);
//!
//! // One value per cell: here the distance from the middle, at the cells' centres.
//! let field = Field::from_fn("distance", &hierarchy, |level, cell| {
//!     let center = hierarchy.to_world(level, cell.map(|index| index as f64 + 0.5));
//!     center.map(|x| (x - 0.5) * (x - 0.5)).iter().sum::<f64>().sqrt()
//! });
//! let volume = Volume::new(Arc::new(Index::build(hierarchy)), field, Method::Basis);
//! let value = volume.sample(&[[0.65, 0.5, 0.5]])[0];
//! assert!((value - 0.15).abs() < 0.01);
//!
//! // A picture of a shell of it.
//! let point = |value, opacity| OpacityPoint { value, opacity };
//! let shell = Opacity::PerUnitDistance(vec![point(0.2, 0.0), point(0.25, 0.1), point(0.3, 0.0)]);
//! let function = TransferFunction::from_color_map(ColorMap::Viridis, [0.0, 0.5], Scale::Linear, shell)?;
//! let camera = Camera::new(Viewpoint::framing(volume.hierarchy().bounds(), 30.0, 1.0))?;
//! let scene = Scene::new(&volume, function, 0.01, camera);
//! let options = RenderOptions { size: [64, 64], ..RenderOptions::default() };
//! let (film, _) = render(&scene, &options, &|_| {});
//! assert!(film.pixels()[32 * 64 + 32][3] > 0.3 && film.pixels()[0][3] == 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod appearance;
#[doc(hidden)]
pub mod bench;
pub mod hierarchy;
pub mod index;
mod layout;
pub mod reconstruction;
pub mod render;
pub mod scene;
pub mod simd;
mod volume;

pub use volume::{LeafCell, Volume};
