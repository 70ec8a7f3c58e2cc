//! The second pass: kept bricks go to the output, row by row, and what was dropped is compared with the original.

use std::ops::Range;

use amray::hierarchy::{IndexBox, Voxel};
use rayon::prelude::*;

use super::Plan;
use super::errors::{Errors, Window};
use super::pyramid::Pyramid;
use super::shape::LevelShape;
use crate::structured::StructuredVolume;
use crate::{AmrWriter, FormatError};

/// Some slices of a level, x fastest: padding is not among them.
pub(super) struct Slab<T> {
    /// The first slice's number.
    pub(super) first: usize,
    pub(super) values: Vec<T>,
}

/// Writes all kept bricks of all levels. `progress` is told the share that is done, 0 to 1.
pub(super) fn write<T: Voxel>(
    volume: &StructuredVolume,
    plan: &Plan<'_>,
    mut pyramid: Pyramid,
    writer: &AmrWriter,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Errors, FormatError> {
    let failed = FormatError::io(plan.directory, "read a temporary file in");
    let Pyramid { files, kept, .. } = &mut pyramid;
    for (number, file) in files.iter_mut().enumerate() {
        let output = LevelOutput { plan, number, kept: &kept[number], writer };
        output.write(|slices, values: &mut Vec<T>| file.read(slices, values).map_err(&failed), |_, _| Ok(()))?;
    }
    let mut reader = volume.slices(plan.reader_memory)?;
    let mut errors = Errors::default();
    let finest = plan.levels.len() - 1;
    let output = LevelOutput { plan, number: finest, kept: &kept[finest], writer };
    let measure = |slab: &Slab<T>, row: usize| {
        let windows =
            files.iter_mut().zip(&plan.levels).map(|(file, level)| Window::read(level, file, slab, plan.finest()));
        let windows: Vec<Window<T>> = windows.collect::<Result<_, _>>().map_err(&failed)?;
        errors.add_row(&plan.levels, kept, slab, row, plan.refinement.brick, &windows);
        progress((slab.first * plan.finest().slice() + slab.values.len()) as f64 / volume.sample_count() as f64);
        Ok(())
    };
    output.write(|slices, values| reader.read(slices.len(), values), measure)?;
    Ok(errors)
}

/// One level on its way to the output.
struct LevelOutput<'a> {
    plan: &'a Plan<'a>,
    number: usize,
    kept: &'a [bool],
    writer: &'a AmrWriter,
}

impl LevelOutput<'_> {
    /// Goes through the level's slices once, from front to back. `read` gets those that hold a part of the volume;
    /// `look` is shown each slab of them and the number of the row of bricks that it lies in.
    fn write<T: Voxel>(
        &self,
        mut read: impl FnMut(Range<usize>, &mut Vec<T>) -> Result<(), FormatError>,
        mut look: impl FnMut(&Slab<T>, usize) -> Result<(), FormatError>,
    ) -> Result<(), FormatError> {
        let level = &self.plan.levels[self.number];
        let brick = self.plan.refinement.brick;
        let mut slab = Slab { first: 0, values: Vec::new() };
        let mut bricks = self.bricks().peekable();
        for row in 0..level.grid[2] {
            let end = ((row + 1) * brick).min(level.stored[2]);
            let of_row = std::iter::from_fn(|| bricks.next_if(|(_, cells)| cells.low[2] < end as i64));
            let of_row: Vec<(usize, IndexBox)> = of_row.collect();
            for first in (row * brick..end).step_by(self.plan.slab) {
                let slices = first..(first + self.plan.slab).min(end);
                let [first, last] = [slices.start, slices.end].map(|slice| slice.min(level.cells[2]));
                slab.first = first;
                read(first..last, &mut slab.values)?;
                of_row.par_iter().try_for_each(|(brick, cells)| {
                    let before = (slices.start as i64 - cells.low[2]) * cells.size()[0] * cells.size()[1];
                    let values = slab.values_in(level, cells, slices.clone());
                    self.writer.write(self.number, *brick, 0, before as usize, &values)
                })?;
                look(&slab, row)?;
            }
        }
        Ok(())
    }

    /// The kept bricks, each with its number.
    fn bricks(&self) -> impl Iterator<Item = (usize, IndexBox)> {
        bricks(&self.plan.levels[self.number], self.kept, self.plan.refinement.brick).enumerate()
    }
}

/// The kept bricks of a level, in the order of [`LevelShape::places`].
pub(super) fn bricks(level: &LevelShape, kept: &[bool], brick: usize) -> impl Iterator<Item = IndexBox> {
    level.places().zip(kept).filter(|(_, kept)| **kept).map(move |(place, _)| level.brick(place, brick))
}

impl<T: Voxel> Slab<T> {
    /// The values of a brick's cells in some slices, x fastest; padding is not a number.
    fn values_in(&self, level: &LevelShape, cells: &IndexBox, slices: Range<usize>) -> Vec<T> {
        let [width, height, depth] = level.cells;
        let [columns, rows] = [0, 1].map(|axis| cells.low[axis] as usize..cells.high[axis] as usize);
        let padding = T::from_f64(f64::NAN);
        let mut values = Vec::with_capacity(slices.len() * rows.len() * columns.len());
        for z in slices {
            for y in rows.clone() {
                let end = values.len() + columns.len();
                if z < depth && y < height && columns.start < width {
                    let row = (z - self.first) * level.slice() + y * width;
                    values.extend_from_slice(&self.values[row + columns.start..row + columns.end.min(width)]);
                }
                values.resize(end, padding);
            }
        }
        values
    }
}
