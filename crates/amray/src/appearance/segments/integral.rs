//! What intervals of values emit and absorb, sixteen rays at a time.

#[cfg(test)]
mod tests;

use fearless_simd::prelude::*;

use super::{PositionAxis, Segments, Window};
use crate::simd::{Floats, Gather, Integers, Mask, exp2, log2};

/// Windows of so few segments are searched one by one.
const FEW: u16 = 6;

/// What sixteen rays have collected so far.
#[derive(Clone, Copy)]
pub(crate) struct Light<S: Gather> {
    pub(crate) color: [Floats<S>; 3],
    pub(crate) transmittance: Floats<S>,
}

/// Positions, and the segments that they lie in.
#[derive(Clone, Copy)]
pub(crate) struct Place<S: Gather> {
    pub(crate) position: Floats<S>,
    pub(crate) segment: Integers<S>,
}

/// Extinction and emission (extinction times red, green and blue), or their integrals over positions.
#[derive(Clone, Copy)]
pub(crate) struct Glow<S: Gather> {
    extinction: Floats<S>,
    emission: [Floats<S>; 3],
}

/// How the integrals go on over segments: coefficients of their derivatives.
#[derive(Clone, Copy)]
pub(crate) struct Slopes<S: Gather> {
    extinction: [Floats<S>; 2],
    emission: [[Floats<S>; 3]; 3],
}

impl<S: Gather> Light<S> {
    /// None, and everything to come is seen.
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        Self { color: [Floats::splat(simd, 0.0); 3], transmittance: Floats::splat(simd, 1.0) }
    }

    /// Adds what `active` rays meet over a length.
    #[inline(always)]
    pub(crate) fn add(&mut self, simd: S, glow: &Glow<S>, length: Floats<S>, active: Mask<S>) {
        let zero = Floats::splat(simd, 0.0);
        let depth = (glow.extinction * length).max(zero);
        // Alpha over depth. No lookahead of many steps fits into a processor: what counts is how soon a step is done.
        let (ratio, alpha) = if (active & depth.simd_gt(Floats::splat(simd, THIN))).all_false() {
            let ratio = thin(simd, depth);
            (ratio, ratio * depth)
        } else {
            let is_thick = depth.simd_gt(Floats::splat(simd, THIN));
            let ratio = thin(simd, depth);
            let alpha = Floats::splat(simd, 1.0) - exp2(simd, depth * Floats::splat(simd, -std::f32::consts::LOG2_E));
            (is_thick.select(alpha / depth, ratio), is_thick.select(alpha, ratio * depth))
        };
        let share = self.transmittance * ratio * length;
        for channel in 0..3 {
            // What other rays would add may be no number.
            let sum = share.mul_add(glow.emission[channel], self.color[channel]);
            self.color[channel] = active.select(sum, self.color[channel]);
        }
        self.transmittance = active.select(self.transmittance - self.transmittance * alpha, self.transmittance);
    }
}

/// Optical depths up to which `thin` is used.
const THIN: f32 = 0.5;

/// (1 - exp(-depth)) / depth for depths of 0 to 1/2, relative error below 2e-7.
#[inline(always)]
fn thin<S: Gather>(simd: S, depth: Floats<S>) -> Floats<S> {
    let square = depth * depth;
    let low = depth.mul_add(Floats::splat(simd, -0.499_994_63), Floats::splat(simd, 1.0));
    let high = depth.mul_add(Floats::splat(simd, -0.041_042_48), Floats::splat(simd, 0.166_563_6));
    square.mul_add(square.mul_add(Floats::splat(simd, 0.006_807_61), high), low)
}

impl<S: Gather> Place<S> {
    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self { position: mask.select(yes.position, no.position), segment: mask.select(yes.segment, no.segment) }
    }
}

impl<S: Gather> Glow<S> {
    /// Nothing.
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        Self { extinction: Floats::splat(simd, 0.0), emission: [Floats::splat(simd, 0.0); 3] }
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        let mut selected = Self { extinction: mask.select(yes.extinction, no.extinction), ..no };
        for channel in 0..3 {
            selected.emission[channel] = mask.select(yes.emission[channel], no.emission[channel]);
        }
        selected
    }

    /// The mean between two places, from the integrals up to them.
    #[inline(always)]
    fn between([from, to]: [&Self; 2], width: Floats<S>) -> Self {
        // To four digits: this goes into an opacity.
        let inverse = width.approximate_recip();
        let mut mean = Self { extinction: (to.extinction - from.extinction) * inverse, ..*to };
        for channel in 0..3 {
            mean.emission[channel] = (to.emission[channel] - from.emission[channel]) * inverse;
        }
        mean
    }
}

impl<S: Gather> Slopes<S> {
    /// The mean over intervals that lie on one segment each, between two positions.
    #[inline(always)]
    pub(crate) fn mean(&self, simd: S, from: Floats<S>, to: Floats<S>) -> Glow<S> {
        let middle = (from + to) * Floats::splat(simd, 0.5);
        let width = to - from;
        // The mean square of the position.
        let square = (width * width).mul_add(Floats::splat(simd, 1.0 / 12.0), middle * middle);
        let [base, slope] = self.extinction;
        let mut mean = Glow { extinction: middle.mul_add(slope, base), emission: [square; 3] };
        for channel in 0..3 {
            let [base, slope, curvature] = self.emission[channel];
            mean.emission[channel] = square.mul_add(curvature, middle.mul_add(slope, base));
        }
        mean
    }
}

