//! How far cells take part in samples, and the largest box found inside a region that no neighbour reaches.

use super::Index;
use crate::hierarchy::IndexBox;

impl Index {
    /// Where the cells of `level` take part that a region of `cells` (of the finest level) has: in reach, nearer than
    /// half a cell. In half cells of the finest level.
    pub(crate) fn reach(&self, level: usize, cells: &IndexBox) -> IndexBox {
        let size = self.hierarchy.levels()[level].finest_cells();
        // A region's cells fill its box or go on in a region of the same brick, unless one is covered in part.
        let whole = if self.may_cover_partly { cells.coarsened(size).refined(size) } else { *cells };
        whole.refined([2; 3]).grown(size)
    }
}

/// Space beside a region.
pub(crate) struct Neighbour {
    /// The space, in half cells of the finest level, in which the neighbour's cells take part.
    reach: IndexBox,
    /// On how many axes the neighbour lies beside the region, rather than along it.
    apart: usize,
}

impl Neighbour {
    /// The neighbour that fills `space` beside a region of `cells`.
    pub(crate) fn new(reach: IndexBox, space: &IndexBox, cells: &IndexBox) -> Self {
        let beside = |&axis: &usize| space.high[axis] <= cells.low[axis] || cells.high[axis] <= space.low[axis];
        Self { reach, apart: (0..3).filter(beside).count() }
    }
}

/// The largest box found inside `interior` that is in no neighbour's reach.
pub(crate) fn out_of_reach(mut interior: IndexBox, neighbours: &mut [Neighbour]) -> IndexBox {
    // Neighbours across a face first: what they take mostly settles those across an edge or a corner.
    neighbours.sort_by_key(|neighbour| neighbour.apart);
    for Neighbour { reach, .. } in neighbours {
        if reach.intersects(&interior) {
            interior = without(&interior, reach);
        }
    }
    interior
}

/// The largest of the boxes that remain of `interior` on one side of `taken`, which reaches into it.
fn without(interior: &IndexBox, taken: &IndexBox) -> IndexBox {
    let mut largest = *interior;
    let mut share = f64::NEG_INFINITY;
    for axis in 0..3 {
        let (low, high) = (interior.low[axis], interior.high[axis]);
        let (below, above) = (taken.low[axis].min(high), taken.high[axis].max(low));
        // The other axes keep their width: boxes compare by the share that is left of this one.
        let width = (high - low) as f64;
        for (left, [low, high]) in [(below - low, [low, below]), (high - above, [above, high])] {
            if left as f64 / width >= share {
                share = left as f64 / width;
                largest = *interior;
                largest.low[axis] = low;
                largest.high[axis] = high;
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left_of(interior: IndexBox, reaches: &[IndexBox]) -> IndexBox {
        let mut neighbours: Vec<_> = reaches.iter().map(|reach| Neighbour::new(*reach, reach, &interior)).collect();
        out_of_reach(interior, &mut neighbours)
    }

    #[test]
    fn the_largest_side_is_left() {
        let interior = IndexBox::new([0; 3], [10; 3]);
        let taken = [IndexBox::new([7, 0, 0], [12, 10, 10]), IndexBox::new([0, 9, 0], [10, 12, 3])];
        assert_eq!(left_of(interior, &taken[..1]), IndexBox::new([0; 3], [7, 10, 10]));
        assert_eq!(left_of(interior, &taken), IndexBox::new([0; 3], [7, 9, 10]));
        assert_eq!(left_of(interior, &[IndexBox::new([10; 3], [12; 3])]), interior);
    }

    #[test]
    fn nothing_is_left_under_a_neighbour_that_reaches_far_beyond() {
        let interior = IndexBox::new([0; 3], [1; 3]);
        assert!(left_of(interior, &[IndexBox::new([-9; 3], [9; 3])]).is_empty());
    }
}
