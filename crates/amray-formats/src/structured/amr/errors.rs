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
            let first = place[axis] * brick;
            first..(first + brick).min(finest.cells[axis])
        });
        for (slice, samples) in slab.values.chunks_exact(finest.slice()).enumerate() {
            for y in rows.clone() {
                for x in columns.clone() {
                    let sample = samples[y * finest.cells[0] + x].to_f64();
                    if !sample.is_finite() {
                        continue;
                    }
                    errors.numbers += 1;
                    if let Some((level, window)) = leaf {
                        let cell =
                            [x / level.samples[0], y / level.samples[1], (slab.first + slice) / level.samples[2]];
                        let row = cell[1] + level.cells[1] * (cell[2] - window.first);
                        let error = (sample - window.values[cell[0] + level.cells[0] * row].to_f64()).abs();
                        errors.max = errors.max.max(error);
                        errors.sum += error;
                    }
                }
            }
        }
        errors
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
