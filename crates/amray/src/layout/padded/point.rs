//! One sample at a time, where a region's brick alone is enough.

use super::Padded;
use crate::reconstruction::Method;

impl Padded {
    /// The value at a point of a region, in cells of the finest level, where the region's brick alone is enough and all
    /// corners are finite; there most methods are trilinear. `None` elsewhere.
    #[inline]
    pub(crate) fn trilinear(&self, region: usize, point: [f64; 3]) -> Option<f64> {
        if matches!(self.plan.method, Method::Nearest | Method::Finest) {
            return None;
        }
        let region = &self.plan.regions[region];
        let size = &self.plan.finest_cells[usize::from(region.frame.level?)];
        let strides = [1, region.brick.strides[0] as usize, region.brick.strides[1] as usize];
        let (mut base, mut shares) = (0, [0.0; 3]);
        for axis in 0..3 {
            let place = point[axis] / size[axis] - region.frame.low[axis];
            let [low, high] = [0, 1].map(|end| f64::from(region.frame.pure[end][axis]));
            if !(low <= place && place <= high) {
                return None;
            }
            let cell = (place as usize).min(region.brick.cells[axis] as usize);
            base += cell * strides[axis];
            shares[axis] = place - cell as f64;
        }
        let values = self.field.brick(&region.brick);
        let mix = |low: f64, high: f64, share: f64| low + (high - low) * share;
        let along_x = |start: usize| mix(f64::from(values[start]), f64::from(values[start + 1]), shares[0]);
        let along_y = |start: usize| mix(along_x(start), along_x(start + strides[1]), shares[1]);
        let value = mix(along_y(base), along_y(base + strides[2]), shares[2]);
        value.is_finite().then(|| self.field.normalisation.undo_exactly(value))
    }
}
