//! Where things are: the kd-tree over brick faces (section 5.1 of the paper), its regions, and value ranges.
//!
//! The tree cuts the domain at brick faces until no brick's face crosses a node: inside such a leaf, a [`Region`], each
//! level is either one brick or nothing, so one descent answers every question about a place. All comparisons are of
//! integer cell indices of the finest level.

mod blocks;
mod build;
mod cut;
mod faces;
mod interior;
mod leaf_cells;
mod neighbours;
mod packet;
mod query;
mod ranges;
mod walk;

use std::sync::Arc;

use crate::hierarchy::{Hierarchy, IndexBox};

pub(crate) use interior::{Neighbour, out_of_reach};
pub(crate) use packet::{DualDescent, PacketCells, PlaneLanes, PointDescent};
pub use query::{Found, Planes};
pub use ranges::ValueRanges;
pub(crate) use walk::{Cuts, NodeSpan, Walk};
pub use walk::{Ray, RegionSpan};

/// The kd-tree over a hierarchy's brick faces. It holds no values and serves every field of its hierarchy.
#[derive(Clone, Debug)]
pub struct Index {
    hierarchy: Arc<Hierarchy>,
    /// The domain in cells of the finest level: the box of the root.
    domain: IndexBox,
    nodes: Vec<Node>,
    regions: Vec<Region>,
    /// The regions' bricks, one list after the other, each from coarse to fine.
    bricks: Vec<u32>,
    /// Whether a cell may be covered in part: possible only under bricks that stick out of the next coarser level.
    may_cover_partly: bool,
}

/// A node of the tree; a node's low child follows it directly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Node {
    /// Cuts its box across `axis` at the low face of the finest level's cells `plane`.
    Inner { axis: u8, plane: i64, high: u32 },
    /// The place of the region in [`Index::regions`].
    Leaf(u32),
}

/// A leaf of the kd-tree: a box in which the finest brick, and each coarser one, does not change.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Bit `l` is set where a brick of level `l` covers the region.
    levels: u64,
    /// The place of the region's coarsest brick in [`Index::bricks`].
    first_brick: u32,
    coarsest_in_reach: u8,
    finest_in_reach: u8,
    interior: [[f64; 3]; 2],
}

impl Region {
    /// A hole whose surroundings are not known yet.
    const EMPTY: Self =
        Self { levels: 0, first_brick: 0, coarsest_in_reach: 0, finest_in_reach: 0, interior: [[0.0; 3], [-1.0; 3]] };

    /// The finest level with cells in the region: that of its leaf cells. `None` in a hole.
    #[inline]
    pub fn finest_level(&self) -> Option<usize> {
        self.levels.checked_ilog2().map(|level| level as usize)
    }

    /// Whether a brick of `level` covers the region.
    #[inline]
    pub fn has_level(&self, level: usize) -> bool {
        (self.levels >> level) & 1 == 1
    }

    /// The coarsest level that has leaf cells in reach of a point in the region: nearer than half a cell width.
    pub fn coarsest_in_reach(&self) -> usize {
        usize::from(self.coarsest_in_reach)
    }

    /// The finest level that has cells in reach of a point in the region.
    pub fn finest_in_reach(&self) -> usize {
        usize::from(self.finest_in_reach)
    }

    /// The low and high corner, in cells of the finest level, of a box inside the region in which the eight corners
    /// of the leaf level's dual cell all lie in the region's finest brick and no cell of another brick is in reach:
    /// every reconstruction is trilinear there, but `nearest`, and `finest` where finer levels exist elsewhere.
    /// `high < low` where there is no such box.
    pub fn interior(&self) -> [[f64; 3]; 2] {
        self.interior
    }

    /// Whether the point (in cells of the finest level) lies in the [`interior`](Self::interior). Its high faces belong
    /// to the dual cells that lie beyond them.
    #[inline]
    pub fn is_interior(&self, point: [f64; 3]) -> bool {
        let [low, high] = &self.interior;
        (0..3).all(|axis| low[axis] <= point[axis] && point[axis] < high[axis])
    }
}

impl Index {
    /// The hierarchy that the index describes.
    pub fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    /// The domain in cells of the finest level.
    pub fn domain(&self) -> IndexBox {
        self.domain
    }

