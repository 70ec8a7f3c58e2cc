//! A transfer function as linear segments: what an interval of values emits and absorbs has a closed form on each.

mod integral;
mod knots;
mod tables;

use super::{PreparedTransferFunction, Scale};
use knots::Knot;
use tables::{KINDS, START, Tables};

pub(crate) use integral::{Absorbed, Glow, Place, Radiance, Slopes, attenuate};

/// Extinction and colour, linear in the position on each of a number of segments.
///
/// Positions are 0 to 1: over the field's range on a linear scale, over the function's own points on a log scale.
#[derive(Clone, Debug)]
pub(crate) struct Segments {
    axis: PositionAxis,
    tables: Tables,
    count: usize,
    /// The first and the last segment with any extinction; where there is none, not in this order.
    lit: [i32; 2],
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
                // A little more than all points: what is beyond is as at the ends.
                let [first, last] = function.position_range();
                let margin = if last > first { (last - first) / 64.0 } else { 1.0 };
                let (first, span) = (first - margin, last - first + 2.0 * margin);
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
        let mut integrals = [0.0; 4];
        let numbers: Vec<_> = knots.windows(2).map(|pair| numbers(&pair[0], &pair[1], &mut integrals)).collect();
        let steepness = knots.windows(2).map(|pair| steepness(&pair[0], &pair[1])).collect();
        let is_lit = |pair: &[Knot]| pair[0].after[0] > 0.0 || pair[1].before[0] > 0.0;
        let lit = [
            knots.windows(2).position(is_lit).map_or(i32::MAX, |first| first as i32),
            knots.windows(2).rposition(is_lit).map_or(-1, |last| last as i32),
        ];
        Self { axis, tables: Tables::new(&numbers), count, lit, steepness }
    }

    /// Where each segment starts; the first one reaches down to minus, the last one up to plus infinity.
    fn starts(&self) -> &[f32] {
        &self.tables.table(START)[..self.count]
    }

    /// The segments of the values from `low` to `high`, in units of the field's range.
    pub(crate) fn window(&self, [low, high]: [f32; 2]) -> Window {
        let segment = |unit: f32| {
            let position = self.position(unit);
            self.starts()[1..].partition_point(|&start| start <= position) as u16
        };
        Window { first: segment(low), last: segment(high) }
    }

    /// By how much extinction or emission changes, at most, per unit of the field's range.
    pub(crate) fn steepness(&self, window: Window) -> f64 {
        let steepest = self.steepness[usize::from(window.first)..=usize::from(window.last)].iter().copied();
        steepest.fold(0.0, f64::max)
    }

    /// Whether values of a window can lie below or above all that is seen.
    pub(crate) fn may_be_dark(&self, window: Window) -> bool {
        i32::from(window.first) < self.lit[0] || i32::from(window.last) > self.lit[1]
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

/// What the tables hold of the segment between two knots; `integrals` are those of extinction and emission up to its
/// start.
fn numbers(from: &Knot, to: &Knot, integrals: &mut [f64; 4]) -> [f32; KINDS] {
    let width = to.position - from.position;
    let line = |component: usize| {
        let start = from.after[component];
        [start, (to.before[component] - start) / width]
    };
    let [extinction, slope] = line(0);
    let mut numbers = vec![from.position, extinction, slope];
    let before = *integrals;
    integrals[0] += width * (extinction + width * slope / 2.0);
    for channel in 0..3 {
        let [color, color_slope] = line(channel + 1);
        let product = [extinction * color, extinction * color_slope + slope * color, slope * color_slope];
        integrals[channel + 1] += width * (product[0] + width * (product[1] / 2.0 + width * product[2] / 3.0));
        numbers.extend(product);
    }
    numbers.extend(before);
    std::array::from_fn(|kind| numbers[kind] as f32)
}

/// By how much extinction changes per position between two knots.
fn steepness(from: &Knot, to: &Knot) -> f64 {
    // A step, if only at the far end, is as if it took a thousandth of the range.
    let step = (to.after[0] - to.before[0]).abs() / 1e-3;
    ((to.before[0] - from.after[0]).abs() / (to.position - from.position)).max(step)
}
