//! Blend: every level's trilinear value, weighed by how much of its dual cell is actual.

use super::Sampler;
use super::number::Number;
use crate::hierarchy::Voxel;
use crate::index::Region;

impl<T: Voxel> Sampler<'_, T> {
    /// The recurrence f = a_l lerp_l + (1 - a_l) f over the levels, coarse to fine, evaluated from the finest level in
    /// reach down: what is left of the weight goes to coarser levels until one is all actual. The coarsest level with
    /// actual corners takes all that is left.
    pub(super) fn blend<N: Number>(&self, region: &Region, point: [f64; 3]) -> N {
        let (mut sum, mut left) = (N::constant(0.0), N::constant(1.0));
        let mut coarsest = N::constant(f64::NAN);
        for level in (0..=region.finest_in_reach()).rev() {
            let lerp = self.lerp::<N>(level, point);
            if !lerp.actual.is_zero() {
                sum += (left * lerp.actual).weigh(lerp.value);
                left = left * (N::constant(1.0) - lerp.actual);
                // A level whose weight only begins at the point has a slope there, but no value yet.
                if lerp.actual.value() > 0.0 {
                    coarsest = lerp.value;
                }
            }
            if left.is_zero() {
                return sum;
            }
        }
        sum + left.weigh(coarsest)
    }
}
