//! The regions along a ray, front to back.

use super::{Index, Node};

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

impl Index {
    /// The regions that the ray passes between `near` and `far`, in order, without gaps; holes included.
    pub fn walk(&self, ray: Ray, near: f64, far: f64) -> impl Iterator<Item = RegionSpan> + '_ {
        let mut stack = Vec::with_capacity(64);
        if let Some((enter, leave)) = self.clip(&ray, near, far) {
            stack.push((0, enter, leave));
        }
        std::iter::from_fn(move || {
            let (mut node, enter, mut leave) = stack.pop()?;
            loop {
                let (axis, plane, high) = match self.nodes[node] {
                    Node::Leaf(region) => return Some(RegionSpan { region: region as usize, enter, leave }),
                    Node::Inner { axis, plane, high } => (usize::from(axis), plane as f64, high as usize),
                };
                let low = node + 1;
                let (start, direction) = (ray.start[axis], ray.direction[axis]);
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
                        stack.push((second, cut, leave));
                        leave = cut;
                    }
                    node = first;
                }
            }
        })
    }

    /// The part of the ray between `near` and `far` that lies in the domain.
    fn clip(&self, ray: &Ray, near: f64, far: f64) -> Option<(f64, f64)> {
        let (mut enter, mut leave) = (near, far);
        for axis in 0..3 {
            let (low, high) = (self.domain.low[axis] as f64, self.domain.high[axis] as f64);
            let (start, direction) = (ray.start[axis], ray.direction[axis]);
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
        (enter < leave).then_some((enter, leave))
    }
}
