//! Blend, for packets: every level's trilinear value, weighed by how much of its dual cell is actual.

use fearless_simd::prelude::*;

use super::{Packet, PacketSampler};
use crate::hierarchy::Voxel;
use crate::simd::{Floats, Gather, Integers, LaneSet, lanes_of, mask_of};

impl<T: Voxel> PacketSampler<'_, T> {
    /// From the finest level in reach down: what is left of the weight goes to coarser levels until one is all actual.
    /// The coarsest level with actual corners takes all that is left.
    #[inline(always)]
    pub(super) fn blend<S: Gather>(&self, simd: S, mut lanes: LaneSet, packet: &mut Packet<S>) {
        let asked = lanes;
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let (mut sum, mut left, mut coarsest) = (zero, one, Floats::splat(simd, f32::NAN));
        let [_, finest] = packet.reach;
        for level in (0..=finest.reduce_max().max(0) as usize).rev() {
            let here = lanes & lanes_of(finest.simd_ge(Integers::splat(simd, level as i32)));
            if here == 0 {
                continue;
            }
            let lerp = self.dual_cells(simd, level, &packet.points, here).lerp(simd);
            let counts = mask_of(simd, here & lerp.any_actual);
            sum = counts.select((left * (one - lerp.missing)).mul_add(lerp.values, sum), sum);
            left = counts.select(left * lerp.missing, left);
            coarsest = counts.select(lerp.values, coarsest);
            lanes &= lanes_of(left.simd_gt(0.0));
            if lanes == 0 {
                break;
            }
        }
        // Where nothing is left, not even a coarser value that is no number counts.
        sum = left.simd_gt(0.0).select(left.mul_add(coarsest, sum), sum);
        packet.values = mask_of(simd, asked).select(sum, packet.values);
    }
}
