//! One level from the one before: tag what changes, keep a distance from the level's edge, cluster into bricks.

use amray::hierarchy::IndexBox;
use rayon::prelude::*;

use super::blocks::{BlockSet, TILE_SIDE};
use super::clustering::cluster;
use super::tagging::tagged_blocks;

/// Bricks start and end at multiples of this many cells, or at the domain's end.
pub(super) const ALIGNMENT: i64 = 8;
/// Bricks tagged at a time: their tags are lists until they are merged.
const BATCH: usize = 4096;

/// A level in its own cells.
pub(super) struct Mesh {
    /// Cells per side of the domain, which is a unit cube.
    pub(super) side: i64,
    pub(super) bricks: Vec<IndexBox>,
}

/// How one level follows from the one before.
pub(super) struct Refinement {
    pub(super) ratio: i64,
    /// Cells per side of the largest brick.
    pub(super) brick: i64,
    /// Cells are refined whose contrast with a neighbour is larger.
    pub(super) threshold: f64,
}

impl Refinement {
    /// Coarse cells per side of a block. Everything is decided in blocks, which become the smallest bricks; the coarse
    /// level's bricks consist of whole ones.
    pub(super) fn block(&self) -> i64 {
        ALIGNMENT / self.ratio
    }
}

impl Mesh {
    /// Level 0: the domain cut into bricks.
    pub(super) fn coarsest(side: i64, brick: i64) -> Self {
        let bricks = IndexBox::new([0; 3], [side; 3]).coarsened([brick; 3]).iter().map(|place| {
            let low = place.map(|index| index * brick);
            IndexBox::new(low, low.map(|index| side.min(index + brick)))
        });
        Self { side, bricks: bricks.collect() }
    }

    pub(super) fn domain(&self) -> IndexBox {
        IndexBox::new([0; 3], [self.side; 3])
    }

    /// The next finer level; no bricks where nothing is left to refine. Every brick of it, and one coarse cell around
    /// it, lies in this level's bricks or outside the domain. `tagged` is told the cells of each brick that is done.
    pub(super) fn refined(&self, how: &Refinement, tagged: &(dyn Fn(u64) + Sync)) -> Self {
        let fine = Self { side: self.side * how.ratio, bricks: Vec::new() };
        let blocks = self.domain().coarsened([how.block(); 3]);
        let tags = self.tagged(how, tagged);
        let mut covered = BlockSet::default();
        self.bricks.iter().for_each(|brick| covered.insert_box(&brick.coarsened([how.block(); 3])));

        let tiles: Vec<_> = tags.tiles().collect();
        let bricks = tiles.into_par_iter().flat_map_iter(|(place, tags)| {
            let nested = covered.interior(place, &blocks);
            let boxes = cluster(&tags.intersection(&nested), &nested, how.brick / ALIGNMENT);
            let domain = fine.domain();
            boxes.into_iter().map(move |found| {
                let in_cells = |corner: [i64; 3]| [0, 1, 2].map(|n| (corner[n] + place[n] * TILE_SIDE) * ALIGNMENT);
                IndexBox::new(in_cells(found.low), in_cells(found.high)).intersection(&domain)
            })
        });
        Self { bricks: bricks.collect(), ..fine }
    }

    fn tagged(&self, how: &Refinement, tagged: &(dyn Fn(u64) + Sync)) -> BlockSet {
        let mut tags = BlockSet::default();
        for batch in self.bricks.chunks(BATCH) {
            let lists = batch.par_iter().map(|brick| {
                let list = tagged_blocks(brick, self.side, how);
                tagged(brick.cells());
                list
            });
            let lists: Vec<Vec<[i64; 3]>> = lists.collect();
            lists.iter().flatten().for_each(|&block| tags.insert(block));
        }
        tags
    }
}
