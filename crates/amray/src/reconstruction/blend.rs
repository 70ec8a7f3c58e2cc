//! Blend: every level's trilinear value, weighed by how much of its dual cell is actual.

use super::Sampler;
use crate::hierarchy::Voxel;
use crate::index::Region;

impl<T: Voxel> Sampler<'_, T> {
    /// The recurrence f = a_l lerp_l + (1 - a_l) f over the levels, coarse to fine, evaluated from the finest level in
    /// reach down: what is left of the weight goes to coarser levels until one is all actual. The coarsest level with
    /// actual corners takes all that is left.
    pub(super) fn blend(&self, region: &Region, point: [f64; 3]) -> f64 {
        let (mut sum, mut left) = (0.0, 1.0);
        let mut coarsest = f64::NAN;
        for level in (0..=region.finest_in_reach()).rev() {
            let lerp = self.lerp(level, point);
            if lerp.actual > 0.0 {
                sum += left * lerp.actual * lerp.value;
                left *= 1.0 - lerp.actual;
                coarsest = lerp.value;
            }
            if left == 0.0 {
                return sum;
            }
        }
        sum + left * coarsest
    }
}
