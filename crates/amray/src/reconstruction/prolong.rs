//! Prolong: virtual corners take the coarser levels' continuous function, as AMR codes fill ghost cells.

use super::Sampler;
use super::dual_cell::{ActualShare, Corner};
use super::number::{Number, WeightedMean};
use crate::hierarchy::Voxel;

impl<T: Voxel> Sampler<'_, T> {
    /// f_l = a_l g_l + (1 - a_l) f_(l-1), where g_l is trilinear on the actual cells of `level` and, at virtual
    /// corners, on the values that f_(l-1) has at their centres. `None` where no level up to `level` has a value.
    pub(super) fn prolong<N: Number>(&self, level: usize, point: [f64; 3]) -> Option<N> {
        let mut mean = WeightedMean::new();
        let mut share = ActualShare::new();
        let mut virtual_corners = [([0i64; 3], N::constant(0.0)); 8];
        let mut virtual_count = 0;
        self.for_each_corner(level, point, |corner: Corner<N>| {
            let actual = corner.closest.filter(|found| found.level == level);
            share.add(corner.hat, actual.is_some());
            if let Some(found) = actual {
                mean.add(corner.hat, self.value(&found));
            } else {
                virtual_corners[virtual_count] = (corner.cell, corner.hat);
                virtual_count += 1;
            }
        });
        if virtual_count == 0 {
            return Some(mean.mean());
        }
        let actual = share.actual();
        let coarser = self.prolong_below(level, point);
        if actual.is_zero() {
            return coarser;
        }
        let finest_cells = self.level(level).finest_cells();
        for (cell, hat) in &virtual_corners[..virtual_count] {
            let center = std::array::from_fn(|axis| (cell[axis] as f64 + 0.5) * finest_cells[axis] as f64);
            if let Some(value) = self.prolong_below(level, center) {
                mean.add(*hat, value);
            }
        }
        let own = mean.mean();
        match coarser {
            Some(coarser) => Some(actual.weigh(own) + (N::constant(1.0) - actual).weigh(coarser)),
            None => (actual.value() > 0.0).then_some(own),
        }
    }

    /// f_(level - 1).
    fn prolong_below<N: Number>(&self, level: usize, point: [f64; 3]) -> Option<N> {
        level.checked_sub(1).and_then(|coarser| self.prolong(coarser, point))
    }
}
