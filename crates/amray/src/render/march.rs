//! Marching: a packet of rays visits the regions that are seen, front to back, and samples them with no search.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::RenderStatistics;
use super::packet::Packet;
use super::traverse::{Span, Visitor};
use super::visibility::{RegionLook, Visibility};
use crate::appearance::{Interval, Light, Place, Segments, Window};
use crate::padded::{Evaluator, RegionPlan};
use crate::simd::{Floats, Gather, Integers, LANES, Mask};

/// What is still visible below this transmittance would change no 8-bit picture.
pub(super) const OPAQUE: f32 = 1.0 / 4096.0;

/// Everything that the packets of a picture share.
#[derive(Clone, Copy)]
pub(super) struct March<'a> {
    pub(super) evaluator: Evaluator<'a>,
    pub(super) segments: &'a Segments,
    pub(super) visibility: &'a Visibility,
}

/// A packet under way: light that it has collected and where its last samples were.
///
/// Samples lie on one lattice along each ray, shifted per pixel; a finer region's lattice holds the points of a coarser
/// one's. Light is added for the interval between a sample and the one before, wherever that was. Where rays come out
/// of what is invisible, or out of nowhere, their first sample is on the region's face.
pub(super) struct Marcher<'a, S: Gather> {
    simd: S,
    march: March<'a>,
    packet: &'a Packet<S>,
    /// Where the rays leave the volume.
    end: Floats<S>,
    pub(super) light: Light<S>,
    /// Rays through which something behind can be seen.
    clear: Mask<S>,
    /// Rays that have a sample to go on from.
    begun: Mask<S>,
    /// That sample.
    last: Place<S>,
    last_at: [f64; LANES],
    pub(super) statistics: RenderStatistics,
}

/// Rays in a region's padded coordinates: `start + t * direction`.
struct LocalRays {
    start: [[f64; LANES]; 3],
    direction: [[f64; LANES]; 3],
}

