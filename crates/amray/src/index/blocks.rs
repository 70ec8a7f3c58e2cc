//! Value ranges of a brick's cells, block by block: computed once, combined for every region that shows them.

use rayon::prelude::*;

use crate::hierarchy::{BrickValues, Voxel};

/// Cells of a block per axis. Smaller ones cost memory (with 4, a thirty-second of single-precision values), of larger
/// ones regions cut more.
const BLOCK: usize = 4;
/// Fewer cells are looked at by one thread.
const PARALLEL_CELLS: usize = 1 << 14;

/// The range of no values.
pub(super) const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// A box of a brick's cells, counted from its low corner: the first, and one past the last, per axis.
pub(super) type Cells = [[usize; 3]; 2];

/// Lowest and highest finite value per block of a brick, and the brick's values where blocks are cut.
pub(super) struct Blocks<'a, T> {
    values: &'a BrickValues<T>,
    /// Blocks per axis.
    count: [usize; 3],
    /// x fastest.
    ranges: Vec<[f32; 2]>,
    /// Of all blocks.
    range: [f32; 2],
}

impl<'a, T: Voxel> Blocks<'a, T> {
    /// Looks at every value once.
    pub(super) fn new(values: &'a BrickValues<T>) -> Self {
        let size = values.size();
        let count = size.map(|cells| cells.div_ceil(BLOCK));
        let mut ranges = vec![NOTHING; count.iter().product()];
        let of_a_row = size[0] * BLOCK * BLOCK;
        let rows = ranges.par_chunks_mut(count[0].max(1)).enumerate();
        rows.with_min_len(PARALLEL_CELLS.div_ceil(of_a_row.max(1))).for_each(|(row, ranges)| {
            let (j, k) = (row % count[1], row / count[1]);
            // Two blocks at a time: more cells in a row are fewer instructions a cell.
            for (pair, ranges) in ranges.chunks_mut(2).enumerate() {
                let block = |place: usize| corners([2 * pair + place, j, k], size);
                let [low, high] = block(0);
                if low[0] + 2 * BLOCK <= size[0] {
                    let lanes = lanes::<T, { 2 * BLOCK }>(values, low, high);
                    for (place, range) in ranges.iter_mut().enumerate() {
                        let own = |lanes: [T; 2 * BLOCK]| -> [T; BLOCK] {
                            std::array::from_fn(|lane| lanes[place * BLOCK + lane])
                        };
                        *range = finite(joined(NOTHING.map(f64::from), lanes.map(own)), values, block(place));
                    }
                } else {
                    for (place, range) in ranges.iter_mut().enumerate() {
                        *range = exact_range(values, block(place));
                    }
                }
            }
        });
        let range = ranges.iter().copied().fold(NOTHING, union);
        Self { values, count, ranges, range }
    }

    /// Widens `range` by the whole blocks among the `cells`.
    pub(super) fn widen_by_whole(&self, range: &mut [f32; 2], cells: Cells) {
        let whole = self.whole(cells);
        if (0..3).all(|axis| whole[0][axis] < whole[1][axis]) {
            *range = union(*range, self.range_of_blocks(whole));
        }
    }

    /// Widens `range` by those of the `cells` that lie in blocks which are cut.
    pub(super) fn widen_by_cut(&self, range: &mut [f32; 2], cells: Cells) {
        if holds(*range, self.range) {
            return;
        }
        let whole = self.whole(cells).map(|block| block.map(|place| place * BLOCK));
        if (0..3).any(|axis| whole[0][axis] >= whole[1][axis]) {
            return self.widen_by_some(range, cells);
        }
        let mut rest = cells;
        for axis in (0..3).rev() {
            let (mut below, mut above) = (rest, rest);
            below[1][axis] = whole[0][axis];
            above[0][axis] = whole[1][axis].min(rest[1][axis]);
            rest[0][axis] = below[1][axis];
            rest[1][axis] = above[0][axis];
            for side in [below, above] {
                if side[0][axis] < side[1][axis] {
                    self.widen_by_some(range, side);
                }
            }
        }
    }

    /// Widens `range` by `cells`, wherever they lie in their blocks.
    fn widen_by_some(&self, range: &mut [f32; 2], cells: Cells) {
        let [low, high] = cells;
        // What the blocks hold may be known to be in the range without a look.
        let blocks = [low.map(|cell| cell / BLOCK), high.map(|cell| cell.div_ceil(BLOCK))];
        if !holds(*range, self.range_of_blocks(blocks)) {
            *range = union(*range, exact_range(self.values, cells));
        }
    }

    /// The range of the blocks from the first up to, but not with, the second.
    fn range_of_blocks(&self, [first, end]: [[usize; 3]; 2]) -> [f32; 2] {
        let mut range = NOTHING;
        for k in first[2]..end[2] {
            for j in first[1]..end[1] {
                let row = (k * self.count[1] + j) * self.count[0];
                range = self.ranges[row + first[0]..row + end[0]].iter().copied().fold(range, union);
            }
        }
        range
    }

