//! Marching: a packet of rays visits the regions that are seen, front to back, and samples them with no search.

use fearless_simd::prelude::*;

use super::packet::{Masks, PACKETS, Packet, Packets};
use super::traverse::{Span, Stack, Visitor, traverse};
use super::visibility::{NodeLook, SeenLook};
use super::{Integration, RenderStatistics, Trace};
use crate::appearance::{Glow, Place, Radiance, Segments, Slopes, Window};
use crate::layout::{PieceNode, RegionFrame, RegionValues};
use crate::simd::{Doubles, Floats, Gather, Integers, Mask};

/// What is still visible below this transmittance would change no 8-bit picture.
const OPAQUE: f32 = 1.0 / 4096.0;

/// Everything that the packets of a picture share.
pub(super) struct March<'a, V> {
    pub(super) values: V,
    pub(super) segments: &'a Segments,
    pub(super) pieces: &'a [PieceNode],
    pub(super) looks: &'a [NodeLook],
    pub(super) integration: Integration,
    pub(super) footprint: Footprint,
}

/// How intervals between samples become light.
#[derive(Clone, Copy)]
pub(super) struct How<'a> {
    pub(super) segments: &'a Segments,
    pub(super) integration: Integration,
    /// Whether all samples are numbers.
    pub(super) is_finite: bool,
}

/// How wide a pixel is, in world units over the samples per cell: at the eye, and by how much more per distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Footprint {
    pub(super) near: f32,
    pub(super) growth: f32,
}

impl Footprint {
    /// The highest power of two by which a step can be longer and still fit the pixel; 1 at least.
    #[inline(always)]
    fn longer(self, step: f32, distance: f32) -> f32 {
        let times = (self.near + self.growth * distance) / step;
        // Without its fraction a number is the power of two below.
        if (2.0..f32::MAX).contains(&times) { f32::from_bits(times.to_bits() & 0x7f80_0000) } else { 1.0 }
    }
}

impl<V: RegionValues> March<'_, V> {
    /// How intervals are added.
    #[inline(always)]
    fn how(&self) -> How<'_> {
        How { segments: self.segments, integration: self.integration, is_finite: self.values.is_finite() }
    }
}

impl<V: RegionValues> Trace for March<'_, V> {
    type Scratch<S: Gather> = Stack<S>;

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) -> [Radiance<S>; PACKETS] {
        let mut marcher = Marcher::new(simd, self, packets, span, *statistics);
        traverse(simd, self.pieces, self.looks, packets, *span, stack, &mut marcher);
        *statistics = marcher.statistics;
        statistics.skipped_length += f64::from(simd.reduce_sum_f32x16(marcher.skipped));
        let mut lights = [Radiance::none(simd); PACKETS];
        for number in 0..PACKETS {
            lights[number] = marcher.rays[number].light;
        }
        lights
    }
}

/// Packets under way.
///
/// Samples lie on one lattice along each ray, shifted per pixel; a finer region's lattice holds the points of a coarser
/// one's. Radiance is added for the interval between a sample and the one before, wherever that was. Where rays come out
/// of what is invisible, or out of nowhere, their first sample is on the region's face, and where they go into it their
/// last one is on the face of the region that they leave: values may jump there.
struct Marcher<'a, S: Gather, V> {
    simd: S,
    march: &'a March<'a, V>,
    packets: &'a Packets<S>,
    /// Where the rays leave the volume.
    end: [Floats<S>; PACKETS],
    rays: [Rays<S>; PACKETS],
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

/// A packet on its way through one region.
#[derive(Clone, Copy)]
struct Course<S: Gather> {
    /// The first point, in the region's local coordinates, and how far a step goes.
    start: [Floats<S>; 3],
    stride: [Floats<S>; 3],
    /// How many samples each ray takes, and the most of them.
    counts: Floats<S>,
    most: f32,
    first_at: Doubles<S>,
    step: Floats<S>,
    /// How far it is from the last sample to the next.
    length: Floats<S>,
    /// From the first to the last step at which all rays are in the region's pure box.
    pure: [f32; 2],
}

impl<S: Gather> Course<S> {
    /// Of no rays.
    #[inline(always)]
    fn none(simd: S) -> Self {
        let zero = Floats::splat(simd, 0.0);
        let nowhere = Doubles::splat(simd, 0.0);
        Self {
            start: [zero; 3],
            stride: [zero; 3],
            counts: zero,
            most: 0.0,
            first_at: nowhere,
            step: zero,
            length: zero,
            pure: [0.0; 2],
        }
    }
}

