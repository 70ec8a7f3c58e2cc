//! A transfer function ready for sampling: extinctions per world length, and bounds on them.

use super::curve::Curve;
use super::{Opacity, Scale, TransferFunction};

/// A [`TransferFunction`] for one unit distance.
#[derive(Clone, Debug)]
pub struct PreparedTransferFunction {
    scale: Scale,
    colors: Curve<3>,
    opacity: Curve<1>,
    quantity: Quantity,
}

/// What the opacity curve gives.
#[derive(Clone, Copy, Debug)]
enum Quantity {
    /// The opacity of a path of this length.
    OpacityOf(f64),
    Extinction,
}

/// Colour and extinction at one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Display colour, not multiplied by any opacity.
    pub color: [f32; 3],
    /// Extinction per world length; infinite where the opacity is 1.
    pub extinction: f64,
}

impl Sample {
    /// What non-finite values look like.
    pub const TRANSPARENT: Self = Self { color: [0.0; 3], extinction: 0.0 };

    /// The opacity of a path of `length`: 0 for no length, even where the extinction is infinite.
    #[inline]
    pub fn alpha(&self, length: f64) -> f32 {
        // World lengths can lie far outside the range of single precision; the optical depth decides.
        if length > 0.0 { -((-self.extinction * length) as f32).exp_m1() } else { 0.0 }
    }
}

impl PreparedTransferFunction {
    pub(super) fn new(function: &TransferFunction, unit_distance: f64) -> Self {
        assert!(unit_distance > 0.0 && unit_distance.is_finite(), "unit distance {unit_distance}");
        let quantity = match function.opacity() {
            Opacity::PerUnitDistance(_) => Quantity::OpacityOf(unit_distance),
            Opacity::Extinction(_) => Quantity::Extinction,
        };
        Self { scale: function.scale(), colors: function.color_curve(), opacity: function.opacity_curve(), quantity }
    }

    /// Colour and extinction of `value`; transparent where it is not finite.
    #[inline]
    pub fn sample(&self, value: f64) -> Sample {
        if !value.is_finite() {
            return Sample::TRANSPARENT;
        }
        let position = self.scale.position(value);
        let [opacity] = self.opacity.at(position);
        Sample { color: self.colors.at(position).map(|value| value as f32), extinction: self.extinction(opacity) }
    }

    /// The extinction of `value`; 0 where it is not finite.
    #[inline]
    pub(crate) fn extinction_at(&self, value: f64) -> f64 {
        if !value.is_finite() {
            return 0.0;
        }
        let [opacity] = self.opacity.at(self.scale.position(value));
        self.extinction(opacity)
    }

    /// The largest extinction of the values from `low` to `high`, both included; 0 where there are none.
    pub fn max_extinction(&self, low: f64, high: f64) -> f64 {
        if low <= high {
            self.extinction(self.opacity.max(self.scale.position(low), self.scale.position(high)))
        } else {
            0.0
        }
    }

    /// How values lie along the curves.
    pub(super) fn scale(&self) -> Scale {
        self.scale
    }

    /// The length that opacities are of; 1 for extinctions.
    pub(super) fn unit_distance(&self) -> f64 {
        match self.quantity {
            Quantity::OpacityOf(distance) => distance,
            Quantity::Extinction => 1.0,
        }
    }

    /// The positions of all points, ascending, each once.
    pub(super) fn point_positions(&self) -> Vec<f64> {
        let mut positions = [self.colors.positions(), self.opacity.positions()].concat();
        positions.sort_by(f64::total_cmp);
        positions.dedup();
        positions
    }

    /// The lowest and the highest position of a point.
    pub(super) fn position_range(&self) -> [f64; 2] {
        let positions = self.point_positions();
        [positions[0], positions[positions.len() - 1]]
    }

    /// Extinction, red, green and blue right before a position.
    pub(super) fn before(&self, position: f64) -> [f64; 4] {
        let ([opacity], [red, green, blue]) = (self.opacity.left_of(position), self.colors.left_of(position));
        [self.extinction(opacity), red, green, blue]
    }

    /// Extinction, red, green and blue at, and right behind, a position.
    pub(super) fn after(&self, position: f64) -> [f64; 4] {
        let ([opacity], [red, green, blue]) = (self.opacity.at(position), self.colors.at(position));
        [self.extinction(opacity), red, green, blue]
    }

