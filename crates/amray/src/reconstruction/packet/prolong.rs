//! Prolong, for packets.

use super::{Packet, PacketSampler};
use crate::hierarchy::Voxel;
use crate::simd::{Gather, LaneSet};

impl<T: Voxel> PacketSampler<'_, T> {
    #[inline(always)]
    pub(super) fn prolong<S: Gather>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S>) {
        self.by_reference(simd, lanes, packet);
    }
}
