//! Boxes in single precision.

/// What lies between two corners; the empty box has them the wrong way round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: [f32; 3],
    pub(crate) high: [f32; 3],
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The smallest box around points.
    pub(crate) fn around(points: &[[f32; 3]]) -> Self {
        let mut bounds = Self::EMPTY;
        for point in points {
            bounds.include(&Self { low: *point, high: *point });
        }
        bounds
    }

    /// Widens the box to contain another.
    #[inline(always)]
    pub(crate) fn include(&mut self, other: &Self) {
        for axis in 0..3 {
            let [low, high] = [other.low[axis], other.high[axis]];
            self.low[axis] = if low < self.low[axis] { low } else { self.low[axis] };
            self.high[axis] = if high > self.high[axis] { high } else { self.high[axis] };
        }
    }

    /// Half of the surface: proportional to how many of all rays go through.
    pub(crate) fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|axis| (self.high[axis] - self.low[axis]).max(0.0));
        x * y + y * z + z * x
    }

    /// Twice the middle.
    #[inline(always)]
    pub(crate) fn twice_center(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }
}
