//! A transfer function as linear segments: what an interval of values emits and absorbs has a closed form on each.

mod integral;
mod knots;

use super::{PreparedTransferFunction, Scale};
use crate::simd::TABLE;

pub(crate) use integral::{Interval, Light, Place};

/// Extinction and colour, linear in the position on each of a number of segments.
///
/// Positions are 0 to 1: over the field's range on a linear scale, over the function's own points on a log scale.
#[derive(Clone, Debug)]
pub(crate) struct Segments {
    axis: PositionAxis,
    /// Where each segment starts; the first one reaches down to minus, the last one up to plus infinity.
    starts: Vec<f32>,
    /// Extinction: its value at position 0 and its slope.
    extinction: [Vec<f32>; 2],
    /// Red, green and blue: the same.
    color: [[Vec<f32>; 2]; 3],
    count: usize,
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
            color: Default::default(),
            count,
        };
        for pair in knots.windows(2) {
            let [from, to] = [&pair[0], &pair[1]];
            segments.starts.push(from.position as f32);
            let line = |component: usize| {
                let [a, b] = [from.after[component], to.before[component]];
                let slope = (b - a) / (to.position - from.position);
                [(a - slope * from.position) as f32, slope as f32]
            };
            let [[extinction, color @ ..], [extinction_slope, color_slopes @ ..]] =
                [0, 1].map(|coefficient| [0, 1, 2, 3].map(|component| line(component)[coefficient]));
            segments.extinction[0].push(extinction);
            segments.extinction[1].push(extinction_slope);
            for channel in 0..3 {
                segments.color[channel][0].push(color[channel]);
                segments.color[channel][1].push(color_slopes[channel]);
            }
        }
        // Tables have one length, and no value is found beyond the last segment.
        let length = count.max(TABLE);
        segments.starts.resize(length, f32::INFINITY);
        let [red, green, blue] = &mut segments.color;
        for table in [&mut segments.extinction, red, green, blue].into_iter().flatten() {
            table.resize(length, 0.0);
        }
        segments
    }

    /// The number of segments.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The segments of the values from `low` to `high`, in units of the field's range.
    pub(crate) fn window(&self, [low, high]: [f32; 2]) -> Window {
        let segment = |unit: f32| {
            let position = self.position(unit);
            self.starts[1..self.count].partition_point(|&start| start <= position) as u16
        };
        Window { first: segment(low), last: segment(high) }
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
