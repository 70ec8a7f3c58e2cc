//! Marching: a packet of rays visits the regions that are seen, front to back, and samples them with no search.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::packet::Packet;
use super::traverse::{Span, Stack, Visitor, traverse};
use super::visibility::{NodeLook, SeenLook};
use super::{Integration, RenderStatistics, Trace};
use crate::appearance::{Glow, Light, Place, Segments, Window};
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
}

impl<V: RegionValues> March<'_, V> {
    /// How intervals are added.
    #[inline(always)]
    fn how(&self) -> (&Segments, Integration, bool) {
        (self.segments, self.integration, self.values.is_finite())
    }
}

impl<V: RegionValues> Trace for March<'_, V> {
    type Scratch<S: Gather> = Stack<S>;

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packet: &Packet<S>,
        span: &Span<S>,
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) -> Light<S> {
        let mut marcher = Marcher::new(simd, self, packet, span, *statistics);
        traverse(simd, self.pieces, self.looks, packet, *span, stack, &mut marcher);
        *statistics = marcher.statistics;
        marcher.rays.light
    }
}

/// A packet under way.
///
/// Samples lie on one lattice along each ray, shifted per pixel; a finer region's lattice holds the points of a coarser
/// one's. Light is added for the interval between a sample and the one before, wherever that was. Where rays come out
/// of what is invisible, or out of nowhere, their first sample is on the region's face.
struct Marcher<'a, S: Gather, V> {
    simd: S,
    march: &'a March<'a, V>,
    packet: &'a Packet<S>,
    /// Where the rays leave the volume.
    end: Floats<S>,
    rays: Rays<S>,
    /// Rays through which something behind can be seen.
    clear: Mask<S>,
    /// Rays that have a sample to go on from.
    begun: Mask<S>,
    /// Where that sample was.
    last_at: Doubles<S>,
    statistics: RenderStatistics,
}

/// What changes with every sample.
#[derive(Clone, Copy)]
pub(super) struct Rays<S: Gather> {
    pub(super) light: Light<S>,
    /// The last samples.
    pub(super) last: Place<S>,
}

/// Rays in a region's padded coordinates: scale * (start + t * direction) - low.
struct LocalRays<'a, S: Gather> {
    packet: &'a Packet<S>,
    frame: &'a RegionFrame,
    scale: [f64; 3],
}

impl<'a, S: Gather, V: RegionValues> Marcher<'a, S, V> {
    #[inline(always)]
    fn new(
        simd: S,
        march: &'a March<'a, V>,
        packet: &'a Packet<S>,
        span: &Span<S>,
        statistics: RenderStatistics,
    ) -> Self {
        Self {
            simd,
            march,
            packet,
            end: span.leave,
            rays: Rays::new(simd),
            clear: span.enter.simd_lt(span.leave),
            begun: Mask::splat(simd, false),
            last_at: Doubles::splat(simd, 0.0),
            statistics,
        }
    }