/// What changes with every sample.
#[derive(Clone, Copy)]
pub(super) struct Rays<S: Gather> {
    pub(super) light: Radiance<S>,
    /// The last samples.
    pub(super) last: Place<S>,
}

/// Rays in a region's padded coordinates: scale * (start + t * direction) - low.
struct LocalRays<'a, S: Gather> {
    packet: &'a Packet<S>,
    frame: &'a RegionFrame,
    /// Cells of the finest level per cell of the region's.
    size: &'a [f64; 3],
    scale: [f64; 3],
}

impl<'a, S: Gather, V: RegionValues> Marcher<'a, S, V> {
    #[inline(always)]
    fn new(
        simd: S,
        march: &'a March<'a, V>,
        packets: &'a Packets<S>,
        span: &Span<S>,
        statistics: RenderStatistics,
    ) -> Self {
        let none = Mask::splat(simd, false);
        let mut clear = [none; PACKETS];
        for number in 0..PACKETS {
            clear[number] = span.enter[number].simd_lt(span.leave[number]);
        }
        Self {
            simd,
            march,
            packets,
            end: span.leave,
            rays: [Rays::new(simd); PACKETS],
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
                let value = self.march.values.anywhere(simd, region, point, rays);
                let place = self.march.segments.place(simd, value, Window::all(self.march.segments));
                let state = &mut self.rays[packet];
                if is_end {
                    let length = (at - self.last_at[packet]).to_floats();
                    state.add(simd, self.march.how(), place, length, rays);
                }
                state.last = Place::select(rays, place, state.last);
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
        let frame = self.march.values.frame(region);
        let size = self.march.values.finest_cells(frame.level.unwrap_or(0));
        let packet = &self.packets[packet];
        LocalRays { packet, frame, size, scale: [size[0].recip(), size[1].recip(), size[2].recip()] }
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
        let March { values, segments, footprint, .. } = self.march;
        let far = Floats::splat(simd, f32::INFINITY);
        let mut nearest = far;
        for packet in 0..PACKETS {
            nearest = rays[packet].select(nearest.min(span.enter[packet]), nearest);
        }
        let nearest = simd.reduce_min_f32x16(nearest);
        // Cells much smaller than a pixel need not all be looked at.
        let step = self.packets[0].coarse_step.first() as f32 * look.step;
        let look = &SeenLook { step: look.step * footprint.longer(step, self.packets[0].distance + nearest), ..*look };
        let mut courses = [Course::none(simd); PACKETS];
        for packet in 0..PACKETS {
            if rays[packet].any_true() {
                let ends = [span.enter[packet], span.leave[packet]];
                courses[packet] = self.course(packet, region, look, ends, rays[packet]);
            }
        }
        // Mostly all values lie on one segment.
        let is_one_segment = look.window.first == look.window.last && values.is_finite();
        let may_be_dark = segments.may_be_dark(look.window) && values.is_finite();
        let mut slopes = segments.slopes(simd, Integers::splat(simd, i32::from(look.window.first)));
        let mut states = self.rays;
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
                let seen = active & state.clear(simd);
                let mut point = course.start;
                for axis in 0..3 {
                    point[axis] = numbers.mul_add(course.stride[axis], course.start[axis]);
                }
                let samples = u64::from(active.to_bitmask().count_ones());
                statistics.samples += samples;
                let value = if course.pure[0] <= number && number <= course.pure[1] {
                    statistics.interior_samples += samples;
                    values.pure(simd, region, point)
                } else {
                    values.anywhere(simd, region, point, active)
                };
                let place = segments.place(simd, value, look.window);
                if !(may_be_dark && segments.is_dark(simd, [&state.last, &place], seen)) {
                    if !is_one_segment {
                        slopes = segments.slopes(simd, place.segment);
                    }
                    state.add_along(simd, self.march.how(), &slopes, place, course.length, seen);
                }
                state.last = Place::select(active, place, state.last);
                course.length = course.step;
                under_way |= number + 1.0 < course.most && (seen & state.clear(simd)).any_true();
            }
            number += 1.0;
        }
        self.statistics = statistics;
        for packet in 0..PACKETS {
            let Course { counts, first_at, step, .. } = courses[packet];
            self.clear[packet] &= states[packet].clear(simd);
            self.rays[packet] = states[packet];
            let one = Floats::splat(simd, 1.0);
            let last_at = Doubles::from_floats(counts - one).mul_add(Doubles::from_floats(step), first_at);
            self.last_at[packet] = Doubles::select(simd, counts.simd_ge(one), last_at, self.last_at[packet]);
        }
    }
}

