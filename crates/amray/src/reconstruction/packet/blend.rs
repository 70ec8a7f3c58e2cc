//! Blend, for packets: every level's trilinear value, weighed by how much of its dual cell is actual.

use fearless_simd::prelude::*;

use super::{LaneNumber, Packet, PacketSampler};
use crate::hierarchy::Voxel;
use crate::simd::{Floats, Gather, Integers, LaneSet, lanes_of, mask_of};

impl<T: Voxel> PacketSampler<'_, T> {
    /// From the finest level in reach down: what is left of the weight goes to coarser levels until one is all actual.
    /// The coarsest level with actual corners takes all that is left.
    #[inline(always)]
    pub(super) fn blend<S: Gather, N: LaneNumber<S>>(&self, simd: S, mut lanes: LaneSet, packet: &mut Packet<S, N>) {
        let asked = lanes;
        let one = N::constant(Floats::splat(simd, 1.0));
        let (mut sum, mut left) = (N::constant(Floats::splat(simd, 0.0)), one);
        let mut coarsest = N::constant(Floats::splat(simd, f32::NAN));
        let [_, finest] = packet.reach;
        for level in (0..=finest.reduce_max().max(0) as usize).rev() {
            let here = lanes & lanes_of(finest.simd_ge(Integers::splat(simd, level as i32)));
            if here == 0 {
                continue;
            }
            let lerp = self.dual_cells::<S, N>(simd, level, &packet.points, here).lerp(simd);
            let counts = mask_of(simd, here & lerp.any_actual);
            sum = N::select(counts, (left * (one - lerp.missing)).weigh(lerp.values, sum), sum);
            left = N::select(counts, left * lerp.missing, left);
            coarsest = N::select(mask_of(simd, here & lerp.any_weight), lerp.values, coarsest);
            lanes &= lanes_of(left.takes_part());
            if lanes == 0 {
                break;
            }
        }
        // Where nothing is left, not even a coarser value that is no number counts.
        sum = N::select(left.takes_part(), left.weigh(coarsest, sum), sum);
        packet.values = N::select(mask_of(simd, asked), sum, packet.values);
    }
}
