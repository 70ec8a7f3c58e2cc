//! Completing: coarse bricks under finer ones, where a file stores leaf cells alone.

use std::collections::HashMap;

use super::merge::merged_boxes;
use super::overlap::for_each_overlap;
use super::rebricking::{Rebricking, Source};
use super::{Hierarchy, HierarchyError, IndexBox};

/// Added bricks are joined up to so many cells per axis.
const TILE: i64 = 32;

impl Hierarchy {
    /// The hierarchy with bricks added under all finer cells that no coarser ones lie under: their values are means of
    /// the finer ones. So data of leaf cells alone (octrees) have coarse levels to look at, and to blend with.
    ///
    /// Where they would fill a cell of the next coarser level only in part, which octrees do not do, nothing is added.
    ///
    /// # Errors
    /// [`HierarchyError::TooMany`] where there is no room for the bricks that are added.
    pub fn completed(&self) -> Result<Rebricking, HierarchyError> {
        let mut levels = self.descriptions();
        for finer in (1..levels.len()).rev() {
            let ratio = levels[finer].ratio;
            let footprints: Vec<IndexBox> = levels[finer].bricks.iter().map(|brick| brick.coarsened(ratio)).collect();
            let coarse = &mut levels[finer - 1];
            let missing = aligned(&without(&footprints, &coarse.bricks), coarse.ratio);
            coarse.bricks.extend(merged_boxes(&missing, TILE).into_iter().map(|brick| brick.cells));
        }
        let mut sources = Vec::new();
        for (level, description) in self.levels().iter().zip(&levels) {
            let kept = level.bricks().iter().enumerate();
            sources.extend(kept.map(|(brick, &cells)| Source::Bricks(vec![(level.first_brick() + brick, cells)])));
            sources.extend((level.bricks().len()..description.bricks.len()).map(|_| Source::Finer));
        }
        Rebricking::new(self.origin(), levels, sources)
    }
}

/// What the disjoint `boxes` hold and `taken` does not, as disjoint boxes.
fn without(boxes: &[IndexBox], taken: &[IndexBox]) -> Vec<IndexBox> {
    let mut holes: Vec<Vec<IndexBox>> = vec![Vec::new(); boxes.len()];
    for_each_overlap(boxes, taken, |place, _, shared| {
        holes[place].push(shared);
        true
    });
    let left = |(cells, holes): (&IndexBox, Vec<IndexBox>)| {
        holes.iter().fold(vec![*cells], |left, hole| left.iter().flat_map(|part| cut_out(part, hole)).collect())
    };
    boxes.iter().zip(holes).flat_map(left).collect()
}

/// `cells` without those of `hole`, in up to six boxes.
fn cut_out(cells: &IndexBox, hole: &IndexBox) -> Vec<IndexBox> {
    let hole = cells.intersection(hole);
    if hole.is_empty() {
        return vec![*cells];
    }
    let mut parts = Vec::new();
    let mut left = *cells;
    for axis in (0..3).rev() {
        let (mut below, mut above) = (left, left);
        below.high[axis] = hole.low[axis];
        above.low[axis] = hole.high[axis];
        parts.extend([below, above].into_iter().filter(|part| !part.is_empty()));
        (left.low[axis], left.high[axis]) = (hole.low[axis], hole.high[axis]);
    }
    parts
}

/// The cells of disjoint `boxes`, as disjoint boxes that cut no cell `ratio` times coarser; without those of coarser
/// cells that the boxes do not fill together.
fn aligned(boxes: &[IndexBox], ratio: [i64; 3]) -> Vec<IndexBox> {
    let per_coarser: i64 = ratio.iter().product();
    let mut whole = Vec::with_capacity(boxes.len());
    let mut cut: HashMap<[i64; 3], i64> = HashMap::new();
    for cells in boxes {
        let core = whole_cells(cells, ratio);
        for rest in cut_out(cells, &core) {
            for cell in rest.iter() {
                *cut.entry(std::array::from_fn(|axis| cell[axis].div_euclid(ratio[axis]))).or_default() += 1;
            }
        }
        whole.extend(Some(core).filter(|core| !core.is_empty()));
    }
    let filled = cut.into_iter().filter(|&(_, cells)| cells == per_coarser);
    let mut filled: Vec<_> = filled.map(|(cell, _)| cell).collect();
    // The order of bricks does not depend on that of a hash map.
    filled.sort_unstable();
    whole.extend(filled.into_iter().map(|cell| IndexBox::new(cell, cell.map(|index| index + 1)).refined(ratio)));
    whole
}

/// The largest box inside `cells` that cuts no cell `ratio` times coarser.
fn whole_cells(cells: &IndexBox, ratio: [i64; 3]) -> IndexBox {
    let coarser = cells.cells_starting_inside(ratio);
    let mut whole = coarser.refined(ratio);
    for axis in 0..3 {
        if whole.high[axis] > cells.high[axis] {
            whole.high[axis] -= ratio[axis];
        }
    }
    whole
}
