//! Sixteen neighbouring rays that go through the volume together.

use fearless_simd::prelude::*;
use glam::DVec3;

use crate::index::Index;
use crate::scene::PictureRays;
use crate::simd::{Doubles, Floats, Gather, Mask};

/// Pixels per side of a packet.
pub(super) const SIDE: usize = 4;
/// Packets that go side by side: what finds the way is shared, and while one waits for memory the other one computes.
pub(super) const PACKETS: usize = 2;

/// Packets side by side.
pub(super) type Packets<S> = [Packet<S>; PACKETS];

/// Some of the rays of packets side by side.
pub(super) type Masks<S> = [Mask<S>; PACKETS];

/// Sixteen rays, in cells of the finest level: at `t`, a length in world units, a ray is at `start + t * direction`. They
/// start where they enter the domain, or at the eye inside of it: single precision is enough for `t`, however far away
/// the eye is.
#[derive(Clone, Copy)]
pub(super) struct Packet<S: Gather> {
    pub(super) start: [Doubles<S>; 3],
    pub(super) direction: [Doubles<S>; 3],
    /// How far from their origin the rays start.
    pub(super) entry: Floats<S>,
    /// Where on its ray each lattice of samples has a point.
    pub(super) offset: Doubles<S>,
    /// The length of a step on level 0, and one over it.
    pub(super) coarse_step: Doubles<S>,
    pub(super) coarse_rate: Doubles<S>,
    /// A place in the domain that all planes are measured from, so that single precision is enough for where rays cross
    /// them.
    reference: [f64; 3],
    /// One over the directions.
    pub(super) inverse: [Floats<S>; 3],
    /// By how much a ray crosses a plane later than one through the reference.
    lag: [Floats<S>; 3],
    order: Order,
}

/// Sixteen rays of any kind.
#[derive(Clone, Copy)]
pub(super) struct Bundle<S: Gather> {
    /// Where they start, in cells of the finest level.
    pub(super) start: [Doubles<S>; 3],
    /// Where they go in world space, not of length 1 but near it: single precision can hold the squares.
    pub(super) parts: [Doubles<S>; 3],
    /// Whether all of them go into one octant of directions; otherwise all start at one point.
    pub(super) is_parallel: bool,
}

impl<S: Gather> Bundle<S> {
    #[inline(always)]
    pub(super) fn nothing(simd: S) -> Self {
        let zero = Doubles::splat(simd, 0.0);
        Self { start: [zero; 3], parts: [zero; 3], is_parallel: true }
    }
}

/// How a packet knows which side of a plane its rays meet first.
#[derive(Clone, Copy)]
enum Order {
    /// All rays come from the eye: its side.
    Eye([f64; 3]),
    /// Rays are parallel: the low side, where true.
    LowFirst([bool; 3]),
}

