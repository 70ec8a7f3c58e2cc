//! Basis: the hats of all leaf cells of all levels, normalised.

use super::Sampler;
use crate::hierarchy::Voxel;
use crate::index::Region;

impl<T: Voxel> Sampler<'_, T> {
    /// sum(hat v) / sum(hat) over all leaf cells. Only levels in reach of the region can contribute.
    pub(super) fn basis(&self, region: &Region, point: [f64; 3]) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for level in region.coarsest_in_reach()..=region.finest_in_reach() {
            self.for_each_corner(level, point, |corner| {
                let Some(found) = corner.closest else { return };
                if corner.in_domain && found.level == level && !found.covered {
                    sum += corner.hat * self.value(&found);
                    weight += corner.hat;
                }
            });
        }
        sum / weight
    }
}
