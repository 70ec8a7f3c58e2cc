//! Slopes at cell centres: differences over the neighbours on both sides of a cell.
//!
//! A neighbour is the cell of the same level, in whichever brick. Where there is none, it is what the finest coarser cell
//! there says: that cell's value and, for the way between the centres, its own differences over coarser neighbours. Where
//! there is no cell at all, at the domain's faces and at holes, the difference is one-sided. So the slope of a linear
//! field is exact wherever covered cells hold means of finer ones and no level is only one cell thick.

use amray::hierarchy::{Brick, BrickValues, Field, FieldValues, IndexBox, Voxel};
use amray::index::{Found, Index};
use rayon::prelude::*;

use crate::source::read_row;

/// A field of which slopes along an axis are taken, with what lies beyond the faces of its bricks.
pub(crate) struct Sloped<'a> {
    field: &'a Field,
    axis: usize,
    halos: Vec<Halo>,
}

/// The values just beyond a brick's low and high face; where there is nothing, what continues the brick's values in a
/// straight line. Of the two axes along the faces, the first one runs fastest.
struct Halo {
    size: [usize; 3],
    /// Along the axis, in world units.
    cell_size: f64,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl<'a> Sloped<'a> {
    pub(crate) fn new(field: &'a Field, axis: usize, index: &Index) -> Self {
        let halos = match field.values() {
            FieldValues::F32(bricks) => halos(&Cells { bricks, index }, axis),
            FieldValues::F64(bricks) => halos(&Cells { bricks, index }, axis),
        };
        Self { field, axis, halos }
    }

    /// Puts the slopes in the row `[j, k]` of the brick `place` into `above`, at first the values above each cell;
    /// `below` is for those below.
    pub(crate) fn slopes(&self, place: usize, [j, k]: [usize; 2], below: &mut [f64], above: &mut [f64]) {
        let Halo { size, cell_size, low, high } = &self.halos[place];
        let length = size[0];
        let read = |jk: [usize; 2], row: &mut [f64]| read_row(self.field, place, jk, row);
        if self.axis == 0 {
            let (row, last) = (j + k * size[1], length - 1);
            read([j, k], below);
            above[..last].copy_from_slice(&below[1..]);
            above[last] = high[row];
            below.copy_within(..last, 1);
            below[0] = low[row];
        } else {
            let (at, row) = if self.axis == 1 { (j, k) } else { (k, j) };
            let moved = |at: usize| if self.axis == 1 { [at, k] } else { [j, at] };
            let face = row * length..(row + 1) * length;
            match at.checked_sub(1) {
                Some(at) => read(moved(at), below),
                None => below.copy_from_slice(&low[face.clone()]),
            }
            match at + 1 < size[self.axis] {
                true => read(moved(at + 1), above),
                false => above.copy_from_slice(&high[face]),
            }
        }
        for (above, below) in above.iter_mut().zip(below) {
            *above = (*above - *below) * (0.5 / cell_size);
        }
    }
}

/// What lies beyond each brick.
fn halos<T: Voxel>(cells: &Cells<T>, axis: usize) -> Vec<Halo> {
    let bricks: Vec<Brick> = cells.index.hierarchy().bricks().collect();
    bricks.par_iter().enumerate().map(|(place, brick)| cells.halo(place, *brick, axis)).collect()
}

/// A field's cells, to be found by their indices.
struct Cells<'a, T> {
    bricks: &'a [BrickValues<T>],
    index: &'a Index,
}

