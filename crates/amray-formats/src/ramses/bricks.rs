//! Bricks of many grids: a brick for every 2x2x2 cells would take far more memory than the cells.

use amray::hierarchy::IndexBox;
use rayon::prelude::*;

/// Grids along each axis of the largest brick.
const TILE: i64 = 16;
const GRIDS: usize = (TILE * TILE * TILE) as usize;

/// Where the values of a grid are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Source {
    /// The process, from 0 on.
    pub(super) cpu: u32,
    /// The number among the process's own grids of the level.
    pub(super) grid: u32,
}

/// A grid of a level, at a place in grids of the level.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) place: [i64; 3],
    pub(super) source: Source,
}

/// Grids that fill a box.
#[derive(Debug)]
pub(super) struct Brick {
    /// In grids of the level.
    pub(super) grids: IndexBox,
    /// For each grid, x fastest.
    pub(super) sources: Vec<Source>,
}

/// Joins grids of a level to bricks: neighbours in the same tile, where that makes a box.
///
/// # Errors
/// The first place that has several grids.
pub(super) fn joined(mut grids: Vec<Grid>) -> Result<Vec<Brick>, [i64; 3]> {
    let tile = |grid: &Grid| grid.place.map(|index| index.div_euclid(TILE));
    // The order of bricks does not depend on that of the files.
    grids.par_sort_unstable_by_key(|grid| (tile(grid), grid.source));
    let tiles: Vec<&[Grid]> = grids.chunk_by(|a, b| tile(a) == tile(b)).collect();
    let bricks: Vec<Vec<Brick>> = tiles.into_par_iter().map(joined_in_tile).collect::<Result<_, _>>()?;
    Ok(bricks.into_iter().flatten().collect())
}

/// Joins the grids of one tile.
fn joined_in_tile(grids: &[Grid]) -> Result<Vec<Brick>, [i64; 3]> {
    let corner = grids[0].place.map(|index| index.div_euclid(TILE) * TILE);
    let mut tile = Tile { left: vec![None; GRIDS] };
    for grid in grids {
        let left = &mut tile.left[Tile::at(std::array::from_fn(|axis| grid.place[axis] - corner[axis]))];
        if left.replace(grid.source).is_some() {
            return Err(grid.place);
        }
    }
    let mut bricks = Vec::new();
    for first in IndexBox::new([0; 3], [TILE; 3]).iter() {
        if tile.left[Tile::at(first)].is_some() {
            let cells = tile.box_from(first);
            let sources = cells.iter().filter_map(|place| tile.left[Tile::at(place)].take()).collect();
            let [low, high] = [cells.low, cells.high].map(|end| std::array::from_fn(|axis| corner[axis] + end[axis]));
            bricks.push(Brick { grids: IndexBox::new(low, high), sources });
        }
    }
    Ok(bricks)
}

/// The grids of a tile that are in no brick yet.
struct Tile {
    left: Vec<Option<Source>>,
}

impl Tile {
    fn at([x, y, z]: [i64; 3]) -> usize {
        (x + TILE * (y + TILE * z)) as usize
    }

    /// The box of grids from one on that reaches as far as it can along x, then y, then z.
    fn box_from(&self, first: [i64; 3]) -> IndexBox {
        let mut cells = IndexBox::new(first, first.map(|index| index + 1));
        for axis in 0..3 {
            while cells.high[axis] < TILE {
                let mut next = cells;
                (next.low[axis], next.high[axis]) = (cells.high[axis], cells.high[axis] + 1);
                if next.iter().any(|place| self.left[Self::at(place)].is_none()) {
                    break;
                }
                cells.high[axis] += 1;
            }
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(place: [i64; 3], grid: u32) -> Grid {
        Grid { place, source: Source { cpu: 0, grid } }
    }

    #[test]
    fn grids_are_in_one_brick_each() {
        let all = IndexBox::new([14, 0, 3], [18, 2, 5]);
        // An L in the first tile, a full half of the box in the second.
        let kept = all.iter().filter(|place| place[0] != 15 || place[1] == 0);
        let grids: Vec<Grid> = kept.enumerate().map(|(number, place)| grid(place, number as u32)).collect();
        let bricks = joined(grids.clone()).unwrap();
        assert_eq!(bricks.len(), 3);
        assert_eq!(bricks[2].grids, IndexBox::new([16, 0, 3], [18, 2, 5]));
        let mut found: Vec<([i64; 3], Source)> =
            bricks.iter().flat_map(|brick| brick.grids.iter().zip(brick.sources.iter().copied())).collect();
        let mut expected: Vec<_> = grids.iter().map(|grid| (grid.place, grid.source)).collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
    }

    #[test]
    fn two_grids_at_a_place_are_refused() {
        assert_eq!(joined(vec![grid([20, 1, 2], 0), grid([0; 3], 1), grid([20, 1, 2], 2)]).unwrap_err(), [20, 1, 2]);
        assert!(joined(Vec::new()).unwrap().is_empty());
    }
}