impl<'a, S: Gather> Marcher<'a, S> {
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        march: March<'a>,
        packet: &'a Packet<S>,
        span: &Span<S>,
        statistics: RenderStatistics,
    ) -> Self {
        Self {
            simd,
            march,
            packet,
            end: span.leave,
            light: Light::none(simd),
            clear: span.enter.simd_lt(span.leave),
            begun: Mask::splat(simd, false),
            last: Place { position: Floats::splat(simd, 0.0), segment: Integers::splat(simd, 0) },
            last_at: [0.0; LANES],
            statistics,
        }
    }

    /// The rays in a region's padded coordinates.
    #[inline(always)]
    fn local(&self, plan: &RegionPlan, level: u8) -> LocalRays {
        let size = &self.march.evaluator.plan.finest_cells[usize::from(level)];
        let (mut start, mut direction) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for axis in 0..3 {
            let scale = size[axis].recip();
            for lane in 0..LANES {
                start[axis][lane] = self.packet.start[axis][lane] * scale - plan.low[axis];
                direction[axis][lane] = self.packet.direction[axis][lane] * scale;
            }
        }
        LocalRays { start, direction }
    }

    /// Takes a sample on the region's face or in it, at `at`, and adds the interval that ends there for `joined` rays.
    #[inline(never)]
    fn sample_at(
        &mut self,
        region: usize,
        local: &LocalRays,
        at: &[f64; LANES],
        rays: Mask<S>,
        joined: Mask<S>,
        window: Window,
    ) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let plan = &self.march.evaluator.plan.regions[region];
                let point = local.at(simd, at);
                let value = self.march.evaluator.anywhere(simd, region, plan, point, rays);
                let place = self.march.segments.place(simd, value, window);
                let mut length = [0.0; LANES];
                for lane in 0..LANES {
                    length[lane] = (at[lane] - self.last_at[lane]) as f32;
                }
                self.add(place, Floats::from_slice(simd, &length), joined);
                self.last = select(rays, place, self.last);
                let at = *at;
                for lane in 0..LANES {
                    if rays.test(lane) {
                        self.last_at[lane] = at[lane];
                    }
                }
                self.statistics.samples += u64::from(rays.to_bitmask().count_ones());
            },
        );
    }

    /// Adds the interval from the last samples to `place`. Samples that are no numbers are as if they were like the
    /// other end of their interval, over half of it.
    #[inline(always)]
    fn add(&mut self, place: Place<S>, length: Floats<S>, rays: Mask<S>) {
        let simd = self.simd;
        let mut interval = Interval { from: self.last, to: place, length };
        let mut seen = rays;
        let sum = self.last.position + place.position;
        let unknown = sum.simd_ne(sum) & rays;
        if unknown.any_true() {
            let known_from = interval.from.position.simd_eq(interval.from.position);
            let known_to = interval.to.position.simd_eq(interval.to.position);
            seen &= known_from | known_to;
            let half = length * Floats::splat(simd, 0.5);
            interval = Interval {
                from: select(known_from, interval.from, interval.to),
                to: select(known_to, interval.to, interval.from),
                length: unknown.select(half, length),
            };
        }
        self.march.segments.add(simd, &mut self.light, &interval, seen);
    }

    /// The samples of a region that is seen.
    #[inline(always)]
    fn march_through(
        &mut self,
        region: usize,
        plan: &RegionPlan,
        look: &RegionLook,
        local: &LocalRays,
        span: &Span<S>,
        rays: Mask<S>,
    ) {
        let simd = self.simd;
        let zero = Floats::splat(simd, 0.0);
        let [enter, leave]: [[f32; LANES]; 2] = [span.enter.into(), span.leave.into()];
        let (mut first, mut count, mut step) = ([0.0f64; LANES], [0.0f64; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let length = self.packet.coarse_step[lane] * look.step;
            let offset = self.packet.offset[lane];
            let number = |place: f32| ((f64::from(place) - offset) / length).ceil();
            let start = number(enter[lane]);
            first[lane] = offset + start * length;
            count[lane] = number(leave[lane]) - start;
            step[lane] = length;
        }
        let mut start = [zero; 3];
        let mut stride = [zero; 3];
        let start_points = local.at(simd, &first);
        for axis in 0..3 {
            start[axis] = start_points[axis];
            stride[axis] = floats(simd, |lane| local.direction[axis][lane] * step[lane]);
        }
        let counts = rays.select(floats(simd, |lane| count[lane]), zero);
        let most = reduce(counts, f32::max);
        if most < 1.0 {
            return;
        }
        let mut length = floats(simd, |lane| first[lane] - self.last_at[lane]);
        let whole_length = floats(simd, |lane| step[lane]);
        let pure = pure_steps(simd, plan, &start, &stride, counts);
        let evaluator = self.march.evaluator;
        let segments = self.march.segments;
        let mut number = 0.0f32;
        while number < most {
            let numbers = Floats::splat(simd, number);
            let active = numbers.simd_lt(counts) & self.clear;
            if active.all_false() {
                break;
            }
            let mut point = start;
            for axis in 0..3 {
                point[axis] = numbers.mul_add(stride[axis], start[axis]);
            }
            let samples = u64::from(active.to_bitmask().count_ones());
            let value = if pure.contains(&number) {
                self.statistics.interior_samples += samples;
                evaluator.pure(simd, plan, point)
            } else {
                evaluator.anywhere(simd, region, plan, point, active)
            };
            self.statistics.samples += samples;
            let place = segments.place(simd, value, look.window);
            self.add(place, length, active);
            self.last = select(active, place, self.last);
            self.clear &= self.light.transmittance.simd_ge(Floats::splat(simd, OPAQUE));
            length = whole_length;
            number += 1.0;
        }
        let counts: [f32; LANES] = counts.into();
        for lane in 0..LANES {
            if counts[lane] >= 1.0 {
                self.last_at[lane] = first[lane] + (count[lane] - 1.0) * step[lane];
            }
        }
    }
}

