//! What lies along rays: samples of a field, and what the intervals between them give off.

use fearless_simd::prelude::*;

use super::super::Integration;
use super::super::visibility::SeenLook;
use crate::appearance::{Glow, Place, Segments, Slopes, Window};
use crate::layout::{RegionFrame, RegionValues};
use crate::simd::{Floats, Gather, Integers, Mask};

/// Where samples come from, and how intervals between them look.
pub(in super::super) trait Medium: Sync {
    /// What is known of sixteen points.
    type Sample<S: Gather>: Copy;
    /// What is known of all samples in a part of a region ahead of them.
    type Here<S: Gather>: Copy;

    /// Where a region lies.
    fn frame(&self, region: usize) -> &RegionFrame;

    /// Cells of the finest level per cell of `level`.
    fn finest_cells(&self, level: u8) -> &[f64; 3];

    /// No sample.
    fn nothing<S: Gather>(&self, simd: S) -> Self::Sample<S>;

    /// `yes` where the mask is set, else `no`.
    fn select<S: Gather>(&self, mask: Mask<S>, yes: Self::Sample<S>, no: Self::Sample<S>) -> Self::Sample<S>;

    /// A part of a region that has a look; without one, all values may come.
    fn here<S: Gather>(&self, simd: S, look: Option<&SeenLook>) -> Self::Here<S>;

    /// Samples at points in a region's local coordinates: all of them in its pure box, or the `active` ones anywhere.
    fn sample<S: Gather>(
        &self,
        simd: S,
        region: usize,
        here: &Self::Here<S>,
        point: [Floats<S>; 3],
        points: Points<S>,
    ) -> Self::Sample<S>;

    /// What lies between the samples at both ends of intervals; `None` where nothing of it is seen.
    fn interval<S: Gather>(
        &self,
        simd: S,
        here: &mut Self::Here<S>,
        ends: [&Self::Sample<S>; 2],
        length: Floats<S>,
        rays: Mask<S>,
    ) -> Option<Interval<S>>;
}

/// Which points are sampled.
#[derive(Clone, Copy)]
pub(in super::super) enum Points<S: Gather> {
    /// All, and all of them lie in the pure box.
    Pure,
    /// Some, anywhere in the region.
    Anywhere(Mask<S>),
}

/// What lies between two samples of some rays.
#[derive(Clone, Copy)]
pub(in super::super) struct Interval<S: Gather> {
    pub(in super::super) glow: Glow<S>,
    pub(in super::super) length: Floats<S>,
    pub(in super::super) rays: Mask<S>,
}

/// One field under one transfer function.
#[derive(Clone, Copy)]
pub(in super::super) struct Single<'a, V> {
    pub(in super::super) values: V,
    pub(in super::super) how: How<'a>,
}

/// How intervals between samples become light.
#[derive(Clone, Copy)]
pub(in super::super) struct How<'a> {
    pub(in super::super) segments: &'a Segments,
    pub(in super::super) integration: Integration,
    /// Whether all samples are numbers.
    pub(in super::super) is_finite: bool,
}

/// What is known of the samples of one field ahead of them.
#[derive(Clone, Copy)]
pub(in super::super) struct SingleHere<S: Gather> {
    pub(super) window: Window,
    /// Whether all values lie on one segment, as they mostly do; `slopes` are its.
    is_one_segment: bool,
    may_be_dark: bool,
    slopes: Slopes<S>,
}

impl<V: RegionValues> Medium for Single<'_, V> {
    type Sample<S: Gather> = Place<S>;
    type Here<S: Gather> = SingleHere<S>;

    #[inline(always)]
    fn frame(&self, region: usize) -> &RegionFrame {
        self.values.frame(region)
    }

    #[inline(always)]
    fn finest_cells(&self, level: u8) -> &[f64; 3] {
        self.values.finest_cells(level)
    }

    #[inline(always)]
    fn nothing<S: Gather>(&self, simd: S) -> Place<S> {
        Place::nowhere(simd)
    }

    #[inline(always)]
    fn select<S: Gather>(&self, mask: Mask<S>, yes: Place<S>, no: Place<S>) -> Place<S> {
        Place::select(mask, yes, no)
    }

    #[inline(always)]
    fn here<S: Gather>(&self, simd: S, look: Option<&SeenLook>) -> SingleHere<S> {
        let How { segments, is_finite, .. } = self.how;
        let window = look.map_or(Window::all(segments), |look| look.window);
        SingleHere {
            window,
            is_one_segment: window.first == window.last && is_finite,
            may_be_dark: look.is_some() && segments.may_be_dark(window) && is_finite,
            slopes: segments.slopes(simd, Integers::splat(simd, i32::from(window.first))),
        }
    }

    #[inline(always)]
    fn sample<S: Gather>(
        &self,
        simd: S,
        region: usize,
        here: &SingleHere<S>,
        point: [Floats<S>; 3],
        points: Points<S>,
    ) -> Place<S> {
        let value = match points {
            Points::Pure => self.values.pure(simd, region, point),
            Points::Anywhere(active) => self.values.anywhere(simd, region, point, active),
        };
        self.how.segments.place(simd, value, here.window)
    }

    #[inline(always)]
    fn interval<S: Gather>(
        &self,
        simd: S,
        here: &mut SingleHere<S>,
        ends: [&Place<S>; 2],
        length: Floats<S>,
        rays: Mask<S>,
    ) -> Option<Interval<S>> {
        let segments = self.how.segments;
        if here.may_be_dark && segments.is_dark(simd, ends, rays) {
            return None;
        }
        if !here.is_one_segment {
            here.slopes = segments.slopes(simd, ends[1].segment);
        }
        Some(self.how.between(simd, &here.slopes, ends, length, rays))
    }
}

impl How<'_> {
    /// The intervals between two places, with the slopes of the second one. A sample that is no number is taken to be
    /// like the other end of its interval, over half of it.
    #[inline(always)]
    pub(in super::super) fn between<S: Gather>(
        self,
        simd: S,
        slopes: &Slopes<S>,
        [from, to]: [&Place<S>; 2],
        length: Floats<S>,
        rays: Mask<S>,
    ) -> Interval<S> {
        let Self { segments, integration, is_finite } = self;
        let mut interval = Interval {
            glow: match integration {
                Integration::Preintegrated => segments.mean(simd, [from, to], slopes, rays),
                Integration::AtSamples => segments.midway(simd, from.position, to.position),
            },
            length,
            rays,
        };
        if !is_finite {
            let sum = from.position + to.position;
            let unknown = sum.simd_ne(sum) & rays;
            let known_from = from.position.simd_eq(from.position);
            let known_to = to.position.simd_eq(to.position);
            let known = Place::select(known_to, *to, *from);
            let alone = segments.slopes(simd, known.segment).mean(simd, known.position, known.position);
            interval.glow = Glow::select(unknown, alone, interval.glow);
            interval.length = unknown.select(length * Floats::splat(simd, 0.5), length);
            interval.rays &= known_from | known_to;
        }
        interval
    }
}
