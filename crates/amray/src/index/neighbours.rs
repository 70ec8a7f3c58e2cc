//! What surrounds each region: the levels in reach of its points, and the interior where one brick is enough.

use rayon::prelude::*;

use super::{Index, Node, Region};
use crate::hierarchy::IndexBox;

/// Fills in what depends on neighbouring regions: levels in reach and interior.
pub(super) fn describe_regions(index: &mut Index) {
    let boxes = index.region_boxes();
    let coarsest = coarsest_levels(index);
    let shared: &Index = index;
    let regions: Vec<Region> =
        boxes.par_iter().enumerate().map(|(region, cells)| described(shared, &coarsest, region, cells)).collect();
    index.regions = regions;
}

/// Per node, the coarsest level that is some region's finest one: how far the regions below can reach.
fn coarsest_levels(index: &Index) -> Vec<u8> {
    let mut coarsest = vec![0; index.nodes.len()];
    // Children follow their parents.
    for (place, node) in index.nodes.iter().enumerate().rev() {
        coarsest[place] = match *node {
            Node::Leaf(region) => index.regions[region as usize].finest_level().map_or(u8::MAX, |level| level as u8),
            Node::Inner { high, .. } => coarsest[place + 1].min(coarsest[high as usize]),
        };
    }
    coarsest
}

/// A region beside the one that is described.
struct Neighbour {
    /// The space, in half cells of the finest level, in which the neighbour's cells take part.
    reach: IndexBox,
    /// On how many axes the neighbour lies beside the region, rather than along it.
    apart: usize,
}

/// The region with its surroundings.
fn described(index: &Index, coarsest: &[u8], number: usize, cells: &IndexBox) -> Region {
    let region = &index.regions[number];
    let Some(level) = region.finest_level() else { return region.clone() };
    let brick = index.finest_brick(region, level);
    let (mut coarsest_in_reach, mut finest_in_reach) = (level, level);
    let mut neighbours = Vec::new();
    for_each_neighbour(index, coarsest, level, cells, &mut |other, other_cells| {
        let other = &index.regions[other];
        let Some(other_level) = other.finest_level() else {
            return neighbours.push(neighbour(index, level, cells, &other_cells));
        };
        // Cells of the same level are met half a cell inside the brick's own faces.
        if other_level == level {
            return;
        }
        // In reach: nearer than half a cell of the neighbour's level.
        if other_level < level && touches(&reach(index, other_level, &other_cells), cells) {
            coarsest_in_reach = coarsest_in_reach.min(other_level);
        }
        for finer in (level + 1..=other_level).filter(|&finer| other.has_level(finer)) {
            if touches(&reach(index, finer, &other_cells), cells) {
                finest_in_reach = finest_in_reach.max(finer);
            }
        }
        // Whichever cells are larger: a fine neighbour covers cells of this level that a dual cell would touch.
        neighbours.push(neighbour(index, level.min(other_level), cells, &other_cells));
    });
    Region {
        coarsest_in_reach: coarsest_in_reach as u8,
        finest_in_reach: finest_in_reach as u8,
        interior: interior(index, level, brick.map(|(_, brick)| brick), cells, neighbours),
        ..region.clone()
    }
}

/// The region `other` beside `cells`, with the reach of cells of `level`.
fn neighbour(index: &Index, level: usize, cells: &IndexBox, other: &IndexBox) -> Neighbour {
    let apart = (0..3).filter(|&axis| other.high[axis] <= cells.low[axis] || cells.high[axis] <= other.low[axis]);
    Neighbour { reach: reach(index, level, other), apart: apart.count() }
}

/// A region's `cells` (of the finest level) grown by half a cell of `level`, in half cells of the finest level.
fn reach(index: &Index, level: usize, cells: &IndexBox) -> IndexBox {
    let size = index.hierarchy.levels()[level].finest_cells();
    // A region's leaf cells fill its box or go on in a region of the same brick, unless one is covered in part.
    let whole = if index.may_cover_partly { cells.coarsened(size).refined(size) } else { *cells };
    IndexBox {
        low: std::array::from_fn(|axis| 2 * whole.low[axis] - size[axis]),
        high: std::array::from_fn(|axis| 2 * whole.high[axis] + size[axis]),
    }
}

/// Whether a box in half cells reaches into `cells`.
fn touches(half_cells: &IndexBox, cells: &IndexBox) -> bool {
    half_cells.intersects(&cells.refined([2; 3]))
}

/// Calls `visit` with every other region that may lie within half a cell (of the coarser of the two levels) of `cells`.
fn for_each_neighbour(
    index: &Index,
    coarsest: &[u8],
    level: usize,
    cells: &IndexBox,
    visit: &mut impl FnMut(usize, IndexBox),
) {
    let levels = index.hierarchy.levels();
    // Half a cell, and where a cell may be covered in part up to one more by which a region falls short of its cells.
    let halves = if index.may_cover_partly { 3 } else { 1 };
    let mut stack = vec![(0usize, index.domain)];
    while let Some((node, node_cells)) = stack.pop() {
        let size = levels[level.min(usize::from(coarsest[node]))].finest_cells();
        let margin = size.map(|cells| (halves * cells + 1) / 2);
        let near = IndexBox {
            low: std::array::from_fn(|axis| node_cells.low[axis] - margin[axis]),
            high: std::array::from_fn(|axis| node_cells.high[axis] + margin[axis]),
        };
        if !near.intersects(cells) {
            continue;
        }
        match index.nodes[node] {
            Node::Leaf(_) if node_cells == *cells => {}
            Node::Leaf(region) => visit(region as usize, node_cells),
            Node::Inner { axis, plane, high } => {
                let (mut below, mut above) = (node_cells, node_cells);
                below.high[usize::from(axis)] = plane;
                above.low[usize::from(axis)] = plane;
                stack.push((high as usize, above));
                stack.push((node + 1, below));
            }
        }
    }
}

/// The largest box found inside the region that lies half a cell inside its brick and in no neighbour's reach.
fn interior(
    index: &Index,
    level: usize,
    brick: Option<usize>,
    cells: &IndexBox,
    mut neighbours: Vec<Neighbour>,
) -> [[f64; 3]; 2] {
    let Some(brick) = brick else { return Region::EMPTY.interior };
    let description = &index.hierarchy.levels()[level];
    let size = description.finest_cells();
    let brick = description.brick_at(brick).refined(size).refined([2; 3]);
    let inside = IndexBox {
        low: std::array::from_fn(|axis| brick.low[axis] + size[axis]),
        high: std::array::from_fn(|axis| brick.high[axis] - size[axis]),
    };
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
