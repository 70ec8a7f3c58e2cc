//! The largest box found inside a region that no neighbour reaches.

use crate::hierarchy::IndexBox;

/// Space beside a region.
pub(super) struct Neighbour {
    /// The space, in half cells of the finest level, in which the neighbour's cells take part.
    reach: IndexBox,
    /// On how many axes the neighbour lies beside the region, rather than along it.
    apart: usize,
}

impl Neighbour {
    /// The neighbour that fills `space` beside a region of `cells`.
    pub(super) fn new(reach: IndexBox, space: &IndexBox, cells: &IndexBox) -> Self {
        let beside = |&axis: &usize| space.high[axis] <= cells.low[axis] || cells.high[axis] <= space.low[axis];
        Self { reach, apart: (0..3).filter(beside).count() }
    }
}

/// The largest box found inside `interior` that is in no neighbour's reach.
pub(super) fn out_of_reach(mut interior: IndexBox, neighbours: &mut [Neighbour]) -> IndexBox {
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
