//! What surrounds each region: the levels in reach of its points, and the interior where one brick is enough.

use rayon::prelude::*;

use super::{Index, Node, Region};
use crate::hierarchy::{IndexBox, Level};

/// Fills in what depends on neighbouring regions: levels in reach and interior.
pub(super) fn describe_regions(index: &mut Index) {
    let survey = Survey::new(index);
    let described = (0..index.regions.len()).into_par_iter().map(|region| survey.described(region));
    let regions: Vec<Region> = described.collect();
    index.regions = regions;
}

/// What is known while the regions are described.
struct Survey<'a> {
    index: &'a Index,
    /// The regions' boxes, in cells of the finest level.
    boxes: Vec<IndexBox>,
    /// Per node, the coarsest level that is some region's finest one: how far the regions below can reach.
    coarsest: Vec<u8>,
    /// Per level, how far its cells can reach from a region's box, in cells of the finest level.
    margins: Vec<[i64; 3]>,
}

/// A region beside the one that is described.
struct Neighbour {
    /// The space, in half cells of the finest level, in which the neighbour's cells take part.
    reach: IndexBox,
    /// On how many axes the neighbour lies beside the region, rather than along it.
    apart: usize,
}

impl<'a> Survey<'a> {
    fn new(index: &'a Index) -> Self {
        let mut coarsest = vec![0; index.nodes.len()];
        // Children follow their parents.
        for (place, node) in index.nodes.iter().enumerate().rev() {
            coarsest[place] = match *node {
                Node::Leaf(region) => {
                    index.regions[region as usize].finest_level().map_or(u8::MAX, |level| level as u8)
                }
                Node::Inner { high, .. } => coarsest[place + 1].min(coarsest[high as usize]),
            };
        }
        // Half a cell, and where a cell may be covered in part up to one more by which a box falls short of its cells.
        let halves = if index.may_cover_partly { 3 } else { 1 };
        let margin = |level: &Level| level.finest_cells().map(|cells| (halves * cells + 1) / 2);
        let margins = index.hierarchy.levels().iter().map(margin).collect();
        Self { index, boxes: index.region_boxes(), coarsest, margins }
    }

    /// The region with its surroundings.
    fn described(&self, number: usize) -> Region {
        let index = self.index;
        let region = &index.regions[number];
        let cells = &self.boxes[number];
        let Some(level) = region.finest_level() else { return region.clone() };
        let (mut coarsest_in_reach, mut finest_in_reach) = (level, level);
        let mut neighbours = Vec::new();
        self.for_each_neighbour(level, cells, &mut |other| {
            let other_cells = &self.boxes[other];
            let other = &index.regions[other];
            let Some(other_level) = other.finest_level() else {
                return neighbours.push(self.neighbour(level, cells, other_cells));
            };
            // Cells of the same level are met half a cell inside the brick's own faces.
            if other_level == level {
                return;
            }
            // In reach: nearer than half a cell of the neighbour's level.
            if other_level < level && touches(&self.reach(other_level, other_cells), cells) {
                coarsest_in_reach = coarsest_in_reach.min(other_level);
            }
            for finer in (level + 1..=other_level).filter(|&finer| other.has_level(finer)) {
                if touches(&self.reach(finer, other_cells), cells) {
                    finest_in_reach = finest_in_reach.max(finer);
                }
            }
            // Whichever cells are larger: a fine neighbour covers cells of this level that a dual cell would touch.
            neighbours.push(self.neighbour(level.min(other_level), cells, other_cells));
        });
        Region {
            coarsest_in_reach: coarsest_in_reach as u8,
            finest_in_reach: finest_in_reach as u8,
            interior: interior(index, region, level, cells, neighbours),
            ..region.clone()
        }
    }