impl<S: Gather> Visitor<S> for Marcher<'_, S> {
    #[inline(always)]
    fn wanted(&mut self, node: usize, _: &Span<S>, rays: Mask<S>) -> Mask<S> {
        let rays = rays & self.clear;
        // Where nothing is seen, intervals that came from elsewhere still have to end.
        if self.march.visibility.nodes[node] { rays } else { rays & self.begun }
    }

    #[inline(always)]
    fn visit(&mut self, region: usize, span: &Span<S>, rays: Mask<S>) {
        let simd = self.simd;
        let plan = &self.march.evaluator.plan.regions[region];
        let look = &self.march.visibility.regions[region];
        let [enter, leave]: [[f32; LANES]; 2] = [span.enter.into(), span.leave.into()];
        let [enter, leave] = [enter.map(f64::from), leave.map(f64::from)];
        self.statistics.region_visits += 1;
        let Some(level) = plan.level else {
            // A hole: the last value goes on up to it.
            let length = floats(simd, |lane| enter[lane] - self.last_at[lane]);
            self.add(self.last, length, rays & self.begun);
            self.begun &= !rays;
            return;
        };
        let local = self.local(plan, level);
        if !look.visible {
            let ending = rays & self.begun;
            self.sample_at(region, &local, &enter, ending, ending, look.window);
            self.begun &= !ending;
            return;
        }
        let beginning = rays & !self.begun;
        if beginning.any_true() {
            self.sample_at(region, &local, &enter, beginning, Mask::splat(simd, false), look.window);
            self.begun |= beginning;
        }
        self.march_through(region, plan, look, &local, span, rays);
        let ending = rays & self.clear & span.leave.simd_ge(self.end);
        if ending.any_true() {
            self.sample_at(region, &local, &leave, ending, ending, look.window);
            self.begun &= !ending;
        }
    }
}

impl LocalRays {
    #[inline(always)]
    fn at<S: Gather>(&self, simd: S, at: &[f64; LANES]) -> [Floats<S>; 3] {
        [0, 1, 2].map(
            #[inline(always)]
            |axis| floats(simd, |lane| self.start[axis][lane] + at[lane] * self.direction[axis][lane]),
        )
    }
}

/// The steps, counted from 0, at which all rays are inside the region's pure box.
#[inline(always)]
fn pure_steps<S: Gather>(
    simd: S,
    plan: &RegionPlan,
    start: &[Floats<S>; 3],
    stride: &[Floats<S>; 3],
    counts: Floats<S>,
) -> Range<f32> {
    if plan.is_pure {
        return 0.0..f32::INFINITY;
    }
    let zero = Floats::splat(simd, 0.0);
    let infinity = Floats::splat(simd, f32::INFINITY);
    let (mut enter, mut leave) = (zero, infinity);
    for axis in 0..3 {
        let inverse = Floats::splat(simd, 1.0) / stride[axis];
        let [a, b] = [0, 1].map(
            #[inline(always)]
            |side| (Floats::splat(simd, plan.pure[side][axis]) - start[axis]) * inverse,
        );
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    // Rays that are through before they get there, or before they leave, do not matter.
    let enter = enter.min(counts);
    let leave = leave.simd_ge(counts - Floats::splat(simd, 1.0)).select(infinity, leave);
    let used = counts.simd_gt(zero);
    reduce(used.select(enter, zero), f32::max)..reduce(used.select(leave, infinity), f32::min)
}

#[inline(always)]
fn select<S: Gather>(mask: Mask<S>, yes: Place<S>, no: Place<S>) -> Place<S> {
    Place { position: mask.select(yes.position, no.position), segment: mask.select(yes.segment, no.segment) }
}

/// Lanes computed in double precision.
#[inline(always)]
fn floats<S: Gather>(simd: S, lane: impl Fn(usize) -> f64) -> Floats<S> {
    let mut values = [0.0f32; LANES];
    for (number, value) in values.iter_mut().enumerate() {
        *value = lane(number) as f32;
    }
    Floats::from_slice(simd, &values)
}

#[inline(always)]
fn reduce<S: Gather>(lanes: Floats<S>, combine: impl Fn(f32, f32) -> f32) -> f32 {
    let lanes: [f32; LANES] = lanes.into();
    lanes.into_iter().fold(lanes[0], combine)
}
