//! What intervals of values emit and absorb, sixteen rays at a time.

#[cfg(test)]
mod tests;

use fearless_simd::prelude::*;

use super::tables::{INTEGRALS, SLOPES, START};
use super::{PositionAxis, Segments, Window};
use crate::simd::{Floats, Gather, Integers, Mask, exp2, log2};

/// Windows of so few segments are searched one by one.
const FEW: u16 = 6;

/// What sixteen rays have collected so far.
#[derive(Clone, Copy)]
pub(crate) struct Radiance<S: Gather> {
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
    pub(crate) extinction: Floats<S>,
    pub(crate) emission: [Floats<S>; 3],
}

/// How extinction and emission run on segments: polynomials of the distance from where each starts.
#[derive(Clone, Copy)]
pub(crate) struct Slopes<S: Gather> {
    start: Floats<S>,
    extinction: [Floats<S>; 2],
    emission: [[Floats<S>; 3]; 3],
}

impl<S: Gather> Radiance<S> {
    /// None, and everything to come is seen.
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        Self { color: [Floats::splat(simd, 0.0); 3], transmittance: Floats::splat(simd, 1.0) }
    }

    /// Adds what `active` rays meet over a length.
    #[inline(always)]
    pub(crate) fn add(&mut self, simd: S, glow: &Glow<S>, length: Floats<S>, active: Mask<S>) {
        let Some(Absorbed { share, .. }) = attenuate(simd, &mut self.transmittance, glow.extinction, length, active)
        else {
            return;
        };
        for channel in 0..3 {
            // What other rays would add may be no number.
            let sum = share.mul_add(glow.emission[channel], self.color[channel]);
            self.color[channel] = active.select(sum, self.color[channel]);
        }
    }
}

/// What rays have absorbed over a length.
pub(crate) struct Absorbed<S: Gather> {
    /// By what emission is multiplied.
    pub(crate) share: Floats<S>,
    /// By how much the transmittance has fallen, and by what share of it.
    pub(crate) opacity: Floats<S>,
    pub(crate) alpha: Floats<S>,
}

/// Lessens the transmittance of `active` rays by what they absorb over a length; `None` where that is nothing.
#[inline(always)]
pub(crate) fn attenuate<S: Gather>(
    simd: S,
    transmittance: &mut Floats<S>,
    extinction: Floats<S>,
    length: Floats<S>,
    active: Mask<S>,
) -> Option<Absorbed<S>> {
    let zero = Floats::splat(simd, 0.0);
    // Rounding may leave a little less than nothing.
    let depth = (extinction * length).max(zero);
    if (active & depth.simd_gt(zero)).all_false() {
        return None;
    }
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
    let (share, opacity) = (*transmittance * ratio * length, *transmittance * alpha);
    *transmittance = active.select(*transmittance - opacity, *transmittance);
    Some(Absorbed { share, opacity, alpha })
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
    /// A place that stands for none.
    #[inline(always)]
    pub(crate) fn nowhere(simd: S) -> Self {
        Self { position: Floats::splat(simd, 0.0), segment: Integers::splat(simd, 0) }
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self { position: mask.select(yes.position, no.position), segment: mask.select(yes.segment, no.segment) }
    }
}

impl<S: Gather> Glow<S> {
    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        let mut selected = Self { extinction: mask.select(yes.extinction, no.extinction), ..no };
        for channel in 0..3 {
            selected.emission[channel] = mask.select(yes.emission[channel], no.emission[channel]);
        }
        selected
    }

    /// `weight` times the difference of two.
    #[inline(always)]
    fn difference(&self, other: &Self, weight: Floats<S>) -> Self {
        let mut difference = Self { extinction: (self.extinction - other.extinction) * weight, ..*self };
        for channel in 0..3 {
            difference.emission[channel] = (self.emission[channel] - other.emission[channel]) * weight;
        }
        difference
    }
}

