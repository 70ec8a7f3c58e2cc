//! The value at a point: how cells become a continuous function. One file per method, all in f64: the reference that
//! everything faster is held to.
//!
//! Section 4 of the paper describes `finest`, `current`, `blend` and `basis`; `octant` follows Wang et al., *CPU
//! Isosurface Ray Tracing of Adaptive Mesh Refinement Data* (2019); `prolong` is amray's own.

mod basis;
mod blend;
mod dual_cell;
mod method;
mod octant;
mod packet;
mod prolong;

use crate::hierarchy::{BrickValues, Level, Voxel};
use crate::index::{Found, Index, Region};

pub use method::{Method, UnknownMethod};
pub use packet::{PacketPoints, PacketSampler, PacketSamples};

/// Evaluates one method over one field.
///
/// Points are in cells of the finest level, as [`Hierarchy::to_cells`](crate::hierarchy::Hierarchy::to_cells) gives
/// them.
#[derive(Clone, Copy, Debug)]
pub struct Sampler<'a, T> {
    index: &'a Index,
    bricks: &'a [BrickValues<T>],
    method: Method,
}

impl<'a, T: Voxel> Sampler<'a, T> {
    /// A sampler of the values in `bricks`, one for each brick of the index's hierarchy; sampling panics where one is
    /// missing.
    pub fn new(index: &'a Index, bricks: &'a [BrickValues<T>], method: Method) -> Self {
        Self { index, bricks, method }
    }

    /// The value at a world position; NaN outside the domain and in holes, and where a non-finite cell takes part.
    /// The domain's boundary belongs to it.
    pub fn sample_world(&self, point: [f64; 3]) -> f64 {
        let hierarchy = self.index.hierarchy();
        let [low, high] = hierarchy.bounds();
        // Compared in world units, so that the very corners that `bounds` reports are inside.
        if !(0..3).all(|axis| (low[axis]..=high[axis]).contains(&point[axis])) {
            return f64::NAN;
        }
        self.sample(hierarchy.to_cells(hierarchy.finest_level(), point))
    }

    /// The value at a point of the domain, in cells of the finest level; one outside is moved to the boundary.
    pub fn sample(&self, point: [f64; 3]) -> f64 {
        let domain = self.index.domain();
        let point = std::array::from_fn(|axis| point[axis].clamp(domain.low[axis] as f64, domain.high[axis] as f64));
        self.sample_in(self.index.find_region(self.cell_of(point)), point)
    }

    /// The value at a point, in cells of the finest level, that lies in `region` (its place in [`Index::regions`]); NaN
    /// in a hole.
    #[inline]
    pub fn sample_in(&self, region: usize, point: [f64; 3]) -> f64 {
        let region = &self.index.regions()[region];
        let Some(level) = region.finest_level() else { return f64::NAN };
        let one_level = match self.method {
            Method::Nearest => false,
            Method::Finest => level == self.index.hierarchy().finest_level(),
            _ => true,
        };
        if one_level && region.is_interior(point) {
            let value = self.trilinear(region, level, point);
            // A corner of weight zero does not take part, not even one that is not a number: the long way knows.
            if value.is_finite() {
                return value;
            }
        }
        self.evaluate(region, level, point)
    }

    /// The level of the leaf cell that contains a point of the domain; `None` in a hole.
    fn leaf_level(&self, point: [f64; 3]) -> Option<usize> {
        self.index.regions()[self.index.find_region(self.cell_of(point))].finest_level()
    }

    fn evaluate(&self, region: &Region, level: usize, point: [f64; 3]) -> f64 {
        match self.method {
            Method::Nearest => self.nearest(point),
            Method::Finest => self.lerp(self.index.hierarchy().finest_level(), point).value,
            Method::Current => self.lerp(level, point).value,
            Method::Blend => self.blend(region, point),
            Method::Basis => self.basis(region, point),
            Method::Octant => self.octant(point),
            Method::Prolong => self.prolong(region.finest_in_reach(), point).unwrap_or(f64::NAN),
        }
    }

    /// The value of the leaf cell that contains the point.
    fn nearest(&self, point: [f64; 3]) -> f64 {
        self.index.find_leaf(self.cell_of(point)).map_or(f64::NAN, |leaf| self.value(&leaf))
    }

    /// Trilinear interpolation of the region's finest brick, around a point of the region's interior.
    #[inline]
    fn trilinear(&self, region: &Region, level: usize, point: [f64; 3]) -> f64 {
        let Some((_, place)) = self.index.finest_brick(region, level) else { return f64::NAN };
        let description = &self.index.hierarchy().levels()[level];
        let low = description.brick_at(place).low;
        let brick = &self.bricks[place];
        let mut base = [0; 3];
        let mut fraction = [0.0; 3];
        for axis in 0..3 {
            let position = point[axis] / description.finest_cells()[axis] as f64 - low[axis] as f64 - 0.5;
            // On the interior's high face the last dual cell is used to its end.
            let cell = (position as usize).min(brick.size()[axis] - 2);
            base[axis] = cell;
            fraction[axis] = position - cell as f64;
        }
        let corners = brick.corners(base).map(Voxel::to_f64);
        let mix = |low: f64, high: f64, share: f64| low + (high - low) * share;
        let along_x = [0, 2, 4, 6].map(|corner| mix(corners[corner], corners[corner + 1], fraction[0]));
        let along_y = [0, 2].map(|edge| mix(along_x[edge], along_x[edge + 1], fraction[1]));
        mix(along_y[0], along_y[1], fraction[2])
    }

    fn value(&self, found: &Found) -> f64 {
        self.bricks[found.brick].get(found.cell).to_f64()
    }

    fn level(&self, level: usize) -> &'a Level {
        &self.index.hierarchy().levels()[level]
    }

    /// The cell of the finest level that contains a point of the domain.
    fn cell_of(&self, point: [f64; 3]) -> [i64; 3] {
        self.index.domain().clamp(point.map(|position| position.floor() as i64))
    }
}
