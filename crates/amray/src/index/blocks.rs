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

/// Lowest and highest finite value per block of a brick, and the brick's values where blocks are cut.
pub(super) struct Blocks<'a, T> {
    values: &'a BrickValues<T>,
    /// Blocks per axis.
    count: [usize; 3],
    /// x fastest.
    ranges: Vec<[f32; 2]>,
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
        Self { values, count, ranges }
    }

    /// Widens `range` by those of the whole blocks between the cells `low` and `high`.
    pub(super) fn widen_by_whole(&self, range: &mut [f32; 2], low: [usize; 3], high: [usize; 3]) {
        let [first, end] = self.whole(low, high);
        for k in first[2]..end[2] {
            for j in first[1]..end[1] {
                let row = (k * self.count[1] + j) * self.count[0];
                for &[low, high] in &self.ranges[row + first[0]..row + end[0].max(first[0])] {
                    *range = [range[0].min(low), range[1].max(high)];
                }
            }
        }
    }

    /// Widens `range` by the values between the cells `low` and `high` that lie in blocks which are cut there.
    pub(super) fn widen_by_cut(&self, range: &mut [f32; 2], low: [usize; 3], high: [usize; 3]) {
        let [first_whole, end_whole] = self.whole(low, high);
        let first = low.map(|cell| cell / BLOCK);
        let end = high.map(|cell| cell.div_ceil(BLOCK));
        let inside = |axis: usize, block: usize| first_whole[axis] <= block && block < end_whole[axis];
        for k in first[2]..end[2] {
            for j in first[1]..end[1] {
                let mut i = first[0];
                while i < end[0] {
                    if inside(0, i) && inside(1, j) && inside(2, k) {
                        i = end_whole[0];
                        continue;
                    }
                    let block = [i, j, k];
                    i += 1;
                    let [least, most] = self.ranges[(k * self.count[1] + j) * self.count[0] + block[0]];
                    // What the block holds may be known to be there without a look.
                    if range[0] <= least && most <= range[1] {
                        continue;
                    }
                    let [from, to] = corners(block, self.values.size());
                    let cut = [
                        std::array::from_fn(|axis| from[axis].max(low[axis])),
                        std::array::from_fn(|axis| to[axis].min(high[axis])),
                    ];
                    let [least, most] = exact_range(self.values, cut);
                    *range = [range[0].min(least), range[1].max(most)];
                }
            }
        }
    }

    /// The first and one past the last block per axis that lies between the cells `low` and `high` in whole.
    fn whole(&self, low: [usize; 3], high: [usize; 3]) -> [[usize; 3]; 2] {
        let size = self.values.size();
        let end = |axis: usize| if high[axis] == size[axis] { self.count[axis] } else { high[axis] / BLOCK };
        [low.map(|cell| cell.div_ceil(BLOCK)), std::array::from_fn(end)]
    }
}

/// The cells of a block of a brick of `size` cells: the first, and one past the last, per axis.
fn corners(block: [usize; 3], size: [usize; 3]) -> [[usize; 3]; 2] {
    let low = block.map(|place| place * BLOCK);
    [low, std::array::from_fn(|axis| size[axis].min(low[axis] + BLOCK))]
}

/// The lowest and highest finite value between the cells `low` and `high`, in single precision, rounded outward.
fn exact_range<T: Voxel>(values: &BrickValues<T>, [low, high]: [[usize; 3]; 2]) -> [f32; 2] {
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
fn finite<T: Voxel>(range: [f64; 2], values: &BrickValues<T>, [low, high]: [[usize; 3]; 2]) -> [f32; 2] {
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
