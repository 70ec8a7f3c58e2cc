//! From the grids of all processes to the bricks and levels of a hierarchy.

use amray::hierarchy::IndexBox;

use super::amr::Mesh;
use super::bricks::{Brick, Grid, Source, joined};
use crate::refined::Root;

/// Cells of a grid along each axis.
pub(super) const GRID: i64 = 2;

/// A brick with the hierarchy's level that it is on, and its cells there.
pub(super) type PlacedBrick = (usize, IndexBox, Brick);

/// The grids of all processes.
pub(super) struct Levels {
    /// The coarse cells inside the boundaries.
    domain: IndexBox,
    /// The place of the hierarchy's first level among those of grids.
    pub(super) first: usize,
    /// By level: the first one has a grid in each coarse cell, the last one at least one.
    grids: Vec<Vec<Grid>>,
}

impl Levels {
    /// All grids of all meshes, each of which a process wrote. The hierarchy begins at the finest level whose grids fill
    /// the domain, up to the run's `level_min`. `None` where there is no grid.
    pub(super) fn new(meshes: Vec<Mesh>, level_min: usize) -> Option<Self> {
        let domain = domain(&meshes)?;
        let mut grids: Vec<Vec<Grid>> = Vec::new();
        for (cpu, mesh) in meshes.into_iter().enumerate() {
            for (level, places) in mesh.levels.into_iter().enumerate().filter(|(_, places)| !places.is_empty()) {
                if grids.len() <= level {
                    grids.resize_with(level + 1, Vec::new);
                }
                let source = |grid: usize| Source { cpu: cpu as u32, grid: grid as u32 };
                let placed = places.into_iter().enumerate();
                grids[level].extend(placed.map(|(grid, place)| Grid { place, source: source(grid) }));
            }
        }
        let fills = |level: &usize| {
            let all = 8u64.checked_pow(*level as u32).and_then(|grids| grids.checked_mul(domain.cells()));
            all == Some(grids[*level].len() as u64)
        };
        let first = (0..level_min.min(grids.len())).rev().find(fills).unwrap_or(0);
        Some(Self { domain, first, grids })
    }

    /// Levels of the hierarchy.
    pub(super) fn count(&self) -> usize {
        self.grids.len() - self.first
    }

    /// The hierarchy's first level, if a coarse cell is so wide.
    pub(super) fn root(&self, coarse_cell: f64) -> Root {
        let across = cells_across(self.first);
        let cells = self.domain.size().map(|coarse| coarse * across);
        Root { low: [0.0; 3], cell_size: [coarse_cell / across as f64; 3], cells, ratio: 2 }
    }

    /// The bricks of the hierarchy's first levels, so many.
    ///
    /// # Errors
    /// The level, counted from 1 as RAMSES does, and the place of several grids.
    pub(super) fn bricks(self, count: usize) -> Result<Vec<PlacedBrick>, (usize, [i64; 3])> {
        let mut bricks = Vec::new();
        for (level, grids) in self.grids.into_iter().enumerate().skip(self.first).take(count) {
            let corner = self.domain.low.map(|coarse| coarse * cells_across(level));
            let found = joined(grids).map_err(|place| (level + 1, place))?;
            bricks.extend(found.into_iter().map(|brick| {
                let cells = brick.grids.refined([GRID; 3]);
                let [low, high] =
                    [cells.low, cells.high].map(|end| std::array::from_fn(|axis| end[axis] - corner[axis]));
                (level - self.first, IndexBox::new(low, high), brick)
            }));
        }
        Ok(bricks)
    }
}

/// The coarse cells of the domain: those beyond it hold no grids of a process.
fn domain(meshes: &[Mesh]) -> Option<IndexBox> {
    let coarse = || meshes.iter().flat_map(|mesh| mesh.levels.first()).flatten();
    let mut domain = coarse().next().map(|&first| IndexBox::new(first, first.map(|index| index + 1)))?;
    for cell in coarse() {
        for axis in 0..3 {
            domain.low[axis] = domain.low[axis].min(cell[axis]);
            domain.high[axis] = domain.high[axis].max(cell[axis] + 1);
        }
    }
    Some(domain)
}

/// Cells per coarse cell, along each axis, of the grids of a level.
fn cells_across(level: usize) -> i64 {
    GRID << level
}