impl<S: Gather> Packet<S> {
    /// The rays through points of a picture, whose lattices are shifted by `shift` of a coarse step.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        index: &Index,
        rays: &PictureRays,
        [x, y]: [Doubles<S>; 2],
        shift: Doubles<S>,
        samples_per_cell: f64,
    ) -> Self {
        let hierarchy = index.hierarchy();
        let levels = hierarchy.levels();
        let (origin, finest) = (hierarchy.origin(), levels[levels.len() - 1].cell_size());
        let zero = Doubles::splat(simd, 0.0);
        let (mut start, mut parts) = ([zero; 3], [zero; 3]);
        let is_parallel = match rays {
            PictureRays::Plane { start: starts, direction } => {
                for axis in 0..3 {
                    parts[axis] = at_pixels(simd, direction, [x, y], axis);
                    start[axis] = at_pixels(simd, starts, [x, y], axis);
                }
                starts[1] != DVec3::ZERO
            }
            PictureRays::Panorama(panorama) => {
                let directions = panorama.directions(&x.store(), &y.store());
                for axis in 0..3 {
                    parts[axis] = Doubles::load(simd, &directions[axis]);
                    start[axis] = Doubles::splat(simd, panorama.eye[axis]);
                }
                false
            }
        };
        for axis in 0..3 {
            let from_origin = start[axis] - Doubles::splat(simd, origin[axis]);
            start[axis] = from_origin * Doubles::splat(simd, finest[axis].recip());
        }
        Self::along(simd, index, Bundle { start, parts, is_parallel }, shift, samples_per_cell)
    }

    /// A bundle of rays, whose lattices are shifted by `shift` of a coarse step.
    #[inline(always)]
    pub(super) fn along(
        simd: S,
        index: &Index,
        Bundle { mut start, parts, is_parallel }: Bundle<S>,
        shift: Doubles<S>,
        samples_per_cell: f64,
    ) -> Self {
        // A ray along a plane crosses it very far away, not never: no division by zero.
        const LEAST: f64 = 1e-12;
        let levels = index.hierarchy().levels();
        let (coarsest, finest) = (levels[0].cell_size(), levels[levels.len() - 1].cell_size());
        let zero = Doubles::splat(simd, 0.0);
        let squares = parts[0] * parts[0] + parts[1] * parts[1] + parts[2] * parts[2];
        let normal = squares.inverse_sqrt(simd);
        let (mut direction, mut inverse) = ([zero; 3], [Floats::splat(simd, 0.0); 3]);
        let mut cells = Floats::splat(simd, 0.0);
        for axis in 0..3 {
            let part = parts[axis] * normal;
            let small = part.to_floats().abs().simd_lt(Floats::splat(simd, LEAST as f32));
            let part = Doubles::select(simd, small, Doubles::splat(simd, LEAST), part);
            let per_cell = part.to_floats() * Floats::splat(simd, (coarsest[0] / coarsest[axis]) as f32);
            cells = per_cell.mul_add(per_cell, cells);
            direction[axis] = part * Doubles::splat(simd, finest[axis].recip());
            inverse[axis] = Floats::splat(simd, 1.0) / direction[axis].to_floats();
        }
        // To the digits of single precision only, but the same in all regions.
        let cells = cells.sqrt();
        let step = Doubles::from_floats(Floats::splat(simd, 1.0) / cells);
        let coarse_rate = Doubles::from_floats(cells) * Doubles::splat(simd, samples_per_cell / coarsest[0]);
        let coarse_step = step * Doubles::splat(simd, coarsest[0] / samples_per_cell);
        let order = if is_parallel {
            let [x, y, z] = direction;
            Order::LowFirst([x.first() > 0.0, y.first() > 0.0, z.first() > 0.0])
        } else {
            Order::Eye([start[0].first(), start[1].first(), start[2].first()])
        };
        let domain = index.domain();
        let [low, high] = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
        let mut entry = Floats::splat(simd, 0.0);
        for axis in 0..3 {
            let a = (Doubles::splat(simd, low[axis]) - start[axis]).to_floats() * inverse[axis];
            let b = (Doubles::splat(simd, high[axis]) - start[axis]).to_floats() * inverse[axis];
            entry = entry.max(a.min(b));
        }
        // A ray that misses the domain starts beside it, not where it crosses a plane far away.
        let (mut toward_middle, mut half_diagonal) = (zero, 0.0);
        for axis in 0..3 {
            let size = finest[axis];
            let middle = Doubles::splat(simd, (low[axis] + high[axis]) / 2.0);
            let square = Doubles::splat(simd, size * size);
            toward_middle = (middle - start[axis]).mul_add(direction[axis] * square, toward_middle);
            half_diagonal += ((high[axis] - low[axis]) * size / 2.0).powi(2);
        }
        let farthest = toward_middle.to_floats() + Floats::splat(simd, half_diagonal.sqrt() as f32);
        let entry = entry.min(farthest.max(Floats::splat(simd, 0.0)));
        // Rather too early than too late.
        let entry = Doubles::from_floats(entry * Floats::splat(simd, 1.0 - 1e-6));
        let (mut reference, mut lag) = ([0.0; 3], [Floats::splat(simd, 0.0); 3]);
        for axis in 0..3 {
            start[axis] = entry.mul_add(direction[axis], start[axis]);
            // A ray that misses the domain may start anywhere.
            reference[axis] = start[axis].first().clamp(low[axis], high[axis]);
            lag[axis] = (Doubles::splat(simd, reference[axis]) - start[axis]).to_floats() * inverse[axis];
        }
        let offset = coarse_step * shift;
        Self {
            start,
            direction,
            entry: entry.to_floats(),
            offset,
            coarse_step,
            coarse_rate,
            reference,
            inverse,
            lag,
            order,
        }
    }

    /// Where the rays are at `at`, in cells of the finest level.
    #[inline(always)]
    pub(super) fn at(&self, at: Floats<S>) -> [Doubles<S>; 3] {
        let mut place = self.start;
        for axis in 0..3 {
            place[axis] = Doubles::from_floats(at).mul_add(self.direction[axis], self.start[axis]);
        }
        place
    }

    /// Whether all rays come from one point.
    #[inline(always)]
    pub(super) fn comes_from_eye(&self) -> bool {
        matches!(self.order, Order::Eye(_))
    }

    /// Where on the rays places are that lie on them, given the size of a cell of the finest level.
    #[inline(always)]
    pub(super) fn distance_to(&self, simd: S, place: &[Doubles<S>; 3], size: [f64; 3]) -> Floats<S> {
        let mut distance = Doubles::splat(simd, 0.0);
        for axis in 0..3 {
            let square = Doubles::splat(simd, size[axis] * size[axis]);
            distance = (place[axis] - self.start[axis]).mul_add(self.direction[axis] * square, distance);
        }
        distance.to_floats()
    }

    /// Where the rays cross the plane at `place` (in cells of the finest level) across `axis`.
    #[inline(always)]
    fn crossing(&self, simd: S, axis: usize, place: f64) -> Floats<S> {
        let distance = Floats::splat(simd, (place - self.reference[axis]) as f32);
        distance.mul_add(self.inverse[axis], self.lag[axis])
    }

    /// Where the rays go from the near side of a plane to the far side; infinity where they stay on the near side.
    #[inline(always)]
    pub(super) fn change(&self, simd: S, axis: usize, place: f64) -> Floats<S> {
        let crossing = self.crossing(simd, axis, place);
        match self.order {
            Order::Eye(eye) => {
                // Told from where rays go, not from where they cross: the eye may lie in the plane.
                let (low_first, zero) = (eye[axis] < place, Floats::splat(simd, 0.0));
                let inverse = self.inverse[axis];
                let ahead = if low_first { inverse.simd_gt(zero) } else { inverse.simd_lt(zero) };
                ahead.select(crossing, Floats::splat(simd, f32::INFINITY))
            }
            Order::LowFirst(_) => crossing,
        }
    }

    /// Whether the rays meet the low side of a plane first.
    #[inline(always)]
    pub(super) fn is_low_first(&self, axis: usize, place: f64) -> bool {
        match self.order {
            Order::Eye(eye) => eye[axis] < place,
            Order::LowFirst(low) => low[axis],
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

/// A vector that is linear in the pixel, along one axis.
#[inline(always)]
fn at_pixels<S: Gather>(
    simd: S,
    [corner, right, down]: &[DVec3; 3],
    [x, y]: [Doubles<S>; 2],
    axis: usize,
) -> Doubles<S> {
    let (corner, right) = (Doubles::splat(simd, corner[axis]), Doubles::splat(simd, right[axis]));
    x.mul_add(right, y.mul_add(Doubles::splat(simd, down[axis]), corner))
}
