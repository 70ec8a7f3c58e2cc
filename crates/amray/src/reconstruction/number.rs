//! What a reconstruction computes with: values alone, or values with their gradients in one pass.

use std::ops::{Add, AddAssign, Div, Mul, Sub};

/// A number that may know how it changes with the point. A method written over it gives the value with `f64`, and with
/// [`ValueAndGradient`] the exact derivative of the same formula beside it.
pub(crate) trait Number:
    Copy + Add<Output = Self> + AddAssign + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A number that does not change.
    fn constant(value: f64) -> Self;

    /// A number that changes along `axis` alone, by `slope` per cell of the finest level.
    fn along(axis: usize, value: f64, slope: f64) -> Self;

    /// The number at the point itself.
    fn value(self) -> f64;

    /// Whether the number is zero and does not begin to change at the point: what it weighs does not take part.
    fn is_zero(self) -> bool;

    /// Whether all of the number is finite.
    fn is_finite(self) -> bool;

    /// `number` times this weight, which is not [zero](Self::is_zero). Where its value or a derivative is zero all the
    /// same, the number does not take part in that one, not even a number that is not finite.
    fn weigh(self, number: Self) -> Self;
}

/// A value and its gradient: a dual number, whose arithmetic carries derivatives along (forward-mode differentiation).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueAndGradient {
    /// The value, in the field's units.
    pub value: f64,
    /// How much the value changes along each axis, per unit of length.
    pub gradient: [f64; 3],
}

impl Number for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline]
    fn along(_axis: usize, value: f64, _slope: f64) -> Self {
        value
    }

    #[inline]
    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn is_zero(self) -> bool {
        self == 0.0
    }

    #[inline]
    fn is_finite(self) -> bool {
        self.is_finite()
    }

    #[inline]
    fn weigh(self, number: Self) -> Self {
        self * number
    }
}

impl Number for ValueAndGradient {
    fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; 3] }
    }

    fn along(axis: usize, value: f64, slope: f64) -> Self {
        let mut gradient = [0.0; 3];
        gradient[axis] = slope;
        Self { value, gradient }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn is_zero(self) -> bool {
        self.value == 0.0 && self.gradient == [0.0; 3]
    }

    fn is_finite(self) -> bool {
        self.value.is_finite() && self.gradient.iter().all(|slope| slope.is_finite())
    }

    fn weigh(self, number: Self) -> Self {
        let part = |weight: f64, number: f64| if weight == 0.0 { 0.0 } else { weight * number };
        Self {
            value: part(self.value, number.value),
            gradient: std::array::from_fn(|axis| {
                part(self.gradient[axis], number.value) + part(self.value, number.gradient[axis])
            }),
        }
    }
}

impl Add for ValueAndGradient {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: std::array::from_fn(|axis| self.gradient[axis] + other.gradient[axis]),
        }
    }
}

impl AddAssign for ValueAndGradient {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for ValueAndGradient {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            value: self.value - other.value,
            gradient: std::array::from_fn(|axis| self.gradient[axis] - other.gradient[axis]),
        }
    }
}

impl Mul for ValueAndGradient {
    type Output = Self;

    #[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule")]
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            gradient: std::array::from_fn(|axis| self.gradient[axis] * other.value + self.value * other.gradient[axis]),
        }
    }
}

impl Div for ValueAndGradient {
    type Output = Self;

    #[expect(clippy::suspicious_arithmetic_impl, reason = "the quotient rule")]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            gradient: std::array::from_fn(|axis| (self.gradient[axis] - value * other.gradient[axis]) / other.value),
        }
    }
}

/// The mean of values, each with its own weight.
pub(super) struct WeightedMean<N> {
    sum: N,
    weight: N,
}

impl<N: Number> WeightedMean<N> {
    pub(super) fn new() -> Self {
        Self { sum: N::constant(0.0), weight: N::constant(0.0) }
    }

    #[inline]
    pub(super) fn add(&mut self, weight: N, value: f64) {
        self.sum += weight.weigh(N::constant(value));
        self.weight += weight;
    }

    /// The mean; NaN where nothing has weight.
    #[inline]
    pub(super) fn mean(&self) -> N {
        self.sum / self.weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_carries_derivatives() {
        let x = ValueAndGradient::along(0, 3.0, 1.0);
        let y = ValueAndGradient::along(1, 2.0, 4.0);
        let with = |value, gradient| ValueAndGradient { value, gradient };
        assert_eq!(x + y, with(5.0, [1.0, 4.0, 0.0]));
        assert_eq!(x - y, with(1.0, [1.0, -4.0, 0.0]));
        assert_eq!(x * y, with(6.0, [2.0, 12.0, 0.0]));
        assert_eq!(x / y, with(1.5, [0.5, -3.0, 0.0]));
        assert_eq!(x.weigh(y), x * y);
    }

    #[test]
    fn what_has_no_weight_does_not_take_part() {
        let infinite = ValueAndGradient::constant(f64::INFINITY);
        let starting = ValueAndGradient::along(1, 0.0, 1.0);
        let weighed = starting.weigh(infinite);
        assert_eq!(weighed, ValueAndGradient { value: 0.0, gradient: [0.0, f64::INFINITY, 0.0] });
        assert!(!starting.is_zero() && !weighed.is_finite());
    }
}
