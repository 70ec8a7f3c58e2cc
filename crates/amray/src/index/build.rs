//! Building the kd-tree: cut nodes at brick faces until none is left, in parallel.

use std::sync::Arc;

use rayon::prelude::*;

use super::cut::Cutter;
use super::faces::{FaceBox, Faces};
use super::{Index, Node, neighbours};
use crate::hierarchy::{Hierarchy, HierarchyWarning, IndexBox};

/// Subtrees with fewer bricks are built by one thread.
const PARALLEL_BRICKS: usize = 256;

impl Index {
    /// Builds the index of a hierarchy.
    pub fn build(hierarchy: Arc<Hierarchy>) -> Self {
        let levels = hierarchy.levels();
        let domain = levels[0].domain().refined(levels[0].finest_cells());
        let faces = Faces::new(&hierarchy, &domain);
        let builder = Builder { faces: &faces, cell_size: levels[levels.len() - 1].cell_size() };
        let mut growth = Growth::new([0; u64::BITS as usize]);
        for (number, level) in levels.iter().enumerate() {
            let bricks = level.bricks().par_iter().enumerate().map(|(place, brick)| Candidate {
                faces: faces.numbered(&brick.refined(level.finest_cells())),
                level: number as u32,
                number: (level.first_brick() + place) as u32,
            });
            growth.crossing.par_extend(bricks.with_min_len(PARALLEL_BRICKS));
        }
        builder.grow_part(&mut growth, &faces.numbered(&domain), 0, 0, 0);
        let Tree { nodes, leaves, bricks } = growth.tree;
        let improper = |warning: &HierarchyWarning| matches!(warning, HierarchyWarning::ImproperNesting { .. });
        let may_cover_partly = hierarchy.warnings().iter().any(improper);
        let mut index = Self { hierarchy, domain, nodes, regions: Vec::new(), bricks, may_cover_partly };
        index.regions = neighbours::described(&index, &leaves);
        index
    }
}

/// A brick that reaches into a node.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    /// What it fills of the node.
    pub(super) faces: FaceBox,
    pub(super) level: u32,
    /// Its place in [`Hierarchy::bricks`].
    pub(super) number: u32,
}

/// A leaf of the tree, before its surroundings are known.
pub(super) struct Leaf {
    /// In cells of the finest level.
    pub(super) cells: IndexBox,
    /// As in [`Region`](super::Region).
    pub(super) levels: u64,
    pub(super) first_brick: u32,
}

struct Builder<'a> {
    faces: &'a Faces,
    /// Of the finest level, in world units.
    cell_size: [f64; 3],
}

/// A tree while it grows.
struct Growth {
    tree: Tree,
    /// A stack of bricks with faces inside a node: those of the node that is next lie on top of its ancestors'.
    crossing: Vec<Candidate>,
    /// Per level, the brick that covers all of the node, where the node has one.
    covering: [u32; u64::BITS as usize],
    cutter: Cutter,
}

impl Builder<'_> {
    /// Appends the tree over `node`, which bricks of `levels` cover and the bricks from the place `first` on cross.
    fn grow(&self, growth: &mut Growth, node: &FaceBox, levels: u64, first: usize) {
        let cut = growth.cutter.cut(self.faces, self.cell_size, node, &growth.crossing[first..]);
        let Some((axis, face)) = cut else {
            return growth.tree.push_leaf(self.faces.cells(node), levels, &growth.covering);
        };
        let (mut below, mut above) = (*node, *node);
        below.high[axis] = face;
        above.low[axis] = face;
        let inner = growth.tree.nodes.len();
        let plane = self.faces.place(axis, face);
        growth.tree.nodes.push(Node::Inner { axis: axis as u8, plane, high: 0 });
        let high = if growth.crossing.len() - first > PARALLEL_BRICKS {
            let crossing = growth.crossing[first..].to_vec();
            let mut other = Growth { crossing, ..Growth::new(growth.covering) };
            rayon::join(
                || self.grow_part(growth, &below, axis, levels, first),
                || self.grow_part(&mut other, &above, axis, levels, 0),
            );
            growth.tree.append(other.tree)
        } else {
            self.grow_part(growth, &below, axis, levels, first);
            let high = growth.tree.nodes.len();
            self.grow_part(growth, &above, axis, levels, first);
            high
        };
        growth.tree.nodes[inner] = Node::Inner { axis: axis as u8, plane, high: high as u32 };
    }

    /// Appends the tree over a part of a node, cut across `axis`; what is said of the bricks holds for the whole node.
    fn grow_part(&self, growth: &mut Growth, part: &FaceBox, axis: usize, mut levels: u64, first: usize) {
        let end = growth.crossing.len();
        for place in first..end {
            let mut brick = growth.crossing[place];
            let (low, high) = (brick.faces.low[axis].max(part.low[axis]), brick.faces.high[axis].min(part.high[axis]));
            if low >= high {
                continue;
            }
            brick.faces.low[axis] = low;
            brick.faces.high[axis] = high;
            if brick.faces == *part {
                levels |= 1 << brick.level;
                growth.covering[brick.level as usize] = brick.number;
            } else {
                growth.crossing.push(brick);
            }
        }
        self.grow(growth, part, levels, end);
        growth.crossing.truncate(end);
    }
}

impl Growth {
    fn new(covering: [u32; u64::BITS as usize]) -> Self {
        Self { tree: Tree::default(), crossing: Vec::new(), covering, cutter: Cutter::default() }
    }
}

/// A part of the tree, its nodes, leaves and bricks numbered from 0.
#[derive(Default)]
struct Tree {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    bricks: Vec<u32>,
}

impl Tree {
    fn push_leaf(&mut self, cells: IndexBox, levels: u64, covering: &[u32; u64::BITS as usize]) {
        self.nodes.push(Node::Leaf(self.leaves.len() as u32));
        self.leaves.push(Leaf { cells, levels, first_brick: self.bricks.len() as u32 });
        let mut left = levels;
        while left != 0 {
            self.bricks.push(covering[left.trailing_zeros() as usize]);
            left &= left - 1;
        }
    }

    /// Appends another part. Returns the place of its root.
    fn append(&mut self, other: Self) -> usize {
        let (nodes, leaves, bricks) = (self.nodes.len() as u32, self.leaves.len() as u32, self.bricks.len() as u32);
        self.nodes.extend(other.nodes.into_iter().map(|node| match node {
            Node::Inner { axis, plane, high } => Node::Inner { axis, plane, high: high + nodes },
            Node::Leaf(leaf) => Node::Leaf(leaf + leaves),
        }));
        let renumbered = |leaf: Leaf| Leaf { first_brick: leaf.first_brick + bricks, ..leaf };
        self.leaves.extend(other.leaves.into_iter().map(renumbered));
        self.bricks.extend(other.bricks);
        nodes as usize
    }
}
