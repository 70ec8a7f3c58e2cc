//! Values as numbers that single precision holds well, whatever their offset and magnitude.

use super::{BrickValues, Voxel};

/// What turns a field's values into numbers that single precision holds well: those from `low` on become small numbers
/// from 0 on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normalisation {
    /// The value that becomes 0.
    pub low: f64,
    /// What the distance from `low` is multiplied by.
    pub scale: f64,
}

impl Normalisation {
    /// The one that makes `low` 0 and `high` 1. Where there is no such range, or its width is at the ends of what double
    /// precision can hold, numbers are as wide as values.
    pub fn of_range([low, high]: [f64; 2]) -> Self {
        let scale = (high - low).recip();
        Self { low: if low.is_finite() { low } else { 0.0 }, scale: if scale.is_normal() { scale.abs() } else { 1.0 } }
    }

    /// One that serves the values of `bricks`, of which it looks at a few.
    ///
    /// Numbers are exact beside the distance of their value from `low`, so all that matters of `low` is that it lies
    /// among the values. `scale` only keeps them from the ends of what single precision can hold.
    pub(crate) fn probe<T: Voxel>(bricks: &[BrickValues<T>]) -> Self {
        const BRICKS: usize = 64;
        let step = bricks.len().div_ceil(BRICKS).max(1);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for brick in bricks.iter().step_by(step).filter(|brick| !brick.size().contains(&0)) {
            for cell in [brick.size().map(|_| 0), brick.size().map(|size| size / 2), brick.size().map(|size| size - 1)]
            {
                let value = brick.get(cell).to_f64();
                if value.is_finite() {
                    (low, high) = (low.min(value), high.max(value));
                }
            }
        }
        Self::of_range([low, high])
    }

    /// The number that stands for a value.
    #[inline]
    pub fn apply(self, value: f64) -> f32 {
        ((value - self.low) * self.scale) as f32
    }

    /// The value that a number stands for.
    #[inline]
    pub fn undo(self, number: f32) -> f64 {
        self.undo_exactly(number.into())
    }

    /// The value that a number in double precision stands for.
    #[inline]
    pub(crate) fn undo_exactly(self, number: f64) -> f64 {
        self.low + number / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_all_kinds_become_small_numbers() {
        for [low, high] in [[-2.0, 3.0], [1e300, 2e307], [-2e307, 2e307], [1e-300, 3e-300], [7.0, 7.0 + 1e-9]] {
            let normalisation = Normalisation::of_range([low, high]);
            for (value, expected) in [(low, 0.0), (high, 1.0), (low / 2.0 + high / 2.0, 0.5)] {
                let number = normalisation.apply(value);
                assert!((f64::from(number) - expected).abs() < 1e-6, "{value} in {low} to {high}: {number}");
                let back = normalisation.undo(number) - value;
                assert!(back.abs() <= 1e-7 * (high / 2.0 - low / 2.0), "{value} comes back off by {back}");
            }
        }
    }

    #[test]
    fn where_there_is_no_range_numbers_are_values() {
        for range in [[f64::INFINITY, f64::NEG_INFINITY], [0.0, 0.0], [f64::NAN; 2]] {
            assert_eq!(Normalisation::of_range(range), Normalisation { low: 0.0, scale: 1.0 });
        }
        assert!(Normalisation::of_range([1.0, 2.0]).apply(f64::NAN).is_nan());
    }
}
