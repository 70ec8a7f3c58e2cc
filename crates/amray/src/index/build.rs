//! Building the kd-tree: cut nodes at brick faces until none is left, in parallel.

use std::sync::Arc;

use super::{Index, Node, Region, neighbours};
use crate::hierarchy::{Hierarchy, HierarchyWarning, IndexBox};

/// What it costs to cut all bricks of a node in two, where a face at a node's end instead of its middle costs 1. Higher
/// costs make no fewer regions; without any, there are three times as many.
const CUT_COST: f64 = 4.0;
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

    /// The face inside the node at which to cut it: one that cuts few bricks in two, near the middle of a long side.
    fn cut(&self, node: &IndexBox, crossing: &[Candidate]) -> Option<(usize, i64)> {
        let size = node.size();
        let width: [f64; 3] = std::array::from_fn(|axis| size[axis] as f64 * self.cell_size[axis]);
        let widest = width.into_iter().fold(0.0, f64::max);
        let mut best = None;
        let mut lowest = f64::INFINITY;
        for axis in 0..3 {
            let (low, high) = (node.low[axis], node.high[axis]);
            for (face, cut) in faces(crossing, axis, low, high) {
                let share = cut as f64 / crossing.len() as f64;
                let off_middle = (2 * face - low - high).abs() as f64 / size[axis] as f64;
                let cost = CUT_COST * share + off_middle + (1.0 - width[axis] / widest);
                if cost < lowest {
                    lowest = cost;
                    best = Some((axis, face));
                }
            }
        }
        best
    }
}

/// The brick faces across `axis` between `low` and `high`, each with the number of bricks that it would cut.
fn faces(crossing: &[Candidate], axis: usize, low: i64, high: i64) -> impl Iterator<Item = (i64, usize)> {
    let sorted = |corner: fn(&IndexBox) -> [i64; 3]| {
        let mut faces: Vec<i64> = crossing.iter().map(|brick| corner(&brick.cells)[axis]).collect();
        faces.sort_unstable();
        faces
    };
    let (starts, ends) = (sorted(|cells| cells.low), sorted(|cells| cells.high));
    let mut faces: Vec<i64> = starts.iter().chain(&ends).copied().filter(|&face| low < face && face < high).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.into_iter().map(move |face| {
        let begun = starts.partition_point(|&start| start < face);
        let ended = ends.partition_point(|&end| end <= face);
        (face, begun - ended)
    })
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
