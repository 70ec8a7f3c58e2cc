//! How far the result is from the original, at the original's samples.

use amray::hierarchy::Voxel;
use rayon::prelude::*;
use std::io;

use super::level_file::LevelFile;
use super::output::Slab;
use super::shape::LevelShape;

/// Differences between samples and the leaf cells around them; samples that are no numbers do not count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Errors {
    pub(super) max: f64,
    sum: f64,
    numbers: u64,
}

/// The cells of a coarser level around some slices of samples.
pub(super) struct Window<T> {
    first: usize,
    values: Vec<T>,
}

/// A row of coarser cells, each of two to the `shift` samples.
struct Row<'a, T> {
    values: &'a [T],
    shift: u32,
}

impl<T: Voxel> Window<T> {
    /// Those of `level` around `slab`, which is of the finest level.
    pub(super) fn read(
        level: &LevelShape,
        file: &mut LevelFile,
        slab: &Slab<T>,
        finest: &LevelShape,
    ) -> io::Result<Self> {
        let first = slab.first / level.samples[2];
        let end = slab.first + slab.values.len() / finest.slice();
        let mut values = Vec::new();
        file.read(first..end.div_ceil(level.samples[2]), &mut values)?;
        Ok(Self { first, values })
    }

    /// The cells of `level`, whose window this is, around the row of samples at y and z.
    fn row(&self, level: &LevelShape, y: usize, z: usize) -> Row<'_, T> {
        let first = level.cells[0] * (y / level.samples[1] + level.cells[1] * (z / level.samples[2] - self.first));
        Row { values: &self.values[first..][..level.cells[0]], shift: level.samples[0].ilog2() }
    }
}

impl Errors {
    /// The mean difference; 0 where no sample is a number.
    pub(super) fn mean(&self) -> f64 {
        if self.numbers == 0 { 0.0 } else { self.sum / self.numbers as f64 }
    }

    /// Adds the samples of `slab`, which lies in one row of finest bricks. The sum does not depend on the threads.
    pub(super) fn add_row<T: Voxel>(
        &mut self,
        levels: &[LevelShape],
        kept: &[Vec<bool>],
        slab: &Slab<T>,
        row: usize,
        brick: usize,
        windows: &[Window<T>],
    ) {
        let finest = &levels[levels.len() - 1];
        let places = 0..finest.grid[0] * finest.grid[1];
        let of_brick = |number: usize| {
            let place = [number % finest.grid[0], number / finest.grid[0], row];
            let leaf = leaf_level(levels, kept, place);
            Self::of_brick(finest, slab, place, brick, windows.get(leaf).map(|window| (&levels[leaf], window)))
        };
        let bricks: Vec<Self> = places.into_par_iter().map(of_brick).collect();
        for brick in bricks {
            self.max = self.max.max(brick.max);
            self.sum += brick.sum;
            self.numbers += brick.numbers;
        }
    }

    /// The samples of one brick of the finest level; `leaf` is what stands for them where it is not kept.
    fn of_brick<T: Voxel>(
        finest: &LevelShape,
        slab: &Slab<T>,
        place: [usize; 3],
        brick: usize,
        leaf: Option<(&LevelShape, &Window<T>)>,
    ) -> Self {
        let mut errors = Self::default();
        let [columns, rows] = [0, 1].map(|axis| {
            let [first, end] = [0, brick].map(|cells| (place[axis] * brick + cells).min(finest.cells[axis]));
            first..end
        });
        for (slice, samples) in slab.values.chunks_exact(finest.slice()).enumerate() {
            for y in rows.clone() {
                let samples = &samples[y * finest.cells[0]..][columns.clone()];
                if let Some((level, window)) = leaf {
                    errors.add(samples, columns.start, window.row(level, y, slab.first + slice));
                } else {
                    errors.numbers += samples.iter().filter(|sample| sample.to_f64().is_finite()).count() as u64;
                }
            }
        }
        errors
    }

    /// Adds a row of samples that begins at x.
    fn add<T: Voxel>(&mut self, samples: &[T], x: usize, cells: Row<'_, T>) {
        for (place, sample) in samples.iter().map(|sample| sample.to_f64()).enumerate() {
            if sample.is_finite() {
                let error = (sample - cells.values[(x + place) >> cells.shift].to_f64()).abs();
                self.max = self.max.max(error);
                self.sum += error;
                self.numbers += 1;
            }
        }
    }
}

/// The finest level that is kept where a brick of the finest of all would be.
fn leaf_level(levels: &[LevelShape], kept: &[Vec<bool>], place: [usize; 3]) -> usize {
    let mut place = place;
    let mut level = levels.len() - 1;
    while level > 0 && !kept[level][levels[level].number(place)] {
        place = levels[level].parent(place);
        level -= 1;
    }
    level
}
