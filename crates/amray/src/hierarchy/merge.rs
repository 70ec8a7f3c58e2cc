//! Merging: neighbouring bricks of a level become one larger brick. Octrees of small blocks need it, because the index
//! and the borders of bricks cost by the brick.

use super::rebricking::{Rebricking, Source};
use super::{Hierarchy, HierarchyError, IndexBox};

/// A box that is tiled by boxes of a list.
pub(super) struct MergedBox {
    pub(super) cells: IndexBox,
    /// The places of the boxes in the list.
    parts: Vec<usize>,
}

impl Hierarchy {
    /// The same cells in fewer bricks: neighbours are joined where that makes a box inside one tile of `tile` cells per
    /// axis, which start at cell 0 of each level.
    ///
    /// # Errors
    /// None that the hierarchy itself did not have.
    ///
    /// # Panics
    /// Where `tile` is not positive.
    pub fn merged(&self, tile: i64) -> Result<Rebricking, HierarchyError> {
        let mut levels = self.descriptions();
        let mut sources = Vec::new();
        for (level, description) in self.levels().iter().zip(&mut levels) {
            let merged = merged_boxes(level.bricks(), tile);
            description.bricks = merged.iter().map(|brick| brick.cells).collect();
            let source = |part: usize| (level.first_brick() + part, level.bricks()[part]);
            sources
                .extend(merged.into_iter().map(|brick| Source::Bricks(brick.parts.into_iter().map(source).collect())));
        }
        Rebricking::new(self.origin(), levels, sources)
    }
}

/// Joins boxes that share no cell, in no particular order.
pub(super) fn merged_boxes(boxes: &[IndexBox], tile: i64) -> Vec<MergedBox> {
    let mut merged: Vec<MergedBox> =
        boxes.iter().enumerate().map(|(part, &cells)| MergedBox { cells, parts: vec![part] }).collect();
    for axis in 0..3 {
        merged = merged_along(merged, axis, tile);
    }
    merged
}

/// Joins boxes that touch along `axis`, have the same extent across it, and lie in the same tile.
fn merged_along(mut boxes: Vec<MergedBox>, axis: usize, tile: i64) -> Vec<MergedBox> {
    let across = |cells: &IndexBox| {
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
        [cells.low[a], cells.high[a], cells.low[b], cells.high[b]]
    };
    boxes.sort_unstable_by_key(|one| (across(&one.cells), one.cells.low[axis]));
    let mut merged: Vec<MergedBox> = Vec::with_capacity(boxes.len());
    for next in boxes {
        match merged.last_mut() {
            Some(last)
                if across(&last.cells) == across(&next.cells)
                    && last.cells.high[axis] == next.cells.low[axis]
                    && last.cells.low[axis].div_euclid(tile) == (next.cells.high[axis] - 1).div_euclid(tile) =>
            {
                last.cells.high[axis] = next.cells.high[axis];
                last.parts.extend(next.parts);
            }
            _ => merged.push(next),
        }
    }
    merged
}
