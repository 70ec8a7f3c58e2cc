//! Functions of sixteen floats.

use fearless_simd::prelude::*;

use super::{Floats, Gather, Integers, Naturals};

/// 2 to the power of `x`, relative error below 3e-7 where `x` is within -126 and 127; clamped below.
#[inline(always)]
pub(crate) fn exp2<S: Gather>(simd: S, x: Floats<S>) -> Floats<S> {
    let x = x.max(Floats::splat(simd, -126.0));
    // To the nearest integer: the polynomial covers -1/2 to 1/2.
    let whole = x.round_ties_even();
    let part = x - whole;
    // Minimax on [-1/2, 1/2] with the constant term 1, so that exp2(0) is exact.
    let mut sum = Floats::splat(simd, 1.326_472_5e-3);
    #[allow(clippy::approx_constant)] // Nearly ln 2, as the best fit has it.
    for coefficient in [9.671_506e-3, 5.550_733_7e-2, 2.402_224_2e-1, 6.931_47e-1, 1.0] {
        sum = sum.mul_add(part, Floats::splat(simd, coefficient));
    }
    let power: Integers<S> = whole.to_int::<Integers<S>>() << 23;
    (sum.bitcast::<Integers<S>>() + power).bitcast()
}

/// The logarithm to base 2 of positive normal `x`, absolute error below 2e-6.
#[inline(always)]
pub(crate) fn log2<S: Gather>(simd: S, x: Floats<S>) -> Floats<S> {
    let bits: Naturals<S> = x.bitcast();
    // The mantissa between sqrt(1/2) and sqrt(2).
    let shifted = bits - Naturals::splat(simd, 0x3f35_04f3);
    let exponent: Integers<S> = shifted.bitcast::<Integers<S>>() >> 23;
    let mantissa_bits = (shifted & Naturals::splat(simd, 0x007f_ffff)) + Naturals::splat(simd, 0x3f35_04f3);
    let mantissa: Floats<S> = mantissa_bits.bitcast();
    // log2 m = 2 / ln 2 * atanh(z), z = (m - 1) / (m + 1), |z| < 0.172.
    let one = Floats::splat(simd, 1.0);
    let z = (mantissa - one) / (mantissa + one);
    let square = z * z;
    let mut sum = Floats::splat(simd, 2.885_39 / 9.0);
    for coefficient in [2.885_39 / 7.0, 2.885_39 / 5.0, 2.885_39 / 3.0, 2.885_39] {
        sum = sum.mul_add(square, Floats::splat(simd, coefficient));
    }
    let exponent: Floats<S> = exponent.to_float();
    sum.mul_add(z, exponent)
}

#[cfg(test)]
mod tests {
    use super::super::{InstructionSet, Kernel};
    use super::*;

    /// Applies the functions to sixteen numbers.
    struct Functions([f32; 16]);

    impl Kernel for Functions {
        type Output = [[f32; 16]; 2];
        fn run<S: Gather>(self, simd: S) -> Self::Output {
            let x = Floats::from_slice(simd, &self.0);
            [*exp2(simd, x), *log2(simd, x.abs())]
        }
    }

    #[test]
    fn the_functions_are_as_exact_as_they_say() {
        for set in InstructionSet::available() {
            for start in 0..2000 {
                let x: [f32; 16] = std::array::from_fn(|lane| (start * 16 + lane) as f32 * 0.00311 - 49.7);
                let [exponentials, logarithms] = set.run(Functions(x));
                for (lane, x) in x.into_iter().map(f64::from).enumerate() {
                    let name = set.name();
                    let error = f64::from(exponentials[lane]) / x.exp2() - 1.0;
                    assert!(error.abs() < 3e-7, "{name}: 2^{x} is off by {error:e}");
                    let error = f64::from(logarithms[lane]) - x.abs().log2();
                    assert!(error.abs() < 2e-6, "{name}: log2 {x} is off by {error:e}");
                }
            }
            let [exponentials, ..] = set.run(Functions([0.0; 16]));
            assert_eq!(exponentials, [1.0; 16]);
            let [exponentials, ..] = set.run(Functions([f32::NEG_INFINITY; 16]));
            assert!(exponentials[0] < 1.2e-38);
        }
    }
}
