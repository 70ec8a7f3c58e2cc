//! Octant, for packets: trilinear in the eighths of leaf cells, whose corners are shared by the cells that touch them.

use fearless_simd::prelude::*;

use super::dual_cell::DualCells;
use super::{Levels, Packet, PacketSampler, mix};
use crate::hierarchy::Voxel;
use crate::simd::{Floats, Gather, LaneSet, lanes_of, mask_of};

impl<T: Voxel> PacketSampler<'_, T> {
    /// The eight corners of a point's octant are means of the eight corners of its dual cell, as long as no coarser
    /// cell touches them.
    #[inline(always)]
    pub(super) fn octant<S: Gather>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S>) {
        let mut levels = Levels { of_lanes: packet.levels, left: lanes };
        while let Some((level, lanes)) = levels.next(simd) {
            let octant = Octant::new(simd, self.dual_cells(simd, level, &packet.points, lanes));
            let values = mix(octant.corners(simd), octant.share);
            packet.values = mask_of(simd, lanes).select(values, packet.values);
            let beside = lanes & octant.beside_other_levels();
            if beside != 0 {
                self.by_reference(simd, beside, packet);
            }
        }
    }
}

/// A dual cell turned so that the point's own cell comes first: corners count x + 2 y + 4 z, 0 the own cell's side and 1
/// the other one per axis.
struct Octant<S: Gather> {
    /// How far the point is from the cell's centre to its face, per axis.
    share: [Floats<S>; 3],
    /// 0 where there is no cell of the level.
    values: [Floats<S>; 8],
    /// Where there is one.
    actual: [LaneSet; 8],
    /// Where there is one of another level instead.
    other: [LaneSet; 8],
}

impl<S: Gather> Octant<S> {
    #[inline(always)]
    fn new(simd: S, dual: DualCells<S>) -> Self {
        let zero = Floats::splat(simd, 0.0);
        let mut octant = Self { share: dual.share, values: [zero; 8], actual: [0; 8], other: [0; 8] };
        for corner in 0..8 {
            octant.actual[corner] = dual.actual[corner] & dual.in_domain[corner];
            octant.other[corner] = dual.existing[corner] & dual.in_domain[corner] & !dual.actual[corner];
            octant.values[corner] = mask_of(simd, octant.actual[corner]).select(dual.values[corner], zero);
        }
        for axis in 0..3 {
            let high = Floats::splat(simd, 1.0) - dual.share[axis];
            octant.share[axis] = dual.share[axis].min(high) * 2.0;
            octant.turn(simd, axis, lanes_of(dual.share[axis].simd_ge(0.5)));
        }
        octant
    }

    /// Swaps the sides across `axis` in some lanes.
    #[inline(always)]
    fn turn(&mut self, simd: S, axis: usize, lanes: LaneSet) {
        let mask = mask_of(simd, lanes);
        for corner in 0..8usize {
            let opposite = corner | 1 << axis;
            if corner == opposite {
                continue;
            }
            let (low, high) = (self.values[corner], self.values[opposite]);
            self.values[corner] = mask.select(high, low);
            self.values[opposite] = mask.select(low, high);
            for sets in [&mut self.actual, &mut self.other] {
                let (low, high) = (sets[corner], sets[opposite]);
                sets[corner] = low & !lanes | high & lanes;
                sets[opposite] = high & !lanes | low & lanes;
            }
        }
    }

    /// The values at the octant's corners: the means of the level's cells that touch them. Those on the other side across
    /// an axis are touched by cells of both sides.
    #[inline(always)]
    fn corners(&self, simd: S) -> [Floats<S>; 8] {
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
            sums[corner] = sums[corner] / counts[corner];
        }
        sums
    }

    /// The lanes that cells of other levels touch, or whose own cell is not where it was looked for.
    #[inline(always)]
    fn beside_other_levels(&self) -> LaneSet {
        let [a, b, c, d, e, f, g, h] = self.other;
        a | b | c | d | e | f | g | h | !self.actual[0]
    }
}
