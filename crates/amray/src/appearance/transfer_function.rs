//! The transfer function: which colour and opacity a value has.

use thiserror::Error;

use super::curve::Curve;
use super::{ColorMap, PreparedTransferFunction, RangeError, Scale};

/// Colours of a colour map that a transfer function takes over.
const MAP_COLORS: usize = 256;

/// Colour and opacity of every value: two piecewise-linear curves with points of their own.
///
/// Values outside the points have the colour and opacity of the nearest one; non-finite values are transparent. Two
/// points at one value make a step, at which the second one counts (of more points at one value, the first and last
/// are kept). On a log scale the curves are linear in the value's logarithm.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    scale: Scale,
    colors: Vec<ColorPoint>,
    opacity: Opacity,
}

/// The colour of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorPoint {
    /// The value, in units of the data.
    pub value: f64,
    /// Its display colour: red, green and blue within 0 and 1.
    pub color: [f32; 3],
}

/// The opacity of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpacityPoint {
    /// The value, in units of the data.
    pub value: f64,
    /// Its opacity; see [`Opacity`] for the quantity.
    pub opacity: f64,
}

/// Opacity points, and the quantity that they give and that is linear between them.
#[derive(Clone, Debug, PartialEq)]
pub enum Opacity {
    /// The opacity a, within 0 and 1, of a path of one unit distance D: a step dt has alpha 1 - (1 - a)^(dt / D).
    PerUnitDistance(Vec<OpacityPoint>),
    /// The extinction sigma, 0 or more, per world length: a step dt has alpha 1 - exp(-sigma dt).
    Extinction(Vec<OpacityPoint>),
}

