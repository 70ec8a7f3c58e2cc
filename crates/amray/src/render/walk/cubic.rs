//! Cubics: how values run along a ray between the planes of a dual cell.

use fearless_simd::prelude::*;

use crate::simd::{Floats, Gather};

/// A cubic over a unit interval, by its coefficients.
pub(super) struct Cubic<S: Gather>([Floats<S>; 4]);

impl<S: Gather> Cubic<S> {
    /// Through values at 0, 1/3, 2/3 and 1.
    #[inline(always)]
    pub(super) fn through(simd: S, [a, b, c, d]: &[Floats<S>; 4]) -> Self {
        let (first, second, third) = (*b - *a, *c - *b, *d - *c);
        // In differences, which keep digits where values hardly change.
        let bend = second - first;
        let twist = third - second - bend;
        Self([
            *a,
            first.mul_add(Floats::splat(simd, 3.0), bend.mul_add(Floats::splat(simd, -1.5), twist)),
            bend.mul_add(Floats::splat(simd, 4.5), twist * Floats::splat(simd, -4.5)),
            twist * Floats::splat(simd, 4.5),
        ])
    }

    /// What all its values over the interval lie between.
    #[inline(always)]
    pub(super) fn bounds(&self, simd: S) -> [Floats<S>; 2] {
        let [constant, linear, square, cube] = self.0;
        let third = Floats::splat(simd, 1.0 / 3.0);
        let second = linear.mul_add(third, constant);
        let inner = (linear + square).mul_add(third, second);
        let end = constant + linear + square + cube;
        [constant.min(second).min(inner.min(end)), constant.max(second).max(inner.max(end))]
    }

    /// Where inside of the interval it turns, in ascending order; infinity where it does not.
    #[inline(always)]
    pub(super) fn extremes(&self, simd: S) -> [Floats<S>; 2] {
        let [_, linear, square, cube] = self.0;
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        // Of linear + 2 square x + 3 cube x^2, in the way that does not cancel.
        let root = (square * square - cube * linear * Floats::splat(simd, 3.0)).sqrt();
        let sum = -(square + square.simd_lt(zero).select(-root, root));
        let [a, b] = [linear / sum, sum / (cube * Floats::splat(simd, 3.0))];
        let infinity = Floats::splat(simd, f32::INFINITY);
        let a = (a.simd_gt(zero) & a.simd_lt(one)).select(a, infinity);
        let b = (b.simd_gt(zero) & b.simd_lt(one)).select(b, infinity);
        let is_first = a.simd_lt(b);
        [is_first.select(a, b), is_first.select(b, a)]
    }
}
