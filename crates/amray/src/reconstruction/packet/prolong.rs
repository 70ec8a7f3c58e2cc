//! Prolong, for packets: virtual corners take the coarser levels' continuous function, as AMR codes fill ghost cells.

use fearless_simd::prelude::*;

use super::dual_cell::interpolate;
use super::{LaneNumber, Levels, Packet, PacketSampler};
use crate::hierarchy::Voxel;
use crate::simd::{Doubles, Floats, Gather, Integers, LANES, LaneSet, mask_of};

/// The function of one level and all coarser ones.
struct Prolonged<N> {
    values: N,
    /// Where there is a value at all.
    existing: LaneSet,
}

impl<T: Voxel> PacketSampler<'_, T> {
    #[inline(always)]
    pub(super) fn prolong<S: Gather, N: LaneNumber<S>>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S, N>) {
        let mut levels = Levels { of_lanes: packet.reach[1], left: lanes };
        while let Some((level, lanes)) = levels.next(simd) {
            let found = self.prolong_at::<S, N>(simd, level, &packet.points, lanes);
            packet.values = N::select(mask_of(simd, lanes & found.existing), found.values, packet.values);
        }
    }

    /// f_l = a_l g_l + (1 - a_l) f_(l-1), where g_l is trilinear on the actual cells of `level` and, at virtual corners,
    /// on the values that f_(l-1) has at their centres.
    #[inline(never)]
    fn prolong_at<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        level: usize,
        points: &[Doubles<S>; 3],
        lanes: LaneSet,
    ) -> Prolonged<N> {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut dual = self.dual_cells::<S, N>(simd, level, points, lanes);
                let incomplete = lanes & dual.virtual_corners();
                if incomplete == 0 {
                    return Prolonged { values: interpolate(simd, &dual.values, &dual.weights), existing: lanes };
                }
                let coarser = self.prolong_below::<S, N>(simd, level, points, incomplete);
                let (some, weight) = (incomplete & dual.any_actual(), dual.any_weight());
                let actual = dual.weight(simd, &dual.actual);
                for corner in 0..8 {
                    let missing = dual.weighty[corner] & !dual.actual[corner];
                    let mut found = missing & some;
                    let mut value = Floats::splat(simd, 0.0);
                    if found != 0 {
                        let center = self.center(simd, level, &dual.cells, corner);
                        let prolonged = self.prolong_below::<S, Floats<S>>(simd, level, &center, found);
                        found &= prolonged.existing;
                        value = mask_of(simd, found).select(prolonged.values, value);
                    }
                    dual.values[corner] = mask_of(simd, missing).select(value, dual.values[corner]);
                    dual.existing[corner] = dual.actual[corner] | found;
                }
                let own = dual.mean(simd);
                let blended = N::mix(coarser.values, own, actual);
                let values = N::select(mask_of(simd, coarser.existing), blended, own);
                let values = N::select(mask_of(simd, incomplete & !some), coarser.values, values);
                let values = N::select(mask_of(simd, incomplete), values, own);
                Prolonged { values, existing: lanes & !(incomplete & !weight) | coarser.existing }
            },
        )
    }

    /// The function of the levels coarser than `level`.
    #[inline(always)]
    fn prolong_below<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        level: usize,
        points: &[Doubles<S>; 3],
        lanes: LaneSet,
    ) -> Prolonged<N> {
        match level.checked_sub(1) {
            Some(coarser) => self.prolong_at(simd, coarser, points, lanes),
            None => Prolonged { values: N::constant(Floats::splat(simd, f32::NAN)), existing: 0 },
        }
    }

    /// The centres of a corner's cells.
    #[inline(always)]
    fn center<S: Gather>(
        &self,
        simd: S,
        level: usize,
        cells: &[[Integers<S>; 2]; 3],
        corner: usize,
    ) -> [Doubles<S>; 3] {
        let mut center = [Doubles::load(simd, &[0.0; LANES]); 3];
        for axis in 0..3 {
            let cell = Doubles::from_integers(simd, cells[axis][corner >> axis & 1]);
            let size = f64::from(self.levels[level].size(axis));
            center[axis] = cell.scaled(simd, -0.5, size, self.domain[axis][0]);
        }
        center
    }
}
