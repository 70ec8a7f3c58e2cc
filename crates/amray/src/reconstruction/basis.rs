//! Basis: the hats of all leaf cells of all levels, normalised.

use super::Sampler;
use super::dual_cell::Corner;
use super::number::{Number, WeightedMean};
use crate::hierarchy::Voxel;
use crate::index::Region;

impl<T: Voxel> Sampler<'_, T> {
    /// sum(hat v) / sum(hat) over all leaf cells. Only levels in reach of the region can contribute.
    pub(super) fn basis<N: Number>(&self, region: &Region, point: [f64; 3]) -> N {
        let mut mean = WeightedMean::new();
        for level in region.coarsest_in_reach()..=region.finest_in_reach() {
            self.for_each_corner(level, point, |corner: Corner<N>| {
                let Some(found) = corner.closest else { return };
                if corner.in_domain && found.level == level && !found.covered {
                    mean.add(corner.hat, self.value(&found));
                }
            });
        }
        mean.mean()
    }
}
