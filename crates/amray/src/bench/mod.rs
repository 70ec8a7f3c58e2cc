//! What benchmarks need of the inside: kernels that have no public face. No part of the library's interface.

mod integration;
mod region;

pub use integration::Integrator;
pub use region::RegionSampler;

use crate::Volume;
use crate::hierarchy::Normalisation;
use crate::layout::PaddedField;

/// Makes the padded copy of a volume's values, with those of `range` from 0 to 1, and drops it; how many there are.
pub fn padded_values(volume: &Volume, range: [f64; 2]) -> usize {
    PaddedField::with(volume, Normalisation::of_range(range)).len()
}
