//! Prolong: virtual corners take the coarser levels' continuous function, as AMR codes fill ghost cells.

use super::Sampler;
use crate::hierarchy::Voxel;

impl<T: Voxel> Sampler<'_, T> {
    /// f_l = a_l g_l + (1 - a_l) f_(l-1), where g_l is trilinear on the actual cells of `level` and, at virtual
    /// corners, on the values that f_(l-1) has at their centres. `None` where no level up to `level` has a value.
    pub(crate) fn prolong(&self, level: usize, point: [f64; 3]) -> Option<f64> {
        let (mut sum, mut weight, mut actual) = (0.0, 0.0, 0.0);
        let mut virtual_corners = [([0i64; 3], 0.0); 8];
        let mut virtual_count = 0;
        self.for_each_corner(level, point, |corner| match corner.closest {
            Some(found) if found.level == level => {
                sum += corner.hat * self.value(&found);
                weight += corner.hat;
                actual += corner.hat;
            }
            _ => {
                virtual_corners[virtual_count] = (corner.cell, corner.hat);
                virtual_count += 1;
            }
        });
        if virtual_count == 0 {
            return Some(sum / weight);
        }
        let coarser = |point| level.checked_sub(1).and_then(|coarser| self.prolong(coarser, point));
        if actual == 0.0 {
            return coarser(point);
        }
        let finest_cells = self.level(level).finest_cells();
        for (cell, hat) in &virtual_corners[..virtual_count] {
            let center = std::array::from_fn(|axis| (cell[axis] as f64 + 0.5) * finest_cells[axis] as f64);
            if let Some(value) = coarser(center) {
                sum += hat * value;
                weight += hat;
            }
        }
        let own = sum / weight;
        Some(coarser(point).map_or(own, |coarser| actual * own + (1.0 - actual) * coarser))
    }
}