    /// Takes samples of `rays` at `at`, on the region's face, and adds the intervals that end there for `joined` rays.
    #[inline(never)]
    fn sample_on_face(&mut self, region: usize, at: Floats<S>, rays: Mask<S>, joined: Mask<S>, window: Window) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let at = Doubles::from_floats(at);
                let point = self.local(region).at(simd, at);
                let value = self.march.values.anywhere(simd, region, point, rays);
                let place = self.march.segments.place(simd, value, window);
                let length = (at - self.last_at).to_floats();
                let integral = self.rays.integral(simd, self.march.segments);
                self.rays.add(simd, self.march.how(), &integral, place, length, joined);
                self.rays.last = Place::select(rays, place, self.rays.last);
                self.last_at = Doubles::select(simd, rays, at, self.last_at);
                self.statistics.samples += u64::from(rays.to_bitmask().count_ones());
            },
        );
    }

    #[inline(always)]
    fn local(&self, region: usize) -> LocalRays<'a, S> {
        let frame = self.march.values.frame(region);
        let size = self.march.values.finest_cells(frame.level.unwrap_or(0));
        LocalRays { packet: self.packet, frame, scale: [size[0].recip(), size[1].recip(), size[2].recip()] }
    }

    /// The samples of a region that is seen.
    #[inline(always)]
    fn march_through(&mut self, region: usize, look: &SeenLook, span: &Span<S>, rays: Mask<S>) {
        let simd = self.simd;
        let packet = self.packet;
        let step = packet.coarse_step * Doubles::splat(simd, f64::from(look.step));
        let rate = packet.coarse_rate * Doubles::splat(simd, f64::from(look.step.recip()));
        let start = ((Doubles::from_floats(span.enter) - packet.offset) * rate).ceil();
        let end = ((Doubles::from_floats(span.leave) - packet.offset) * rate).ceil();
        let count = end - start;
        let first_at = start.mul_add(step, packet.offset);
        let counts = rays.select(count.to_floats(), Floats::splat(simd, 0.0));
        let most = simd.reduce_max_f32x16(counts);
        if most < 1.0 {
            return;
        }
        let local = self.local(region);
        let start = local.at(simd, first_at);
        let step = step.to_floats();
        let stride = local.stride(simd, step);
        let pure = pure_steps(simd, local.frame, &start, &stride, counts);
        let March { values, segments, .. } = self.march;
        let mut state = self.rays;
        let mut statistics = self.statistics;
        let mut length = (first_at - self.last_at).to_floats();
        // Where all values lie on one segment, no integrals are needed between them.
        let one_segment = look.window.first == look.window.last && values.is_finite();
        let slopes = segments.slopes(simd, Integers::splat(simd, i32::from(look.window.first)));
        let mut integral = state.integral(simd, segments);
        let mut number = 0.0f32;
        while number < most {
            let numbers = Floats::splat(simd, number);
            // Rays that have become opaque go on with the others, but add nothing: if samples waited for the light of
            // those before, no two steps would overlap.
            let active = numbers.simd_lt(counts);
            let seen = active & state.clear(simd);
            let mut point = start;
            for axis in 0..3 {
                point[axis] = numbers.mul_add(stride[axis], start[axis]);
            }
            let samples = u64::from(active.to_bitmask().count_ones());
            statistics.samples += samples;
            let value = if pure.contains(&number) {
                statistics.interior_samples += samples;
                values.pure(simd, region, point)
            } else {
                values.anywhere(simd, region, point, active)
            };
            let place = segments.place(simd, value, look.window);
            if number > 0.0 && one_segment {
                let mean = slopes.mean(simd, state.last.position, place.position);
                state.light.add(simd, &mean, length, seen);
            } else {
                let next = state.add(simd, self.march.how(), &integral, place, length, seen);
                integral = Glow::select(active, next, integral);
            }
            state.last = Place::select(active, place, state.last);
            length = step;
            number += 1.0;
            if (state.clear(simd) & numbers.simd_lt(counts)).all_false() {
                break;
            }
        }
        self.clear &= state.clear(simd);
        self.rays = state;
        self.statistics = statistics;
        let one = Floats::splat(simd, 1.0);
        let sampled = counts.simd_ge(one);
        let last_at = Doubles::from_floats(counts - one).mul_add(Doubles::from_floats(step), first_at);
        self.last_at = Doubles::select(simd, sampled, last_at, self.last_at);
    }
}

impl<S: Gather> Rays<S> {
    /// Rays that have met nothing yet.
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let nowhere = Place { position: Floats::splat(simd, 0.0), segment: Integers::splat(simd, 0) };
        Self { light: Light::none(simd), last: nowhere }
    }

    /// Rays through which something behind can be seen.
    #[inline(always)]
    pub(super) fn clear(&self, simd: S) -> Mask<S> {
        self.light.transmittance.simd_ge(Floats::splat(simd, OPAQUE))
    }

    /// Adds the interval from the last samples, up to which the integrals are `integral`, to `place`; returns the
    /// integrals up to there. A sample that is no number is taken to be like the other end of its interval, over half
    /// of it.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        simd: S,
        (segments, integration, finite): (&Segments, Integration, bool),
        integral: &Glow<S>,
        place: Place<S>,
        length: Floats<S>,
        rays: Mask<S>,
    ) -> Glow<S> {
        let slopes = segments.slopes(simd, place.segment);
        let next = segments.integral(simd, &place, &slopes);
        let mut mean = segments.mean(simd, [(&self.last, integral), (&place, &next)], &slopes);
        let (mut length, mut seen) = (length, rays);
        if integration == Integration::AtSamples {
            mean = segments.midway(simd, self.last.position, place.position);
        }
        if !finite {
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
        next
    }

    /// The integrals up to the last samples.
    #[inline(always)]
    pub(super) fn integral(&self, simd: S, segments: &Segments) -> Glow<S> {
        segments.integral(simd, &self.last, &segments.slopes(simd, self.last.segment))
    }
}

