//! What surrounds each region: the levels in reach of its points, and the interior where one brick is enough.

use rayon::prelude::*;

use super::build::Leaf;
use super::{Index, Node, Region};
use crate::hierarchy::{IndexBox, Level};

/// The regions of the tree's leaves: with the levels in reach and the interior, which depend on neighbours.
pub(super) fn described(index: &Index, leaves: &[Leaf]) -> Vec<Region> {
    let survey = Survey::new(index, leaves);
    leaves.par_iter().map_init(Vec::new, |neighbours, leaf| survey.described(leaf, neighbours)).collect()
}

/// What is known while the regions are described.
struct Survey<'a> {
    index: &'a Index,
    leaves: &'a [Leaf],
    /// Per node, which levels show below it.
    shown: Vec<Shown>,
    /// Per level, cells of the finest level per cell.
    sizes: Vec<[i64; 3]>,
    /// Per level, how far its cells can reach from a region's box, in cells of the finest level.
    margins: Vec<[i64; 3]>,
}

/// The finest levels of the regions below a node. A hole counts as finer than all levels: only its neighbours reach.
#[derive(Clone, Copy)]
struct Shown {
    coarsest: u8,
    finest: u8,
}

impl Shown {
    const HOLE: u8 = u8::MAX;
}

/// Space beside the region that is described.
struct Neighbour {
    /// The space, in half cells of the finest level, in which the neighbour's cells take part.
    reach: IndexBox,
    /// On how many axes the neighbour lies beside the region, rather than along it.
    apart: usize,
}

impl<'a> Survey<'a> {
    fn new(index: &'a Index, leaves: &'a [Leaf]) -> Self {
        let mut shown = vec![Shown { coarsest: 0, finest: 0 }; index.nodes.len()];
        // Children follow their parents.
        for (place, node) in index.nodes.iter().enumerate().rev() {
            shown[place] = match *node {
                Node::Leaf(leaf) => {
                    let level = leaves[leaf as usize].levels.checked_ilog2().map_or(Shown::HOLE, |level| level as u8);
                    Shown { coarsest: level, finest: level }
                }
                Node::Inner { high, .. } => {
                    let (low, high) = (shown[place + 1], shown[high as usize]);
                    Shown { coarsest: low.coarsest.min(high.coarsest), finest: low.finest.max(high.finest) }
                }
            };
        }
        // Half a cell, and where a cell may be covered in part up to one more by which a box falls short of its cells.
        let halves = if index.may_cover_partly { 3 } else { 1 };
        let margin = |level: &Level| level.finest_cells().map(|cells| (halves * cells + 1) / 2);
        let levels = index.hierarchy.levels();
        Self {
            index,
            leaves,
            shown,
            sizes: levels.iter().map(Level::finest_cells).collect(),
            margins: levels.iter().map(margin).collect(),
        }
    }

    /// The region of a leaf, with its surroundings. `neighbours` is memory to use.
    fn described(&self, leaf: &Leaf, neighbours: &mut Vec<Neighbour>) -> Region {
        let &Leaf { ref cells, levels, first_brick } = leaf;
        let hole = Region { levels, first_brick, ..Region::EMPTY };
        let Some(level) = hole.finest_level() else { return hole };
        let Some((_, brick)) = self.index.finest_brick(&hole, level) else { return hole };
        let size = self.sizes[level];
        let brick = self.index.hierarchy.levels()[level].brick_at(brick).refined(size).refined([2; 3]);
        let half_cells = cells.refined([2; 3]);
        neighbours.clear();
        let mut around = Surroundings {
            survey: self,
            level,
            cells: *cells,
            half_cells,
            levels_in_reach: [level; 2],
            // Cells of the same level are met half a cell inside the brick's own faces.
            interior: brick.grown(size.map(|cells| -cells)).intersection(&half_cells),
            neighbours,
        };
        around.look(0, &mut self.index.domain.clone());
        Region {
            coarsest_in_reach: around.levels_in_reach[0] as u8,
            finest_in_reach: around.levels_in_reach[1] as u8,
            interior: around.interior(),
            ..hole
        }
    }

    /// A region's `cells` (of the finest level) grown by half a cell of `level`, in half cells of the finest level.
    fn reach(&self, level: usize, cells: &IndexBox) -> IndexBox {
        let size = self.sizes[level];
        // A region's leaf cells fill its box or go on in a region of the same brick, unless one is covered in part.
        let whole = if self.index.may_cover_partly { cells.coarsened(size).refined(size) } else { *cells };
        whole.refined([2; 3]).grown(size)
    }
}

