//! How much volume has which value.

use super::{RangeError, Scale};

/// A volume-weighted histogram with bins of equal width in position (see [`Scale`]); filled in parts and merged.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    range: [f64; 2],
    scale: Scale,
    weights: Vec<f64>,
}

impl Histogram {
    /// An empty histogram with `bins` bins between `low` and `high`. The range of a field that is constant
    /// (`low == high`) is widened on both sides.
    ///
    /// # Errors
    /// [`RangeError`] where the ends are not finite, descend, or are not above 0 on a log scale.
    ///
    /// # Panics
    /// Where there are no bins.
    pub fn new(low: f64, high: f64, scale: Scale, bins: usize) -> Result<Self, RangeError> {
        assert!(bins > 0, "a histogram without bins");
        let range = if low == high { widened(low) } else { [low, high] };
        scale.check(range)?;
        Ok(Self { range, scale, weights: vec![0.0; bins] })
    }

    /// Counts `value` with `weight`, its volume: in the nearest bin where it lies outside the range, not at all where
    /// it is not finite.
    #[inline]
    pub fn add(&mut self, value: f64, weight: f64) {
        if value.is_finite() {
            let bins = self.weights.len();
            // Saturates at bin 0.
            let bin = (self.scale.fraction(self.range, value) * bins as f64) as usize;
            self.weights[bin.min(bins - 1)] += weight;
        }
    }

    /// Counts all that `other` counted.
    ///
    /// # Panics
    /// Where the two differ in range, scale or number of bins.
    pub fn merge(&mut self, other: &Self) {
        assert_eq!(
            (self.range, self.scale, self.weights.len()),
            (other.range, other.scale, other.weights.len()),
            "histograms of different bins"
        );
        self.weights.iter_mut().zip(&other.weights).for_each(|(weight, more)| *weight += more);
    }

    /// The low end of the first and the high end of the last bin.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// How the bins are spread over the range.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// The weight of every bin.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The weight of all that was counted.
    pub fn total_weight(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// The value in the middle of a bin.
    pub fn center(&self, bin: usize) -> f64 {
        self.edge(bin as f64 + 0.5)
    }

    /// The value below which `share` (0 to 1) of the weight lies, linear within a bin; `None` where nothing was
    /// counted.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let total = self.total_weight();
        let wanted = share.clamp(0.0, 1.0) * total;
        let mut below = 0.0;
        let mut last = None;
        for (bin, &weight) in self.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            if below + weight >= wanted {
                return Some(self.edge(bin as f64 + (wanted - below) / weight));
            }
            below += weight;
            last = Some(self.edge(bin as f64 + 1.0));
        }
        // Only rounding leads here, if anything was counted.
        last
    }

    /// The value at a number of bins from the low end.
    fn edge(&self, bins: f64) -> f64 {
        self.scale.at_fraction(self.range, bins / self.weights.len() as f64)
    }
}

/// A range around a single value, above 0 where the value is.
fn widened(value: f64) -> [f64; 2] {
    if value == 0.0 { [-1.0, 1.0] } else { [value - 0.5 * value.abs(), value + 0.5 * value.abs()] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_merge_into_the_whole() {
        let empty = Histogram::new(0.0, 4.0, Scale::Linear, 4).unwrap();
        let (mut whole, mut left, mut right) = (empty.clone(), empty.clone(), empty);
        for (index, value) in [0.0, 0.5, 1.0, 3.9, 4.0, -7.0, 99.0, f64::NAN, f64::INFINITY].into_iter().enumerate() {
            whole.add(value, 0.5);
            if index % 2 == 0 { &mut left } else { &mut right }.add(value, 0.5);
        }
        assert_eq!(whole.weights(), [1.5, 0.5, 0.0, 1.5]);
        assert_eq!(whole.total_weight(), 3.5);
        left.merge(&right);
        assert_eq!(left, whole);
    }

    #[test]
    fn quantiles_are_linear_within_bins() {
        let mut histogram = Histogram::new(0.0, 10.0, Scale::Linear, 5).unwrap();
        assert_eq!(histogram.quantile(0.5), None);
        histogram.add(3.0, 3.0);
        histogram.add(9.0, 1.0);
        let quantiles = [0.0, 0.25, 0.375, 0.75, 0.875, 1.0, 7.0].map(|share| histogram.quantile(share).unwrap());
        assert_eq!(quantiles, [2.0, 2.0 + 2.0 / 3.0, 3.0, 4.0, 9.0, 10.0, 10.0]);
    }

    #[test]
    fn a_log_scale_has_a_bin_a_decade() {
        let mut histogram = Histogram::new(1e-2, 1e2, Scale::Log10, 4).unwrap();
        for value in [0.0, -3.0, 0.05, 0.5, 5.0, 50.0] {
            histogram.add(value, 1.0);
        }
        assert_eq!(histogram.weights(), [3.0, 1.0, 1.0, 1.0]);
        assert!((histogram.center(2) - 10f64.sqrt()).abs() < 1e-12);
        assert!((histogram.quantile(0.5).unwrap() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_constant_field_gets_a_range() {
        for (value, range) in [(2.0, [1.0, 3.0]), (-2.0, [-3.0, -1.0]), (0.0, [-1.0, 1.0])] {
            assert_eq!(Histogram::new(value, value, Scale::Linear, 8).unwrap().range(), range);
        }
        assert!(Histogram::new(f64::INFINITY, f64::NEG_INFINITY, Scale::Linear, 8).is_err());
        assert!(Histogram::new(0.0, 1.0, Scale::Log10, 8).is_err());
    }
}
