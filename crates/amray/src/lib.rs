//! amray shows adaptive-mesh-refinement (AMR) simulation data directly, on CPUs, without resampling it.

pub mod appearance;
pub mod hierarchy;
pub mod index;
pub mod reconstruction;
pub mod render;
pub mod scene;
mod volume;

pub use volume::{LeafCell, Volume};
