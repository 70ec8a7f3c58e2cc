//! Slopes at cell centres: differences over the neighbours on both sides of a cell.
//!
//! A neighbour is the cell of the same level, in whichever brick. Where there is none, it is what the finest coarser cell
//! there says: that cell's value and, for the way between the centres, its own differences over coarser neighbours. Where
//! there is no cell at all, at the domain's faces and at holes, the difference is one-sided. So the slope of a linear
//! field is exact wherever covered cells hold means of finer ones and no level is only one cell thick.

use amray::hierarchy::{Brick, Field, IndexBox};
use amray::index::{Found, Index};
use rayon::prelude::*;

use crate::source::read_row;

/// A field of which slopes are taken, with what lies around its bricks.
pub(crate) struct Sloped<'a> {
    field: &'a Field,
    halos: Vec<Halo>,
}

/// The values just beyond a brick's faces.
struct Halo {
    size: [usize; 3],
    /// Per axis those beyond the low and the high face; of the other two axes, the first one runs fastest. Where there is
    /// nothing beyond, what continues the brick's values in a straight line.
    faces: [[Vec<f64>; 2]; 3],
}

impl<'a> Sloped<'a> {
    pub(crate) fn new(field: &'a Field, index: &Index) -> Self {
        let bricks: Vec<Brick> = index.hierarchy().bricks().collect();
        let cells = Cells { field, index };
        let halos = bricks.par_iter().enumerate().map(|(place, brick)| cells.halo(place, *brick)).collect();
        Self { field, halos }
    }

    /// For the row `[j, k]` of the brick `place`, the neighbours above each cell along `axis` less those below. `below` is
    /// for use meanwhile, as long as `differences`.
    pub(crate) fn differences(
        &self,
        place: usize,
        [j, k]: [usize; 2],
        axis: usize,
        below: &mut [f64],
        differences: &mut [f64],
    ) {
        let Halo { size: [length, width, height], faces } = &self.halos[place];
        let [low, high] = &faces[axis];
        match axis {
            0 => {
                let (face, last) = (j + k * width, length - 1);
                read_row(self.field, place, [j, k], below);
                differences[..last].copy_from_slice(&below[1..]);
                differences[last] = high[face];
                below.copy_within(..last, 1);
                below[0] = low[face];
            }
            1 => {
                let face = &|layer: &[f64], row: &mut [f64]| row.copy_from_slice(&layer[k * length..][..*length]);
                match j.checked_sub(1) {
                    Some(j) => read_row(self.field, place, [j, k], below),
                    None => face(low, below),
                }
                match j + 1 < *width {
                    true => read_row(self.field, place, [j + 1, k], differences),
                    false => face(high, differences),
                }
            }
            _ => {
                let face = &|layer: &[f64], row: &mut [f64]| row.copy_from_slice(&layer[j * length..][..*length]);
                match k.checked_sub(1) {
                    Some(k) => read_row(self.field, place, [j, k], below),
                    None => face(low, below),
                }
                match k + 1 < *height {
                    true => read_row(self.field, place, [j, k + 1], differences),
                    false => face(high, differences),
                }
            }
        }
        for (above, below) in differences.iter_mut().zip(below) {
            *above -= *below;
        }
    }
}

/// A field's cells, to be found by their indices.
struct Cells<'a> {
    field: &'a Field,
    index: &'a Index,
}

impl Cells<'_> {
    fn halo(&self, place: usize, brick: Brick) -> Halo {
        let size = brick.cells.size();
        let faces = [0, 1, 2].map(|axis| {
            let [mut below, mut above] = [brick.cells; 2];
            (below.low[axis], below.high[axis]) = (brick.cells.low[axis] - 1, brick.cells.low[axis]);
            (above.low[axis], above.high[axis]) = (brick.cells.high[axis], brick.cells.high[axis] + 1);
            let [below, above] = [below, above].map(|layer| self.layer(brick.level, layer));
            let mut face = IndexBox::new([0; 3], size);
            face.high[axis] = 1;
            let last = size[axis] - 1;
            let (low, high) = face
                .iter()
                .zip(below.into_iter().zip(above))
                .map(|(cell, (below, above))| {
                    let value = |at: i64| {
                        let mut cell = cell.map(|index| index as usize);
                        cell[axis] = at as usize;
                        self.field.value(place, cell)
                    };
                    let inner = if last > 0 { [Some(value(1)), Some(value(last - 1))] } else { [above, below] };
                    let straight = |edge: f64, inner: Option<f64>| inner.map_or(edge, |inner| 2.0 * edge - inner);
                    (
                        below.unwrap_or_else(|| straight(value(0), inner[0])),
                        above.unwrap_or_else(|| straight(value(last), inner[1])),
                    )
                })
                .unzip();
            [low, high]
        });
        Halo { size: size.map(|cells| cells as usize), faces }
    }

    /// The values of a layer of cells, x fastest, in or out of bricks; none where there is no cell of any level.
    fn layer(&self, level: usize, layer: IndexBox) -> Vec<Option<f64>> {
        let description = &self.index.hierarchy().levels()[level];
        // Neighbouring cells mostly lie in the same brick.
        let mut recent: Option<usize> = None;
        let value = |cell: [i64; 3]| {
            if let Some(place) = recent
                && description.brick_at(place).contains(cell)
            {
                return Some(self.value(level, place, cell));
            }
            let found = self.index.find_cell(level, cell)?;
            if found.level < level {
                return Some(self.prolonged(level, cell, found));
            }
            recent = Some(found.brick);
            Some(self.field.value(found.brick, found.cell))
        };
        layer.iter().map(value).collect()
    }

    /// What a coarser cell, its value and its slopes, has at the centre of a cell that it contains.
    fn prolonged(&self, level: usize, cell: [i64; 3], coarse: Found) -> f64 {
        let levels = self.index.hierarchy().levels();
        let (fine_size, coarse_size) = (levels[level].finest_cells(), levels[coarse.level].finest_cells());
        let low = levels[coarse.level].brick_at(coarse.brick).low;
        let parent: [i64; 3] = std::array::from_fn(|axis| low[axis] + coarse.cell[axis] as i64);
        let value = self.field.value(coarse.brick, coarse.cell);
        (0..3).fold(value, |sum, axis| {
            let ratio = fine_size[axis] as f64 / coarse_size[axis] as f64;
            let way = (cell[axis] as f64 + 0.5) * ratio - (parent[axis] as f64 + 0.5);
            // Where the centres are level, what lies beside them does not matter, not even if it is no number.
            if way == 0.0 {
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
            sum + way * slope
        })
    }

    /// The value of a cell of `level`, if there is such a cell; it may well lie in the brick `near`.
    fn actual(&self, level: usize, near: usize, cell: [i64; 3]) -> Option<f64> {
        if self.index.hierarchy().levels()[level].brick_at(near).contains(cell) {
            return Some(self.value(level, near, cell));
        }
        let found = self.index.find_cell(level, cell).filter(|found| found.level == level)?;
        Some(self.field.value(found.brick, found.cell))
    }

    /// The value of a cell of the brick `place`.
    fn value(&self, level: usize, place: usize, cell: [i64; 3]) -> f64 {
        let low = self.index.hierarchy().levels()[level].brick_at(place).low;
        self.field.value(place, std::array::from_fn(|axis| (cell[axis] - low[axis]) as usize))
    }
}
