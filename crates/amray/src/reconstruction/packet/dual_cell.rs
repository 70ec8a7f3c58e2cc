//! The dual cells of one level around the points of a packet: eight corners, their hats and their closest existing
//! cells.

use fearless_simd::prelude::*;

use super::{Packet, PacketSampler, mix};
use crate::hierarchy::Voxel;
use crate::index::{DualDescent, PlaneLanes};
use crate::simd::{Doubles, Floats, Gather, Integers, LaneSet, lanes_of, mask_of};

/// Beside 1, single precision does not see weights up to this one.
pub(super) const NO_WEIGHT: f32 = f32::EPSILON / 2.0;

/// What is known of dual cells. Corners count x + 2 y + 4 z, 0 low and 1 high per axis; sets of lanes are per corner.
pub(super) struct DualCells<S: Gather> {
    /// The weight of the high side, per axis.
    pub(super) share: [Floats<S>; 3],
    /// The weight of the low side: beside holes it may be all that a mean has, so it is as exact as the high side's.
    low: [Floats<S>; 3],
    /// The logical cells of each side, moved into the domain.
    pub(super) cells: [[Integers<S>; 2]; 3],
    /// The closest existing cells' values; 0 where there is none, or no weight.
    pub(super) values: [Floats<S>; 8],
    /// The corner carries weight.
    pub(super) weighty: [LaneSet; 8],
    /// The corner carries weight and has a closest existing cell.
    pub(super) existing: [LaneSet; 8],
    /// The corner carries weight and is an actual cell of the level.
    pub(super) actual: [LaneSet; 8],
    /// ... and no finer level covers its centre.
    pub(super) uncovered: [LaneSet; 8],
    /// The logical cell lay in the domain to begin with.
    pub(super) in_domain: [LaneSet; 8],
}

/// The trilinear values of one level.
pub(super) struct Lerp<S: Gather> {
    /// The hat-weighted mean of the corners' closest existing cells; NaN where no corner has one.
    pub(super) values: Floats<S>,
    /// The share of the weight that virtual corners carry: 0 to 1, and exactly 0 where there are none.
    pub(super) missing: Floats<S>,
    /// Where actual corners carry weight.
    pub(super) any_actual: LaneSet,
}

impl<T: Voxel> PacketSampler<'_, T> {
    /// The dual cells of `level` around the points of `lanes`.
    #[inline(always)]
    pub(super) fn dual_cells<S: Gather>(
        &self,
        simd: S,
        level: usize,
        points: &[Doubles<S>; 3],
        lanes: LaneSet,
    ) -> DualCells<S> {
        let lattice = &self.levels[level];
        let (zero, nothing) = (Integers::splat(simd, 0), Floats::splat(simd, 0.0));
        let (mut cells, mut share, mut low) = ([[zero; 2]; 3], [nothing; 3], [nothing; 3]);
        let (mut planes, mut in_domain) = (PlaneLanes::default(), PlaneLanes::default());
        for axis in 0..3 {
            let position = points[axis].scaled(simd, self.domain[axis][0], lattice.scale(axis), -0.5);
            let (base, rest) = position.split(simd);
            share[axis] = rest;
            low[axis] = (Doubles::splat(simd, 1.0) - (position - position.floor())).to_floats();
            let weighty = [rest.simd_lt(1.0), rest.simd_gt(NO_WEIGHT)];
            for side in 0..2 {
                let cell = base + side as i32;
                cells[axis][side] = cell.max(zero).min(Integers::splat(simd, lattice.last(axis)));
                planes.0[axis][side] = lanes & lanes_of(weighty[side]);
                in_domain.0[axis][side] = lanes_of(cell.simd_eq(cells[axis][side]));
            }
        }
        let mut dual = self.read_dual_cells(simd, level, [low, share], cells, planes);
        dual.in_domain = in_domain.corners();
        dual
    }

    /// Finds and reads the `cells` of `level` where the `planes` through them meet; those that are looked at lie in the
    /// domain.
    #[inline(always)]
    pub(super) fn read_dual_cells<S: Gather>(
        &self,
        simd: S,
        level: usize,
        [low, share]: [[Floats<S>; 3]; 2],
        cells: [[Integers<S>; 2]; 3],
        planes: PlaneLanes,
    ) -> DualCells<S> {
        let weighty = planes.corners();
        let mut dual = DualCells {
            share,
            low,
            cells,
            values: [Floats::splat(simd, 0.0); 8],
            weighty,
            existing: [0; 8],
            actual: [0; 8],
            uncovered: [0; 8],
            in_domain: weighty,
        };
        let mut centers = cells;
        for axis in 0..3 {
            for side in 0..2 {
                centers[axis][side] = self.levels[level].center(axis, cells[axis][side]);
            }
        }
        let mut descent = DualDescent::new(planes);
        while let Some((region, planes)) = descent.next(simd, self.index, &centers) {
            let region = &self.index.regions()[region];
            let Some((found, brick)) = self.index.finest_brick(region, level) else { continue };
            let here = planes.corners();
            let brick = &self.bricks[brick];
            if found == level {
                brick.read_corners(simd, &cells, &here, &self.normalisation, &mut dual.values);
            } else {
                let lattice = &self.levels[found];
                let mut coarser = centers;
                for axis in 0..3 {
                    for side in 0..2 {
                        coarser[axis][side] = lattice.holding(simd, axis, centers[axis][side]);
                    }
                }
                brick.read_corners(simd, &coarser, &here, &self.normalisation, &mut dual.values);
            }
            let covered = region.finest_level() > Some(level);
            for corner in 0..8 {
                dual.existing[corner] |= here[corner];
                dual.actual[corner] |= if found == level { here[corner] } else { 0 };
                dual.uncovered[corner] |= if found == level && !covered { here[corner] } else { 0 };
            }
        }
        dual
    }

    /// Takes the trilinear values of `level` for `lanes`.
    #[inline(always)]
    pub(super) fn lerp_at<S: Gather>(&self, simd: S, level: usize, lanes: LaneSet, packet: &mut Packet<S>) {
        let values = self.dual_cells(simd, level, &packet.points, lanes).mean(simd);
        packet.values = mask_of(simd, lanes).select(values, packet.values);
    }
}

