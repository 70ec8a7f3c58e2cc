//! Building the kd-tree: cut nodes at brick faces until none is left, in parallel.

use std::sync::Arc;

use super::{Index, Node, Region, neighbours};
use crate::hierarchy::{Hierarchy, HierarchyWarning, IndexBox};

/// Subtrees with fewer bricks are built by one thread.
const PARALLEL_BRICKS: usize = 1024;

impl Index {
    /// Builds the index of a hierarchy.
    pub fn build(hierarchy: Arc<Hierarchy>) -> Self {
        let levels = hierarchy.levels();
        let domain = levels[0].domain().refined(levels[0].finest_cells());
        let bricks: Vec<Candidate> = hierarchy
            .bricks()
            .enumerate()
            .map(|(number, brick)| Candidate {
                cells: brick.cells.refined(levels[brick.level].finest_cells()),
                number: number as u32,
                level: brick.level as u8,
            })
            .collect();
        let builder = Builder { cell_size: levels[levels.len() - 1].cell_size() };
        let mut tree = Tree::default();
        builder.grow(&mut tree, domain, bricks, Vec::new());
        let Tree { nodes, regions, bricks } = tree;
        let improper = |warning: &HierarchyWarning| matches!(warning, HierarchyWarning::ImproperNesting { .. });
        let may_cover_partly = hierarchy.warnings().iter().any(improper);
        let mut index = Self { hierarchy, domain, nodes, regions, bricks, may_cover_partly };
        neighbours::describe_regions(&mut index);
        index
    }
}

/// A brick that reaches into a node.
#[derive(Clone, Copy)]
struct Candidate {
    /// Its cells, in cells of the finest level.
    cells: IndexBox,
    number: u32,
    level: u8,
}

struct Builder {
    /// Of the finest level, in world units: which axis is widest is a question of the world.
    cell_size: [f64; 3],
}

impl Builder {
    /// Appends the tree over `node` to `tree`: cut by the faces of `crossing`; the `covering` bricks cover all of it.
    fn grow(&self, tree: &mut Tree, node: IndexBox, mut crossing: Vec<Candidate>, mut covering: Vec<Candidate>) {
        crossing.retain(|brick| {
            let covers = brick.cells.contains_box(&node);
            if covers {
                covering.push(*brick);
            }
            !covers
        });
        let Some((axis, plane)) = self.cut(&node, &crossing) else {
            return tree.push_region(covering);
        };
        let (mut below, mut above) = (node, node);
        below.high[axis] = plane;
        above.low[axis] = plane;
        let parallel = crossing.len() > PARALLEL_BRICKS;
        let low: Vec<_> = crossing.iter().copied().filter(|brick| brick.cells.low[axis] < plane).collect();
        crossing.retain(|brick| brick.cells.high[axis] > plane);
        let also_covering = covering.clone();
        let inner = tree.nodes.len();
        tree.nodes.push(Node::Inner { axis: axis as u8, plane, high: 0 });
        let high = if parallel {
            let (mut low_tree, mut high_tree) = (Tree::default(), Tree::default());
            rayon::join(
                || self.grow(&mut low_tree, below, low, covering),
                || self.grow(&mut high_tree, above, crossing, also_covering),
            );
            tree.append(low_tree);
            let high = tree.nodes.len();
            tree.append(high_tree);
            high
        } else {
            self.grow(tree, below, low, covering);
            let high = tree.nodes.len();
            self.grow(tree, above, crossing, also_covering);
            high
        };
        tree.nodes[inner] = Node::Inner { axis: axis as u8, plane, high: high as u32 };
    }

    /// The face nearest to the node's middle on the widest axis that has a face inside the node.
    fn cut(&self, node: &IndexBox, crossing: &[Candidate]) -> Option<(usize, i64)> {
        let size = node.size();
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| (size[b] as f64 * self.cell_size[b]).total_cmp(&(size[a] as f64 * self.cell_size[a])));
        axes.into_iter().find_map(|axis| {
            let (low, high) = (node.low[axis], node.high[axis]);
            crossing
                .iter()
                .flat_map(|brick| [brick.cells.low[axis], brick.cells.high[axis]])
                .filter(|&face| low < face && face < high)
                .min_by_key(|&face| (2 * face - low - high).unsigned_abs())
                .map(|face| (axis, face))
        })
    }
}

/// A part of the tree, its nodes, regions and bricks numbered from 0.
#[derive(Default)]
struct Tree {
    nodes: Vec<Node>,
    regions: Vec<Region>,
    bricks: Vec<u32>,
}

impl Tree {
    fn push_region(&mut self, mut covering: Vec<Candidate>) {
        covering.sort_unstable_by_key(|brick| brick.level);
        self.nodes.push(Node::Leaf(self.regions.len() as u32));
        self.regions.push(Region {
            levels: covering.iter().fold(0, |levels, brick| levels | 1 << brick.level),
            first_brick: self.bricks.len() as u32,
            ..Region::EMPTY
        });
        self.bricks.extend(covering.iter().map(|brick| brick.number));
    }

    fn append(&mut self, other: Self) {
        let (nodes, regions, bricks) = (self.nodes.len() as u32, self.regions.len() as u32, self.bricks.len() as u32);
        self.nodes.extend(other.nodes.into_iter().map(|node| match node {
            Node::Inner { axis, plane, high } => Node::Inner { axis, plane, high: high + nodes },
            Node::Leaf(region) => Node::Leaf(region + regions),
        }));
        let renumbered = |region: Region| Region { first_brick: region.first_brick + bricks, ..region };
        self.regions.extend(other.regions.into_iter().map(renumbered));
        self.bricks.extend(other.bricks);
    }
}
