//! Piecewise-linear curves with steps, clamped at both ends.

/// A piecewise-linear curve of `N` components. Two points at one position make a step, at which the second one counts.
#[derive(Clone, Debug)]
pub(super) struct Curve<const N: usize> {
    positions: Vec<f64>,
    values: Vec<[f64; N]>,
}

impl<const N: usize> Curve<N> {
    /// The curve through points in ascending order; there must be one at least.
    pub(super) fn new(points: impl Iterator<Item = (f64, [f64; N])>) -> Self {
        let (positions, values): (Vec<_>, Vec<_>) = points.unzip();
        assert!(!positions.is_empty(), "a curve without points");
        Self { positions, values }
    }

    /// The points' positions, ascending.
    pub(super) fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// The value at `position`, and right after it.
    #[inline]
    pub(super) fn at(&self, position: f64) -> [f64; N] {
        self.before(self.positions.partition_point(|&point| point <= position), position)
    }

    /// The value right before `position`.
    pub(super) fn left_of(&self, position: f64) -> [f64; N] {
        let end = self.positions.partition_point(|&point| point < position);
        if self.positions.get(end) == Some(&position) { self.values[end] } else { self.before(end, position) }
    }

    /// Whether the curve has a step at `position`.
    pub(super) fn has_step(&self, position: f64) -> bool {
        let first = self.positions.partition_point(|&point| point < position);
        self.positions.get(first + 1) == Some(&position)
    }

    /// The value at `position` on the segment that ends at point `end`.
    #[inline]
    fn before(&self, end: usize, position: f64) -> [f64; N] {
        if end == 0 {
            return self.values[0];
        }
        let start = self.values[end - 1];
        let Some(&last) = self.values.get(end) else { return start };
        let [low, high] = [self.positions[end - 1], self.positions[end]];
        let share = (position - low) / (high - low);
        // Rounding must not lead out of the segment: bounds on a range of positions rely on it.
        std::array::from_fn(|component| {
            let [a, b] = [start[component], last[component]];
            (a + (b - a) * share).clamp(a.min(b), a.max(b))
        })
    }
}

impl Curve<1> {
    /// The largest value at positions from `low` to `high`, both included.
    pub(super) fn max(&self, low: f64, high: f64) -> f64 {
        let first = self.positions.partition_point(|&point| point <= low);
        let last = self.positions.partition_point(|&point| point <= high);
        let inside = self.values[first..last.max(first)].iter().map(|&[value]| value);
        inside.fold(self.at(low)[0].max(self.at(high)[0]), f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Curve<1> {
        Curve::new([(0.0, [1.0]), (1.0, [3.0]), (1.0, [0.0]), (3.0, [4.0])].into_iter())
    }

    #[test]
    fn is_linear_between_points_and_constant_outside() {
        let curve = curve();
        let at = [-1.0, 0.0, 0.25, 1.0, 2.0, 3.0, 9.0, f64::NEG_INFINITY].map(|position| curve.at(position)[0]);
        assert_eq!(at, [1.0, 1.0, 1.5, 0.0, 2.0, 4.0, 4.0, 1.0]);
    }

    #[test]
    fn a_step_has_two_sides() {
        let curve = curve();
        assert_eq!([curve.left_of(1.0), curve.at(1.0)], [[3.0], [0.0]]);
        assert_eq!([0.0, 1.0, 2.0, 3.0].map(|position| curve.has_step(position)), [false, true, false, false]);
    }

    #[test]
    fn the_maximum_counts_points_inside() {
        let curve = curve();
        assert_eq!(curve.max(0.5, 2.0), 3.0);
        assert_eq!(curve.max(1.0, 2.0), 2.0);
        assert_eq!(curve.max(f64::NEG_INFINITY, f64::INFINITY), 4.0);
        assert_eq!(curve.max(0.25, 0.25), 1.5);
    }
}
