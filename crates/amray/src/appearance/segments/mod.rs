//! A transfer function as linear segments: what an interval of values emits and absorbs has a closed form on each.

mod integral;
mod knots;

use super::{PreparedTransferFunction, Scale};
use crate::simd::SHORT_TABLES;
use knots::Knot;

pub(crate) use integral::{Glow, Light, Place, Slopes};

/// Extinction and colour, linear in the position on each of a number of segments.
///
/// Positions are 0 to 1: over the field's range on a linear scale, over the function's own points on a log scale.
#[derive(Clone, Debug)]
pub(crate) struct Segments {
    axis: PositionAxis,
    /// Where each segment starts; the first one reaches down to minus, the last one up to plus infinity.
    starts: Vec<f32>,
    /// Coefficients of the extinction's integral, then, for powers 0 and 1 of the position, of the extinction.
    extinction: [Vec<f32>; 3],
    /// The same of red, green and blue times extinction, with powers 0 to 2.
    emission: [[Vec<f32>; 4]; 3],
    count: usize,
    /// Per segment, how much extinction or emission change per position.
    steepness: Vec<f64>,
}

/// How positions follow from units of the field's range.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PositionAxis {
    /// A position is the value, in units of the field's range.
    Linear,
    /// log2(value + shift) * factor + offset, held within 0 and 1.
    Log { shift: f32, factor: f32, offset: f32 },
}

/// The segments that a range of values meets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Window {
    pub(crate) first: u16,
    pub(crate) last: u16,
}

impl Window {
    /// All segments.
    pub(crate) fn all(segments: &Segments) -> Self {
        Self { first: 0, last: segments.count as u16 - 1 }
    }
}

impl Segments {
    /// The segments of a function over a field whose values run from `low` to `low + width`.
    ///
    /// Colours are within 1/1024 of the function's, extinctions within 2 thousandths; both are exact where the function
    /// itself has no more than a few points.
    pub(crate) fn new(function: &PreparedTransferFunction, low: f64, width: f64) -> Self {
        let (axis, ends) = match function.scale() {
            Scale::Linear => (PositionAxis::Linear, [low, low + width]),
            Scale::Log10 => {
                let [first, last] = function.position_range();
                let span = if last > first { last - first } else { 1.0 };
                let decade = std::f64::consts::LOG10_2;
                let axis = PositionAxis::Log {
                    shift: (low / width) as f32,
                    factor: (decade / span) as f32,
                    offset: ((width.log10() - first) / span) as f32,
                };
                (axis, [first, first + span])
            }
        };
        let knots = knots::simplified(knots::of_function(function, ends));
        let count = knots.len() - 1;
        let mut segments = Self {
            axis,
            starts: Vec::with_capacity(count),
            extinction: Default::default(),
            emission: Default::default(),
            count,
            steepness: Vec::with_capacity(count),
        };
        let mut integrals = [0.0; 4];
        for pair in knots.windows(2) {
            segments.push(&pair[0], &pair[1], &mut integrals);
        }
        // Short tables can be kept in registers, and no value is found beyond the last segment.
        let length = SHORT_TABLES.into_iter().find(|&length| count <= length).unwrap_or(count);
        segments.starts.resize(length, f32::INFINITY);
        for table in segments.extinction.iter_mut().chain(segments.emission.as_flattened_mut()) {
            table.resize(length, 0.0);
        }
        segments
    }

    /// Appends the segment between two knots; `integrals` are those of extinction and emission up to its start.
    fn push(&mut self, from: &Knot, to: &Knot, integrals: &mut [f64; 4]) {
        let line = |component: usize| {
            let slope = (to.before[component] - from.after[component]) / (to.position - from.position);
            [from.after[component] - slope * from.position, slope]
        };
        // The antiderivative of a polynomial, whose coefficients start with power 0, without its constant.
        let antiderivative = |coefficients: &[f64], x: f64| -> f64 {
            coefficients.iter().enumerate().map(|(power, c)| c * x.powi(power as i32 + 1) / (power + 1) as f64).sum()
        };
        let [extinction, slope] = line(0);
        self.starts.push(from.position as f32);
        let append = |tables: &mut [Vec<f32>], coefficients: &[f64], integral: &mut f64| {
            let [start, end] = [from.position, to.position].map(|x| antiderivative(coefficients, x));
            tables[0].push((*integral - start) as f32);
            *integral += end - start;
            for (table, coefficient) in tables[1..].iter_mut().zip(coefficients) {
                table.push(*coefficient as f32);
            }
        };
        // A step, if only at the far end, is as if it took a thousandth of the range.
        let width = to.position - from.position;
        let step = (to.after[0] - to.before[0]).abs() / 1e-3;
        self.steepness.push(((to.before[0] - from.after[0]).abs() / width).max(step));
        append(&mut self.extinction, &[extinction, slope], &mut integrals[0]);
        for channel in 0..3 {
            let [color, color_slope] = line(channel + 1);
            let product = [extinction * color, extinction * color_slope + slope * color, slope * color_slope];
            append(&mut self.emission[channel], &product, &mut integrals[channel + 1]);
        }
    }

    /// The segments of the values from `low` to `high`, in units of the field's range.
    pub(crate) fn window(&self, [low, high]: [f32; 2]) -> Window {
        let segment = |unit: f32| {
            let position = self.position(unit);
            self.starts[1..self.count].partition_point(|&start| start <= position) as u16
        };
        Window { first: segment(low), last: segment(high) }
    }

    /// By how much extinction or emission changes, at most, per unit of the field's range.
    pub(crate) fn steepness(&self, window: Window) -> f64 {
        let steepest = self.steepness[usize::from(window.first)..=usize::from(window.last)].iter().copied();
        steepest.fold(0.0, f64::max)
    }

    fn position(&self, unit: f32) -> f32 {
        match self.axis {
            PositionAxis::Linear => unit,
            PositionAxis::Log { shift, factor, offset } => {
                ((unit + shift).max(f32::MIN_POSITIVE).log2() * factor + offset).clamp(0.0, 1.0)
            }
        }
    }
}
