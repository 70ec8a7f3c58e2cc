//! Sixteen points go down the tree together: a node is read once for all that pass it, and where they part, one side
//! waits on a short stack with the lanes that go there.

use fearless_simd::prelude::*;

use super::{Index, Node};
use crate::simd::{Gather, Integers, LANES, LaneSet, lanes_of};

/// Cells of the finest level, one a lane and axis, counted from the domain's low corner.
pub(crate) type PacketCells<S> = [Integers<S>; 3];

/// A visit to the region of each point of a packet.
pub(crate) struct PointDescent {
    /// Nodes and the lanes that go there. No lane waits twice.
    waiting: [(u32, LaneSet); LANES],
    count: usize,
}

impl PointDescent {
    /// The descent of `lanes`, of which there must be some.
    #[inline(always)]
    pub(crate) fn new(lanes: LaneSet) -> Self {
        let mut waiting = [(0, 0); LANES];
        waiting[0].1 = lanes;
        Self { waiting, count: 1 }
    }

    /// The next region and the lanes whose cells lie in it.
    #[inline(always)]
    pub(crate) fn next<S: Gather>(
        &mut self,
        simd: S,
        index: &Index,
        cells: &PacketCells<S>,
    ) -> Option<(usize, LaneSet)> {
        self.count = self.count.checked_sub(1)?;
        let (mut node, mut lanes) = self.waiting[self.count];
        loop {
            match index.nodes[node as usize] {
                Node::Leaf(region) => return Some((region as usize, lanes)),
                Node::Inner { axis, plane, high } => {
                    let axis = usize::from(axis);
                    let below = lanes & index.below(simd, cells[axis], axis, plane);
                    if below == lanes {
                        node += 1;
                    } else if below == 0 {
                        node = high;
                    } else {
                        self.waiting[self.count] = (high, lanes & !below);
                        self.count += 1;
                        lanes = below;
                        node += 1;
                    }
                }
            }
        }
    }
}

/// The lanes that look at the low and at the high plane of cells across each axis. A lane looks at the corners where
/// three of its planes meet; it looks at planes across all axes or at none.
#[derive(Clone, Copy, Default)]
pub(crate) struct PlaneLanes(pub(crate) [[LaneSet; 2]; 3]);

impl PlaneLanes {
    /// The lanes that look at each corner (x + 2 y + 4 z, 0 low and 1 high per axis).
    #[inline(always)]
    pub(crate) fn corners(&self) -> [LaneSet; 8] {
        let [x, y, z] = self.0;
        let mut corners = [0; 8];
        for (corner, lanes) in corners.iter_mut().enumerate() {
            *lanes = x[corner & 1] & y[corner >> 1 & 1] & z[corner >> 2];
        }
        corners
    }

    /// The lanes that look at any corner.
    #[inline(always)]
    pub(crate) fn lanes(&self) -> LaneSet {
        self.0[0][0] | self.0[0][1]
    }

    /// The same with other planes across `axis`.
    #[inline(always)]
    fn with(mut self, axis: usize, planes: [LaneSet; 2]) -> Self {
        let alive = planes[0] | planes[1];
        for lanes in self.0.as_flattened_mut() {
            *lanes &= alive;
        }
        self.0[axis] = planes;
        self
    }
}

/// A visit to the regions of a packet's dual cells: six planes a lane, whose eight crossings go down together.
pub(crate) struct DualDescent {
    /// Nodes and the planes that reach there. No corner of a lane waits twice.
    waiting: [(u32, PlaneLanes); 8 * LANES],
    count: usize,
}

impl DualDescent {
    /// The descent of the planes that each lane looks at.
    #[inline(always)]
    pub(crate) fn new(planes: PlaneLanes) -> Self {
        let mut waiting = [(0, PlaneLanes::default()); 8 * LANES];
        waiting[0].1 = planes;
        Self { waiting, count: 1 }
    }

    /// The next region and the planes whose crossings with others lie in it. `centers` holds where the low and the high
    /// plane run, in cells of the finest level from the domain's low corner on.
    #[inline(always)]
    pub(crate) fn next<S: Gather>(
        &mut self,
        simd: S,
        index: &Index,
        centers: &[[Integers<S>; 2]; 3],
    ) -> Option<(usize, PlaneLanes)> {
        self.count = self.count.checked_sub(1)?;
        let (mut node, mut planes) = self.waiting[self.count];
        loop {
            match index.nodes[node as usize] {
                Node::Leaf(region) => return Some((region as usize, planes)),
                Node::Inner { axis, plane, high } => {
                    let axis = usize::from(axis);
                    let [low_plane, high_plane] = planes.0[axis];
                    let low_below = low_plane & index.below(simd, centers[axis][0], axis, plane);
                    let high_below = high_plane & index.below(simd, centers[axis][1], axis, plane);
                    let above = [low_plane & !low_below, high_plane & !high_below];
                    if above == [0; 2] {
                        node += 1;
                    } else if low_below | high_below == 0 {
                        node = high;
                    } else {
                        self.waiting[self.count] = (high, planes.with(axis, above));
                        self.count += 1;
                        planes = planes.with(axis, [low_below, high_below]);
                        node += 1;
                    }
                }
            }
        }
    }
}

impl Index {
    /// Whether packets can go down the tree: half cells are counted in 32 bits.
    pub(crate) fn fits_packets(&self) -> bool {
        self.domain.size().iter().all(|&cells| 2 * cells <= i64::from(i32::MAX))
    }

    /// The lanes that lie below a node's plane.
    #[inline(always)]
    fn below<S: Gather>(&self, simd: S, cells: Integers<S>, axis: usize, plane: i64) -> LaneSet {
        let plane = (plane - self.domain.low[axis]) as i32;
        lanes_of(cells.simd_lt(Integers::splat(simd, plane)))
    }
}
