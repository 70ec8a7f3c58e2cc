//! The values that samples can take, per region and node: conservative for every reconstruction.

use rayon::prelude::*;

use super::blocks::{Blocks, Cells, NOTHING};
use super::{Index, Node};
use crate::hierarchy::{Centering, Field, IndexBox, Level, Voxel, with_voxels};

/// Value ranges of a field over an index. Non-finite values do not count.
#[derive(Clone, Debug)]
pub struct ValueRanges {
    /// Per node of the tree; `[inf, -inf]` where a node has no finite value.
    nodes: Vec<[f32; 2]>,
    regions: Vec<[f32; 2]>,
}

impl ValueRanges {
    /// The ranges of `field`, which must belong to the index's hierarchy.
    pub fn build(index: &Index, field: &Field) -> Self {
        let regions: Vec<[f32; 2]> = with_voxels!(field.values(), bricks => {
            let blocks: Vec<_> = bricks.par_iter().map(Blocks::new).collect();
            let of_region = |pieces: &mut Vec<(usize, Cells)>, (region, cells): (usize, &IndexBox)| {
                match field.centering() {
                    Centering::Cells => find_pieces(index, region, cells, pieces),
                    Centering::Nodes => find_nodes(index, region, cells, pieces),
                }
                range_of(&blocks, pieces)
            };
            index.region_boxes().par_iter().enumerate().map_init(Vec::new, of_region).collect()
        });
        let mut nodes = vec![NOTHING; index.nodes.len()];
        for (place, node) in index.nodes.iter().enumerate().rev() {
            nodes[place] = match *node {
                Node::Leaf(region) => regions[region as usize],
                Node::Inner { high, .. } => {
                    let (low, high) = (nodes[place + 1], nodes[high as usize]);
                    [low[0].min(high[0]), low[1].max(high[1])]
                }
            };
        }
        Self { nodes, regions }
    }

    /// The lowest and highest value of any sample in a region; `[inf, -inf]` where there is none.
    pub fn region(&self, region: usize) -> [f32; 2] {
        self.regions[region]
    }

    /// The lowest and highest value of any sample in the domain; `[inf, -inf]` where there is none.
    pub fn whole(&self) -> [f32; 2] {
        self.nodes[0]
    }

    /// Bytes of memory that the ranges take.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes) + size_of_val(&*self.regions)) as u64
    }
}

/// Finds all cells that any reconstruction can use for a point in the region: in which bricks, and which of theirs.
///
/// From the finest level in reach down: the cells of the dual cells that the region's points can lie in. Where they
/// are all actual, no method looks at coarser levels. Where one is virtual, its value comes from coarser cells around
/// it, so the box to look at grows by it.
fn find_pieces(index: &Index, number: usize, cells: &IndexBox, pieces: &mut Vec<(usize, Cells)>) {
    pieces.clear();
    let region = &index.regions[number];
    let Some(finest) = region.finest_level() else { return };
    let coarsest_needed = region.coarsest_in_reach().min(finest);
    let mut around = *cells;
    for level in (0..=region.finest_in_reach()).rev() {
        let description = &index.hierarchy.levels()[level];
        let dual = dual_cells(description, &around);
        let mut actual = 0;
        index.for_each_piece(level, &dual, &mut |brick, piece| {
            actual += piece.cells();
            let first = description.brick_at(brick).low;
            let inside = |corner: [i64; 3]| std::array::from_fn(|axis| (corner[axis] - first[axis]) as usize);
            pieces.push((brick, [piece.low, piece.high].map(inside)));
        });
        if level <= coarsest_needed && actual == dual.cells() {
            break;
        }
        let reached = dual.refined(description.finest_cells());
        around = IndexBox {
            low: std::array::from_fn(|axis| around.low[axis].min(reached.low[axis])),
            high: std::array::from_fn(|axis| around.high[axis].max(reached.high[axis])),
        };
    }
}

/// Finds the nodes of the region's leaf cells.
fn find_nodes(index: &Index, number: usize, cells: &IndexBox, pieces: &mut Vec<(usize, Cells)>) {
    pieces.clear();
    let region = &index.regions[number];
    let Some((level, brick)) = region.finest_level().and_then(|level| index.finest_brick(region, level)) else {
        return;
    };
    let description = &index.hierarchy.levels()[level];
    let first = description.brick_at(brick).low;
    let nodes = Centering::Nodes.values_of(&cells.coarsened(description.finest_cells()));
    let inside = |corner: [i64; 3]| std::array::from_fn(|axis| (corner[axis] - first[axis]) as usize);
    pieces.push((brick, [nodes.low, nodes.high].map(inside)));
}

/// The corners of all dual cells of a level around the points of `cells` (of the finest level, closed), in the domain.
fn dual_cells(level: &Level, cells: &IndexBox) -> IndexBox {
    let size = level.finest_cells();
    let base = |corner: i64, axis: usize| (2 * corner - size[axis]).div_euclid(2 * size[axis]);
    let corners = IndexBox {
        low: std::array::from_fn(|axis| base(cells.low[axis], axis)),
        high: std::array::from_fn(|axis| base(cells.high[axis], axis) + 2),
    };
    corners.intersection(&level.domain())
}

/// The range of the cells of all `pieces`.
fn range_of<T: Voxel>(blocks: &[Blocks<T>], pieces: &[(usize, Cells)]) -> [f32; 2] {
    let mut range = NOTHING;
    // Blocks that are cut have to be looked at only where the others leave a doubt.
    for &(brick, cells) in pieces {
        blocks[brick].widen_by_whole(&mut range, cells);
    }
    for &(brick, cells) in pieces {
        blocks[brick].widen_by_cut(&mut range, cells);
    }
    range
}
