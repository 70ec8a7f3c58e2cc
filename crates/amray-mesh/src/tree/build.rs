//! From triangles to the tree: the box with the largest surface is cut in two until there are four; and so on in each.
//!
//! Cuts follow the surface area heuristic. Where that finds none (many triangles at one place) or has made paths long
//! (triangles that are each half as large as the one before), the larger half is halved instead: so no input makes the
//! tree deep.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::bins::Cut;
use super::{Bounds, Child, DEPTH, LEAF, Node, Tree, WIDTH};

/// From this depth on sets are halved: two cuts a node, so at most 2^32 triangles take 15 nodes down to a leaf's, and
/// one more as halves are rounded.
const HEURISTIC_DEPTH: usize = DEPTH - 16;
/// Sets with fewer triangles than this are not worth a task of their own.
const TASK: usize = 4096;

/// A triangle to sort into the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Primitive {
    pub(crate) bounds: Bounds,
    pub(crate) triangle: u32,
}

/// A part of the tree that is not yet in its place.
#[derive(Debug)]
enum Branch {
    Leaf { triangles: usize },
    Node(Vec<(Bounds, Branch)>),
}

/// Triangles of a node to be, and the box around them.
#[derive(Debug)]
struct Part<'a> {
    primitives: &'a mut [Primitive],
    bounds: Bounds,
}

/// Builds the tree, and sorts the triangles into its order.
pub(crate) fn build(primitives: &mut [Primitive]) -> Tree {
    let mut tree = Tree::default();
    if !primitives.is_empty() {
        let children = divide(Part::new(primitives), 0);
        tree.place(&children, &mut 0);
    }
    tree
}

/// The children of a node with the triangles of `part`.
fn divide(part: Part<'_>, depth: usize) -> Vec<(Bounds, Branch)> {
    let by_heuristic = depth < HEURISTIC_DEPTH;
    let triangles = part.primitives.len();
    let mut parts = vec![part];
    while parts.len() < WIDTH {
        let divisible = (0..parts.len()).filter(|&index| parts[index].primitives.len() > LEAF);
        let Some(largest) = divisible.max_by(|&a, &b| parts[a].compare(&parts[b], by_heuristic)) else { break };
        let halves = parts.remove(largest).cut(by_heuristic);
        // In the order of their triangles.
        parts.splice(largest..largest, halves);
    }
    let branch = |part: Part<'_>| {
        let bounds = part.bounds;
        match part.primitives.len() {
            triangles @ ..=LEAF => (bounds, Branch::Leaf { triangles }),
            _ => (bounds, Branch::Node(divide(part, depth + 1))),
        }
    };
    match triangles < TASK {
        true => parts.into_iter().map(branch).collect(),
        false => parts.into_par_iter().with_max_len(1).map(branch).collect(),
    }
}

impl<'a> Part<'a> {
    fn new(primitives: &'a mut [Primitive]) -> Self {
        let mut bounds = Bounds::EMPTY;
        primitives.iter().for_each(|primitive| bounds.include(&primitive.bounds));
        Self { primitives, bounds }
    }

    /// Which of two parts to cut first: by surface, and by the number of triangles where that is the same or does not
    /// matter.
    fn compare(&self, other: &Self, by_heuristic: bool) -> Ordering {
        let by_count = self.primitives.len().cmp(&other.primitives.len());
        match by_heuristic {
            true => self.bounds.half_area().total_cmp(&other.bounds.half_area()).then(by_count),
            false => by_count,
        }
    }

    /// Two parts, neither of them empty.
    fn cut(self, by_heuristic: bool) -> [Self; 2] {
        let primitives = self.primitives;
        let mut twice_centers = Bounds::EMPTY;
        for Primitive { bounds, .. } in primitives.iter() {
            let twice_center = [0, 1, 2].map(|axis| bounds.twice_center(axis));
            twice_centers.include(&Bounds { low: twice_center, high: twice_center });
        }
        let cut = if by_heuristic { Cut::best(primitives, &twice_centers) } else { None };
        let middle = match cut {
            Some(cut) => partition(primitives, |primitive| cut.is_below(primitive)),
            None => halve(primitives, &twice_centers),
        };
        let (below, above) = primitives.split_at_mut(middle);
        [Self::new(below), Self::new(above)]
    }
}

/// Moves those that are `below` to the front, and counts them.
fn partition(primitives: &mut [Primitive], below: impl Fn(&Primitive) -> bool) -> usize {
    let mut middle = 0;
    for index in 0..primitives.len() {
        if below(&primitives[index]) {
            primitives.swap(middle, index);
            middle += 1;
        }
    }
    middle
}

