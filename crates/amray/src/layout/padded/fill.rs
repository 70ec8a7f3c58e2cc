//! Filling padded bricks: their own cells, their neighbours' and what stands for cells that do not exist.

use rayon::prelude::*;

use super::{FLAG, HOLE, NOT_FINITE, Padding, is_hole};
use crate::hierarchy::{Brick, Centering, IndexBox, Normalisation, Voxel};
use crate::reconstruction::Sampler;

/// Fills all bricks, each between two of `starts`; returns whether all values are finite.
pub(super) fn fill<T: Voxel>(
    sampler: &Sampler<T>,
    normalisation: Normalisation,
    padding: Padding,
    starts: &[usize],
    values: &mut [f32],
) -> bool {
    let mut rest = values;
    let mut bricks = Vec::with_capacity(starts.len());
    for (place, brick) in sampler.index().hierarchy().bricks().enumerate() {
        let (own, others) = rest.split_at_mut(starts[place + 1] - starts[place]);
        rest = others;
        bricks.push((place, brick, own));
    }
    let filler = Filler { sampler, normalisation, padding };
    let finite = bricks.into_par_iter().map(|(place, brick, values)| {
        filler.brick(place, &brick, values);
        // All of them, even behind one that is not: eight are as fast as one.
        values.iter().fold(true, |finite, value| finite & (value.is_finite() | is_hole(*value)))
    });
    finite.reduce(|| true, |a, b| a && b)
}

struct Filler<'a, T> {
    sampler: &'a Sampler<'a, T>,
    normalisation: Normalisation,
    padding: Padding,
}

/// A brick's values with their padding.
struct Padded<'a> {
    /// The padded box, in cells of the brick's level.
    cells: IndexBox,
    values: &'a mut [f32],
}

impl Padded<'_> {
    /// The values of a row of cells that starts at `cell`.
    fn row(&mut self, cell: [i64; 3], length: usize) -> &mut [f32] {
        let size = self.cells.size();
        let [x, y, z]: [i64; 3] = std::array::from_fn(|axis| cell[axis] - self.cells.low[axis]);
        let start = (x + size[0] * (y + size[1] * z)) as usize;
        &mut self.values[start..start + length]
    }

    /// Calls `visit` with each row of `cells`.
    fn for_each_row(&mut self, cells: &IndexBox, mut visit: impl FnMut([i64; 3], &mut [f32])) {
        let [length, ..] = cells.size();
        for z in cells.low[2]..cells.high[2] {
            for y in cells.low[1]..cells.high[1] {
                let first = [cells.low[0], y, z];
                visit(first, self.row(first, length as usize));
            }
        }
    }
}

