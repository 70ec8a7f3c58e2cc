//! The dual cell of a level around a point: eight corners, their hats and their closest existing cells.

use super::Sampler;
use super::number::{Number, WeightedMean};
use crate::hierarchy::Voxel;
use crate::index::{Found, Planes};

/// One corner of a dual cell.
pub(super) struct Corner<N> {
    /// The weight of the corner's hat at the point; 0 only where its slopes take part too.
    pub(super) hat: N,
    /// The logical cell, moved into the domain.
    pub(super) cell: [i64; 3],
    /// Whether the logical cell lay in the domain to begin with.
    pub(super) in_domain: bool,
    /// Its closest existing cell; `None` next to a hole.
    pub(super) closest: Option<Found>,
}

/// The trilinear value of one level.
pub(super) struct Lerp<N> {
    /// The hat-weighted mean of the corners' closest existing cells; NaN where no corner has one.
    pub(super) value: N,
    /// The share of the weight that actual corners carry: 0 to 1.
    pub(super) actual: N,
}

/// How the weight of a dual cell is shared by actual and virtual corners.
pub(super) struct ActualShare<N> {
    actual: N,
    missing: N,
}

impl<N: Number> ActualShare<N> {
    pub(super) fn new() -> Self {
        Self { actual: N::constant(0.0), missing: N::constant(0.0) }
    }

    pub(super) fn add(&mut self, hat: N, is_actual: bool) {
        *(if is_actual { &mut self.actual } else { &mut self.missing }) += hat;
    }

    /// The share of actual corners: exactly 0 where there are none, exactly 1 where there are no others.
    pub(super) fn actual(&self) -> N {
        if self.missing.value() == 0.0 { N::constant(1.0) - self.missing } else { self.actual }
    }
}

/// The weights of the low and of the high end of a unit interval that lies along `axis`, at `share` of the way, where
/// the share grows by `slope` per cell of the finest level.
pub(super) fn linear_weights<N: Number>(axis: usize, share: f64, slope: f64) -> [N; 2] {
    [N::along(axis, 1.0 - share, -slope), N::along(axis, share, slope)]
}

/// The trilinear weight of a corner (x + 2 y + 4 z, 0 low and 1 high per axis).
pub(super) fn hat<N: Number>(weights: &[[N; 2]; 3], corner: usize) -> N {
    weights[0][corner & 1] * weights[1][corner >> 1 & 1] * weights[2][corner >> 2]
}

impl<T: Voxel> Sampler<'_, T> {
    /// Calls `visit` with each corner of the dual cell of `level` around the point that carries weight. On a face
    /// between dual cells that is the one on the high side.
    pub(super) fn for_each_corner<N: Number>(&self, level: usize, point: [f64; 3], mut visit: impl FnMut(Corner<N>)) {
        let description = self.level(level);
        let domain = description.domain();
        let mut planes = Planes { cells: [[0; 2]; 3], active: 0 };
        let mut weights = [[N::constant(0.0); 2]; 3];
        let mut in_domain = [[true; 2]; 3];
        for axis in 0..3 {
            let size = description.finest_cells()[axis] as f64;
            let position = point[axis] / size - 0.5;
            let base = position.floor();
            weights[axis] = linear_weights(axis, position - base, 1.0 / size);
            for side in 0..2 {
                let cell = base as i64 + side as i64;
                planes.cells[axis][side] = cell.clamp(domain.low[axis], domain.high[axis] - 1);
                in_domain[axis][side] = planes.cells[axis][side] == cell;
                planes.active |= u8::from(!weights[axis][side].is_zero()) << (2 * axis + side);
            }
        }
        self.index.find_dual(level, &planes, &mut |corner, closest| {
            let side = |axis: usize| corner >> axis & 1;
            visit(Corner {
                hat: hat(&weights, corner),
                cell: std::array::from_fn(|axis| planes.cells[axis][side(axis)]),
                in_domain: (0..3).all(|axis| in_domain[axis][side(axis)]),
                closest,
            });
        });
    }

    /// The trilinear value of `level` at the point. Corners without an existing cell are left out of the mean.
    pub(super) fn lerp<N: Number>(&self, level: usize, point: [f64; 3]) -> Lerp<N> {
        let mut mean = WeightedMean::new();
        let mut share = ActualShare::new();
        self.for_each_corner(level, point, |corner: Corner<N>| {
            share.add(corner.hat, corner.closest.is_some_and(|found| found.level == level));
            if let Some(found) = corner.closest {
                mean.add(corner.hat, self.value(&found));
            }
        });
        Lerp { value: mean.mean(), actual: share.actual() }
    }
}
