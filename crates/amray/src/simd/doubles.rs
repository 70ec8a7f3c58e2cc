//! Sixteen lanes of double precision: places in the world, before they become small numbers inside a brick.

use std::ops::{Add, Mul, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};

use super::{Floats, Gather, LANES, Mask};

/// Sixteen numbers in double precision.
#[derive(Clone, Copy)]
pub(crate) struct Doubles<S: Gather>([f64x8<S>; 2]);

impl<S: Gather> Doubles<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self([f64x8::splat(simd, value); 2])
    }

    #[inline(always)]
    pub(crate) fn from_array(simd: S, values: &[f64; LANES]) -> Self {
        let (low, high) = values.split_at(LANES / 2);
        Self([f64x8::from_slice(simd, low), f64x8::from_slice(simd, high)])
    }

    /// The first lane's number.
    #[inline(always)]
    pub(crate) fn first(self) -> f64 {
        self.0[0][0]
    }

    /// The same numbers, exactly.
    #[inline(always)]
    pub(crate) fn from_floats(values: Floats<S>) -> Self {
        let (low, high) = values.widen();
        Self([low, high])
    }

    /// The nearest numbers of single precision.
    #[inline(always)]
    pub(crate) fn to_floats(self) -> Floats<S> {
        self.0[0].narrow(self.0[1])
    }

    /// self * factor + term.
    #[inline(always)]
    pub(crate) fn mul_add(self, factor: Self, term: Self) -> Self {
        Self([self.0[0].mul_add(factor.0[0], term.0[0]), self.0[1].mul_add(factor.0[1], term.0[1])])
    }

    #[inline(always)]
    pub(crate) fn ceil(self) -> Self {
        Self([self.0[0].ceil(), self.0[1].ceil()])
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self([self.0[0].sqrt(), self.0[1].sqrt()])
    }

    /// One over each number.
    #[inline(always)]
    pub(crate) fn recip(self, simd: S) -> Self {
        let one = f64x8::splat(simd, 1.0);
        Self([one / self.0[0], one / self.0[1]])
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(crate) fn select(simd: S, mask: Mask<S>, yes: Self, no: Self) -> Self {
        let bits = mask.to_bitmask();
        let low = mask64x8::from_bitmask(simd, bits & 0xff);
        let high = mask64x8::from_bitmask(simd, bits >> 8);
        Self([low.select(yes.0[0], no.0[0]), high.select(yes.0[1], no.0[1])])
    }
}

impl<S: Gather> Add for Doubles<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl<S: Gather> Sub for Doubles<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl<S: Gather> Mul for Doubles<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }
}
