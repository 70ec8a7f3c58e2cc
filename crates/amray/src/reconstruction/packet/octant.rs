//! Octant, for packets: trilinear in the eighths of leaf cells, whose corners are shared by the cells that touch them.

use fearless_simd::prelude::*;

use super::dual_cell::{DualCells, NO_WEIGHT, interpolate};
use super::level::PacketLevel;
use super::{LaneNumber, Levels, Packet, PacketSampler, linear_weights};
use crate::hierarchy::Voxel;
use crate::index::{DualDescent, PlaneLanes};
use crate::simd::{Doubles, Floats, Gather, Integers, LaneSet, lanes_of, mask_of};

/// Values of some lanes, and the lanes that have to be asked elsewhere.
struct Attempt<N> {
    values: N,
    failed: LaneSet,
}

impl<T: Voxel> PacketSampler<'_, T> {
    /// The values in the octants of the points' leaf cells.
    #[inline(always)]
    pub(super) fn octant<S: Gather, N: LaneNumber<S>>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S, N>) {
        // Finer cells may touch a corner of a leaf cell that is covered in part from inside.
        if self.index.may_cover_partly() {
            return self.by_reference(simd, lanes, packet);
        }
        let mut failed = 0;
        let mut levels = Levels { of_lanes: packet.levels, left: lanes };
        while let Some((level, lanes)) = levels.next(simd) {
            let found = self.in_octants::<S, N>(simd, level, &packet.points, lanes);
            packet.values = N::select(mask_of(simd, lanes), found.values, packet.values);
            failed |= lanes & found.failed;
        }
        if failed != 0 {
            self.by_reference(simd, failed, packet);
        }
    }

    /// The values in the octants of the cells of `level` that hold the points, no coarser cell among them.
    #[inline(never)]
    fn in_octants<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        level: usize,
        points: &[Doubles<S>; 3],
        lanes: LaneSet,
    ) -> Attempt<N> {
        simd.vectorize(
            #[inline(always)]
            || {
                let lattice = &self.levels[level];
                let octant = Octant::new(simd, lattice, &self.dual_cells::<S, N>(simd, level, points, lanes));
                let mut corners = octant.means(simd);
                let beside_coarser = octant.beside_coarser();
                let mut failed = lanes & !octant.actual[0];
                if beside_coarser[7] & lanes != 0 {
                    for corner in 0..8 {
                        let here = beside_coarser[corner] & lanes & !failed;
                        if here != 0 {
                            let found = self.at_corner(simd, &octant.corner(simd, lattice, corner), here);
                            corners[corner] = mask_of(simd, here).select(found.values, corners[corner]);
                            failed |= here & found.failed;
                        }
                    }
                    if !N::HAS_SLOPES {
                        octant.drop_weightless(simd, &mut corners);
                    }
                }
                Attempt { values: interpolate(simd, &corners, &octant.weights), failed }
            },
        )
    }

    /// The values at octants' corners, in half cells of the finest level from the domain's low corner on: what the
    /// coarsest cells that touch them make of them.
    #[inline(always)]
    fn at_corner<S: Gather>(&self, simd: S, corner: &[Integers<S>; 3], lanes: LaneSet) -> Attempt<Floats<S>> {
        let mut all = Attempt { values: Floats::splat(simd, f32::NAN), failed: 0 };
        let coarsest = self.coarsest_touching(simd, corner, lanes);
        let touched = lanes & lanes_of(coarsest.simd_lt(self.levels.len() as i32));
        let mut levels = Levels { of_lanes: coarsest, left: touched };
        while let Some((level, lanes)) = levels.next(simd) {
            let lattice = &self.levels[level];
            let mut on_lattice = lanes;
            let mut halves = *corner;
            for axis in 0..3 {
                halves[axis] = lattice.holding(simd, axis, corner[axis]);
                on_lattice &= lanes_of((halves[axis] * lattice.size(axis)).simd_eq(corner[axis]));
            }
            if on_lattice != 0 {
                let means = self.mean_of_touching(simd, level, &halves, on_lattice);
                all.values = mask_of(simd, on_lattice).select(means, all.values);
            }
            let inside = lanes & !on_lattice;
            if inside != 0 {
                // On the face of a coarser cell's octant, which says what the value is, so that no crack opens.
                let mut points = [Doubles::from_integers(simd, corner[0]); 3];
                for axis in 0..3 {
                    let position = Doubles::from_integers(simd, corner[axis]);
                    points[axis] = position.scaled(simd, 0.0, 0.5, self.domain[axis][0]);
                }
                let found = self.in_octants::<S, Floats<S>>(simd, level, &points, inside);
                all.values = mask_of(simd, inside).select(found.values, all.values);
                all.failed |= inside & found.failed;
            }
        }
        all
    }

    /// The level of the coarsest leaf cell that touches each corner; the number of levels where there is none.
    #[inline(always)]
    fn coarsest_touching<S: Gather>(&self, simd: S, corner: &[Integers<S>; 3], lanes: LaneSet) -> Integers<S> {
        let mut coarsest = Integers::splat(simd, self.levels.len() as i32);
        let (cells, planes) = self.touching(simd, self.levels.len() - 1, corner, lanes);
        let mut descent = DualDescent::new(planes);
        while let Some((region, planes)) = descent.next(simd, self.index, &cells) {
            if let Some(level) = self.index.regions()[region].finest_level() {
                let coarser = coarsest.min(Integers::splat(simd, level as i32));
                coarsest = mask_of(simd, planes.lanes()).select(coarser, coarsest);
            }
        }
        coarsest
    }

    /// The means of the cells of `level` that touch each corner, in half cells of that level.
    #[inline(always)]
    fn mean_of_touching<S: Gather>(
        &self,
        simd: S,
        level: usize,
        corner: &[Integers<S>; 3],
        lanes: LaneSet,
    ) -> Floats<S> {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let (cells, planes) = self.touching(simd, level, corner, lanes);
        let dual = self.read_dual_cells(simd, level, [[zero; 2]; 3], cells, planes);
        let (mut sum, mut count) = (zero, zero);
        for corner in 0..8 {
            let actual = mask_of(simd, dual.actual[corner]);
            sum = actual.select(sum + dual.values[corner], sum);
            count = actual.select(count + one, count);
        }
        sum / count
    }

    /// The cells of `level` below and above each corner, in half cells of that level, and which of them touch it.
    #[inline(always)]
    fn touching<S: Gather>(
        &self,
        simd: S,
        level: usize,
        corner: &[Integers<S>; 3],
        lanes: LaneSet,
    ) -> ([[Integers<S>; 2]; 3], PlaneLanes) {
        let zero = Integers::splat(simd, 0);
        let (mut cells, mut planes) = ([[zero; 2]; 3], PlaneLanes::default());
        for axis in 0..3 {
            let high = corner[axis] >> 1;
            let low = high - 1;
            let last = Integers::splat(simd, self.levels[level].last(axis));
            let on_face = (corner[axis] & 1).simd_eq(zero);
            planes.0[axis] = [lanes & lanes_of(on_face & low.simd_ge(zero)), lanes & lanes_of(high.simd_le(last))];
            cells[axis] = [low, high];
        }
        (cells, planes)
    }
}