/// Moves the lower half on the widest axis to the front, and says where it ends.
fn halve(primitives: &mut [Primitive], twice_centers: &Bounds) -> usize {
    let width = |axis: &usize| twice_centers.high[*axis] - twice_centers.low[*axis];
    let axis = (0..3).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let middle = primitives.len() / 2;
    let center = |primitive: &Primitive| primitive.bounds.twice_center(axis);
    primitives.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)));
    middle
}

impl Tree {
    /// Adds a node and all below it, and says where it is. `first` is the first triangle that is not placed yet.
    fn place(&mut self, children: &[(Bounds, Branch)], first: &mut u32) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        for (lane, (bounds, branch)) in children.iter().enumerate() {
            let child = match branch {
                Branch::Leaf { triangles } => {
                    let child = Child { first: *first, triangles: *triangles as u32 };
                    *first += child.triangles;
                    child
                }
                Branch::Node(children) => Child { first: self.place(children, first), triangles: 0 },
            };
            self.nodes[index].set(lane, bounds, child);
        }
        index as u32
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn boxes(corners: impl IntoIterator<Item = [[f32; 3]; 2]>) -> Vec<Primitive> {
        let primitive = |(triangle, corners): (usize, [[f32; 3]; 2])| Primitive {
            bounds: Bounds::around(&corners),
            triangle: triangle as u32,
        };
        corners.into_iter().enumerate().map(primitive).collect()
    }

    /// Builds the tree and checks that every triangle is in one leaf and in all boxes above it; the depth.
    fn checked_depth(mut primitives: Vec<Primitive>) -> usize {
        let tree = build(&mut primitives);
        let mut seen = vec![false; primitives.len()];
        primitives
            .iter()
            .for_each(|primitive| assert!(!std::mem::replace(&mut seen[primitive.triangle as usize], true)));
        let mut next = 0;
        let depth = check(&tree, 0, &primitives, &mut next);
        assert_eq!(next, primitives.len());
        assert!(depth <= DEPTH);
        depth
    }

    fn check(tree: &Tree, node: usize, primitives: &[Primitive], next: &mut usize) -> usize {
        let node = &tree.nodes[node];
        let mut depth = 0;
        for lane in 0..WIDTH {
            let Child { first, triangles } = node.children[lane];
            let from = *next;
            if triangles > 0 {
                assert_eq!(first as usize, from);
                assert!(triangles as usize <= LEAF);
                *next += triangles as usize;
            } else if first > 0 {
                depth = depth.max(check(tree, first as usize, primitives, next));
            }
            for primitive in &primitives[from..*next] {
                for axis in 0..3 {
                    assert!(node.low[axis][lane] < primitive.bounds.low[axis]);
                    assert!(node.high[axis][lane] > primitive.bounds.high[axis]);
                }
            }
        }
        depth + 1
    }

    #[test]
    fn a_node_is_two_lines_of_the_cache() {
        assert_eq!(size_of::<Node>(), 128);
    }

    #[test]
    fn many_boxes_at_one_place_make_a_low_tree() {
        assert!(checked_depth(boxes(vec![[[0.0; 3], [0.5; 3]]; 100_000])) <= 9);
    }

    #[test]
    fn boxes_within_boxes_make_a_bounded_tree() {
        let nested = |count: i32| (0..count).map(|power| [[0.0; 3], [0.5f32.powi(power / 8); 3]]);
        checked_depth(boxes(nested(8 * 150)));
        let apart = |count: i32| (0..count).map(|power| [[0.5f32.powi(power / 64); 3]; 2]);
        checked_depth(boxes(apart(64 * 150)));
    }

    /// The heuristic cuts off one at a time: the others are all in the first bin.
    #[test]
    fn long_paths_end_in_halves() {
        let along = |axis: usize, length: f32| [0, 1, 2].map(|other| if other == axis { length } else { 0.0 });
        let needles = |power: i32| [0, 1, 2].map(|axis| [[0.0; 3], along(axis, 17f32.powi(-power))]);
        let depth = checked_depth(boxes((0..30).flat_map(needles)));
        assert!(depth > HEURISTIC_DEPTH && depth <= HEURISTIC_DEPTH + 3, "{depth}");
    }

    proptest! {
        #[test]
        fn any_boxes_are_in_their_place(
            corners in prop::collection::vec(prop::array::uniform2(prop::array::uniform3(-1f32..1.0)), 1..600)
        ) {
            checked_depth(boxes(corners));
        }
    }
}
