//! Marching: a packet of rays visits the regions that are seen, front to back, and samples them with no search.

mod collect;
mod course;
mod medium;
mod several;
mod steep;

use fearless_simd::prelude::*;

use super::packet::{Masks, PACKETS, Packet, Packets};
use super::traverse::{Span, Stack, Visitor, traverse};
use super::visibility::{NodeLook, SeenLook};
use super::{RenderStatistics, Trace};
use crate::appearance::Radiance;
use crate::layout::PieceNode;
use crate::simd::{Doubles, Floats, Gather, Integers, Mask};

pub(super) use collect::{Collector, Dimming, Glowing, clear};
use course::Course;
pub(super) use course::{Footprint, LocalRays};
pub(super) use medium::{How, Interval, Medium, Points, Single};
pub(super) use several::Several;
pub(super) use steep::{Sloped, Steep};

/// Everything that the packets of a picture share.
pub(super) struct March<'a, M> {
    pub(super) medium: M,
    pub(super) pieces: &'a [PieceNode],
    pub(super) looks: &'a [NodeLook],
    pub(super) footprint: Footprint,
}

impl<M: Medium> March<'_, M> {
    /// Takes packets from one end of `span` to the other; what they pass is added to `states`.
    #[inline(always)]
    pub(super) fn collect<S: Gather, C: Collector<S, M>>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        (collector, states): (&mut C, &mut [C::State; PACKETS]),
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) {
        let mut marcher = Marcher::new(simd, self, packets, span, (collector, *states), *statistics);
        traverse(simd, self.pieces, self.looks, packets, *span, stack, &mut marcher);
        for packet in 0..PACKETS {
            marcher.collector.leave(simd, packet, &mut marcher.states[packet]);
        }
        *statistics = marcher.statistics;
        statistics.skipped_length += f64::from(simd.reduce_sum_f32x16(marcher.skipped));
        *states = marcher.states;
    }
}

impl<M: Medium> Trace for March<'_, M> {
    type Scratch<S: Gather> = Stack<S>;

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) {
        self.collect(simd, packets, span, (&mut Glowing, lights), stack, statistics);
    }
}

/// Packets under way.
///
/// Samples lie on one lattice along each ray, shifted per pixel; a finer region's lattice holds the points of a coarser
/// one's. Light is added for the interval between a sample and the one before, wherever that was. Where rays come out
/// of what is invisible, or out of nowhere, their first sample is on the region's face, and where they go into it their
/// last one is on the face of the region that they leave: values may jump there.
struct Marcher<'a, S: Gather, M: Medium, C: Collector<S, M>> {
    simd: S,
    march: &'a March<'a, M>,
    packets: &'a Packets<S>,
    /// Where the rays leave the volume.
    end: [Floats<S>; PACKETS],
    collector: &'a mut C,
    states: [C::State; PACKETS],
    /// The last samples.
    last: [M::Sample<S>; PACKETS],
    /// Rays through which something behind can be seen.
    clear: Masks<S>,
    /// Rays that have a sample to go on from.
    begun: Masks<S>,
    /// Where that sample was.
    last_at: [Doubles<S>; PACKETS],
    /// How far each lane's rays have passed over what is invisible.
    skipped: Floats<S>,
    /// The regions that these rays are in.
    regions: [Integers<S>; PACKETS],
    statistics: RenderStatistics,
}