/// A dual cell turned so that the point's own cell comes first: corners count x + 2 y + 4 z, 0 the own cell's side and 1
/// the other one per axis.
struct Octant<S: Gather, N> {
    /// The weights of the cell's centre and of its face, per axis.
    weights: [[N; 2]; 3],
    /// The point's own cell.
    cell: [Integers<S>; 3],
    /// The lanes whose own side is the high one, per axis.
    turned: [LaneSet; 3],
    /// 0 where there is no cell of the level.
    values: [Floats<S>; 8],
    /// Where there is one.
    actual: [LaneSet; 8],
    /// Where there is a coarser one instead.
    coarser: [LaneSet; 8],
}

impl<S: Gather, N: LaneNumber<S>> Octant<S, N> {
    #[inline(always)]
    fn new(simd: S, lattice: &PacketLevel, dual: &DualCells<S, N>) -> Self {
        let zero = Floats::splat(simd, 0.0);
        let mut octant = Self {
            weights: dual.weights,
            cell: [Integers::splat(simd, 0); 3],
            turned: [0; 3],
            values: [zero; 8],
            actual: [0; 8],
            coarser: [0; 8],
        };
        for corner in 0..8 {
            octant.actual[corner] = dual.actual[corner] & dual.in_domain[corner];
            octant.coarser[corner] = dual.existing[corner] & dual.in_domain[corner] & !dual.actual[corner];
            octant.values[corner] = mask_of(simd, octant.actual[corner]).select(dual.values[corner], zero);
        }
        for axis in 0..3 {
            let share = dual.weights[axis][1].values();
            let turned = share.simd_ge(0.5);
            octant.turned[axis] = lanes_of(turned);
            octant.cell[axis] = turned.select(dual.cells[axis][1], dual.cells[axis][0]);
            let one = Floats::splat(simd, 1.0);
            let outward = share.min(one - share) * 2.0;
            let slope = Floats::splat(simd, 2.0 * lattice.scale(axis) as f32);
            octant.weights[axis] = linear_weights(axis, [one - outward, outward], turned.select(-slope, slope));
            octant.turn(simd, axis);
        }
        octant
    }

