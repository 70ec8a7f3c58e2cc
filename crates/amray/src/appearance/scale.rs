//! Linear or logarithmic: how values lie along a transfer function, a histogram or a colour bar.

use thiserror::Error;

/// How values are spread over positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Scale {
    /// A position is the value.
    #[default]
    Linear,
    /// A position is the value's decimal logarithm; values of 0 and below lie at the low end.
    Log10,
}

/// A range of values that a scale cannot spread.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("range {low:?} to {high:?}, expected {expected}")]
pub struct RangeError {
    /// The low end.
    pub low: f64,
    /// The high end.
    pub high: f64,
    /// What the ends should be.
    pub expected: &'static str,
}

impl Scale {
    /// Where `value`, which is not NaN, lies; negative infinity for values of 0 and below on a log scale.
    #[inline]
    pub fn position(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log10 if value > 0.0 => value.log10(),
            Self::Log10 => f64::NEG_INFINITY,
        }
    }

    /// How far `value` lies from the low (0) to the high end (1) of a range; less or more outside of it.
    pub fn fraction(self, [low, high]: [f64; 2], value: f64) -> f64 {
        let [low, high, position] = [low, high, value].map(|value| self.position(value));
        // Positions of values that differ in the last digits alone may be equal.
        if high > low { (position - low) / (high - low) } else { 0.5 }
    }

    /// The value that lies `fraction` of the way through a range; exactly the low end at 0, the high end at 1.
    pub fn at_fraction(self, [low, high]: [f64; 2], fraction: f64) -> f64 {
        if fraction <= 0.0 {
            return low;
        }
        if fraction >= 1.0 {
            return high;
        }
        let [first, last] = [low, high].map(|value| self.position(value));
        let position = first + (last - first) * fraction;
        let value = match self {
            Self::Linear => position,
            Self::Log10 => 10f64.powf(position),
        };
        value.clamp(low, high)
    }

    /// Whether values between `low` and `high` can be spread.
    ///
    /// # Errors
    /// [`RangeError`] where the ends are not finite, not ascending, or not above 0 on a log scale.
    pub fn check(self, [low, high]: [f64; 2]) -> Result<(), RangeError> {
        let expected = if !(low < high && (high - low).is_finite()) {
            "two finite numbers, the lower one first"
        } else if self == Self::Log10 && low <= 0.0 {
            "numbers above 0 on a log scale"
        } else {
            return Ok(());
        };
        Err(RangeError { low, high, expected })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_and_values_are_inverse() {
        assert_eq!(Scale::Linear.fraction([2.0, 4.0], 2.5), 0.25);
        assert_eq!(Scale::Linear.at_fraction([2.0, 4.0], 0.25), 2.5);
        assert_eq!(Scale::Log10.fraction([1e-2, 1e2], 10.0), 0.75);
        assert!((Scale::Log10.at_fraction([1e-2, 1e2], 0.75) - 10.0).abs() < 1e-12);
        assert_eq!(Scale::Log10.fraction([1e-2, 1e2], -5.0), f64::NEG_INFINITY);
    }

    #[test]
    fn the_ends_are_exact() {
        for range in [[0.1, 0.3], [1e-3, 7e5], [f64::MIN_POSITIVE, 1.0]] {
            for scale in [Scale::Linear, Scale::Log10] {
                assert_eq!([0.0, 1.0].map(|end| scale.at_fraction(range, end)), range);
            }
        }
    }

    #[test]
    fn equal_positions_make_no_nan() {
        let next = 1e5f64.next_up();
        assert_eq!(Scale::Log10.fraction([1e5, next], 1e5), 0.5);
    }

    #[test]
    fn bad_ranges_are_refused() {
        assert_eq!(
            Scale::Linear.check([2.0, 1e300 / 1e-300]).unwrap_err().to_string(),
            "range 2.0 to inf, expected two finite numbers, the lower one first"
        );
        assert!(Scale::Linear.check([1.0, 1.0]).is_err());
        assert!(Scale::Linear.check([f64::NAN, 1.0]).is_err());
        assert!(Scale::Linear.check([-f64::MAX, f64::MAX]).is_err());
        assert_eq!(
            Scale::Log10.check([0.0, 1e20]).unwrap_err().to_string(),
            "range 0.0 to 1e20, expected numbers above 0 on a log scale"
        );
        assert!(Scale::Linear.check([-1.0, 1.0]).is_ok() && Scale::Log10.check([1e-300, 1.0]).is_ok());
    }
}
