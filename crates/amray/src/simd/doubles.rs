//! Sixteen positions in f64, and how they become whole cells and fractions of them.

use std::ops::{Add, Mul, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8, u64x8};

use super::{Floats, Gather, Integers, LANES, LaneSet, Mask, Naturals};

/// Sixteen numbers in double precision.
#[derive(Clone, Copy)]
pub(crate) struct Doubles<S: Gather>([f64x8<S>; 2]);

/// Added to a whole number between -2^31 and 2^31, it leaves the number in the lowest bits of the sum.
const WHOLE: f64 = (3u64 << 51) as f64;

impl<S: Gather> Doubles<S> {
    #[inline(always)]
    pub(crate) fn load(simd: S, numbers: &[f64; LANES]) -> Self {
        let (low, high) = numbers.split_at(LANES / 2);
        Self([f64x8::from_slice(simd, low), f64x8::from_slice(simd, high)])
    }

    #[inline(always)]
    pub(crate) fn from_integers(simd: S, numbers: Integers<S>) -> Self {
        let mut doubles = [0.0; LANES];
        for lane in 0..LANES {
            doubles[lane] = f64::from(numbers[lane]);
        }
        Self::load(simd, &doubles)
    }

    #[inline(always)]
    pub(crate) fn store(self) -> [f64; LANES] {
        let [low, high] = self.0;
        std::array::from_fn(|lane| if lane < LANES / 2 { low[lane] } else { high[lane - LANES / 2] })
    }

    /// Numbers outside of `low` to `high` moved to the nearer end; what is not a number becomes one of them.
    #[inline(always)]
    pub(crate) fn clamp(self, simd: S, [low, high]: [f64; 2]) -> Self {
        let [a, b] = self.0;
        let (low, high) = (f64x8::splat(simd, low), f64x8::splat(simd, high));
        Self([a.max_precise(low).min(high), b.max_precise(low).min(high)])
    }

    /// The lanes from `low` to `high`, both inclusive.
    #[inline(always)]
    pub(crate) fn within(self, simd: S, [low, high]: [f64; 2]) -> LaneSet {
        let [a, b] = self.0;
        let (low, high) = (f64x8::splat(simd, low), f64x8::splat(simd, high));
        let first = (a.simd_ge(low) & a.simd_le(high)).to_bitmask();
        let second = (b.simd_ge(low) & b.simd_le(high)).to_bitmask();
        (first | second << (LANES / 2)) as LaneSet
    }

    /// (number - low) * scale + shift.
    #[inline(always)]
    pub(crate) fn scaled(self, simd: S, low: f64, scale: f64, shift: f64) -> Self {
        let [a, b] = self.0;
        let [low, scale, shift] = [f64x8::splat(simd, low), f64x8::splat(simd, scale), f64x8::splat(simd, shift)];
        Self([(a - low).mul_add(scale, shift), (b - low).mul_add(scale, shift)])
    }

    /// (number - low) / size + shift.
    #[inline(always)]
    pub(crate) fn divided(self, simd: S, low: f64, size: f64, shift: f64) -> Self {
        let [a, b] = self.0;
        let [low, size, shift] = [f64x8::splat(simd, low), f64x8::splat(simd, size), f64x8::splat(simd, shift)];
        Self([(a - low) / size + shift, (b - low) / size + shift])
    }

    /// The next whole number below, and what is left above it. The whole number is right where it fits.
    #[inline(always)]
    pub(crate) fn split(self, simd: S) -> (Integers<S>, Floats<S>) {
        let [a, b] = self.0;
        let (whole_a, whole_b) = (a.floor(), b.floor());
        let rest: Floats<S> = (a - whole_a).narrow(b - whole_b);
        let shift = f64x8::splat(simd, WHOLE);
        let low_bits: Naturals<S> = (whole_a + shift).bitcast::<u64x8<S>>().narrow((whole_b + shift).bitcast());
        (low_bits.bitcast(), rest)
    }

    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self([f64x8::splat(simd, value); 2])
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
    pub(crate) fn floor(self) -> Self {
        Self([self.0[0].floor(), self.0[1].floor()])
    }

    /// The lower of two numbers.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self([self.0[0].min(other.0[0]), self.0[1].min(other.0[1])])
    }

    /// One over the square root of numbers that single precision can hold, with 13 digits.
    #[inline(always)]
    pub(crate) fn inverse_sqrt(self, simd: S) -> Self {
        let near = Self::from_floats(Floats::splat(simd, 1.0) / self.to_floats().sqrt());
        // A step of Newton's method.
        let half = Self::splat(simd, 0.5) * self * near;
        near * (Self::splat(simd, 1.5) - half * near)
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

#[cfg(test)]
mod tests {
    use super::super::{InstructionSet, Kernel};
    use super::*;

    struct Functions([f64; LANES]);

    impl Kernel for Functions {
        type Output = ([i32; LANES], [f32; LANES], LaneSet, [f64; LANES]);
        fn run<S: Gather>(self, simd: S) -> Self::Output {
            let numbers = Doubles::load(simd, &self.0);
            let (whole, rest) = numbers.split(simd);
            let inside = numbers.within(simd, [-2.0, 7.0]);
            (*whole, *rest, inside, numbers.clamp(simd, [-2.0, 7.0]).scaled(simd, 1.0, 0.5, 3.0).store())
        }
    }

    #[test]
    fn whole_numbers_and_rests_add_up() {
        let mut numbers: [f64; LANES] = std::array::from_fn(|lane| lane as f64 * 1.375 - 7.0);
        numbers[14] = 2_147_483_646.75;
        numbers[15] = -2_147_483_647.75;
        for set in InstructionSet::available() {
            let (whole, rest, inside, scaled) = set.run(Functions(numbers));
            for (lane, number) in numbers.into_iter().enumerate() {
                let name = set.name();
                assert_eq!(f64::from(whole[lane]) + f64::from(rest[lane]), number, "{name}");
                assert!((0.0..1.0).contains(&rest[lane]), "{name}");
                assert_eq!(inside >> lane & 1 == 1, (-2.0..=7.0).contains(&number), "{name}: {number}");
                assert_eq!(scaled[lane], (number.clamp(-2.0, 7.0) - 1.0) * 0.5 + 3.0, "{name}");
            }
            let (.., scaled) = set.run(Functions([f64::NAN; LANES]));
            assert!(scaled.iter().all(|number| (1.5..=6.0).contains(number)), "{}: {scaled:?}", set.name());
        }
    }
}