    /// The first and one past the last block per axis that lies among the `cells` in whole.
    fn whole(&self, [low, high]: Cells) -> [[usize; 3]; 2] {
        let size = self.values.size();
        let end = |axis: usize| if high[axis] == size[axis] { self.count[axis] } else { high[axis] / BLOCK };
        [low.map(|cell| cell.div_ceil(BLOCK)), std::array::from_fn(end)]
    }
}

/// Whether all of `b` lies in `a`.
#[inline]
fn holds(a: [f32; 2], b: [f32; 2]) -> bool {
    a[0] <= b[0] && b[1] <= a[1]
}

#[inline]
fn union(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [if b[0] < a[0] { b[0] } else { a[0] }, if b[1] > a[1] { b[1] } else { a[1] }]
}

/// The cells of a block of a brick of `size` cells: the first, and one past the last, per axis.
fn corners(block: [usize; 3], size: [usize; 3]) -> Cells {
    let low = block.map(|place| place * BLOCK);
    [low, std::array::from_fn(|axis| size[axis].min(low[axis] + BLOCK))]
}

/// The lowest and highest finite value between the cells `low` and `high`, in single precision, rounded outward.
fn exact_range<T: Voxel>(values: &BrickValues<T>, [low, high]: Cells) -> [f32; 2] {
    let mut range = NOTHING.map(f64::from);
    let runs_end = high[0] - (high[0] - low[0]) % BLOCK;
    for first in (low[0]..runs_end).step_by(BLOCK) {
        range = joined(range, lanes::<T, BLOCK>(values, [first, low[1], low[2]], high));
    }
    for first in runs_end..high[0] {
        range = joined(range, lanes::<T, 1>(values, [first, low[1], low[2]], high));
    }
    finite(range, values, [low, high])
}

/// The lowest and highest number, infinite ones included, in each of `N` planes of cells across x: from the cell `low`
/// on, on the other axes up to `high`.
#[inline]
fn lanes<T: Voxel, const N: usize>(values: &BrickValues<T>, low: [usize; 3], high: [usize; 3]) -> [[T; N]; 2] {
    let mut least = [T::from_f64(f64::INFINITY); N];
    let mut most = [T::from_f64(f64::NEG_INFINITY); N];
    for k in low[2]..high[2] {
        for j in low[1]..high[1] {
            let run: [T; N] = values.run([low[0], j, k]);
            for lane in 0..N {
                // Nothing is less or more than what is not a number.
                least[lane] = if run[lane] < least[lane] { run[lane] } else { least[lane] };
                most[lane] = if run[lane] > most[lane] { run[lane] } else { most[lane] };
            }
        }
    }
    [least, most]
}

/// `range`, widened by what `lanes` found.
#[inline]
fn joined<T: Voxel, const N: usize>(mut range: [f64; 2], [least, most]: [[T; N]; 2]) -> [f64; 2] {
    for lane in 0..N {
        range = [range[0].min(least[lane].to_f64()), range[1].max(most[lane].to_f64())];
    }
    range
}

/// The `range` of all numbers between the cells `low` and `high`, in single precision, without the infinite ones.
#[inline]
fn finite<T: Voxel>(range: [f64; 2], values: &BrickValues<T>, [low, high]: Cells) -> [f32; 2] {
    if range[0] > f64::NEG_INFINITY && range[1] < f64::INFINITY {
        return outward(range);
    }
    // Rare, so that it may be slow.
    let mut range = NOTHING.map(f64::from);
    values.for_each(low, high, |value| {
        let value = value.to_f64();
        if value.is_finite() {
            range = [range[0].min(value), range[1].max(value)];
        }
    });
    outward(range)
}

/// The range in f32, rounded outward.
fn outward([low, high]: [f64; 2]) -> [f32; 2] {
    let (mut near_low, mut near_high) = (low as f32, high as f32);
    if f64::from(near_low) > low {
        near_low = near_low.next_down();
    }
    if f64::from(near_high) < high {
        near_high = near_high.next_up();
    }
    [near_low, near_high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_their_parts_hold_the_finite_values() {
        let size = [11, 6, 9];
        let value = |place: usize| match place % 97 {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            _ => ((place * 7919) % 1009) as f64 - 500.3,
        };
        let brick = BrickValues::owned((0..11 * 6 * 9).map(value).collect(), size).unwrap();
        let blocks = Blocks::new(&brick);
        let boxes: [Cells; 6] = [
            [[0; 3], size],
            [[0, 0, 4], [11, 6, 5]],
            [[1, 1, 1], [10, 6, 9]],
            [[3, 2, 3], [4, 3, 4]],
            [[10, 0, 0], [11, 6, 9]],
            [[4, 0, 4], [8, 4, 8]],
        ];
        for cells in boxes {
            let mut expected = NOTHING.map(f64::from);
            brick.for_each(cells[0], cells[1], |value| {
                if value.is_finite() {
                    expected = [expected[0].min(value), expected[1].max(value)];
                }
            });
            let mut found = NOTHING;
            blocks.widen_by_whole(&mut found, cells);
            blocks.widen_by_cut(&mut found, cells);
            assert_eq!(found, outward(expected), "{cells:?}");
        }
    }
}