impl<T: Voxel> Cells<'_, T> {
    fn halo(&self, place: usize, brick: Brick, axis: usize) -> Halo {
        let [mut below, mut above, mut face] = [brick.cells; 3];
        (below.low[axis], below.high[axis]) = (brick.cells.low[axis] - 1, brick.cells.low[axis]);
        (above.low[axis], above.high[axis]) = (brick.cells.high[axis], brick.cells.high[axis] + 1);
        face.high[axis] = face.low[axis] + 1;
        let [below, above] = [below, above].map(|layer| self.layer(brick.level, layer));
        let (first, last) = (brick.cells.low[axis], brick.cells.high[axis] - 1);
        let beyond = face.iter().zip(below.into_iter().zip(above)).map(|(mut cell, (below, above))| {
            let mut value = |at: i64| {
                cell[axis] = at;
                self.value(place, brick.cells, cell)
            };
            let mut straight = |edge: i64, inner: i64, opposite: Option<f64>| {
                let inner = if first < last { Some(value(inner)) } else { opposite };
                let edge = value(edge);
                inner.map_or(edge, |inner| 2.0 * edge - inner)
            };
            (
                below.unwrap_or_else(|| straight(first, first + 1, above)),
                above.unwrap_or_else(|| straight(last, last - 1, below)),
            )
        });
        let (low, high) = beyond.unzip();
        let cell_size = self.index.hierarchy().levels()[brick.level].cell_size()[axis];
        Halo { size: brick.cells.size().map(|cells| cells as usize), cell_size, low, high }
    }

    /// The values of a layer of cells, x fastest, in or out of bricks; none where there is no cell of any level.
    fn layer(&self, level: usize, layer: IndexBox) -> Vec<Option<f64>> {
        // Neighbouring cells mostly lie in the same brick.
        let mut recent: Option<(usize, IndexBox)> = None;
        let value = |cell: [i64; 3]| {
            if let Some((place, cells)) = recent.filter(|(_, cells)| cells.contains(cell)) {
                return Some(self.value(place, cells, cell));
            }
            let found = self.index.find_cell(level, cell)?;
            if found.level < level {
                return Some(self.prolonged(level, cell, found));
            }
            recent = Some((found.brick, self.index.hierarchy().levels()[level].brick_at(found.brick)));
            Some(self.bricks[found.brick].get(found.cell).to_f64())
        };
        layer.iter().map(value).collect()
    }

    /// What a coarser cell, its value and its slopes, has at the centre of a cell that it contains.
    fn prolonged(&self, level: usize, cell: [i64; 3], coarse: Found) -> f64 {
        let levels = self.index.hierarchy().levels();
        let (fine_size, coarse_size) = (levels[level].finest_cells(), levels[coarse.level].finest_cells());
        let low = levels[coarse.level].brick_at(coarse.brick).low;
        let parent: [i64; 3] = std::array::from_fn(|axis| low[axis] + coarse.cell[axis] as i64);
        let value = self.bricks[coarse.brick].get(coarse.cell).to_f64();
        (0..3).fold(value, |sum, axis| {
            // Between the centres, in halves of the finest level's cells.
            let [fine, coarse_cell] = [fine_size[axis], coarse_size[axis]];
            let way = (2 * cell[axis] + 1) * fine - (2 * parent[axis] + 1) * coarse_cell;
            // Where the centres are level, what lies beside them does not matter, not even if it is no number.
            if way == 0 {
                return sum;
            }
            let [below, above] = [-1, 1].map(|step| {
                let mut neighbour = parent;
                neighbour[axis] += step;
                self.actual(coarse.level, coarse.brick, neighbour)
            });
            let slope = match (below, above) {
                (Some(below), Some(above)) => (above - below) / 2.0,
                (None, Some(above)) => above - value,
                (Some(below), None) => value - below,
                (None, None) => 0.0,
            };
            sum + slope * way as f64 / (2 * coarse_cell) as f64
        })
    }

    /// The value of a cell of `level`, if there is such a cell; it may well lie in the brick `near`.
    fn actual(&self, level: usize, near: usize, cell: [i64; 3]) -> Option<f64> {
        let cells = self.index.hierarchy().levels()[level].brick_at(near);
        if cells.contains(cell) {
            return Some(self.value(near, cells, cell));
        }
        let found = self.index.find_cell(level, cell).filter(|found| found.level == level)?;
        Some(self.bricks[found.brick].get(found.cell).to_f64())
    }

    /// The value of a cell of the brick `place`, which has these `cells`.
    fn value(&self, place: usize, cells: IndexBox, cell: [i64; 3]) -> f64 {
        self.bricks[place].get(std::array::from_fn(|axis| (cell[axis] - cells.low[axis]) as usize)).to_f64()
    }
}
