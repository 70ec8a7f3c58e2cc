//! One level as packets see it: cells counted from the domain's low corner on, in 32 bits.

use super::LaneNumber;
use crate::hierarchy::Level;
use crate::simd::{Divisor, Doubles, Gather, Integers};

/// A level's lattice of cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketLevel {
    /// Cells of the finest level per cell.
    size: [i32; 3],
    divisors: [Divisor; 3],
    scale: [f64; 3],
    /// The domain's last cells.
    last: [i32; 3],
}

impl PacketLevel {
    pub(super) fn new(level: &Level) -> Self {
        let size = level.finest_cells().map(|cells| cells as i32);
        Self {
            size,
            divisors: size.map(|size| Divisor::new(size as u32)),
            scale: size.map(|size| f64::from(size).recip()),
            last: level.domain().size().map(|cells| cells as i32 - 1),
        }
    }

    /// Cells of this level per cell of the finest one.
    #[inline(always)]
    pub(super) fn scale(&self, axis: usize) -> f64 {
        self.scale[axis]
    }

    /// Where places in cells of the finest level are along an axis: in cells of this one above `low`, plus `shift`.
    #[inline(always)]
    pub(super) fn position<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        axis: usize,
        places: Doubles<S>,
        low: f64,
        shift: f64,
    ) -> Doubles<S> {
        if N::HAS_SLOPES {
            // On a cell's centre it matters which dual cell is found: with a third of a place it might be the one below.
            places.divided(simd, low, f64::from(self.size[axis]), shift)
        } else {
            places.scaled(simd, low, self.scale[axis], shift)
        }
    }

    /// The domain's last cell.
    #[inline(always)]
    pub(super) fn last(&self, axis: usize) -> i32 {
        self.last[axis]
    }

    /// Cells of the finest level per cell of this one.
    #[inline(always)]
    pub(super) fn size(&self, axis: usize) -> i32 {
        self.size[axis]
    }

    /// The cells that hold cells of the finest level.
    #[inline(always)]
    pub(super) fn holding<S: Gather>(&self, simd: S, axis: usize, cells: Integers<S>) -> Integers<S> {
        self.divisors[axis].divide(simd, cells)
    }

    /// The cell of the finest level at, or just above, the centre of each cell.
    #[inline(always)]
    pub(super) fn center<S: Gather>(&self, axis: usize, cells: Integers<S>) -> Integers<S> {
        cells * self.size[axis] + self.size[axis] / 2
    }
}
