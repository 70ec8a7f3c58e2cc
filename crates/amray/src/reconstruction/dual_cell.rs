//! The dual cell of a level around a point: eight corners, their hats and their closest existing cells.

use super::Sampler;
use crate::hierarchy::Voxel;
use crate::index::{Found, Planes};

/// One corner of a dual cell.
pub(super) struct Corner {
    /// The weight of the corner's hat at the point; never 0.
    pub(super) hat: f64,
    /// The logical cell, moved into the domain.
    pub(super) cell: [i64; 3],
    /// Whether the logical cell lay in the domain to begin with.
    pub(super) in_domain: bool,
    /// Its closest existing cell; `None` next to a hole.
    pub(super) closest: Option<Found>,
}

/// The trilinear value of one level.
pub(super) struct Lerp {
    /// The hat-weighted mean of the corners' closest existing cells; NaN where no corner has one.
    pub(super) value: f64,
    /// The share of the weight that actual corners carry: 0 to 1.
    pub(super) actual: f64,
}

impl<T: Voxel> Sampler<'_, T> {
    /// Calls `visit` with each corner of the dual cell of `level` around the point that carries weight.
    pub(super) fn for_each_corner(&self, level: usize, point: [f64; 3], mut visit: impl FnMut(Corner)) {
        let description = self.level(level);
        let domain = description.domain();
        let mut planes = Planes { cells: [[0; 2]; 3], active: 0 };
        let mut weights = [[0.0; 2]; 3];
        let mut in_domain = [[true; 2]; 3];
        for axis in 0..3 {
            let position = point[axis] / description.finest_cells()[axis] as f64 - 0.5;
            let base = position.floor();
            weights[axis] = [1.0 - (position - base), position - base];
            for side in 0..2 {
                let cell = base as i64 + side as i64;
                planes.cells[axis][side] = cell.clamp(domain.low[axis], domain.high[axis] - 1);
                in_domain[axis][side] = planes.cells[axis][side] == cell;
                planes.active |= u8::from(weights[axis][side] > 0.0) << (2 * axis + side);
            }
        }
        self.index.find_dual(level, &planes, &mut |corner, closest| {
            let side = |axis: usize| corner >> axis & 1;
            visit(Corner {
                hat: (0..3).map(|axis| weights[axis][side(axis)]).product(),
                cell: std::array::from_fn(|axis| planes.cells[axis][side(axis)]),
                in_domain: (0..3).all(|axis| in_domain[axis][side(axis)]),
                closest,
            });
        });
    }

    /// The trilinear value of `level` at the point. Corners without an existing cell are left out of the mean.
    pub(super) fn lerp(&self, level: usize, point: [f64; 3]) -> Lerp {
        let (mut sum, mut weight, mut actual) = (0.0, 0.0, 0.0);
        let mut all_actual = true;
        self.for_each_corner(level, point, |corner| {
            let is_actual = corner.closest.is_some_and(|found| found.level == level);
            all_actual &= is_actual;
            if let Some(found) = corner.closest {
                sum += corner.hat * self.value(&found);
                weight += corner.hat;
                actual += if is_actual { corner.hat } else { 0.0 };
            }
        });
        Lerp { value: sum / weight, actual: if all_actual { 1.0 } else { actual } }
    }
}