    #[inline]
    fn extinction(&self, opacity: f64) -> f64 {
        match self.quantity {
            Quantity::OpacityOf(distance) => -(-opacity).ln_1p() / distance,
            Quantity::Extinction => opacity,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::{ColorPoint, OpacityPoint};
    use super::*;

    fn function(scale: Scale, colors: &[(f64, [f32; 3])], opacity: Opacity) -> TransferFunction {
        let colors = colors.iter().map(|&(value, color)| ColorPoint { value, color }).collect();
        TransferFunction::new(scale, colors, opacity).unwrap()
    }

    fn points(points: &[(f64, f64)]) -> Vec<OpacityPoint> {
        points.iter().map(|&(value, opacity)| OpacityPoint { value, opacity }).collect()
    }

    #[test]
    fn samples_are_exact_at_points_and_between() {
        let opacity = Opacity::Extinction(points(&[(0.0, 0.0), (2.0, 4.0)]));
        let colors = [(0.0, [0.0, 0.5, 1.0]), (1.0, [1.0, 0.5, 0.0]), (1.0, [0.0; 3]), (2.0, [1.0; 3])];
        let function = function(Scale::Linear, &colors, opacity).prepared(1.0);
        let expected = [
            (-1.0, [0.0, 0.5, 1.0], 0.0),
            (0.0, [0.0, 0.5, 1.0], 0.0),
            (0.25, [0.25, 0.5, 0.75], 0.5),
            (1.0, [0.0; 3], 2.0),
            (1.5, [0.5; 3], 3.0),
            (2.0, [1.0; 3], 4.0),
            (3.0, [1.0; 3], 4.0),
        ];
        for (value, color, extinction) in expected {
            assert_eq!(function.sample(value), Sample { color, extinction }, "at {value}");
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(function.sample(value), Sample::TRANSPARENT);
        }
    }

    #[test]
    fn a_log_scale_is_linear_in_the_logarithm() {
        let opacity = Opacity::Extinction(points(&[(1e-2, 0.0), (1e2, 1.0)]));
        let function = function(Scale::Log10, &[(1e-2, [0.0; 3]), (1e2, [1.0; 3])], opacity).prepared(1.0);
        assert_eq!(function.sample(1.0), Sample { color: [0.5; 3], extinction: 0.5 });
        assert_eq!(function.sample(10.0), Sample { color: [0.75; 3], extinction: 0.75 });
        assert_eq!(function.sample(0.0), function.sample(1e-2));
        assert_eq!(function.sample(-7.0), function.sample(1e-2));
        assert_eq!(function.max_extinction(-7.0, 1.0), 0.5);
    }

    #[test]
    fn opacity_is_per_unit_distance() {
        let opacity = Opacity::PerUnitDistance(points(&[(0.0, 0.0), (1.0, 1.0)]));
        let function = function(Scale::Linear, &[(0.0, [1.0; 3])], opacity).prepared(0.1);
        let half = function.sample(0.5);
        assert!((half.alpha(0.1) - 0.5).abs() < 1e-6);
        assert!((half.alpha(0.2) - 0.75).abs() < 1e-6);
        assert_eq!(half.alpha(0.0), 0.0);
        let opaque = function.sample(1.0);
        assert_eq!(opaque.extinction, f64::INFINITY);
        assert_eq!([0.0, 1e-30, 1.0].map(|length| opaque.alpha(length)), [0.0, 1.0, 1.0]);
        let clear = function.sample(0.0);
        assert!(clear.extinction == 0.0 && clear.extinction.is_sign_positive());
        assert_eq!(function.max_extinction(0.0, 1.0), f64::INFINITY);
    }

    #[test]
    fn an_empty_range_has_no_extinction() {
        let opacity = Opacity::Extinction(points(&[(0.0, 2.0)]));
        let function = function(Scale::Linear, &[(0.0, [1.0; 3])], opacity).prepared(1.0);
        assert_eq!(function.max_extinction(f64::INFINITY, f64::NEG_INFINITY), 0.0);
        assert_eq!(function.max_extinction(f64::NAN, 1.0), 0.0);
        assert_eq!(function.max_extinction(f64::NEG_INFINITY, f64::INFINITY), 2.0);
    }

    /// Ascending points on a coarse lattice, so that steps and single values occur.
    fn any_points() -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec((1u8..20, 0u8..=10), 1..8).prop_map(|mut points| {
            points.sort_by_key(|point| point.0);
            points.into_iter().map(|(value, opacity)| (f64::from(value) / 2.0, f64::from(opacity) / 10.0)).collect()
        })
    }

    proptest! {
        #[test]
        fn the_maximum_bounds_all_samples_and_is_reached(
            opacities in any_points(),
            log in any::<bool>(),
            extinction in any::<bool>(),
            ends in [0.0f64..11.0, 0.0..11.0],
        ) {
            let scale = if log { Scale::Log10 } else { Scale::Linear };
            let quantity = if extinction { Opacity::Extinction } else { Opacity::PerUnitDistance };
            let opacity = quantity(points(&opacities));
            let function = function(scale, &[(1.0, [0.5; 3])], opacity).prepared(0.3);
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let bound = function.max_extinction(low, high);
            let dense = (0..=2000).map(|i| low + (high - low) * f64::from(i) / 2000.0).filter(|&value| value <= high);
            // Values at and right before the points: the sides of steps.
            let sides = opacities.iter().flat_map(|&(value, _)| [value * (1.0 - 1e-12), value]);
            let inside = sides.filter(|value| (low..=high).contains(value));
            let samples = dense.chain([high]).chain(inside).map(|value| function.sample(value).extinction);
            let largest = samples.fold(0.0, f64::max);
            prop_assert!(largest <= bound, "{largest} exceeds {bound}");
            let [reached, bound] = [largest, bound].map(|extinction| Sample { extinction, ..Sample::TRANSPARENT }.alpha(0.3));
            prop_assert!(bound - reached <= 1e-5, "{bound} is never reached: {reached}");
        }
    }
}