    /// Swaps the sides across `axis` where the point's own one is the high one.
    #[inline(always)]
    fn turn(&mut self, simd: S, axis: usize) {
        let lanes = self.turned[axis];
        let mask = mask_of(simd, lanes);
        for corner in 0..8usize {
            let opposite = corner | 1 << axis;
            if corner == opposite {
                continue;
            }
            let (low, high) = (self.values[corner], self.values[opposite]);
            self.values[corner] = mask.select(high, low);
            self.values[opposite] = mask.select(low, high);
            for sets in [&mut self.actual, &mut self.coarser] {
                let (low, high) = (sets[corner], sets[opposite]);
                sets[corner] = low & !lanes | high & lanes;
                sets[opposite] = high & !lanes | low & lanes;
            }
        }
    }

    /// The means of the level's cells that touch each corner of the octant. Those on the other side across an axis are
    /// touched by cells of both sides.
    #[inline(always)]
    fn means(&self, simd: S) -> [Floats<S>; 8] {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let (mut sums, mut counts) = (self.values, [zero; 8]);
        for (count, &lanes) in counts.iter_mut().zip(&self.actual) {
            *count = mask_of(simd, lanes).select(one, zero);
        }
        for axis in 0..3 {
            for corner in 0..8usize {
                let opposite = corner | 1 << axis;
                if corner != opposite {
                    sums[opposite] += sums[corner];
                    counts[opposite] += counts[corner];
                }
            }
        }
        for corner in 0..8 {
            sums[corner] /= counts[corner];
        }
        sums
    }

    /// The lanes in which a coarser cell touches each corner of the octant.
    #[inline(always)]
    fn beside_coarser(&self) -> [LaneSet; 8] {
        let mut beside = self.coarser;
        for axis in 0..3 {
            for corner in 0..8usize {
                beside[corner | 1 << axis] |= beside[corner];
            }
        }
        beside
    }

    /// Where a corner of the octant lies, in half cells of the finest level.
    #[inline(always)]
    fn corner(&self, simd: S, lattice: &PacketLevel, corner: usize) -> [Integers<S>; 3] {
        let mut place = self.cell;
        for axis in 0..3 {
            let center = (self.cell[axis] * 2 + 1) * lattice.size(axis);
            let turned = mask_of(simd, self.turned[axis]);
            let outside = turned.select(center - lattice.size(axis), center + lattice.size(axis));
            place[axis] = if corner >> axis & 1 == 1 { outside } else { center };
        }
        place
    }

    /// Corners without weight do not take part, not even those that are not a number.
    #[inline(always)]
    fn drop_weightless(&self, simd: S, corners: &mut [Floats<S>; 8]) {
        let zero = Floats::splat(simd, 0.0);
        for axis in 0..3 {
            let share = self.weights[axis][1].values();
            let weightless = [share.simd_ge(1.0), share.simd_le(2.0 * NO_WEIGHT)];
            for (corner, value) in corners.iter_mut().enumerate() {
                *value = weightless[corner >> axis & 1].select(zero, *value);
            }
        }
    }
}
