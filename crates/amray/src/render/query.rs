//! The paper's design (section 5.3): rays ask the kd-tree for every sample, sixteen at a time. Steps fit the leaf cell
//! that the last sample was in, and nothing is skipped: what marching is measured against.

use fearless_simd::prelude::*;

use super::march::{How, clear};
use super::packet::{PACKETS, Packet, Packets};
use super::traverse::Span;
use super::{Integration, RenderStatistics, Trace};
use crate::appearance::{Place, Radiance, Segments, Window};
use crate::hierarchy::Voxel;
use crate::reconstruction::{PacketPoints, PacketSampler};
use crate::simd::{Doubles, Floats, Gather, Mask};

/// Everything that the packets of a picture share.
pub(super) struct Query<'a, T> {
    pub(super) sampler: &'a PacketSampler<'a, T>,
    pub(super) segments: &'a Segments,
    pub(super) integration: Integration,
    /// Per level, the step over that on level 0.
    pub(super) steps: &'a [f32],
}

impl<T: Voxel> Trace for Query<'_, T> {
    type Scratch<S: Gather> = ();

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        (): &mut (),
        statistics: &mut RenderStatistics,
    ) {
        for packet in 0..PACKETS {
            let ends = [span.enter[packet], span.leave[packet]];
            self.packet(simd, &packets[packet], ends, &mut lights[packet], statistics);
        }
    }
}

impl<T: Voxel> Query<'_, T> {
    /// What one packet's rays collect between two places on them.
    #[inline(always)]
    fn packet<S: Gather>(
        &self,
        simd: S,
        packet: &Packet<S>,
        [enter, leave]: [Floats<S>; 2],
        light: &mut Radiance<S>,
        statistics: &mut RenderStatistics,
    ) {
        let zero = Floats::splat(simd, 0.0);
        let mut active = enter.simd_lt(leave);
        let mut last = Place::nowhere(simd);
        let (mut at, end) = (Doubles::from_floats(enter), Doubles::from_floats(leave));
        let mut length = zero;
        let mut begun = Mask::splat(simd, false);
        let window = Window::all(self.segments);
        let how = How { segments: self.segments, integration: self.integration, is_finite: false };
        while active.any_true() {
            let mut points: PacketPoints = [[0.0; 16]; 3];
            for axis in 0..3 {
                points[axis] = at.mul_add(packet.direction[axis], packet.start[axis]).store();
            }
            let samples = self.sampler.sample(simd, &points, active);
            statistics.samples += u64::from(active.to_bitmask().count_ones());
            let place = self.segments.place(simd, samples.values, window);
            let seen = active & begun;
            let slopes = self.segments.slopes(simd, place.segment);
            let interval = how.between(simd, &slopes, [&last, &place], length, seen);
            light.add(simd, &interval.glow, interval.length, interval.rays);
            last = place;
            begun = active;
            // The next point of the lattice whose step fits the leaf cell; the ray's end is the last sample.
            let finest = simd.look_up(self.steps, samples.levels);
            let step = packet.coarse_step * Doubles::from_floats(finest);
            // A place on the lattice is not ahead of itself, however it was rounded.
            let place = (at - packet.offset).mul_add(step.recip(simd), Doubles::splat(simd, 1.0 + 1e-6));
            let ahead = place.floor();
            let next = ahead.mul_add(step, packet.offset);
            active &= !at.to_floats().simd_ge(leave);
            active &= clear(simd, light.transmittance);
            let next = next.min(end);
            length = (next - at).to_floats();
            at = next;
        }
    }
}
