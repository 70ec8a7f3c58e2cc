//! Integrals and extremes of the reconstruction along rays.

use fearless_simd::prelude::*;

use super::cubic::Cubic;
use super::{Steps, Stretch};
use crate::layout::{PieceNode, RegionValues};
use crate::render::packet::{Masks, PACKETS};
use crate::simd::{Doubles, Floats, Gather, Mask};

/// Sums up values times lengths, and lengths where there are values.
pub(in super::super) struct Sums<S: Gather> {
    going: Masks<S>,
    pub(in super::super) integral: [Doubles<S>; PACKETS],
    pub(in super::super) length: [Doubles<S>; PACKETS],
}

/// Finds the highest values.
pub(in super::super) struct Highest<S: Gather> {
    going: Masks<S>,
    /// 1, or -1 to find the lowest ones.
    sign: f32,
    /// The values at the ends of the last steps.
    last: [Floats<S>; PACKETS],
    /// The highest values so far, times the sign; minus infinity where there was none.
    pub(in super::super) highest: [Floats<S>; PACKETS],
}

impl<S: Gather> Sums<S> {
    #[inline(always)]
    pub(in super::super) fn new(simd: S, going: Masks<S>) -> Self {
        let nothing = [Doubles::splat(simd, 0.0); PACKETS];
        Self { going, integral: nothing, length: nothing }
    }
}

impl<S: Gather, V: RegionValues> Steps<S, V> for Sums<S> {
    #[inline(always)]
    fn going(&self) -> &Masks<S> {
        &self.going
    }

    #[inline(always)]
    fn enter(&mut self, _: &Stretch<S, V>, _: usize, _: Mask<S>) {}

    /// Gauss's rule of two points, which is exact for cubics, and which keeps off planes over which values jump.
    #[inline(always)]
    fn step(&mut self, stretch: &Stretch<S, V>, packet: usize, ends: [Floats<S>; 2], rays: Mask<S>) {
        // How far the points are from the middle, over the step.
        const OFF: f32 = 0.288_675_13;
        let simd = stretch.simd;
        let zero = Floats::splat(simd, 0.0);
        let [from, to] = ends;
        let half = (to - from) * Floats::splat(simd, 0.5);
        let (middle, off) = (from + half, (to - from) * Floats::splat(simd, OFF));
        let (mut sum, mut length) = (zero, zero);
        for place in [middle - off, middle + off] {
            let values = stretch.values(place, ends, rays);
            let known = rays & values.is_finite();
            sum += known.select(values * half, zero);
            length += known.select(half, zero);
        }
        self.integral[packet] = self.integral[packet] + Doubles::from_floats(sum);
        self.length[packet] = self.length[packet] + Doubles::from_floats(length);
    }

    #[inline(always)]
    fn pass(&mut self, _: S, _: &PieceNode, _: usize, _: Floats<S>, _: Mask<S>) {}
}

impl<S: Gather> Highest<S> {
    #[inline(always)]
    pub(in super::super) fn new(simd: S, going: Masks<S>, sign: f32) -> Self {
        let nothing = [Floats::splat(simd, f32::NEG_INFINITY); PACKETS];
        Self { going, sign, last: nothing, highest: nothing }
    }

    #[inline(always)]
    fn look(&mut self, packet: usize, values: Floats<S>, rays: Mask<S>) {
        let highest = self.highest[packet];
        self.highest[packet] = (rays & values.simd_gt(highest) & values.is_finite()).select(values, highest);
    }
}

impl<S: Gather, V: RegionValues> Steps<S, V> for Highest<S> {
    #[inline(always)]
    fn going(&self) -> &Masks<S> {
        &self.going
    }

    #[inline(always)]
    fn enter(&mut self, stretch: &Stretch<S, V>, packet: usize, rays: Mask<S>) {
        let zero = Floats::splat(stretch.simd, 0.0);
        self.last[packet] = stretch.values(zero, [zero, zero], rays);
    }

    #[inline(always)]
    fn step(&mut self, stretch: &Stretch<S, V>, packet: usize, ends: [Floats<S>; 2], rays: Mask<S>) {
        let simd = stretch.simd;
        let sign = Floats::splat(simd, self.sign);
        let [from, to] = ends;
        let (mut values, end) = stretch.of_step(self.last[packet], ends, rays);
        self.last[packet] = rays.select(end, self.last[packet]);
        for value in &mut values {
            *value *= sign;
        }
        for value in &values {
            self.look(packet, *value, rays);
        }
        let cubic = Cubic::through(simd, &values);
        let [_, bound] = cubic.bounds(simd);
        let doubtful = rays & bound.simd_gt(self.highest[packet]);
        if doubtful.any_true() {
            for extreme in cubic.extremes(simd) {
                // Infinity, where there is none, is the step's end.
                let at = extreme.min(Floats::splat(simd, 1.0)).mul_add(to - from, from);
                self.look(packet, stretch.values(at, ends, rays) * sign, doubtful);
            }
        }
    }

    #[inline(always)]
    fn pass(&mut self, _: S, _: &PieceNode, _: usize, _: Floats<S>, _: Mask<S>) {}
}