impl<'a, S: Gather, M: Medium, C: Collector<S, M>> Marcher<'a, S, M, C> {
    #[inline(always)]
    fn new(
        simd: S,
        march: &'a March<'a, M>,
        packets: &'a Packets<S>,
        span: &Span<S>,
        (collector, states): (&'a mut C, [C::State; PACKETS]),
        statistics: RenderStatistics,
    ) -> Self {
        let none = Mask::splat(simd, false);
        let mut clear = [none; PACKETS];
        for number in 0..PACKETS {
            clear[number] = span.enter[number].simd_lt(span.leave[number]) & C::clear(simd, &states[number]);
        }
        Self {
            simd,
            march,
            packets,
            end: span.leave,
            collector,
            states,
            last: [march.medium.nothing(simd); PACKETS],
            clear,
            begun: [none; PACKETS],
            last_at: [Doubles::splat(simd, 0.0); PACKETS],
            skipped: Floats::splat(simd, 0.0),
            regions: [Integers::splat(simd, 0); PACKETS],
            statistics,
        }
    }

    /// Takes samples of a packet's `rays` at `at`, on the region's face; where rays end there, adds their last intervals.
    #[inline(never)]
    fn sample_on_face(&mut self, packet: usize, region: usize, at: Floats<S>, rays: Mask<S>, is_end: bool) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let at = Doubles::from_floats(at);
                let point = self.local(packet, region).at(simd, at);
                let medium = &self.march.medium;
                let mut here = medium.here(simd, None);
                let sample = medium.sample(simd, region, &here, point, Points::Anywhere(rays));
                if is_end {
                    let length = (at - self.last_at[packet]).to_floats();
                    let ends = [&self.last[packet], &sample];
                    if let Some(interval) = medium.interval(simd, &mut here, ends, length, rays) {
                        let state = &mut self.states[packet];
                        self.collector.add(simd, packet, state, &interval, ends, at.to_floats());
                    }
                }
                self.last[packet] = medium.select(rays, sample, self.last[packet]);
                self.last_at[packet] = Doubles::select(simd, rays, at, self.last_at[packet]);
                self.statistics.samples += u64::from(rays.to_bitmask().count_ones());
            },
        );
    }

    /// Ends `rays`, which have begun, at `at` on the faces of the regions that they are in.
    #[inline(never)]
    fn end_on_faces(&mut self, packet: usize, at: Floats<S>, rays: Mask<S>) {
        let mut left = rays;
        while left.any_true() {
            let regions = self.regions[packet];
            let region = regions[left.to_bitmask().trailing_zeros() as usize];
            let here = left & regions.simd_eq(Integers::splat(self.simd, region));
            self.sample_on_face(packet, region as usize, at, here, true);
            left &= !here;
        }
        self.begun[packet] &= !rays;
    }

    #[inline(always)]
    fn local(&self, packet: usize, region: usize) -> LocalRays<'a, S> {
        let frame = self.march.medium.frame(region);
        let size = self.march.medium.finest_cells(frame.level.unwrap_or(0));
        LocalRays::new(&self.packets[packet], frame, size)
    }

    /// The way of a packet's `rays` through a region.
    #[inline(always)]
    fn course(
        &self,
        packet: usize,
        region: usize,
        look: &SeenLook,
        [enter, leave]: [Floats<S>; 2],
        rays: Mask<S>,
    ) -> Course<S> {
        let simd = self.simd;
        let Packet { coarse_step, coarse_rate, offset, .. } = self.packets[packet];
        let step = coarse_step * Doubles::splat(simd, f64::from(look.step));
        let rate = coarse_rate * Doubles::splat(simd, f64::from(look.step.recip()));
        let start = ((Doubles::from_floats(enter) - offset) * rate).ceil();
        let end = ((Doubles::from_floats(leave) - offset) * rate).ceil();
        let first_at = start.mul_add(step, offset);
        let counts = rays.select((end - start).to_floats(), Floats::splat(simd, 0.0));
        let local = self.local(packet, region);
        let start = local.at(simd, first_at);
        let step = step.to_floats();
        let stride = local.stride(simd, step);
        Course {
            start,
            stride,
            counts,
            most: simd.reduce_max_f32x16(counts),
            first_at,
            step,
            length: (first_at - self.last_at[packet]).to_floats(),
            pure: local.pure_steps(simd, &start, rate.to_floats(), counts),
        }
    }

    /// The samples of a region that is seen.
    #[inline(always)]
    fn march_through(&mut self, region: usize, look: &SeenLook, span: &Span<S>, rays: &Masks<S>) {
        let simd = self.simd;
        let March { medium, footprint, .. } = self.march;
        let far = Floats::splat(simd, f32::INFINITY);
        let mut nearest = far;
        for packet in 0..PACKETS {
            nearest = rays[packet].select(nearest.min(span.enter[packet]), nearest);
        }
        let nearest = simd.reduce_min_f32x16(nearest);
        // Cells much smaller than a pixel need not all be looked at.
        let step = self.packets[0].coarse_step.first() as f32 * look.step;
        let look = &SeenLook { step: look.step * footprint.longer(step, self.packets[0].entry[0] + nearest), ..*look };
        let mut courses = [Course::none(simd); PACKETS];
        for packet in 0..PACKETS {
            if rays[packet].any_true() {
                let ends = [span.enter[packet], span.leave[packet]];
                courses[packet] = self.course(packet, region, look, ends, rays[packet]);
            }
        }
        let mut here = medium.here(simd, Some(look));
        let (mut states, mut last) = (self.states, self.last);
        let mut statistics = self.statistics;
        let mut number = 0.0f32;
        let mut under_way = true;
        while under_way {
            under_way = false;
            // Packets take turns: while one waits for its values, the other one computes.
            for packet in 0..PACKETS {
                let course = &mut courses[packet];
                if number >= course.most {
                    continue;
                }
                let state = &mut states[packet];
                let numbers = Floats::splat(simd, number);
                // Rays that have become opaque go on with the others, but add nothing: if samples waited for the light
                // of those before, no two steps would overlap.
                let active = numbers.simd_lt(course.counts);
                let seen = active & C::clear(simd, state);
                let mut point = course.start;
                for axis in 0..3 {
                    point[axis] = numbers.mul_add(course.stride[axis], course.start[axis]);
                }
                let samples = u64::from(active.to_bitmask().count_ones());
                statistics.samples += samples;
                let sample = if course.pure[0] <= number && number <= course.pure[1] {
                    statistics.interior_samples += samples;
                    medium.sample(simd, region, &here, point, Points::Pure)
                } else {
                    medium.sample(simd, region, &here, point, Points::Anywhere(active))
                };
                let ends = [&last[packet], &sample];
                if let Some(interval) = medium.interval(simd, &mut here, ends, course.length, seen) {
                    let end = numbers.mul_add(course.step, course.first_at.to_floats());
                    self.collector.add(simd, packet, state, &interval, ends, end);
                }
                last[packet] = medium.select(active, sample, last[packet]);
                course.length = course.step;
                under_way |= number + 1.0 < course.most && (seen & C::clear(simd, state)).any_true();
            }
            number += 1.0;
        }
        self.statistics = statistics;
        (self.states, self.last) = (states, last);
        for packet in 0..PACKETS {
            let Course { counts, first_at, step, .. } = courses[packet];
            self.clear[packet] &= C::clear(simd, &states[packet]);
            let one = Floats::splat(simd, 1.0);
            let last_at = Doubles::from_floats(counts - one).mul_add(Doubles::from_floats(step), first_at);
            self.last_at[packet] = Doubles::select(simd, counts.simd_ge(one), last_at, self.last_at[packet]);
        }
    }
}

