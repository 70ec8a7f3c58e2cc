//! A ray in the mesh's own coordinates, prepared for boxes and triangles.

use crate::Ray;
use crate::frame::Frame;

/// Boxes count a component of a direction as at least this long. Across the whole mesh, less moves a ray by nothing
/// that single precision could tell.
const LEAST_COMPONENT: f32 = 1e-20;

/// A ray whose origin lies on or in the mesh's bounds, so that single precision is enough for boxes. Distances are in
/// the mesh's units, from that origin.
#[derive(Clone, Debug)]
pub(crate) struct LocalRay {
    pub(crate) origin: [f64; 3],
    /// The distance at which the ray leaves the bounds or ends.
    pub(crate) reach: f64,
    /// For triangles.
    pub(crate) shear: Shear,
    /// For boxes.
    pub(crate) slabs: Slabs,
    /// The distance from the world ray's origin to this one's.
    start: f64,
    /// How long the world ray's direction is.
    length: f64,
}

/// How space is sheared so that the ray becomes the axis `axes[2]`, along which it goes farthest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shear {
    pub(crate) axes: [usize; 3],
    /// How far the ray goes along the first two axes for one unit along the third.
    pub(crate) slope: [f64; 2],
    /// The distance for one unit along the third axis.
    pub(crate) distance: f64,
}

/// The ray in single precision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slabs {
    pub(crate) origin: [f32; 3],
    pub(crate) inverse_direction: [f32; 3],
}

impl LocalRay {
    /// The part of a ray inside of `bounds` (in the frame); none where there is none, or where the ray has no
    /// direction or is not of finite numbers.
    pub(crate) fn new(ray: &Ray, frame: &Frame, bounds: [[f64; 3]; 2]) -> Option<Self> {
        let origin = frame.position(ray.origin);
        let widest = ray.direction.iter().fold(0.0, |widest: f64, component| widest.max(component.abs()));
        // Made short before it is scaled and squared: what is tiny or huge would not survive that.
        let direction = ray.direction.map(|component| component / widest);
        let direction_length = direction.iter().map(|component| component * component).sum::<f64>().sqrt();
        let direction = direction.map(|component| component / direction_length);
        let length = frame.direction([widest; 3])[0] * direction_length;
        let finite = origin.iter().chain(&direction).chain([&length]).all(|number| number.is_finite());
        if !finite || length <= 0.0 {
            return None;
        }

        let [mut first, mut last] = [ray.from * length, ray.to * length];
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis] < bounds[0][axis] || origin[axis] > bounds[1][axis] {
                    return None;
                }
            } else {
                let [a, b] = [0, 1].map(|side| (bounds[side][axis] - origin[axis]) / direction[axis]);
                first = first.max(a.min(b));
                last = last.min(a.max(b));
            }
        }
        // Written so that NaN is refused.
        let meets = ray.from <= ray.to && first <= last && first.is_finite();
        meets.then(|| {
            let origin = std::array::from_fn(|axis| origin[axis] + first * direction[axis]);
            Self {
                origin,
                reach: last - first,
                shear: Shear::new(direction),
                slabs: Slabs::new(origin, direction),
                start: first,
                length,
            }
        })
    }

    /// The world ray's `t` at a distance.
    pub(crate) fn t(&self, distance: f64) -> f64 {
        (self.start + distance) / self.length
    }

    /// The distance at the world ray's `t`.
    pub(crate) fn distance(&self, t: f64) -> f64 {
        t * self.length - self.start
    }
}

impl Shear {
    fn new(direction: [f64; 3]) -> Self {
        let longest = |a: usize, b: usize| if direction[b].abs() > direction[a].abs() { b } else { a };
        let along = longest(longest(0, 1), 2);
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        let slope = [axes[0], axes[1]].map(|axis| direction[axis] / direction[along]);
        Self { axes, slope, distance: 1.0 / direction[along] }
    }
}

impl Slabs {
    fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        let inverse_direction = direction.map(|component| {
            let component = component as f32;
            1.0 / if component.abs() < LEAST_COMPONENT { LEAST_COMPONENT.copysign(component) } else { component }
        });
        Self { origin: origin.map(|component| component as f32), inverse_direction }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: [[f64; 3]; 2] = [[-1.0; 3], [1.0; 3]];

    fn local(origin: [f64; 3], direction: [f64; 3], from: f64, to: f64) -> Option<LocalRay> {
        // The frame of a mesh from 96 to 104: its units are 4 long.
        let frame = Frame::new([[96.5; 3], [103.5; 3]]);
        LocalRay::new(&Ray { origin, direction, from, to }, &frame, BOUNDS)
    }

    #[test]
    fn rays_begin_where_they_enter() {
        let ray = local([100.0, 100.0, 120.0], [0.0, 0.0, -8.0], 0.0, f64::INFINITY).unwrap();
        assert_eq!(ray.origin, [0.0, 0.0, 1.0]);
        assert_eq!(ray.reach, 2.0);
        assert_eq!(ray.t(0.0), 2.0);
        assert_eq!(ray.t(2.0), 3.0);
        let ray = local([100.0; 3], [0.0, 4.0, 0.0], -0.5, 0.25).unwrap();
        assert_eq!(ray.origin, [0.0, -0.5, 0.0]);
        assert_eq!(ray.reach, 0.75);
        assert_eq!(ray.t(0.0), -0.5);
    }

    #[test]
    fn rays_that_miss_or_are_none() {
        let infinite = f64::INFINITY;
        assert!(local([100.0, 100.0, 120.0], [0.0, 0.0, 8.0], 0.0, infinite).is_none());
        assert!(local([100.0, 120.0, 120.0], [0.0, 0.0, -8.0], 0.0, infinite).is_none());
        assert!(local([100.0, 100.0, 120.0], [0.0, 0.0, -8.0], 0.0, 1.9).is_none());
        assert!(local([100.0; 3], [0.0; 3], 0.0, infinite).is_none());
        for wrong in [f64::NAN, infinite] {
            assert!(local([100.0, wrong, 100.0], [0.0, 0.0, 1.0], 0.0, infinite).is_none());
            assert!(local([100.0; 3], [0.0, wrong, 1.0], 0.0, infinite).is_none());
            assert!(local([100.0; 3], [0.0, 0.0, 1.0], wrong, infinite).is_none());
        }
        assert!(local([100.0; 3], [0.0, 0.0, 1.0], 0.0, f64::NAN).is_none());
        assert!(local([100.0; 3], [0.0, 0.0, 1.0], 1.0, 0.0).is_none());
    }

    #[test]
    fn directions_may_have_any_length() {
        for length in [1e-300, 1e-20, 1e20, 1e300] {
            let ray = local([100.0; 3], [length, -length, 0.0], 0.0, f64::INFINITY).unwrap();
            assert_eq!(ray.origin, [0.0; 3]);
            assert!((ray.reach - 2f64.sqrt()).abs() < 1e-12);
            assert!((ray.t(ray.reach) * length - 4.0).abs() < 1e-12);
        }
    }
}
