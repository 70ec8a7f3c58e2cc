//! Slices of a level, and coarsening two of them into one.

use amray::hierarchy::Voxel;
use rayon::prelude::*;

use super::shape::LevelShape;

/// One slice of cells across z, x fastest. A cell is no number exactly where no sample in it is one.
pub(super) struct Layer<T> {
    /// The cells' values.
    pub(super) means: Vec<T>,
    /// The lowest sample in each cell; minus infinity where some samples, but not all, are no numbers.
    lows: Vec<T>,
    /// The highest one; infinity there.
    highs: Vec<T>,
}

/// A slice that is looked at.
#[derive(Clone, Copy)]
pub(super) struct LayerView<'a, T> {
    means: &'a [T],
    lows: &'a [T],
    highs: &'a [T],
}

impl<'a, T: Voxel> LayerView<'a, T> {
    /// A slice of the volume itself.
    pub(super) fn of_samples(samples: &'a [T]) -> Self {
        Self { means: samples, lows: samples, highs: samples }
    }
}

/// Two levels between which slices are coarsened, and the side of a brick.
#[derive(Clone, Copy)]
pub(super) struct Between<'a> {
    pub(super) fine: &'a LevelShape,
    pub(super) coarse: &'a LevelShape,
    pub(super) brick: usize,
    /// Fine bricks are kept where a sample differs by more from the coarse cell around it.
    pub(super) threshold: f64,
}

impl<T: Voxel> Layer<T> {
    pub(super) fn view(&self) -> LayerView<'_, T> {
        LayerView { means: &self.means, lows: &self.lows, highs: &self.highs }
    }

    /// The slice that `slices`, one or two fine ones, amount to. Marks those of `kept`, the layer of fine bricks that
    /// they lie in, x fastest, in which a sample differs from the coarse cell around it by more than the threshold.
    pub(super) fn coarsened(between: Between<'_>, slices: &[LayerView<'_, T>], kept: &mut [bool]) -> Self {
        let Between { fine, coarse, brick, threshold } = between;
        let [width, height, _] = coarse.cells;
        let blank = || vec![T::from_f64(f64::NAN); width * height];
        let mut layer = Self { means: blank(), lows: blank(), highs: blank() };
        // Rows of coarse cells that belong to one row of fine bricks.
        let rows = brick / fine.ratio[1];
        let parts = (
            layer.means.par_chunks_mut(width * rows),
            layer.lows.par_chunks_mut(width * rows),
            layer.highs.par_chunks_mut(width * rows),
            kept.par_chunks_mut(fine.grid[0]),
        );
        parts.into_par_iter().enumerate().for_each(|(part, (means, lows, highs, kept))| {
            for row in 0..means.len() / width {
                for x in 0..width {
                    let group = Group::of(fine, slices, [x, part * rows + row]);
                    let Some((mean, [low, high])) = group.mean_and_range() else { continue };
                    let (place, mean) = (row * width + x, T::from_f64(mean));
                    (means[place], lows[place], highs[place]) = (mean, T::from_f64(low), T::from_f64(high));
                    let deviation = (high - mean.to_f64()).max(mean.to_f64() - low);
                    kept[x * fine.ratio[0] / brick] |= deviation > threshold;
                }
            }
        });
        layer
    }
}

/// The fine cells of a coarse one.
struct Group {
    cells: u32,
    /// Cells that are numbers, and all else is of these.
    numbers: u32,
    sum: f64,
    /// Their own lowest and highest value, and that of the samples in them.
    means: [f64; 2],
    samples: [f64; 2],
}

impl Group {
    /// The cells of `slices` in the coarse cell at x and y.
    #[inline]
    fn of<T: Voxel>(fine: &LevelShape, slices: &[LayerView<'_, T>], cell: [usize; 2]) -> Self {
        const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        let mut group = Self { cells: 0, numbers: 0, sum: 0.0, means: NOTHING, samples: NOTHING };
        let [columns, rows] = [0, 1].map(|axis| {
            let first = cell[axis] * fine.ratio[axis];
            first..(first + fine.ratio[axis]).min(fine.cells[axis])
        });
        for slice in slices {
            for row in rows.clone() {
                for place in columns.start + row * fine.cells[0]..columns.end + row * fine.cells[0] {
                    group.add([slice.means[place], slice.lows[place], slice.highs[place]].map(T::to_f64));
                }
            }
        }
        group
    }

    #[inline]
    fn add(&mut self, [mean, low, high]: [f64; 3]) {
        self.cells += 1;
        if mean.is_finite() {
            self.numbers += 1;
            self.sum += mean;
            self.means = [self.means[0].min(mean), self.means[1].max(mean)];
            self.samples = [self.samples[0].min(low), self.samples[1].max(high)];
        }
    }

    /// The mean of the cells that are numbers, and the range of samples in them, which is endless where others are in
    /// them too; `None` where no cell is a number.
    #[inline]
    fn mean_and_range(&self) -> Option<(f64, [f64; 2])> {
        if self.numbers == 0 {
            return None;
        }
        // Rounding, and sums beyond all numbers, must not take the mean of equal values elsewhere.
        let mean = (self.sum / f64::from(self.numbers)).clamp(self.means[0], self.means[1]);
        let mixed = self.numbers < self.cells;
        Some((mean, if mixed { [f64::NEG_INFINITY, f64::INFINITY] } else { self.samples }))
    }
}