impl<S: Gather> Rays<S> {
    /// Rays that have met nothing yet.
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let nowhere = Place { position: Floats::splat(simd, 0.0), segment: Integers::splat(simd, 0) };
        Self { light: Radiance::none(simd), last: nowhere }
    }

    /// Rays through which something behind can be seen.
    #[inline(always)]
    pub(super) fn clear(&self, simd: S) -> Mask<S> {
        self.light.transmittance.simd_ge(Floats::splat(simd, OPAQUE))
    }

    /// Adds the interval from the last samples to `place`.
    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, how: How<'_>, place: Place<S>, length: Floats<S>, rays: Mask<S>) {
        let slopes = how.segments.slopes(simd, place.segment);
        self.add_along(simd, how, &slopes, place, length, rays);
    }

    /// Adds the interval from the last samples to `place`, where the slopes are known. A sample that is no number is
    /// taken to be like the other end of its interval, over half of it.
    #[inline(always)]
    fn add_along(
        &mut self,
        simd: S,
        How { segments, integration, is_finite }: How<'_>,
        slopes: &Slopes<S>,
        place: Place<S>,
        length: Floats<S>,
        rays: Mask<S>,
    ) {
        let mut mean = match integration {
            Integration::Preintegrated => segments.mean(simd, [&self.last, &place], slopes, rays),
            Integration::AtSamples => segments.midway(simd, self.last.position, place.position),
        };
        let (mut length, mut seen) = (length, rays);
        if !is_finite {
            let sum = self.last.position + place.position;
            let unknown = sum.simd_ne(sum) & rays;
            let known_from = self.last.position.simd_eq(self.last.position);
            let known_to = place.position.simd_eq(place.position);
            let known = Place::select(known_to, place, self.last);
            let alone = segments.slopes(simd, known.segment).mean(simd, known.position, known.position);
            mean = Glow::select(unknown, alone, mean);
            length = unknown.select(length * Floats::splat(simd, 0.5), length);
            seen &= known_from | known_to;
        }
        self.light.add(simd, &mean, length, seen);
    }
}

impl<S: Gather, V: RegionValues> Visitor<S> for Marcher<'_, S, V> {
    #[inline(always)]
    fn skip(&mut self, span: &Span<S>, rays: &Masks<S>) {
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
    fn visit(&mut self, region: usize, look: Option<&SeenLook>, span: &Span<S>, rays: &Masks<S>) {
        let simd = self.simd;
        self.statistics.region_visits += 1;
        let look = look.filter(|_| self.march.values.frame(region).level.is_some());
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

impl<S: Gather> LocalRays<'_, S> {
    #[inline(always)]
    fn at(&self, simd: S, at: Doubles<S>) -> [Floats<S>; 3] {
        let mut point = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            let cells = at.mul_add(self.packet.direction[axis], self.packet.start[axis]);
            let scale = Doubles::splat(simd, self.scale[axis]);
            point[axis] = cells.mul_add(scale, Doubles::splat(simd, -self.frame.low[axis])).to_floats();
        }
        point
    }

    /// How far a step goes.
    #[inline(always)]
    fn stride(&self, simd: S, step: Floats<S>) -> [Floats<S>; 3] {
        let mut stride = [step; 3];
        for axis in 0..3 {
            stride[axis] *= self.packet.direction[axis].to_floats() * Floats::splat(simd, self.scale[axis] as f32);
        }
        stride
    }

    /// The steps, counted from 0 at `start`, at which all rays are inside the region's pure box; `rate` are steps per
    /// length.
    #[inline(always)]
    fn pure_steps(&self, simd: S, start: &[Floats<S>; 3], rate: Floats<S>, counts: Floats<S>) -> [f32; 2] {
        if self.frame.is_pure {
            return [0.0, f32::INFINITY];
        }
        let (zero, infinity) = (Floats::splat(simd, 0.0), Floats::splat(simd, f32::INFINITY));
        let (mut enter, mut leave) = (zero, infinity);
        for axis in 0..3 {
            let inverse = self.packet.inverse[axis] * rate * Floats::splat(simd, self.size[axis] as f32);
            let a = (Floats::splat(simd, self.frame.pure[0][axis]) - start[axis]) * inverse;
            let b = (Floats::splat(simd, self.frame.pure[1][axis]) - start[axis]) * inverse;
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        // Rays that are through before they get there, or before they leave, do not matter.
        let enter = enter.min(counts);
        let leave = leave.simd_ge(counts - Floats::splat(simd, 1.0)).select(infinity, leave);
        let used = counts.simd_gt(zero);
        [simd.reduce_max_f32x16(used.select(enter, zero)), simd.reduce_min_f32x16(used.select(leave, infinity))]
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