impl<S: Gather> DualCells<S> {
    /// The corners' hats.
    #[inline(always)]
    pub(super) fn hats(&self, simd: S) -> [Floats<S>; 8] {
        let (low, high) = (self.low, self.share);
        let [x, y, z] = [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]]];
        let mut hats = [Floats::splat(simd, 0.0); 8];
        for (corner, hat) in hats.iter_mut().enumerate() {
            *hat = x[corner & 1] * y[corner >> 1 & 1] * z[corner >> 2];
        }
        hats
    }

    /// The weight that the corners of these lanes carry.
    #[inline(always)]
    pub(super) fn weight(&self, simd: S, corners: &[LaneSet; 8]) -> Floats<S> {
        let hats = self.hats(simd);
        let mut weight = Floats::splat(simd, 0.0);
        for corner in 0..8 {
            weight = mask_of(simd, corners[corner]).select(weight + hats[corner], weight);
        }
        weight
    }

    /// The hat-weighted mean of the corners that exist; NaN where none does.
    #[inline(always)]
    pub(super) fn mean(&self, simd: S) -> Floats<S> {
        if self.existing == self.weighty {
            return mix(self.values, self.share);
        }
        let hats = self.hats(simd);
        let (mut sum, mut weight) = (Floats::splat(simd, 0.0), Floats::splat(simd, 0.0));
        for corner in 0..8 {
            let exists = mask_of(simd, self.existing[corner]);
            sum = exists.select(hats[corner].mul_add(self.values[corner], sum), sum);
            weight = exists.select(weight + hats[corner], weight);
        }
        sum / weight
    }

    #[inline(always)]
    pub(super) fn lerp(&self, simd: S) -> Lerp<S> {
        let mut missing = Floats::splat(simd, 0.0);
        if self.virtual_corners() != 0 {
            let mut corners = self.weighty;
            for (corner, actual) in corners.iter_mut().zip(self.actual) {
                *corner &= !actual;
            }
            missing = self.weight(simd, &corners);
        }
        Lerp { values: self.mean(simd), missing, any_actual: self.any_actual() }
    }

    /// The lanes with corners that are actual cells.
    #[inline(always)]
    pub(super) fn any_actual(&self) -> LaneSet {
        let [a, b, c, d, e, f, g, h] = self.actual;
        a | b | c | d | e | f | g | h
    }

    /// The lanes with corners of weight that are no actual cells.
    #[inline(always)]
    pub(super) fn virtual_corners(&self) -> LaneSet {
        let mut lanes = 0;
        for corner in 0..8 {
            lanes |= self.weighty[corner] & !self.actual[corner];
        }
        lanes
    }
}