/// A region while its surroundings are looked at.
struct Surroundings<'a> {
    survey: &'a Survey<'a>,
    /// The region's finest level.
    level: usize,
    cells: IndexBox,
    /// `cells` in half cells of the finest level, like the interior.
    half_cells: IndexBox,
    /// The coarsest and the finest level in reach so far.
    levels_in_reach: [usize; 2],
    /// Where the region's brick alone is in reach, as far as its own faces say.
    interior: IndexBox,
    /// What takes part in the interior.
    neighbours: &'a mut Vec<Neighbour>,
}

impl Surroundings<'_> {
    /// Looks at everything below `node`, which fills `space`, that can reach into the region or be reached from it.
    fn look(&mut self, node: usize, space: &mut IndexBox) {
        let survey = self.survey;
        let Shown { coarsest, finest } = survey.shown[node];
        if coarsest == finest {
            // Regions that show one level fill their common box, so they reach as far as it does.
            if usize::from(coarsest) == self.level || self.add(node, coarsest, space) {
                return;
            }
        }
        let Node::Inner { axis, plane, high } = survey.index.nodes[node] else { return };
        let axis = usize::from(axis);
        let (low, high) = (node + 1, high as usize);
        let margin = |child: usize| survey.margins[self.level.min(usize::from(survey.shown[child].coarsest))][axis];
        let (into_low, into_high) =
            (self.cells.low[axis] - margin(low) < plane, self.cells.high[axis] + margin(high) > plane);
        let ends = (space.low[axis], space.high[axis]);
        if into_low {
            space.high[axis] = plane;
            self.look(low, space);
            space.high[axis] = ends.1;
        }
        if into_high {
            space.low[axis] = plane;
            self.look(high, space);
            space.low[axis] = ends.0;
        }
    }

    /// Takes note of the regions below `node`, which all show `other`, not the region's own level. Returns whether they
    /// need no closer look.
    fn add(&mut self, node: usize, other: u8, space: &IndexBox) -> bool {
        let survey = self.survey;
        let [coarsest_in_reach, finest_in_reach] = &mut self.levels_in_reach;
        let mut reaching = self.level;
        if other != Shown::HOLE {
            let other = usize::from(other);
            let touches = |level: usize| survey.reach(level, space).intersects(&self.half_cells);
            if other < self.level {
                // In reach: nearer than half a cell of the neighbour's level.
                if touches(other) {
                    *coarsest_in_reach = other.min(*coarsest_in_reach);
                }
                reaching = other;
            } else if other > *finest_in_reach {
                if touches(other) {
                    *finest_in_reach = other;
                } else if let Node::Leaf(leaf) = survey.index.nodes[node] {
                    // Its covered cells reach farther.
                    let levels = survey.leaves[leaf as usize].levels;
                    let covered = (*finest_in_reach + 1..other).rev().filter(|level| levels >> level & 1 == 1);
                    *finest_in_reach = { covered }.find(|&level| touches(level)).unwrap_or(*finest_in_reach);
                } else if *finest_in_reach + 1 < other && touches(*finest_in_reach + 1) {
                    return false;
                }
            }
        }
        // Whichever cells are larger: a fine neighbour covers cells of this level that a dual cell would touch.
        let reach = survey.reach(reaching, space);
        if reach.intersects(&self.interior) {
            let cells = &self.cells;
            let beside = |&axis: &usize| space.high[axis] <= cells.low[axis] || cells.high[axis] <= space.low[axis];
            self.neighbours.push(Neighbour { reach, apart: (0..3).filter(beside).count() });
        }
        true
    }

    /// The largest box found inside the region that lies half a cell inside its brick and in no neighbour's reach.
    fn interior(self) -> [[f64; 3]; 2] {
        let mut interior = self.interior;
        // Neighbours across a face first: what they take mostly settles those across an edge or a corner.
        self.neighbours.sort_by_key(|neighbour| neighbour.apart);
        for Neighbour { reach, .. } in self.neighbours {
            if reach.intersects(&interior) {
                interior = without(&interior, reach);
            }
        }
        if interior.is_empty() {
            // A flat interior would promise a dual cell to a brick that is one cell thin.
            return Region::EMPTY.interior;
        }
        [interior.low, interior.high].map(|corner| corner.map(|half_cells| half_cells as f64 / 2.0))
    }
}

/// The largest of the boxes that remain of `interior` on one side of `taken`, which reaches into it.
fn without(interior: &IndexBox, taken: &IndexBox) -> IndexBox {
    let mut largest = *interior;
    let mut share = -1.0;
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