    /// The nodes of the tree, the root first.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Whether finer bricks may cover a cell in part.
    pub(crate) fn may_cover_partly(&self) -> bool {
        self.may_cover_partly
    }

    /// The regions; together they fill the domain.
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// The finest brick of `region` on `level` or a coarser one, as (level, place in [`Hierarchy::bricks`]).
    #[inline]
    pub fn finest_brick(&self, region: &Region, level: usize) -> Option<(usize, usize)> {
        // Shifting twice keeps level 63 from overflowing.
        let up_to = region.levels & !(!1u64 << level);
        let found = up_to.checked_ilog2()?;
        let place = region.first_brick + up_to.count_ones() - 1;
        Some((found as usize, self.bricks[place as usize] as usize))
    }

    /// Bytes of memory that the index takes, its hierarchy not counted.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes) + size_of_val(&*self.regions) + size_of_val(&*self.bricks)) as u64
    }

    /// The regions' boxes, in cells of the finest level.
    pub fn region_boxes(&self) -> Vec<IndexBox> {
        let mut boxes = vec![self.domain; self.regions.len()];
        self.for_each_region(&mut |region, cells| boxes[region] = cells);
        boxes
    }

    /// Calls `visit` with every region's number and box (in cells of the finest level).
    pub fn for_each_region(&self, visit: &mut impl FnMut(usize, IndexBox)) {
        self.for_each_region_in(&self.domain, visit);
    }

    /// Calls `visit` with every region that shares cells with `cells`, and with the shared ones (both in cells of the
    /// finest level).
    pub fn for_each_region_in(&self, cells: &IndexBox, visit: &mut impl FnMut(usize, IndexBox)) {
        let shared = cells.intersection(&self.domain);
        if !shared.is_empty() {
            self.visit_below(0, shared, visit);
        }
    }

    fn visit_below(&self, node: usize, cells: IndexBox, visit: &mut impl FnMut(usize, IndexBox)) {
        match self.nodes[node] {
            Node::Leaf(region) => visit(region as usize, cells),
            Node::Inner { axis, plane, high } => {
                let axis = usize::from(axis);
                if cells.low[axis] < plane {
                    let mut below = cells;
                    below.high[axis] = below.high[axis].min(plane);
                    self.visit_below(node + 1, below, visit);
                }
                if cells.high[axis] > plane {
                    let mut above = cells;
                    above.low[axis] = above.low[axis].max(plane);
                    self.visit_below(high as usize, above, visit);
                }
            }
        }
    }

    /// Calls `visit` with every piece of a brick of `level` inside `cells` (both in cells of that level): the brick's
    /// place in [`Hierarchy::bricks`] and the piece. The pieces do not overlap.
    pub fn for_each_piece(&self, level: usize, cells: &IndexBox, visit: &mut impl FnMut(usize, IndexBox)) {
        let description = &self.hierarchy.levels()[level];
        let shared = cells.refined(description.finest_cells()).intersection(&self.domain);
        let mut bricks = Vec::new();
        if !shared.is_empty() {
            self.collect_bricks(0, level, &shared, &mut bricks);
        }
        // A brick that several regions show is one piece.
        bricks.sort_unstable();
        bricks.dedup();
        for brick in bricks {
            visit(brick, description.brick_at(brick).intersection(cells));
        }
    }

    /// Appends the bricks of `level` below `node` that share cells with `cells` (of the finest level), some repeatedly.
    fn collect_bricks(&self, mut node: usize, level: usize, cells: &IndexBox, bricks: &mut Vec<usize>) {
        loop {
            match self.nodes[node] {
                Node::Leaf(region) => {
                    let region = &self.regions[region as usize];
                    if region.has_level(level) {
                        bricks.extend(self.finest_brick(region, level).map(|(_, brick)| brick));
                    }
                    return;
                }
                Node::Inner { axis, plane, high } => {
                    let (into_low, into_high) =
                        (cells.low[usize::from(axis)] < plane, cells.high[usize::from(axis)] > plane);
                    if into_low & into_high {
                        self.collect_bricks(node + 1, level, cells, bricks);
                    }
                    // The last side is gone down without recursion.
                    node = if into_high { high as usize } else { node + 1 };
                }
            }
        }
    }
}
