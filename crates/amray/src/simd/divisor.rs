//! Exact division of sixteen whole numbers by one that does not change.

use fearless_simd::prelude::*;

use super::{Gather, Integers, Naturals};

/// Divides numbers from 0 to 2^31 - 1, rounding down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Divisor {
    multiplier: u32,
    shift: u32,
}

impl Divisor {
    /// Division by `divisor`, which is from 1 to 2^31 - 1.
    pub(crate) fn new(divisor: u32) -> Self {
        // multiplier = (2^shift + e) / divisor with e < divisor <= 2^(shift - 31): for n < 2^31 the product is too large
        // by n e / (divisor 2^shift) < 1 / divisor, which never reaches the next whole number.
        let shift = 31 + (divisor - 1).checked_ilog2().map_or(0, |power| power + 1);
        Self { multiplier: (1u64 << shift).div_ceil(u64::from(divisor)) as u32, shift }
    }

    #[inline(always)]
    pub(crate) fn divide<S: Gather>(self, simd: S, numbers: Integers<S>) -> Integers<S> {
        let numbers: Naturals<S> = numbers.bitcast();
        let (low, high) = numbers.widening_mul(Naturals::splat(simd, self.multiplier));
        (low >> self.shift).narrow(high >> self.shift).bitcast()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{InstructionSet, Kernel, LANES};
    use super::*;

    struct Division(Divisor, [i32; LANES]);

    impl Kernel for Division {
        type Output = [i32; LANES];
        fn run<S: Gather>(self, simd: S) -> Self::Output {
            *self.0.divide(simd, Integers::from_slice(simd, &self.1))
        }
    }

    #[test]
    fn division_is_exact() {
        let divisors = (1..40).chain([127, 128, 129, 59_049, 1 << 20, (1 << 30) - 1, 1 << 30, i32::MAX]);
        for set in InstructionSet::available() {
            for divisor in divisors.clone() {
                let most = i32::MAX / divisor;
                let numbers = std::array::from_fn(|lane| {
                    let multiple = [0, 1, most / 3, most / 2, most - 1, most][lane % 6].max(0) * divisor;
                    multiple.saturating_add([0, divisor - 1, divisor / 2][lane % 3])
                });
                let found = set.run(Division(Divisor::new(divisor as u32), numbers));
                assert_eq!(found, numbers.map(|number| number / divisor), "{}: by {divisor}", set.name());
            }
        }
    }
}