impl Segments {
    /// Where values, in units of the field's range, lie; `window` are the segments that they can lie in.
    #[inline(always)]
    pub(crate) fn place<S: Gather>(&self, simd: S, value: Floats<S>, window: Window) -> Place<S> {
        let position = match self.axis {
            PositionAxis::Linear => value,
            PositionAxis::Log { shift, factor, offset } => {
                let least = Floats::splat(simd, f32::MIN_POSITIVE);
                let logarithm = log2(simd, (value + Floats::splat(simd, shift)).max(least));
                let position = logarithm.mul_add(Floats::splat(simd, factor), Floats::splat(simd, offset));
                let position = position.max(Floats::splat(simd, 0.0)).min(Floats::splat(simd, 1.0));
                let unknown = value.simd_ne(value);
                unknown.select(value, position)
            }
        };
        Place { position, segment: self.search(simd, position, window) }
    }

    /// The segments of a window that positions lie in.
    #[inline(always)]
    fn search<S: Gather>(&self, simd: S, position: Floats<S>, window: Window) -> Integers<S> {
        let last = Integers::splat(simd, i32::from(window.last));
        let mut segment = Integers::splat(simd, i32::from(window.first));
        if window.last - window.first < FEW {
            // No comparison waits for another one.
            let one = Integers::splat(simd, 1);
            for next in &self.starts[usize::from(window.first) + 1..=usize::from(window.last)] {
                segment = position.simd_ge(Floats::splat(simd, *next)).select(segment + one, segment);
            }
            return segment;
        }
        // The highest segment that starts at or below the position.
        let mut step = ((u32::from(window.last - window.first) + 1).next_power_of_two() / 2) as i32;
        while step > 0 {
            let next = (segment + Integers::splat(simd, step)).min(last);
            let reached = position.simd_ge(simd.look_up(&self.starts, next));
            segment = reached.select(next, segment);
            step /= 2;
        }
        segment
    }

    /// What is halfway between two positions: the function as it is at one sample.
    #[inline(always)]
    pub(crate) fn midway<S: Gather>(&self, simd: S, from: Floats<S>, to: Floats<S>) -> Glow<S> {
        let middle = (from + to) * Floats::splat(simd, 0.5);
        let segment = self.search(simd, middle, Window::all(self));
        self.slopes(simd, segment).mean(simd, middle, middle)
    }

    /// The slopes of the segments of places.
    #[inline(always)]
    pub(crate) fn slopes<S: Gather>(&self, simd: S, segment: Integers<S>) -> Slopes<S> {
        let [_, base, slope] = &self.extinction;
        let extinction = [simd.look_up(base, segment), simd.look_up(slope, segment)];
        let mut emission = [[extinction[0]; 3]; 3];
        for channel in 0..3 {
            for power in 0..3 {
                emission[channel][power] = simd.look_up(&self.emission[channel][power + 1], segment);
            }
        }
        Slopes { extinction, emission }
    }

    /// The integrals of extinction and emission from position 0 to places.
    #[inline(always)]
    pub(crate) fn integral<S: Gather>(&self, simd: S, place: &Place<S>, slopes: &Slopes<S>) -> Glow<S> {
        let (half, third) = (Floats::splat(simd, 1.0 / 2.0), Floats::splat(simd, 1.0 / 3.0));
        let x = place.position;
        let [base, slope] = slopes.extinction;
        let constant = simd.look_up(&self.extinction[0], place.segment);
        let mut integral = Glow { extinction: x.mul_add(x.mul_add(slope * half, base), constant), emission: [x; 3] };
        for channel in 0..3 {
            let [base, slope, curvature] = slopes.emission[channel];
            let constant = simd.look_up(&self.emission[channel][0], place.segment);
            let rest = x.mul_add(x.mul_add(curvature * third, slope * half), base);
            integral.emission[channel] = x.mul_add(rest, constant);
        }
        integral
    }

    /// The mean over intervals between two places, exact for values that run linearly; each place with the integral up
    /// to it, and the slopes at the second one.
    #[inline(always)]
    pub(crate) fn mean<S: Gather>(
        &self,
        simd: S,
        [from, to]: [(&Place<S>, &Glow<S>); 2],
        slopes: &Slopes<S>,
    ) -> Glow<S> {
        // The difference of integrals over less would be rounding.
        const NARROW: f32 = 1e-4;
        let width = to.0.position - from.0.position;
        let apart = from.0.segment.simd_ne(to.0.segment) & width.abs().simd_gt(Floats::splat(simd, NARROW));
        let same = slopes.mean(simd, from.0.position, to.0.position);
        Glow::select(apart, Glow::between([from.1, to.1], width), same)
    }
}
