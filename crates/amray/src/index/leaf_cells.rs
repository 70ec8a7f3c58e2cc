//! Which region counts which leaf cell, so that each is counted once.

use super::Index;
use crate::hierarchy::IndexBox;

impl Index {
    /// The number of leaf cells on each level.
    pub fn leaf_cells(&self) -> Vec<u64> {
        let mut counts = vec![0; self.hierarchy.levels().len()];
        self.for_each_region(&mut |region, cells| {
            if let Some(level) = self.regions[region].finest_level() {
                self.for_each_leaf_box(region, &cells, &mut |leaves| counts[level] += leaves.cells());
            }
        });
        counts
    }

    /// Calls `visit` with boxes of leaf cells (of the region's finest level) that together hold each leaf cell that the
    /// region, whose box is `cells` (of the finest level), counts. A cell that regions cut, or that is covered in part,
    /// is counted by the first region that shows a part of it.
    pub(crate) fn for_each_leaf_box(&self, region: usize, cells: &IndexBox, visit: &mut impl FnMut(IndexBox)) {
        let Some(level) = self.regions[region].finest_level() else { return };
        let size = self.hierarchy.levels()[level].finest_cells();
        let touched = cells.coarsened(size);
        let whole = IndexBox::new(
            cells.cells_starting_inside(size).low,
            std::array::from_fn(|axis| cells.high[axis].div_euclid(size[axis])),
        );
        if !whole.is_empty() {
            visit(whole);
        }
        if touched == whole {
            return;
        }
        for cell in touched.iter().filter(|&cell| !whole.contains(cell)) {
            let leaf = IndexBox::new(cell, cell.map(|index| index + 1));
            let mut first = usize::MAX;
            self.for_each_region_in(&leaf.refined(size), &mut |other, _| {
                if self.regions[other].finest_level() == Some(level) {
                    first = first.min(other);
                }
            });
            if first == region {
                visit(leaf);
            }
        }
    }
}
