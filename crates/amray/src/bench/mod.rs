//! What benchmarks need of the inside: kernels that have no public face. No part of the library's interface.

mod integration;
mod region;

pub use integration::Integrator;
pub use region::RegionSampler;