impl<S: Gather, M: Medium, C: Collector<S, M>> Visitor<S> for Marcher<'_, S, M, C> {
    #[inline(always)]
    fn skip(&mut self, _: usize, span: &Span<S>, rays: &Masks<S>) {
        self.skipped += lengths(self.simd, span, rays);
    }

    #[inline(always)]
    fn going(&self) -> &Masks<S> {
        &self.clear
    }

    #[inline(always)]
    fn begun(&self) -> &Masks<S> {
        &self.begun
    }

    #[inline(always)]
    fn visit(&mut self, (node, region): (usize, usize), look: Option<&SeenLook>, span: &Span<S>, rays: &Masks<S>) {
        let simd = self.simd;
        self.statistics.region_visits += 1;
        let look = look.filter(|_| self.march.medium.frame(region).level.is_some());
        for packet in 0..PACKETS {
            let (enter, rays, begun) = (span.enter[packet], rays[packet], self.begun[packet]);
            let (ending, beginning) = (rays & begun, rays & !begun);
            if look.is_some() {
                if beginning.any_true() {
                    self.sample_on_face(packet, region, enter, beginning, false);
                    self.begun[packet] |= beginning;
                }
                self.regions[packet] = rays.select(Integers::splat(simd, region as i32), self.regions[packet]);
            } else if ending.any_true() {
                self.end_on_faces(packet, enter, ending);
            }
        }
        let Some(look) = look else { return };
        for packet in 0..PACKETS {
            self.collector.leave(simd, packet, &mut self.states[packet]);
        }
        self.collector.enter(simd, node);
        self.march_through(region, look, span, rays);
        for packet in 0..PACKETS {
            let leave = span.leave[packet];
            let ending = rays[packet] & self.clear[packet] & leave.simd_ge(self.end[packet]);
            if ending.any_true() {
                self.end_on_faces(packet, leave, ending);
            }
        }
    }
}

/// How far each lane's rays go, all together.
#[inline(always)]
pub(super) fn lengths<S: Gather>(simd: S, span: &Span<S>, rays: &Masks<S>) -> Floats<S> {
    let mut sum = Floats::splat(simd, 0.0);
    for packet in 0..PACKETS {
        sum = rays[packet].select(sum + span.leave[packet] - span.enter[packet], sum);
    }
    sum
}
