//! Sixteen neighbouring rays that go through the volume together.

use fearless_simd::prelude::*;

use crate::index::Index;
use crate::scene::PicturePlane;
use crate::simd::{Floats, Gather, LANES};

/// Pixels per side of a packet.
pub(super) const SIDE: usize = 4;

/// Sixteen rays, in cells of the finest level: at `t`, a length in world units, a ray is at `start + t * direction`.
pub(super) struct Packet<S: Gather> {
    pub(super) start: [[f64; LANES]; 3],
    pub(super) direction: [[f64; LANES]; 3],
    /// Where on its ray each lattice of samples has a point.
    pub(super) offset: [f64; LANES],
    /// The length of a step on level 0.
    pub(super) coarse_step: [f64; LANES],
    /// A place that all planes are measured from, so that single precision is enough for where rays cross them.
    reference: [f64; 3],
    inverse: [Floats<S>; 3],
    /// By how much a ray crosses a plane later than one through the reference.
    lag: [Floats<S>; 3],
    /// Which child of a node comes first.
    order: Order,
}

/// How the packet decides which side of a plane its rays meet first.
#[derive(Clone, Copy)]
enum Order {
    /// The side that holds the eye, in cells of the finest level, from which all rays come.
    Eye([f64; 3]),
    /// The low side, where true: rays are parallel.
    LowFirst([bool; 3]),
}

impl<S: Gather> Packet<S> {
    /// The rays through points of a picture, `place` within each of the pixels from `corner` on. Lattices are shifted
    /// by `shift` of a coarse step.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        index: &Index,
        plane: &PicturePlane,
        [x, y]: [[f64; LANES]; 2],
        shift: [f64; LANES],
        samples_per_cell: f64,
    ) -> Self {
        let hierarchy = index.hierarchy();
        let levels = hierarchy.levels();
        let (origin, finest) = (hierarchy.origin(), levels[levels.len() - 1].cell_size());
        let coarsest = levels[0].cell_size();
        let mut start = [[0.0; LANES]; 3];
        let mut direction = [[0.0; LANES]; 3];
        let mut length = [0.0; LANES];
        let mut cells = [0.0; LANES];
        for axis in 0..3 {
            let [s, s_right, s_down] = plane.start.map(|vector| vector[axis]);
            let [d, d_right, d_down] = plane.direction.map(|vector| vector[axis]);
            for lane in 0..LANES {
                start[axis][lane] = (s + s_right * x[lane] + s_down * y[lane] - origin[axis]) / finest[axis];
                let part = d + d_right * x[lane] + d_down * y[lane];
                length[lane] += part * part;
                direction[axis][lane] = part;
            }
        }
        for lane in 0..LANES {
            length[lane] = length[lane].sqrt().recip();
        }
        // A ray along a plane crosses it very far away, not never: no division by zero.
        const LEAST: f64 = 1e-12;
        let mut inverse = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                let part = direction[axis][lane] * length[lane];
                let part = if part.abs() < LEAST { LEAST.copysign(part) } else { part };
                cells[lane] += (part / coarsest[axis]) * (part / coarsest[axis]);
                direction[axis][lane] = part / finest[axis];
                inverse[axis][lane] = finest[axis] / part;
            }
        }
        let mut coarse_step = [0.0; LANES];
        let mut offset = [0.0; LANES];
        for lane in 0..LANES {
            coarse_step[lane] = cells[lane].sqrt().recip() / samples_per_cell;
            offset[lane] = coarse_step[lane] * shift[lane];
        }
        let reference = [0, 1, 2].map(|axis| start[axis][0]);
        let mut lag = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            let mut later = [0.0; LANES];
            for lane in 0..LANES {
                later[lane] = ((reference[axis] - start[axis][lane]) * inverse[axis][lane]) as f32;
            }
            lag[axis] = Floats::from_slice(simd, &later);
        }
        let order = if plane.start[1] == glam::DVec3::ZERO {
            Order::Eye(reference)
        } else {
            Order::LowFirst([0, 1, 2].map(|axis| direction[axis][0] > 0.0))
        };
        let inverse = inverse.map(
            #[inline(always)]
            |lanes| Floats::from_slice(simd, &lanes.map(|value| value as f32)),
        );
        Self { start, direction, offset, coarse_step, reference, inverse, lag, order }
    }

    /// Where the rays cross the plane at `place` (in cells of the finest level) across `axis`.
    #[inline(always)]
    pub(super) fn crossing(&self, simd: S, axis: usize, place: f64) -> Floats<S> {
        let distance = Floats::splat(simd, (place - self.reference[axis]) as f32);
        distance.mul_add(self.inverse[axis], self.lag[axis])
    }

    /// Where the rays go from the near side of a plane to the far side, and whether the low one is near. Infinity where
    /// they stay on the near side.
    #[inline(always)]
    pub(super) fn change(&self, simd: S, axis: usize, place: f64) -> (Floats<S>, bool) {
        let crossing = self.crossing(simd, axis, place);
        match self.order {
            Order::Eye(eye) => {
                let ahead = crossing.simd_ge(Floats::splat(simd, 0.0));
                (ahead.select(crossing, Floats::splat(simd, f32::INFINITY)), eye[axis] < place)
            }
            Order::LowFirst(low) => (crossing, low[axis]),
        }
    }

    /// Where the rays enter and leave a box, in cells of the finest level; not before they start.
    #[inline(always)]
    pub(super) fn clip(&self, simd: S, low: [f64; 3], high: [f64; 3]) -> [Floats<S>; 2] {
        let mut enter = Floats::splat(simd, 0.0);
        let mut leave = Floats::splat(simd, f32::INFINITY);
        for axis in 0..3 {
            let [a, b] = [self.crossing(simd, axis, low[axis]), self.crossing(simd, axis, high[axis])];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        [enter, leave]
    }
}