impl<T: Voxel> Filler<'_, T> {
    fn brick(&self, place: usize, brick: &Brick, values: &mut [f32]) {
        if self.padding == Padding::Nodes {
            return self.nodes(place, brick, values);
        }
        let mut padded = Padded { cells: brick.cells.grown([1; 3]), values };
        self.copy(place, brick.level, &brick.cells, &mut padded, FLAG);
        let index = self.sampler.index();
        let description = &index.hierarchy().levels()[brick.level];
        let size = description.finest_cells();
        let inside = padded.cells.intersection(&description.domain());
        index.for_each_region_in(&inside.refined(size), &mut |region, shared| {
            let region = &index.regions()[region];
            let cells = cells_centered_in(&shared, size).intersection(&inside);
            let covered = region.finest_level() > Some(brick.level);
            match index.finest_brick(region, brick.level) {
                Some((_, found)) if found == place && self.padding == Padding::Leaves && covered => {
                    self.unflag_covered(brick.level, &cells, &mut padded);
                }
                Some((_, found)) if found == place => {}
                Some((level, found)) if level == brick.level => {
                    self.copy(found, level, &cells, &mut padded, FLAG);
                    if self.padding == Padding::Leaves && covered {
                        self.unflag_covered(brick.level, &cells, &mut padded);
                    }
                }
                // Coarser cells around it may give a value to a cell inside a hole, too.
                _ if self.padding == Padding::Prolonged => self.prolong(brick.level, &cells, &mut padded),
                Some((level, found)) => self.copy_coarser(found, level, brick.level, &cells, &mut padded),
                None => padded.for_each_row(&cells, |_, row| row.fill(f32::from_bits(HOLE))),
            }
        });
        self.extend_over_boundary(&inside, &mut padded);
    }

    /// A brick of nodes: beside its own, the function that the field is, or beside holes, where nodes of no weight must
    /// be numbers too, the nearest of its own.
    fn nodes(&self, place: usize, brick: &Brick, values: &mut [f32]) {
        let own = Centering::Nodes.values_of(&brick.cells);
        let mut padded = Padded { cells: own.grown([1; 3]), values };
        let index = self.sampler.index();
        let size = index.hierarchy().levels()[brick.level].finest_cells();
        let all = padded.cells;
        padded.for_each_row(&all, |[x, y, z], row| {
            let inner = own.contains([own.low[0], y, z]);
            for (target, x) in row.iter_mut().zip(x..) {
                if !(inner && (own.low[0]..own.high[0]).contains(&x)) {
                    let node = [x, y, z];
                    let value = self.sampler.sample(std::array::from_fn(|axis| (node[axis] * size[axis]) as f64));
                    let nearest = || self.sampler.bricks()[place].get(from_corner(own.clamp(node), own.low)).to_f64();
                    *target = self.flagged(if value.is_nan() { nearest() } else { value }, FLAG);
                }
            }
        });
        self.copy(place, brick.level, &own, &mut padded, FLAG);
    }

    /// Copies `cells` from the brick at `place`, which is of the same `level`.
    fn copy(&self, place: usize, level: usize, cells: &IndexBox, padded: &mut Padded, flag: u32) {
        let low = self.sampler.index().hierarchy().levels()[level].brick_at(place).low;
        let source = &self.sampler.bricks()[place];
        padded.for_each_row(cells, |[x, y, z], row| {
            let cells = IndexBox::new([x, y, z], [x + row.len() as i64, y + 1, z + 1]);
            let mut targets = row.iter_mut();
            source.for_each_in(low, &cells, |value| {
                *targets.next().expect("a row has its cells' values") = self.flagged(value.to_f64(), flag);
            });
        });
    }

    /// Copies the cells of the brick at `place`, of the coarser level `from`, that contain `cells` of the level `to`.
    fn copy_coarser(&self, place: usize, from: usize, to: usize, cells: &IndexBox, padded: &mut Padded) {
        let levels = self.sampler.index().hierarchy().levels();
        let low = levels[from].brick_at(place).low;
        let ratio: [i64; 3] =
            std::array::from_fn(|axis| levels[from].finest_cells()[axis] / levels[to].finest_cells()[axis]);
        let source = &self.sampler.bricks()[place];
        let value = |cell: [i64; 3]| {
            let cell = std::array::from_fn(|axis| (cell[axis].div_euclid(ratio[axis]) - low[axis]) as usize);
            self.flagged(source.get(cell).to_f64(), 0)
        };
        padded.for_each_row(cells, |[x, y, z], row| {
            let mut last = (i64::MIN, 0.0);
            for (target, x) in row.iter_mut().zip(x..) {
                let coarse = x.div_euclid(ratio[0]);
                if last.0 != coarse {
                    last = (coarse, value([x, y, z]));
                }
                *target = last.1;
            }
        });
    }

    /// Gives virtual `cells` the value of the coarser levels' function at their centres.
    fn prolong(&self, level: usize, cells: &IndexBox, padded: &mut Padded) {
        let size = self.sampler.index().hierarchy().levels()[level].finest_cells();
        padded.for_each_row(cells, |[x, y, z], row| {
            for (target, x) in row.iter_mut().zip(x..) {
                let cell = [x, y, z];
                let center = std::array::from_fn(|axis| (cell[axis] as f64 + 0.5) * size[axis] as f64);
                let value = level.checked_sub(1).and_then(|coarser| self.sampler.prolonged(coarser, center));
                *target = value.map_or(f32::from_bits(HOLE), |value| self.flagged(value, 0));
            }
        });
    }

    /// Takes the flag from those of `cells` that finer levels cover.
    fn unflag_covered(&self, level: usize, cells: &IndexBox, padded: &mut Padded) {
        let index = self.sampler.index();
        padded.for_each_row(cells, |[x, y, z], row| {
            for (value, x) in row.iter_mut().zip(x..) {
                if !index.may_cover_partly() || index.find_cell(level, [x, y, z]).is_some_and(|found| found.covered) {
                    *value = f32::from_bits(value.to_bits() & !FLAG);
                }
            }
        });
    }

    /// Cells outside the domain take the value of the nearest one `inside`.
    fn extend_over_boundary(&self, inside: &IndexBox, padded: &mut Padded) {
        let mut filled = *inside;
        for axis in 0..3 {
            for (outside, edge) in
                [(padded.cells.low[axis], inside.low[axis]), (padded.cells.high[axis] - 1, inside.high[axis] - 1)]
            {
                if outside == edge {
                    continue;
                }
                let mut layer = filled;
                layer.low[axis] = edge;
                layer.high[axis] = edge + 1;
                for cell in layer.iter() {
                    let value = padded.row(cell, 1)[0];
                    let mut beyond = cell;
                    beyond[axis] = outside;
                    padded.row(beyond, 1)[0] = match self.padding {
                        Padding::Leaves => f32::from_bits(value.to_bits() & !FLAG),
                        Padding::Closest | Padding::Prolonged | Padding::Nodes => value,
                    };
                }
            }
            filled.low[axis] = padded.cells.low[axis];
            filled.high[axis] = padded.cells.high[axis];
        }
    }

    #[inline]
    fn flagged(&self, value: f64, flag: u32) -> f32 {
        let unit = self.normalisation.apply(value);
        let bits = if unit.is_finite() { unit.to_bits() & !FLAG } else { NOT_FINITE };
        f32::from_bits(bits | flag)
    }
}

/// A cell or node of a brick, counted from the brick's low corner.
fn from_corner(place: [i64; 3], low: [i64; 3]) -> [usize; 3] {
    std::array::from_fn(|axis| (place[axis] - low[axis]) as usize)
}

/// The cells whose centres lie in a box of finest cells; `size` is a cell's size in them.
fn cells_centered_in(finest: &IndexBox, size: [i64; 3]) -> IndexBox {
    let first = |corner: i64, axis: usize| -(size[axis] / 2 - corner).div_euclid(size[axis]);
    IndexBox::new(
        std::array::from_fn(|axis| first(finest.low[axis], axis)),
        std::array::from_fn(|axis| first(finest.high[axis], axis)),
    )
}
