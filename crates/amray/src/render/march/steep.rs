//! Samples of one field that know where its values rise.

use fearless_simd::prelude::*;

use super::super::visibility::SeenLook;
use super::medium::{Interval, Medium, Points, Single, SingleHere};
use crate::appearance::Place;
use crate::layout::{RegionFrame, RegionValues};
use crate::reconstruction::ValuesAndGradients;
use crate::simd::{Floats, Gather, Mask};

/// A medium whose samples may have gradients.
pub(in super::super) trait Sloped: Medium {
    /// The gradient between two samples: of the position in the transfer function, per longest side of the domain.
    fn gradient<S: Gather>(simd: S, ends: [&Self::Sample<S>; 2]) -> [Floats<S>; 3];
}

/// Without gradients, what reflects does so alike in all directions.
impl<V: RegionValues> Sloped for Single<'_, V> {
    #[inline(always)]
    fn gradient<S: Gather>(simd: S, _ends: [&Place<S>; 2]) -> [Floats<S>; 3] {
        [Floats::splat(simd, 0.0); 3]
    }
}

/// One field under one transfer function, with gradients.
pub(in super::super) struct Steep<'a, V> {
    pub(in super::super) single: Single<'a, V>,
    /// Per level, the domain's longest side over the cell size.
    pub(in super::super) cells: &'a [[f32; 3]],
}

/// A place with the gradient there.
#[derive(Clone, Copy)]
pub(in super::super) struct SteepPlace<S: Gather> {
    pub(super) place: Place<S>,
    pub(super) gradient: [Floats<S>; 3],
}

impl<S: Gather> SteepPlace<S> {
    /// No place.
    #[inline(always)]
    pub(super) fn nowhere(simd: S) -> Self {
        Self { place: Place::nowhere(simd), gradient: [Floats::splat(simd, 0.0); 3] }
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(super) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        let mut selected = Self { place: Place::select(mask, yes.place, no.place), ..no };
        for axis in 0..3 {
            selected.gradient[axis] = mask.select(yes.gradient[axis], no.gradient[axis]);
        }
        selected
    }
}

/// The gradient between two samples.
#[inline(always)]
pub(super) fn between<S: Gather>([from, to]: [&[Floats<S>; 3]; 2]) -> [Floats<S>; 3] {
    let mut sum = *from;
    for axis in 0..3 {
        sum[axis] = (sum[axis] + to[axis]) * 0.5;
    }
    sum
}

impl<V: RegionValues> Single<'_, V> {
    /// Samples with their gradients; `cells` are, per level, the domain's longest side over the cell size.
    #[inline(always)]
    pub(super) fn sample_with_gradient<S: Gather>(
        &self,
        simd: S,
        region: usize,
        here: &SingleHere<S>,
        (point, points): ([Floats<S>; 3], Points<S>),
        cells: &[[f32; 3]],
    ) -> SteepPlace<S> {
        let Single { values, how } = self;
        let ValuesAndGradients { values, gradients: mut gradient } = match points {
            Points::Pure => values.pure_with_gradient(simd, region, point),
            Points::Anywhere(active) => values.anywhere_with_gradient(simd, region, point, active),
        };
        let place = how.segments.place(simd, values, here.window);
        let slope = how.segments.position_slope(simd, values);
        let cells = &cells[usize::from(self.frame(region).level.unwrap_or(0))];
        for axis in 0..3 {
            gradient[axis] *= slope * Floats::splat(simd, cells[axis]);
        }
        SteepPlace { place, gradient }
    }
}

impl<V: RegionValues> Sloped for Steep<'_, V> {
    #[inline(always)]
    fn gradient<S: Gather>(_simd: S, [from, to]: [&SteepPlace<S>; 2]) -> [Floats<S>; 3] {
        between([&from.gradient, &to.gradient])
    }
}

impl<V: RegionValues> Medium for Steep<'_, V> {
    type Sample<S: Gather> = SteepPlace<S>;
    type Here<S: Gather> = SingleHere<S>;

    #[inline(always)]
    fn frame(&self, region: usize) -> &RegionFrame {
        self.single.frame(region)
    }

    #[inline(always)]
    fn finest_cells(&self, level: u8) -> &[f64; 3] {
        self.single.finest_cells(level)
    }

    #[inline(always)]
    fn nothing<S: Gather>(&self, simd: S) -> SteepPlace<S> {
        SteepPlace::nowhere(simd)
    }

    #[inline(always)]
    fn select<S: Gather>(&self, mask: Mask<S>, yes: SteepPlace<S>, no: SteepPlace<S>) -> SteepPlace<S> {
        SteepPlace::select(mask, yes, no)
    }

    #[inline(always)]
    fn here<S: Gather>(&self, simd: S, look: Option<&SeenLook>) -> SingleHere<S> {
        self.single.here(simd, look)
    }

    #[inline(always)]
    fn sample<S: Gather>(
        &self,
        simd: S,
        region: usize,
        here: &SingleHere<S>,
        point: [Floats<S>; 3],
        points: Points<S>,
    ) -> SteepPlace<S> {
        self.single.sample_with_gradient(simd, region, here, (point, points), self.cells)
    }

    #[inline(always)]
    fn interval<S: Gather>(
        &self,
        simd: S,
        here: &mut SingleHere<S>,
        [from, to]: [&SteepPlace<S>; 2],
        length: Floats<S>,
        rays: Mask<S>,
    ) -> Option<Interval<S>> {
        self.single.interval(simd, here, [&from.place, &to.place], length, rays)
    }
}