/// Points that make no transfer function. Points are numbered from 0.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TransferFunctionError {
    /// No point at all.
    #[error("no {what} points, expected at least one")]
    Empty {
        /// Colour or opacity.
        what: &'static str,
    },
    /// A value that cannot be a point.
    #[error("{what} point {index}: value {found:?}, expected {expected}")]
    Value {
        /// Colour or opacity.
        what: &'static str,
        /// The point.
        index: usize,
        /// Its value.
        found: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// A value below the one before.
    #[error("{what} point {index}: value {found:?} after {previous:?}, expected ascending values")]
    Order {
        /// Colour or opacity.
        what: &'static str,
        /// The point.
        index: usize,
        /// Its value.
        found: f64,
        /// The value of the point before it.
        previous: f64,
    },
    /// A colour that no display has.
    #[error("colour point {index}: {found:?}, expected red, green and blue within 0 and 1")]
    Color {
        /// The point.
        index: usize,
        /// Its colour.
        found: [f32; 3],
    },
    /// An opacity that does not exist.
    #[error("opacity point {index}: {quantity} {found:?}, expected {expected}")]
    Opacity {
        /// The point.
        index: usize,
        /// Opacity or extinction.
        quantity: &'static str,
        /// Its opacity.
        found: f64,
        /// What it should be.
        expected: &'static str,
    },
    /// A range of values that cannot be coloured.
    #[error(transparent)]
    Range(#[from] RangeError),
}

impl TransferFunction {
    /// The transfer function through explicit points, ascending in value.
    ///
    /// # Errors
    /// [`TransferFunctionError`] names the first point that is not finite, out of order or out of its range.
    pub fn new(scale: Scale, mut colors: Vec<ColorPoint>, mut opacity: Opacity) -> Result<Self, TransferFunctionError> {
        check_colors(scale, &colors)?;
        check_opacity(scale, &opacity)?;
        drop_inner_points(&mut colors, |point| point.value);
        drop_inner_points(opacity.points_mut(), |point| point.value);
        Ok(Self { scale, colors, opacity })
    }

    /// A colour map spread over `range` (low, high), with opacity points that need not have the same range.
    ///
    /// # Errors
    /// [`TransferFunctionError`] where the range is not ascending, or not above 0 on a log scale, and for bad
    /// opacity points.
    pub fn from_color_map(
        map: ColorMap,
        range: [f64; 2],
        scale: Scale,
        opacity: Opacity,
    ) -> Result<Self, TransferFunctionError> {
        scale.check(range)?;
        let point = |index| {
            let share = index as f64 / (MAP_COLORS - 1) as f64;
            ColorPoint { value: scale.at_fraction(range, share), color: map.color(share as f32) }
        };
        Self::new(scale, (0..MAP_COLORS).map(point).collect(), opacity)
    }

    /// How values lie between the points.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// The colour points, ascending in value.
    pub fn colors(&self) -> &[ColorPoint] {
        &self.colors
    }

    /// The opacity points, ascending in value.
    pub fn opacity(&self) -> &Opacity {
        &self.opacity
    }

    /// The lowest and the highest value that has a point.
    pub fn range(&self) -> [f64; 2] {
        let opacity = self.opacity.points();
        let [first, last] = [self.colors[0].value, self.colors[self.colors.len() - 1].value];
        [first.min(opacity[0].value), last.max(opacity[opacity.len() - 1].value)]
    }

    /// The same function over another range: its lowest point moves to the low, its highest to the high end.
    /// (Points that all have one value move to the middle.)
    ///
    /// # Errors
    /// [`RangeError`] where the range is not ascending, or not above 0 on a log scale.
    pub fn rescaled(&self, range: [f64; 2]) -> Result<Self, RangeError> {
        self.scale.check(range)?;
        let old = self.range();
        let mut scaled = self.clone();
        let move_to = |value: &mut f64| *value = self.scale.at_fraction(range, self.scale.fraction(old, *value));
        scaled.colors.iter_mut().for_each(|point| move_to(&mut point.value));
        scaled.opacity.points_mut().iter_mut().for_each(|point| move_to(&mut point.value));
        // Rounding can change the order of close points, and in a narrow range they fall together.
        scaled.colors.sort_by(|a, b| a.value.total_cmp(&b.value));
        scaled.opacity.points_mut().sort_by(|a, b| a.value.total_cmp(&b.value));
        drop_inner_points(&mut scaled.colors, |point| point.value);
        drop_inner_points(scaled.opacity.points_mut(), |point| point.value);
        Ok(scaled)
    }

    /// The same colours with an extinction of 1 everywhere.
    pub(crate) fn colors_alone(&self) -> Self {
        let opacity = Opacity::Extinction(vec![OpacityPoint { value: self.range()[0], opacity: 1.0 }]);
        Self { opacity, ..self.clone() }
    }

    /// The same function with all opacities (or extinctions) multiplied by `factor`, opacities at most 1.
    ///
    /// # Panics
    /// Where the factor is not finite or below 0.
    pub fn scaled_opacity(&self, factor: f64) -> Self {
        assert!(factor >= 0.0 && factor.is_finite(), "opacity factor {factor}");
        let mut scaled = self.clone();
        match &mut scaled.opacity {
            Opacity::PerUnitDistance(points) => *points = capped(self.scale, points, factor),
            Opacity::Extinction(points) => {
                points.iter_mut().for_each(|point| point.opacity = (point.opacity * factor).min(f64::MAX));
            }
        }
        scaled
    }

    /// The function made ready for sampling, where opacities are those of a path of `unit_distance` in world units.
    ///
    /// # Panics
    /// Where the unit distance is not finite and above 0.
    pub fn prepared(&self, unit_distance: f64) -> PreparedTransferFunction {
        PreparedTransferFunction::new(self, unit_distance)
    }

    pub(super) fn color_curve(&self) -> Curve<3> {
        let point = |point: &ColorPoint| (self.scale.position(point.value), point.color.map(f64::from));
        Curve::new(self.colors.iter().map(point))
    }

    pub(super) fn opacity_curve(&self) -> Curve<1> {
        Curve::new(self.opacity.points().iter().map(|point| (self.scale.position(point.value), [point.opacity])))
    }
}

impl Opacity {
    /// The points, whatever they give.
    pub fn points(&self) -> &[OpacityPoint] {
        match self {
            Self::PerUnitDistance(points) | Self::Extinction(points) => points,
        }
    }

    fn points_mut(&mut self) -> &mut Vec<OpacityPoint> {
        match self {
            Self::PerUnitDistance(points) | Self::Extinction(points) => points,
        }
    }
}

/// Opacities times `factor`, at most 1, with a point more wherever they pass 1.
fn capped(scale: Scale, points: &[OpacityPoint], factor: f64) -> Vec<OpacityPoint> {
    let mut capped = Vec::with_capacity(points.len());
    let mut last: Option<OpacityPoint> = None;
    for point in points {
        let next = OpacityPoint { value: point.value, opacity: point.opacity * factor };
        if let Some(last) = last.filter(|last| (last.opacity - 1.0) * (next.opacity - 1.0) < 0.0) {
            let share = (1.0 - last.opacity) / (next.opacity - last.opacity);
            capped.push(OpacityPoint { value: scale.at_fraction([last.value, next.value], share), opacity: 1.0 });
        }
        capped.push(OpacityPoint { opacity: next.opacity.min(1.0), ..next });
        last = Some(next);
    }
    drop_inner_points(&mut capped, |point| point.value);
    capped
}

/// Of three or more neighbours at one value, keeps the first and the last: the two sides of a step.
fn drop_inner_points<T: Copy>(points: &mut Vec<T>, value: impl Fn(T) -> f64) {
    let mut kept = 0;
    for index in 0..points.len() {
        let [now, back] = [index, kept.max(2) - 2].map(|index| value(points[index]));
        if kept >= 2 && back == now {
            kept -= 1;
        }
        points[kept] = points[index];
        kept += 1;
    }
    points.truncate(kept);
}

pub(super) fn check_colors(scale: Scale, points: &[ColorPoint]) -> Result<(), TransferFunctionError> {
    check_values("colour", scale, points.iter().map(|point| point.value))?;
    let inside = |point: &ColorPoint| point.color.iter().all(|value| (0.0..=1.0).contains(value));
    match points.iter().position(|point| !inside(point)) {
        Some(index) => Err(TransferFunctionError::Color { index, found: points[index].color }),
        None => Ok(()),
    }
}

pub(super) fn check_opacity(scale: Scale, opacity: &Opacity) -> Result<(), TransferFunctionError> {
    let points = opacity.points();
    check_values("opacity", scale, points.iter().map(|point| point.value))?;
    let (quantity, limit, expected) = match opacity {
        Opacity::PerUnitDistance(_) => ("opacity", 1.0, "a number within 0 and 1"),
        Opacity::Extinction(_) => ("extinction", f64::MAX, "a finite number of at least 0"),
    };
    match points.iter().position(|point| !(0.0..=limit).contains(&point.opacity)) {
        Some(index) => Err(TransferFunctionError::Opacity { index, quantity, found: points[index].opacity, expected }),
        None => Ok(()),
    }
}

fn check_values(
    what: &'static str,
    scale: Scale,
    values: impl Iterator<Item = f64>,
) -> Result<(), TransferFunctionError> {
    // No difference of two such values overflows.
    const LIMIT: f64 = f64::MAX / 2.0;
    let mut last = None;
    for (index, found) in values.enumerate() {
        let bad = |expected| Err(TransferFunctionError::Value { what, index, found, expected });
        if !found.is_finite() {
            return bad("a finite number");
        }
        if found.abs() > LIMIT {
            return bad("a number within -8e307 and 8e307");
        }
        if scale == Scale::Log10 && found <= 0.0 {
            return bad("a number above 0 on a log scale");
        }
        if let Some(previous) = last.filter(|&last| found < last) {
            return Err(TransferFunctionError::Order { what, index, found, previous });
        }
        last = Some(found);
    }
    last.map(|_| ()).ok_or(TransferFunctionError::Empty { what })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color(value: f64, color: [f32; 3]) -> ColorPoint {
        ColorPoint { value, color }
    }

    fn opacity(points: &[(f64, f64)]) -> Vec<OpacityPoint> {
        points.iter().map(|&(value, opacity)| OpacityPoint { value, opacity }).collect()
    }

    fn black_to_white(scale: Scale, range: [f64; 2], points: &[(f64, f64)]) -> TransferFunction {
        let colors = vec![color(range[0], [0.0; 3]), color(range[1], [1.0; 3])];
        TransferFunction::new(scale, colors, Opacity::PerUnitDistance(opacity(points))).unwrap()
    }

    #[test]
    fn a_colour_map_fills_its_range() {
        let points = Opacity::Extinction(opacity(&[(10.0, 1.0)]));
        let function = TransferFunction::from_color_map(ColorMap::Gray, [1.0, 1e4], Scale::Log10, points).unwrap();
        assert_eq!(function.range(), [1.0, 1e4]);
        assert_eq!([0, 51, 255].map(|index| function.colors()[index].color[0]), [0.0, 0.2, 1.0]);
        assert!((function.colors()[51].value - 10f64.powf(0.8)).abs() < 1e-12);
    }

    #[test]
    fn of_points_at_one_value_the_outer_two_stay() {
        let function = black_to_white(
            Scale::Linear,
            [0.0, 1.0],
            &[
                (0.0, 0.1),
                (0.0, 0.2),
                (0.0, 0.3),
                (0.5, 0.4),
                (0.5, 0.5),
                (1.0, 0.6),
                (1.0, 0.7),
                (1.0, 0.8),
                (1.0, 0.9),
            ],
        );
        let kept = opacity(&[(0.0, 0.1), (0.0, 0.3), (0.5, 0.4), (0.5, 0.5), (1.0, 0.6), (1.0, 0.9)]);
        assert_eq!(function.opacity().points(), kept);
    }

    #[test]
    fn rescaling_moves_the_ends_exactly() {
        let function = black_to_white(Scale::Linear, [0.0, 2.0], &[(0.5, 0.0), (4.0, 1.0)]);
        let scaled = function.rescaled([-1.0, 7.0]).unwrap();
        assert_eq!(scaled.range(), [-1.0, 7.0]);
        assert_eq!(scaled.colors()[1].value, 3.0);
        assert_eq!(scaled.opacity().points(), opacity(&[(0.0, 0.0), (7.0, 1.0)]));

        let function = black_to_white(Scale::Log10, [1.0, 100.0], &[(10.0, 1.0)]);
        let scaled = function.rescaled([1e-3, 1e3]).unwrap();
        assert_eq!(scaled.range(), [1e-3, 1e3]);
        assert!((scaled.opacity().points()[0].value - 1.0).abs() < 1e-12);
        assert!(function.rescaled([0.0, 1.0]).is_err() && function.rescaled([2.0, 1.0]).is_err());
    }

    #[test]
    fn a_range_of_two_neighbouring_numbers_is_enough() {
        let points = Opacity::PerUnitDistance(opacity(&[(1.0, 1.0)]));
        let range = [1.0, 1.0f64.next_up()];
        let function = TransferFunction::from_color_map(ColorMap::Gray, range, Scale::Linear, points).unwrap();
        assert_eq!(function.range(), range);
        assert_eq!(function.rescaled([5.0, 6.0]).unwrap().range(), [5.0, 6.0]);
        let single = black_to_white(Scale::Linear, [3.0, 3.0], &[(3.0, 0.5)]);
        assert_eq!(single.rescaled([0.0, 2.0]).unwrap().range(), [1.0, 1.0]);
    }

    #[test]
    fn scaled_opacities_stop_at_one() {
        let function = black_to_white(Scale::Linear, [0.0, 1.0], &[(0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (2.0, 0.0)]);
        let doubled = opacity(&[(0.0, 0.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.0)]);
        assert_eq!(function.scaled_opacity(2.0).opacity().points(), doubled);
        let fourfold = opacity(&[(0.0, 0.0), (0.5, 1.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.0)]);
        assert_eq!(function.scaled_opacity(4.0).opacity().points(), fourfold);
        let halved = opacity(&[(0.0, 0.0), (1.0, 0.25), (2.0, 0.5), (2.0, 0.0)]);
        assert_eq!(function.scaled_opacity(0.5).opacity().points(), halved);

        let colors = vec![color(0.0, [0.0; 3])];
        let sigma = |value| Opacity::Extinction(opacity(&[(0.0, value)]));
        let function = TransferFunction::new(Scale::Linear, colors, sigma(3.0)).unwrap();
        assert_eq!(function.scaled_opacity(4.0).opacity(), &sigma(12.0));
    }

    #[test]
    fn every_bad_point_is_named() {
        let good = [color(1.0, [0.0; 3]), color(2.0, [1.0; 3])];
        let message = |scale, colors: &[ColorPoint], points: Opacity| {
            TransferFunction::new(scale, colors.to_vec(), points).unwrap_err().to_string()
        };
        let per_distance = |points: &[(f64, f64)]| Opacity::PerUnitDistance(opacity(points));
        let fine = || per_distance(&[(1.0, 0.5)]);
        let linear = Scale::Linear;
        assert_eq!(message(linear, &[], fine()), "no colour points, expected at least one");
        assert_eq!(message(linear, &good, per_distance(&[])), "no opacity points, expected at least one");
        assert_eq!(
            message(linear, &[good[0], color(f64::NAN, [0.0; 3])], fine()),
            "colour point 1: value NaN, expected a finite number"
        );
        assert_eq!(
            message(linear, &[color(-1e308, [0.0; 3])], fine()),
            "colour point 0: value -1e308, expected a number within -8e307 and 8e307"
        );
        assert_eq!(
            message(linear, &[good[1], good[0]], fine()),
            "colour point 1: value 1.0 after 2.0, expected ascending values"
        );
        assert_eq!(
            message(linear, &[good[0], color(2.0, [0.0, 1.5, 0.0])], fine()),
            "colour point 1: [0.0, 1.5, 0.0], expected red, green and blue within 0 and 1"
        );
        assert_eq!(
            message(linear, &[color(2.0, [f32::NAN, 0.5, 0.0])], fine()),
            "colour point 0: [NaN, 0.5, 0.0], expected red, green and blue within 0 and 1"
        );
        assert_eq!(
            message(Scale::Log10, &good, per_distance(&[(0.0, 0.5)])),
            "opacity point 0: value 0.0, expected a number above 0 on a log scale"
        );
        assert_eq!(
            message(linear, &good, per_distance(&[(1.0, 0.5), (2.0, 1.01)])),
            "opacity point 1: opacity 1.01, expected a number within 0 and 1"
        );
        assert_eq!(
            message(linear, &good, Opacity::Extinction(opacity(&[(1.0, -2.0)]))),
            "opacity point 0: extinction -2.0, expected a finite number of at least 0"
        );
        assert_eq!(
            TransferFunction::from_color_map(ColorMap::Gray, [2.0, 1.0], linear, fine()).unwrap_err().to_string(),
            "range 2.0 to 1.0, expected two finite numbers, the lower one first"
        );
    }
}
