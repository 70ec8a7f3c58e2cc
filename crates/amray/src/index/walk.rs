//! The regions along a ray, front to back.

use std::borrow::BorrowMut;

use super::{Index, Node};
use crate::hierarchy::IndexBox;

/// A ray in cells of the finest level: the point at `t` is `start + t * direction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at 0.
    pub start: [f64; 3],
    /// How far the ray goes from `t` to `t + 1`.
    pub direction: [f64; 3],
}

/// A stretch of a ray inside one region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegionSpan {
    /// The region's place in [`Index::regions`].
    pub region: usize,
    /// Where the ray enters it.
    pub enter: f64,
    /// Where the ray leaves it, at least `enter`.
    pub leave: f64,
}

/// A tree of boxes that are cut in two; a node's low child follows it directly.
pub(crate) trait Cuts {
    /// Where a node is cut: the axis, the plane in cells of the finest level, and the high child. `None` for a leaf.
    fn cut(&self, node: usize) -> Option<(usize, f64, usize)>;
}

/// A stretch of a ray inside one node of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NodeSpan {
    pub(crate) node: usize,
    pub(crate) enter: f64,
    pub(crate) leave: f64,
}

/// The leaves of a tree along a ray, in order and without gaps.
pub(crate) struct Walk<'a, T, W> {
    tree: &'a T,
    ray: Ray,
    /// Nodes that the ray comes to later, the next one last.
    waiting: W,
}

impl<'a, T: Cuts, W: BorrowMut<Vec<NodeSpan>>> Walk<'a, T, W> {
    /// Between `near` and `far`, as far as that lies in the tree's `domain`. `waiting` is memory that walks use one after
    /// the other.
    #[inline]
    pub(crate) fn new(tree: &'a T, domain: &IndexBox, ray: Ray, [near, far]: [f64; 2], mut waiting: W) -> Self {
        let nodes = waiting.borrow_mut();
        nodes.clear();
        nodes.extend(ray.clip(domain, near, far).map(|[enter, leave]| NodeSpan { node: 0, enter, leave }));
        Self { tree, ray, waiting }
    }
}

impl<T: Cuts, W: BorrowMut<Vec<NodeSpan>>> Iterator for Walk<'_, T, W> {
    type Item = NodeSpan;

    #[inline]
    fn next(&mut self) -> Option<NodeSpan> {
        let waiting = self.waiting.borrow_mut();
        let NodeSpan { mut node, enter, mut leave } = waiting.pop()?;
        while let Some((axis, plane, high)) = self.tree.cut(node) {
            let low = node + 1;
            let (start, direction) = (self.ray.start[axis], self.ray.direction[axis]);
            if direction == 0.0 {
                node = if start < plane { low } else { high };
                continue;
            }
            let cut = (plane - start) / direction;
            let (first, second) = if direction > 0.0 { (low, high) } else { (high, low) };
            if cut <= enter {
                node = second;
            } else {
                if cut < leave {
                    waiting.push(NodeSpan { node: second, enter: cut, leave });
                    leave = cut;
                }
                node = first;
            }
        }
        Some(NodeSpan { node, enter, leave })
    }
}

impl Cuts for Index {
    #[inline]
    fn cut(&self, node: usize) -> Option<(usize, f64, usize)> {
        match self.nodes[node] {
            Node::Leaf(_) => None,
            Node::Inner { axis, plane, high } => Some((usize::from(axis), plane as f64, high as usize)),
        }
    }
}

impl Index {
    /// The regions that the ray passes between `near` and `far`, in order, without gaps; holes included.
    pub fn walk(&self, ray: Ray, near: f64, far: f64) -> impl Iterator<Item = RegionSpan> + '_ {
        let walk = Walk::new(self, &self.domain, ray, [near, far], Vec::with_capacity(64));
        walk.filter_map(|NodeSpan { node, enter, leave }| match self.nodes[node] {
            Node::Leaf(region) => Some(RegionSpan { region: region as usize, enter, leave }),
            Node::Inner { .. } => None,
        })
    }
}

impl Ray {
    /// The part of the ray between `near` and `far` that lies in a box.
    fn clip(&self, cells: &IndexBox, near: f64, far: f64) -> Option<[f64; 2]> {
        let (mut enter, mut leave) = (near, far);
        for axis in 0..3 {
            let (low, high) = (cells.low[axis] as f64, cells.high[axis] as f64);
            let (start, direction) = (self.start[axis], self.direction[axis]);
            if direction == 0.0 {
                if !(low..=high).contains(&start) {
                    return None;
                }
            } else {
                let (a, b) = ((low - start) / direction, (high - start) / direction);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        (enter < leave).then_some([enter, leave])
    }
}
