//! A tree of boxes over triangles, four to a node: which triangles can a ray meet?
//!
//! Boxes are in single precision and a little wider than what they hold, by more than all rounding on the way to a
//! box's distance: a box is never missed by a ray that meets something in it.

mod bins;
mod bounds;
mod build;

use std::ops::Range;

use crate::local_ray::{LocalRay, Slabs};

pub(crate) use bounds::Bounds;
pub(crate) use build::{Primitive, build};

/// Children of a node: as many as fit into the narrowest vector registers.
const WIDTH: usize = 4;
/// Triangles that are tested without a further node, at most.
const LEAF: usize = 4;
/// No path from the root goes through more nodes; [`build`] sees to it.
const DEPTH: usize = 40;
/// On the way down each node leaves all its children but one for later.
const STACK: usize = DEPTH * (WIDTH - 1) + 1;
/// By how much boxes are wider than what they hold, on each side. Positions are between -1 and 1: the ray's origin and
/// the box are off by a rounding (2^-24) each, their difference, at most 2, by 2^-23, and the direction, its inverse
/// and the product by 2^-24 of 2 each: less than 2^-21 together. The distance that boxes are compared with, at most 4,
/// is off by 2^-22. This is twice as much.
const MARGIN: f32 = 1.0 / (1 << 19) as f32;

/// The nodes, the root first. Without triangles there is none.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

/// Four boxes and what is in them: two lines of the cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Node {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
    children: [Child; WIDTH],
}

/// What is in a box.
#[derive(Clone, Copy, Debug, Default)]
struct Child {
    /// The first triangle, or where there are none the node.
    first: u32,
    /// How many triangles.
    triangles: u32,
}

/// A child that waits for its turn.
#[derive(Clone, Copy, Debug, Default)]
struct Waiting {
    /// Where the ray enters it.
    distance: f32,
    child: Child,
}

impl Tree {
    /// Shows `meet` the triangles in the boxes that a ray goes through, nearer boxes first, as ranges in the tree's
    /// order. `meet` says from which distance on nothing is of interest any more.
    #[inline]
    pub(crate) fn visit(&self, ray: &LocalRay, mut meet: impl FnMut(Range<usize>) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let mut limit = ray.reach as f32;
        let mut stack = [Waiting::default(); STACK];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let Waiting { distance, child } = stack[waiting];
            if distance > limit {
                continue;
            }
            if child.triangles > 0 {
                let first = child.first as usize;
                limit = meet(first..first + child.triangles as usize) as f32;
                continue;
            }
            let node = &self.nodes[child.first as usize];
            let [entry, exit] = node.distances(&ray.slabs);
            // The nearest comes last, to be taken first.
            let bottom = waiting;
            for lane in 0..WIDTH {
                if entry[lane] <= exit[lane] && entry[lane] <= limit {
                    let mut place = waiting;
                    while place > bottom && stack[place - 1].distance < entry[lane] {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = Waiting { distance: entry[lane], child: node.children[lane] };
                    waiting += 1;
                }
            }
        }
    }
}

impl Node {
    /// A node with boxes that nothing meets.
    const EMPTY: Self = Self {
        low: [[f32::INFINITY; WIDTH]; 3],
        high: [[f32::NEG_INFINITY; WIDTH]; 3],
        children: [Child { first: 0, triangles: 0 }; WIDTH],
    };

    fn set(&mut self, lane: usize, bounds: &Bounds, child: Child) {
        for axis in 0..3 {
            self.low[axis][lane] = bounds.low[axis] - MARGIN;
            self.high[axis][lane] = bounds.high[axis] + MARGIN;
        }
        self.children[lane] = child;
    }

    /// Where the ray enters and leaves the four boxes; boxes that it leaves before it enters are missed. Distances
    /// before the ray's origin count as zero.
    #[inline(always)]
    fn distances(&self, slabs: &Slabs) -> [[f32; WIDTH]; 2] {
        let mut entry = [0.0f32; WIDTH];
        let mut exit = [f32::INFINITY; WIDTH];
        for axis in 0..3 {
            let [origin, inverse] = [slabs.origin[axis], slabs.inverse_direction[axis]];
            let (near, far) =
                if inverse < 0.0 { (&self.high[axis], &self.low[axis]) } else { (&self.low[axis], &self.high[axis]) };
            for lane in 0..WIDTH {
                let into = (near[lane] - origin) * inverse;
                let out_of = (far[lane] - origin) * inverse;
                // As the instructions have it, unlike `f32::max`: no number here is NaN.
                entry[lane] = if into > entry[lane] { into } else { entry[lane] };
                exit[lane] = if out_of < exit[lane] { out_of } else { exit[lane] };
            }
        }
        [entry, exit]
    }
}