impl<S: Gather, V: RegionValues> Visitor<S> for Marcher<'_, S, V> {
    #[inline(always)]
    fn skip(&mut self, span: &Span<S>, rays: Mask<S>) {
        self.statistics.skipped_length += length_of(self.simd, span, rays);
    }

    #[inline(always)]
    fn going(&self) -> Mask<S> {
        self.clear
    }

    #[inline(always)]
    fn begun(&self) -> Mask<S> {
        self.begun
    }

    #[inline(always)]
    fn visit(&mut self, region: usize, look: Option<&SeenLook>, span: &Span<S>, rays: Mask<S>) {
        let simd = self.simd;
        self.statistics.region_visits += 1;
        if self.march.values.frame(region).level.is_none() {
            // A hole: the last value goes on up to it.
            let length = (Doubles::from_floats(span.enter) - self.last_at).to_floats();
            let integral = self.rays.integral(simd, self.march.segments);
            self.rays.add(simd, self.march.how(), &integral, self.rays.last, length, rays & self.begun);
            self.begun &= !rays;
            return;
        }
        let Some(look) = look else {
            let ending = rays & self.begun;
            self.sample_on_face(region, span.enter, ending, ending, Window::all(self.march.segments));
            self.begun &= !ending;
            return;
        };
        let beginning = rays & !self.begun;
        if beginning.any_true() {
            self.sample_on_face(region, span.enter, beginning, Mask::splat(simd, false), look.window);
            self.begun |= beginning;
        }
        self.march_through(region, look, span, rays);
        let ending = rays & self.clear & span.leave.simd_ge(self.end);
        if ending.any_true() {
            self.sample_on_face(region, span.leave, ending, ending, look.window);
            self.begun &= !ending;
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
}

/// The steps, counted from 0, at which all rays are inside the region's pure box.
#[inline(always)]
fn pure_steps<S: Gather>(
    simd: S,
    frame: &RegionFrame,
    start: &[Floats<S>; 3],
    stride: &[Floats<S>; 3],
    counts: Floats<S>,
) -> Range<f32> {
    if frame.is_pure {
        return 0.0..f32::INFINITY;
    }
    let zero = Floats::splat(simd, 0.0);
    let infinity = Floats::splat(simd, f32::INFINITY);
    let (mut enter, mut leave) = (zero, infinity);
    for axis in 0..3 {
        // Not an approximation: what is beyond the box may be a hole.
        let inverse = Floats::splat(simd, 1.0) / stride[axis];
        let a = (Floats::splat(simd, frame.pure[0][axis]) - start[axis]) * inverse;
        let b = (Floats::splat(simd, frame.pure[1][axis]) - start[axis]) * inverse;
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    // Rays that are through before they get there, or before they leave, do not matter.
    let enter = enter.min(counts);
    let leave = leave.simd_ge(counts - Floats::splat(simd, 1.0)).select(infinity, leave);
    let used = counts.simd_gt(zero);
    simd.reduce_max_f32x16(used.select(enter, zero))..simd.reduce_min_f32x16(used.select(leave, infinity))
}

/// How far rays go, all together.
#[inline(always)]
pub(super) fn length_of<S: Gather>(simd: S, span: &Span<S>, rays: Mask<S>) -> f64 {
    let zero = Floats::splat(simd, 0.0);
    f64::from(simd.reduce_sum_f32x16(rays.select(span.leave - span.enter, zero)))
}
