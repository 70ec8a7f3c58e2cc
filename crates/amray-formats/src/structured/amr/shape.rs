//! The levels over a volume: how many cells each has, where they are stored, and how they are cut into bricks.
//!
//! Each level halves the one finer than it, rounding up, but leaves an axis alone that is one cell long. Where a number of
//! cells does not divide by all ratios, the volume ends inside of coarser cells. Bricks must end on faces of the coarser
//! level's cells, so there they hold *padding* beyond the volume: cells that are not a number, and so show nothing. To
//! smooth reconstructions a cell's value reaches a whole cell far from its centre. So that padding hides no sample, the
//! volume's rim is kept on the finest level, and each level pads one cell more than the finer level reaches.

use amray::hierarchy::{Hierarchy, HierarchyError, IndexBox, LevelDescription};

/// One level over the volume. Numbers are per axis, in cells of the level unless it says otherwise.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LevelShape {
    /// Cells that hold a part of the volume.
    pub(super) cells: [usize; 3],
    /// Cells per cell of the next coarser level: 1 or 2; 1 on level 0.
    pub(super) ratio: [usize; 3],
    /// Cells that bricks may store: `cells`, and padding.
    pub(super) stored: [usize; 3],
    /// Bricks in a row, if all were kept.
    pub(super) grid: [usize; 3],
    /// Samples of the volume per cell.
    pub(super) samples: [usize; 3],
    /// The first brick of a row that is part of the rim, where there is one: it touches padding.
    rim: [Option<usize>; 3],
}

/// The levels over a volume of `size` samples, coarsest first; as many as `levels` says, or until level 0 is one brick.
pub(super) fn levels(size: [usize; 3], brick: usize, levels: Option<usize>) -> Vec<LevelShape> {
    let halvings = halvings(size, |cells, count| match levels {
        Some(levels) => count == levels,
        None => cells.iter().all(|&cells| cells <= brick),
    });
    let mut samples = [0, 1, 2].map(|axis| halvings.iter().map(|(_, ratio)| ratio[axis]).product::<usize>());
    let padded = [0, 1, 2].map(|axis| !size[axis].is_multiple_of(samples[axis]));
    let mut shapes: Vec<LevelShape> = Vec::with_capacity(halvings.len());
    for (cells, ratio) in halvings {
        samples = [0, 1, 2].map(|axis| samples[axis] / ratio[axis]);
        let rim = [0, 1, 2].map(|axis| padded[axis].then(|| (cells[axis] - 1) / brick));
        let next = |axis: usize| (cells[axis] / ratio[axis] + 1) * ratio[axis];
        let stored = [0, 1, 2].map(|axis| if padded[axis] { next(axis) } else { cells[axis] });
        shapes.push(LevelShape { cells, ratio, stored, grid: [0; 3], samples, rim });
    }
    // Level 0 holds no more than level 1 needs.
    if let [coarsest, finer, ..] = &mut shapes[..] {
        coarsest.stored = [0, 1, 2].map(|axis| finer.stored[axis] / finer.ratio[axis]);
    }
    for shape in &mut shapes {
        shape.grid = shape.stored.map(|cells| cells.div_ceil(brick));
    }
    shapes
}

/// The cells of each level, and how many of them a coarser cell has per axis: coarsest first. `is_enough` is asked of the
/// coarsest one so far, and of their number.
fn halvings(size: [usize; 3], is_enough: impl Fn([usize; 3], usize) -> bool) -> Vec<([usize; 3], [usize; 3])> {
    let mut levels = Vec::new();
    let mut cells = size;
    while !is_enough(cells, levels.len() + 1) {
        let ratio = cells.map(|cells| cells.min(2));
        levels.push((cells, ratio));
        cells = [0, 1, 2].map(|axis| cells[axis].div_ceil(ratio[axis]));
    }
    levels.push((cells, [1; 3]));
    levels.reverse();
    levels
}

/// The most levels that a volume can have: the coarsest is then one cell.
pub(super) fn most_levels(size: [usize; 3]) -> usize {
    let longest = size.into_iter().max().unwrap_or(1);
    1 + longest.next_power_of_two().ilog2() as usize
}

impl LevelShape {
    /// Cells that bricks hold at most, per brick and axis, from their place in the grid.
    pub(super) fn brick(&self, place: [usize; 3], brick: usize) -> IndexBox {
        let low = place.map(|index| index * brick);
        let high = [0, 1, 2].map(|axis| (low[axis] + brick).min(self.stored[axis]));
        IndexBox::new(low.map(|cell| cell as i64), high.map(|cell| cell as i64))
    }

    /// The places of all bricks, x fastest.
    pub(super) fn places(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [x, y, z] = self.grid;
        (0..x * y * z).map(move |number| [number % x, number / x % y, number / (x * y)])
    }

    /// A brick's number among all places.
    pub(super) fn number(&self, place: [usize; 3]) -> usize {
        place[0] + self.grid[0] * (place[1] + self.grid[1] * place[2])
    }

    /// The place of the brick on the next coarser level that a brick lies in.
    pub(super) fn parent(&self, place: [usize; 3]) -> [usize; 3] {
        [0, 1, 2].map(|axis| place[axis] / self.ratio[axis])
    }

    /// Whether the brick lies at the rim of a volume that is padded there.
    pub(super) fn is_rim(&self, place: [usize; 3]) -> bool {
        (0..3).any(|axis| self.rim[axis].is_some_and(|first| place[axis] >= first))
    }

    /// Cells of a slice across z that hold a part of the volume.
    pub(super) fn slice(&self) -> usize {
        self.cells[0] * self.cells[1]
    }
}

/// The hierarchy of the bricks of all levels. `spacing` and `origin` are the volume's: its samples are cell centres.
pub(super) fn hierarchy(
    levels: &[LevelShape],
    bricks: Vec<Vec<IndexBox>>,
    spacing: [f64; 3],
    origin: [f64; 3],
) -> Result<Hierarchy, HierarchyError> {
    let coarsest = levels[0].stored;
    let descriptions = levels.iter().zip(bricks).map(|(level, bricks)| {
        let refinement = [0, 1, 2].map(|axis| levels[0].samples[axis] / level.samples[axis]);
        LevelDescription {
            ratio: level.ratio.map(|cells| cells as i64),
            cell_size: [0, 1, 2].map(|axis| spacing[axis] * level.samples[axis] as f64),
            domain: IndexBox::new([0; 3], [0, 1, 2].map(|axis| (coarsest[axis] * refinement[axis]) as i64)),
            bricks,
        }
    });
    let origin = [0, 1, 2].map(|axis| origin[axis] - spacing[axis] / 2.0);
    Hierarchy::new(origin, descriptions.collect())
}