    /// The region `other` beside `cells`, with the reach of cells of `level`.
    fn neighbour(&self, level: usize, cells: &IndexBox, other: &IndexBox) -> Neighbour {
        let apart = (0..3).filter(|&axis| other.high[axis] <= cells.low[axis] || cells.high[axis] <= other.low[axis]);
        Neighbour { reach: self.reach(level, other), apart: apart.count() }
    }

    /// A region's `cells` (of the finest level) grown by half a cell of `level`, in half cells of the finest level.
    fn reach(&self, level: usize, cells: &IndexBox) -> IndexBox {
        let size = self.index.hierarchy.levels()[level].finest_cells();
        // A region's leaf cells fill its box or go on in a region of the same brick, unless one is covered in part.
        let whole = if self.index.may_cover_partly { cells.coarsened(size).refined(size) } else { *cells };
        whole.refined([2; 3]).grown(size)
    }

    /// Calls `visit` with every region, also the one that is described, that may reach into its `cells` or be reached
    /// by half a cell of its `level`.
    fn for_each_neighbour(&self, level: usize, cells: &IndexBox, visit: &mut impl FnMut(usize)) {
        let mut stack = vec![0];
        while let Some(node) = stack.pop() {
            match self.index.nodes[node] {
                Node::Leaf(region) => visit(region as usize),
                Node::Inner { axis, plane, high } => {
                    let axis = usize::from(axis);
                    let (low, high) = (node + 1, high as usize);
                    let margin = |child: usize| self.margins[level.min(usize::from(self.coarsest[child]))][axis];
                    if cells.high[axis] + margin(high) > plane {
                        stack.push(high);
                    }
                    if cells.low[axis] - margin(low) < plane {
                        stack.push(low);
                    }
                }
            }
        }
    }
}

/// Whether a box in half cells reaches into `cells`.
fn touches(half_cells: &IndexBox, cells: &IndexBox) -> bool {
    half_cells.intersects(&cells.refined([2; 3]))
}

/// The largest box found inside the region that lies half a cell inside its brick and in no neighbour's reach.
fn interior(
    index: &Index,
    region: &Region,
    level: usize,
    cells: &IndexBox,
    mut neighbours: Vec<Neighbour>,
) -> [[f64; 3]; 2] {
    let Some((_, brick)) = index.finest_brick(region, level) else { return Region::EMPTY.interior };
    let description = &index.hierarchy.levels()[level];
    let size = description.finest_cells();
    let brick = description.brick_at(brick).refined(size).refined([2; 3]);
    let inside = brick.grown(size.map(|cells| -cells));
    let mut interior = inside.intersection(&cells.refined([2; 3]));
    // Neighbours across a face first: what they take mostly settles those across an edge or a corner.
    neighbours.sort_by_key(|neighbour| neighbour.apart);
    for Neighbour { reach, .. } in neighbours {
        if (0..3).all(|axis| reach.low[axis] < interior.high[axis] && interior.low[axis] < reach.high[axis]) {
            interior = without(&interior, &reach);
        }
    }
    if interior.is_empty() {
        // A flat interior would promise a dual cell to a brick that is one cell thin.
        return Region::EMPTY.interior;
    }
    [interior.low, interior.high].map(|corner| corner.map(|half_cells| half_cells as f64 / 2.0))
}

/// The largest of the boxes that remain of `interior` on one side of `taken`.
fn without(interior: &IndexBox, taken: &IndexBox) -> IndexBox {
    let sides = (0..3).flat_map(|axis| {
        let (mut below, mut above) = (*interior, *interior);
        below.high[axis] = taken.low[axis].min(interior.high[axis]);
        above.low[axis] = taken.high[axis].max(interior.low[axis]);
        [below, above]
    });
    // As floats: the boxes may hold more cells than an integer can count.
    let volume = |cells: &IndexBox| cells.size().iter().map(|&side| side.max(0) as f64).product::<f64>();
    sides.max_by(|a, b| volume(a).total_cmp(&volume(b))).unwrap_or(*interior)
}