impl<S: Gather> Slopes<S> {
    /// The mean over intervals that lie on one segment each, between two positions.
    #[inline(always)]
    pub(crate) fn mean(&self, simd: S, from: Floats<S>, to: Floats<S>) -> Glow<S> {
        let middle = (from + to).mul_add(Floats::splat(simd, 0.5), -self.start);
        let width = to - from;
        // The mean square of the distance.
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

    /// By how much positions change per unit of the field's range at values.
    #[inline(always)]
    pub(crate) fn position_slope<S: Gather>(&self, simd: S, value: Floats<S>) -> Floats<S> {
        match self.axis {
            PositionAxis::Linear => Floats::splat(simd, 1.0),
            PositionAxis::Log { shift, factor, .. } => {
                let shifted = (value + Floats::splat(simd, shift)).max(Floats::splat(simd, f32::MIN_POSITIVE));
                Floats::splat(simd, factor * std::f32::consts::LOG2_E) / shifted
            }
        }
    }

    /// The segments of a window that positions lie in.
    #[inline(always)]
    fn search<S: Gather>(&self, simd: S, position: Floats<S>, window: Window) -> Integers<S> {
        let last = Integers::splat(simd, i32::from(window.last));
        let mut segment = Integers::splat(simd, i32::from(window.first));
        if window.last - window.first < FEW {
            // No comparison waits for another one.
            let one = Integers::splat(simd, 1);
            for next in &self.starts()[usize::from(window.first) + 1..=usize::from(window.last)] {
                segment = position.simd_ge(Floats::splat(simd, *next)).select(segment + one, segment);
            }
            return segment;
        }
        // The highest segment that starts at or below the position.
        let mut step = ((u32::from(window.last - window.first) + 1).next_power_of_two() / 2) as i32;
        while step > 0 {
            let next = (segment + Integers::splat(simd, step)).min(last);
            let reached = position.simd_ge(self.tables.look_up(simd, [START], next)[0]);
            segment = reached.select(next, segment);
            step /= 2;
        }
        segment
    }

    /// Whether all values between two places of all `rays` lie below, or above, all that is seen.
    #[inline(always)]
    pub(crate) fn is_dark<S: Gather>(&self, simd: S, [from, to]: [&Place<S>; 2], rays: Mask<S>) -> bool {
        let below = from.segment.max(to.segment).simd_lt(Integers::splat(simd, self.lit[0]));
        let above = from.segment.min(to.segment).simd_gt(Integers::splat(simd, self.lit[1]));
        (rays & !(below | above)).all_false()
    }

    /// What is halfway between two positions: the function as it is at one sample.
    #[inline(always)]
    pub(crate) fn midway<S: Gather>(&self, simd: S, from: Floats<S>, to: Floats<S>) -> Glow<S> {
        let middle = (from + to) * Floats::splat(simd, 0.5);
        let segment = self.search(simd, middle, Window::all(self));
        self.slopes(simd, segment).mean(simd, middle, middle)
    }

    /// The slopes of segments.
    #[inline(always)]
    pub(crate) fn slopes<S: Gather>(&self, simd: S, segment: Integers<S>) -> Slopes<S> {
        let [start, base, slope, r0, r1, r2, g0, g1, g2, b0, b1, b2] = self.tables.look_up(simd, SLOPES, segment);
        Slopes { start, extinction: [base, slope], emission: [[r0, r1, r2], [g0, g1, g2], [b0, b1, b2]] }
    }

    /// The means over intervals between two places, exact for values that run linearly, with the slopes of the second
    /// one. Those of other than `rays` are anything.
    #[inline(always)]
    pub(crate) fn mean<S: Gather>(
        &self,
        simd: S,
        [from, to]: [&Place<S>; 2],
        slopes: &Slopes<S>,
        rays: Mask<S>,
    ) -> Glow<S> {
        let mean = slopes.mean(simd, from.position, to.position);
        let crosses = from.segment.simd_ne(to.segment);
        // Mostly no value crosses from one segment to another.
        if (crosses & rays).all_false() {
            return mean;
        }
        Glow::select(crosses, self.mean_across(simd, [from, to], slopes), mean)
    }

    /// The means over intervals between places on different segments.
    #[inline(always)]
    fn mean_across<S: Gather>(&self, simd: S, [from, to]: [&Place<S>; 2], slopes: &Slopes<S>) -> Glow<S> {
        // The difference of integrals over less would be rounding.
        const NARROW: f32 = 1e-5;
        let from_slopes = self.slopes(simd, from.segment);
        let width = to.position - from.position;
        let inverse = Floats::splat(simd, 1.0) / width;
        let wide = self.integral(simd, to, slopes).difference(&self.integral(simd, from, &from_slopes), inverse);
        let is_wide = width.abs().simd_gt(Floats::splat(simd, NARROW));
        if is_wide.all_true() {
            return wide;
        }
        let [mut first, last] =
            [from_slopes.mean(simd, from.position, from.position), slopes.mean(simd, to.position, to.position)];
        let half = Floats::splat(simd, 0.5);
        first.extinction = (first.extinction + last.extinction) * half;
        for channel in 0..3 {
            first.emission[channel] = (first.emission[channel] + last.emission[channel]) * half;
        }
        Glow::select(is_wide, wide, first)
    }

    /// The integrals of extinction and emission from position 0 to places.
    #[inline(always)]
    fn integral<S: Gather>(&self, simd: S, place: &Place<S>, slopes: &Slopes<S>) -> Glow<S> {
        let (half, third) = (Floats::splat(simd, 1.0 / 2.0), Floats::splat(simd, 1.0 / 3.0));
        let x = place.position - slopes.start;
        let [extinction, red, green, blue] = self.tables.look_up(simd, INTEGRALS, place.segment);
        let [base, slope] = slopes.extinction;
        let mut integral =
            Glow { extinction: x.mul_add(x.mul_add(slope * half, base), extinction), emission: [red, green, blue] };
        for channel in 0..3 {
            let [base, slope, curvature] = slopes.emission[channel];
            let rest = x.mul_add(x.mul_add(curvature * third, slope * half), base);
            integral.emission[channel] = x.mul_add(rest, integral.emission[channel]);
        }
        integral
    }
}
