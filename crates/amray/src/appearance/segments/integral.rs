//! What intervals of values emit and absorb, sixteen rays at a time.

use fearless_simd::prelude::*;

use super::{PositionAxis, Segments, Window};
use crate::simd::{Floats, Gather, Integers, Mask, exp2, log2, reciprocal};

/// What sixteen rays have collected so far.
#[derive(Clone, Copy)]
pub(crate) struct Light<S: Gather> {
    pub(crate) color: [Floats<S>; 3],
    pub(crate) transmittance: Floats<S>,
}

/// An end of an interval: a position and the segment that it lies in.
#[derive(Clone, Copy)]
pub(crate) struct Place<S: Gather> {
    pub(crate) position: Floats<S>,
    pub(crate) segment: Integers<S>,
}

/// A stretch of each ray between two samples, along which the value runs linearly from one to the other.
#[derive(Clone, Copy)]
pub(crate) struct Interval<S: Gather> {
    pub(crate) from: Place<S>,
    pub(crate) to: Place<S>,
    /// In units of the extinction's reciprocal.
    pub(crate) length: Floats<S>,
}

impl<S: Gather> Light<S> {
    /// None, and everything to come is seen.
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        Self { color: [Floats::splat(simd, 0.0); 3], transmittance: Floats::splat(simd, 1.0) }
    }
}

impl Segments {
    /// Where values, in units of the field's range, lie; `window` are the segments that they can lie in.
    #[inline(always)]
    pub(crate) fn place<S: Gather>(&self, simd: S, value: Floats<S>, window: Window) -> Place<S> {
        let position = match self.axis {
            PositionAxis::Linear => value,
            PositionAxis::Log { shift, factor, offset } => {
                let [shift, factor, offset, zero, one, least] = [shift, factor, offset, 0.0, 1.0, f32::MIN_POSITIVE]
                    .map(
                        #[inline(always)]
                        |number| Floats::splat(simd, number),
                    );
                log2(simd, (value + shift).max(least)).mul_add(factor, offset).max(zero).min(one)
            }
        };
        let last = Integers::splat(simd, i32::from(window.last));
        let mut segment = Integers::splat(simd, i32::from(window.first));
        // The highest segment that starts at or below the position.
        let mut step = ((u32::from(window.last - window.first) + 1).next_power_of_two() / 2) as i32;
        while step > 0 {
            let next = (segment + Integers::splat(simd, step)).min(last);
            let reached = position.simd_ge(simd.look_up(&self.starts, next));
            segment = reached.select(next, segment);
            step /= 2;
        }
        Place { position, segment }
    }

    /// Adds what the intervals of `active` rays emit and absorb, exactly for values that run linearly: an interval is
    /// cut where its values go from one segment to the next, and on one segment the optical depth and the mean colour,
    /// weighed by extinction, have closed forms.
    #[inline(always)]
    pub(crate) fn add<S: Gather>(&self, simd: S, light: &mut Light<S>, interval: &Interval<S>, active: Mask<S>) {
        let Interval { from, to, length } = *interval;
        let differs = from.segment.simd_ne(to.segment) & active;
        let width = to.position - from.position;
        if differs.all_false() {
            return self.add_linear(simd, light, to.segment, [from.position, width], length, active);
        }
        let zero = Floats::splat(simd, 0.0);
        let rises = width.simd_gt(zero);
        let per_width = length * differs.select(reciprocal(simd, width), zero);
        let [one, minus_one] = [1, -1].map(
            #[inline(always)]
            |number| Integers::splat(simd, number),
        );
        let direction = rises.select(one, minus_one);
        // The next segment's start lies ahead of rising values, the own one's ahead of falling ones.
        let ahead = rises.select(one, Integers::splat(simd, 0));
        let (mut position, mut segment) = (from.position, from.segment);
        let mut left = active;
        loop {
            let last = segment.simd_eq(to.segment);
            let boundary = simd.look_up(&self.starts, segment + ahead);
            let end = last.select(to.position, boundary);
            let width = end - position;
            let length = differs.select(width * per_width, length).max(zero);
            self.add_linear(simd, light, segment, [position, width], length, left);
            left &= !last;
            if left.all_false() {
                return;
            }
            position = end;
            segment += direction;
        }
    }

    /// Adds an interval on one segment: from a position, over a width of positions.
    #[inline(always)]
    fn add_linear<S: Gather>(
        &self,
        simd: S,
        light: &mut Light<S>,
        segment: Integers<S>,
        [from, width]: [Floats<S>; 2],
        length: Floats<S>,
        active: Mask<S>,
    ) {
        let [zero, half, one, two] = [0.0, 0.5, 1.0, 2.0].map(
            #[inline(always)]
            |number| Floats::splat(simd, number),
        );
        let middle = width.mul_add(half, from);
        let slope = simd.look_up(&self.extinction[1], segment);
        let extinction = middle.mul_add(slope, simd.look_up(&self.extinction[0], segment)).max(zero);
        let depth = extinction * length;
        let alpha = one - exp2(simd, depth * Floats::splat(simd, -std::f32::consts::LOG2_E));
        // Where extinction rises, the colours at the far end count for more: the mean of a product of two lines.
        let tiny = Floats::splat(simd, 1e-30);
        let rise = (slope * width * reciprocal(simd, extinction.max(tiny))).max(-two).min(two);
        let weighed = (rise * width).mul_add(Floats::splat(simd, 1.0 / 12.0), middle);
        let seen = active.select(alpha, zero) * light.transmittance;
        // What other rays would add may be no number.
        for channel in 0..3 {
            let [base, slope] = &self.color[channel];
            let color = weighed.mul_add(simd.look_up(slope, segment), simd.look_up(base, segment));
            light.color[channel] = active.select(seen.mul_add(color, light.color[channel]), light.color[channel]);
        }
        light.transmittance = light.transmittance - seen;
    }
}
