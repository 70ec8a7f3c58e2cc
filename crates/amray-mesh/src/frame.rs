//! The mesh's own coordinates: its middle is the origin, and everything lies between -1 and 1.
//!
//! There, single precision is enough for vertices and boxes, wherever the mesh is in the world and however large.

/// From world coordinates to the mesh's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    center: [f64; 3],
    /// Half of the longest side, rounded up to a power of two, is two to this: scaling by it loses no digit.
    exponent: i32,
}

/// The exponent of the smallest normal number: smaller meshes are as good as this size.
const LEAST_EXPONENT: i32 = f64::MIN_EXP;
/// Half of the distance between neighbouring numbers just below 1.
const SINGLE_ROUNDING: i32 = -25;
const DOUBLE_ROUNDING: f64 = f64::EPSILON / 2.0;

impl Frame {
    /// The frame of what lies between two corners.
    pub(crate) fn new([low, high]: [[f64; 3]; 2]) -> Self {
        // Halved first: the difference of two finite numbers may not be finite.
        let center = std::array::from_fn(|axis| low[axis] / 2.0 + high[axis] / 2.0);
        let half_side = (0..3).map(|axis| high[axis] / 2.0 - low[axis] / 2.0).fold(0.0, f64::max);
        // The biased exponent of a number in [0.5, 1) is 1022.
        let exponent = (half_side.to_bits() >> 52) as i32 - 1022;
        Self { center, exponent: exponent.max(LEAST_EXPONENT) }
    }

    /// A world position in the frame.
    pub(crate) fn position(&self, world: [f64; 3]) -> [f64; 3] {
        self.direction(std::array::from_fn(|axis| world[axis] - self.center[axis]))
    }

    /// A world direction in the frame, where lengths differ.
    pub(crate) fn direction(&self, world: [f64; 3]) -> [f64; 3] {
        let scale = f64::from(-self.exponent).exp2();
        world.map(|component| component * scale)
    }

    /// How far a position on the mesh may be off by rounding, in world units: the vertices' single precision, and the
    /// double precision of world positions.
    pub(crate) fn rounding(&self, [low, high]: [[f64; 3]; 2]) -> f64 {
        let farthest = low.into_iter().chain(high).fold(0.0, |farthest: f64, corner| farthest.max(corner.abs()));
        f64::from(self.exponent + SINGLE_ROUNDING).exp2() + farthest * DOUBLE_ROUNDING
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_finite_box_fills_the_frame() {
        for half in [f64::MIN_POSITIVE, 1e-200, 0.49, 0.5, 1.0, 3e9, f64::MAX] {
            let bounds = [[-half, 0.0, 0.0], [half, half / 4.0, 0.0]];
            let frame = Frame::new(bounds);
            let [low, high] = bounds.map(|corner| frame.position(corner));
            assert!(high[0] >= 0.5 && high[0] <= 1.0, "{half}: {high:?}");
            assert!(low[0] == -high[0] && low[1] == -high[1], "{half}: {low:?} {high:?}");
            assert!(frame.rounding(bounds) < half / 1e6);
        }
    }

    #[test]
    fn an_offset_costs_no_digits() {
        let frame = Frame::new([[1e9 + 1.0; 3], [1e9 + 3.0; 3]]);
        assert_eq!(frame.position([1e9 + 1.0, 1e9 + 2.0, 1e9 + 2.25]), [-0.5, 0.0, 0.125]);
    }
}
