//! What a block of values is like: their range, and how far they bend.

use super::PieceNode;
use crate::layout::padded::{FLAG, is_hole};

/// Values around a piece, x fastest, and which of them to look at.
pub(super) struct Block<'a> {
    pub(super) values: &'a [f32],
    /// Between rows, and between slices.
    pub(super) strides: [usize; 2],
    /// The first places to look at, and their ends.
    pub(super) looked: [[usize; 3]; 2],
    /// The first places that have neighbours on all sides, and their ends.
    pub(super) inner: [[usize; 3]; 2],
    /// Whether all values are known to be numbers.
    pub(super) is_finite: bool,
    /// Whether only flagged values count, as those of leaf cells: what stands for other cells has no weight.
    pub(super) flagged_only: bool,
}

impl Block<'_> {
    /// Widens what is known of a piece; one of its cells bends `scale` times as much as one of the block's.
    #[inline(always)]
    pub(super) fn widen(&self, scale: f32, piece: &mut PieceNode) {
        let Self { values, strides: [row, slice], looked: [first, end], inner, is_finite, flagged_only } = *self;
        if (0..3).any(|axis| end[axis] <= first[axis]) {
            return;
        }
        let counts = |value: f32| !flagged_only || value.to_bits() & FLAG == FLAG;
        let length = end[0] - first[0];
        let [mut lowest, mut highest] = piece.range;
        let mut roughness = 0.0f32;
        for z in first[2]..end[2] {
            for y in first[1]..end[1] {
                let start = first[0] + row * y + slice * z;
                let line = &values[start..start + length];
                for &value in line {
                    // Not a number is neither.
                    lowest = if value < lowest { value } else { lowest };
                    highest = if value > highest { value } else { highest };
                }
                if !is_finite && line.iter().any(|&value| !value.is_finite() && !is_hole(value)) {
                    roughness = f32::INFINITY;
                }
                let is_inner = |place: usize, axis: usize| inner[0][axis] <= place && place < inner[1][axis];
                if !is_inner(y, 1) || !is_inner(z, 2) {
                    continue;
                }
                let (from, to) = (first[0].max(inner[0][0]), end[0].min(inner[1][0]));
                let start = from + row * y + slice * z;
                let length = to.saturating_sub(from);
                let line = |start: usize| &values[start..start + length];
                let (own, left, right) = (line(start), line(start - 1), line(start + 1));
                let (front, back) = (line(start - row), line(start + row));
                let (below, above) = (line(start - slice), line(start + slice));
                // Along diagonals values bend as far as slopes across one axis change along another.
                let corners = [
                    (right, back, start + 1 + row),
                    (right, above, start + 1 + slice),
                    (back, above, start + row + slice),
                ]
                .map(|(a, b, both)| (a, b, line(both)));
                for x in 0..length {
                    // Beside a hole, values go on as they are.
                    let difference = |other: f32| if other.is_nan() { 0.0 } else { other - own[x] };
                    let along = |low: f32, high: f32| {
                        if counts(low) && counts(high) { (difference(low) + difference(high)).abs() } else { 0.0 }
                    };
                    let mut bend = along(left[x], right[x]) + along(front[x], back[x]) + along(below[x], above[x]);
                    for (a, b, both) in &corners {
                        let [a, b, both] = [a[x], b[x], both[x]];
                        let twist = if counts(a) && counts(b) && counts(both) { both - a - b + own[x] } else { 0.0 };
                        bend += if twist.is_nan() { 0.0 } else { twist.abs() };
                    }
                    roughness = if bend > roughness && counts(own[x]) { bend } else { roughness };
                }
            }
        }
        piece.range = [lowest, highest];
        piece.roughness = piece.roughness.max(scale * roughness);
    }

    /// The largest difference of neighbours among all values, which fill the block.
    pub(super) fn steepest(&self) -> f32 {
        let [_, sides] = self.looked;
        let mut steepest = 0.0f32;
        for (place, &value) in self.values.iter().enumerate() {
            let cell = [place % sides[0], place / sides[0] % sides[1], place / self.strides[1]];
            for (axis, stride) in [1, self.strides[0], self.strides[1]].into_iter().enumerate() {
                if cell[axis] + 1 < sides[axis] {
                    // Not `max` of what is no number.
                    let difference = (self.values[place + stride] - value).abs();
                    steepest = if difference > steepest { difference } else { steepest };
                }
            }
        }
        steepest
    }
}
