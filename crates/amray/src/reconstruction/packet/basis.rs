//! Basis, for packets: the hats of all leaf cells of all levels, normalised.

use fearless_simd::prelude::*;

use super::{LaneNumber, Packet, PacketSampler};
use crate::hierarchy::Voxel;
use crate::simd::{Floats, Gather, Integers, LaneSet, lanes_of, mask_of};

impl<T: Voxel> PacketSampler<'_, T> {
    /// sum(hat v) / sum(hat) over all leaf cells of the levels in reach.
    #[inline(always)]
    pub(super) fn basis<S: Gather, N: LaneNumber<S>>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S, N>) {
        let zero = N::constant(Floats::splat(simd, 0.0));
        let (mut sum, mut weight) = (zero, zero);
        let [coarsest, finest] = packet.reach;
        let mut doubtful = 0;
        for level in 0..=finest.reduce_max().max(0) {
            let number = Integers::splat(simd, level);
            let here = lanes & lanes_of(coarsest.simd_le(number) & finest.simd_ge(number));
            if here == 0 {
                continue;
            }
            let dual = self.dual_cells::<S, N>(simd, level as usize, &packet.points, here);
            for corner in 0..8 {
                let leaf = mask_of(simd, dual.uncovered[corner] & dual.in_domain[corner]);
                let hat = N::hat(&dual.weights, corner);
                sum = N::select(leaf, hat.weigh_values(dual.values[corner], sum), sum);
                weight = N::select(leaf, hat + weight, weight);
                doubtful |= dual.actual[corner] & !dual.uncovered[corner];
            }
        }
        packet.values = N::select(mask_of(simd, lanes), sum / weight, packet.values);
        // A cell whose centre is covered may be a leaf cell elsewhere: all of it must be looked at.
        if self.index.may_cover_partly() && doubtful != 0 {
            self.by_reference(simd, doubtful, packet);
        }
    }
}
