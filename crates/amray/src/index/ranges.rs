//! The values that samples can take, per region and node: conservative for every reconstruction.

use rayon::prelude::*;

use super::{Index, Node};
use crate::hierarchy::{BrickValues, Field, IndexBox, Voxel, with_voxels};

/// Value ranges of a field over an index. Non-finite values do not count.
#[derive(Clone, Debug)]
pub struct ValueRanges {
    /// Per node of the tree; `[inf, -inf]` where a node has no finite value.
    nodes: Vec<[f32; 2]>,
    regions: Vec<[f32; 2]>,
}

const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

impl ValueRanges {
    /// The ranges of `field`, which must belong to the index's hierarchy.
    pub fn build(index: &Index, field: &Field) -> Self {
        let regions: Vec<[f32; 2]> = with_voxels!(field.values(), bricks => index
            .region_boxes()
            .par_iter()
            .enumerate()
            .map(|(region, cells)| outward(region_range(index, bricks, region, cells)))
            .collect());
        let mut nodes = vec![outward(NOTHING); index.nodes.len()];
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

/// The range of all cells that any reconstruction can use for a point in the region.
///
/// From the finest level in reach down: the cells of the dual cells that the region's points can lie in. Where they
/// are all actual, no method looks at coarser levels. Where one is virtual, its value comes from coarser cells around
/// it, so the box to look at grows by it.
fn region_range<T: Voxel>(index: &Index, bricks: &[BrickValues<T>], number: usize, cells: &IndexBox) -> [f64; 2] {
    let region = &index.regions[number];
    let Some(finest) = region.finest_level() else { return NOTHING };
    let coarsest_needed = region.coarsest_in_reach().min(finest);
    let mut range = NOTHING;
    let mut around = *cells;
    for level in (0..=region.finest_in_reach()).rev() {
        let dual = dual_cells(index, level, &around);
        let mut actual = 0;
        index.for_each_piece(level, &dual, &mut |brick, piece| {
            actual += piece.cells();
            widen(&mut range, index, bricks, level, brick, &piece);
        });
        if level <= coarsest_needed && actual == dual.cells() {
            break;
        }
        let reached = dual.refined(index.hierarchy.levels()[level].finest_cells());
        around = IndexBox {
            low: std::array::from_fn(|axis| around.low[axis].min(reached.low[axis])),
            high: std::array::from_fn(|axis| around.high[axis].max(reached.high[axis])),
        };
    }
    range
}

/// The corners of all dual cells of `level` around the points of `cells` (of the finest level, closed), in the domain.
fn dual_cells(index: &Index, level: usize, cells: &IndexBox) -> IndexBox {
    let description = &index.hierarchy.levels()[level];
    let size = description.finest_cells();
    let base = |corner: i64, axis: usize| (2 * corner - size[axis]).div_euclid(2 * size[axis]);
    let corners = IndexBox {
        low: std::array::from_fn(|axis| base(cells.low[axis], axis)),
        high: std::array::from_fn(|axis| base(cells.high[axis], axis) + 2),
    };
    corners.intersection(&description.domain())
}

fn widen<T: Voxel>(
    range: &mut [f64; 2],
    index: &Index,
    bricks: &[BrickValues<T>],
    level: usize,
    brick: usize,
    piece: &IndexBox,
) {
    let low = index.hierarchy.levels()[level].brick_at(brick).low;
    bricks[brick].for_each_in(low, piece, |value| {
        let value = value.to_f64();
        if value.is_finite() {
            range[0] = range[0].min(value);
            range[1] = range[1].max(value);
        }
    });
}

/// The range in f32, rounded outward.
fn outward([low, high]: [f64; 2]) -> [f32; 2] {
    let (mut near_low, mut near_high) = (low as f32, high as f32);
    if f64::from(near_low) > low {
        near_low = near_low.next_down();
    }
    if f64::from(near_high) < high {
        near_high = near_high.next_up();
    }
    [near_low, near_high]
}
