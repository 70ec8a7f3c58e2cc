//! The value at a point, and its gradient: how cells become a continuous function. One file per method, all in f64: the
//! reference that everything faster is held to.
//!
//! Section 4 of the paper describes `finest`, `current`, `blend` and `basis`; `octant` follows Wang et al., *CPU
//! Isosurface Ray Tracing of Adaptive Mesh Refinement Data* (2019); `prolong` is amray's own.

mod basis;
mod blend;
mod conforming;
mod dual_cell;
mod method;
mod nodal;
mod number;
mod octant;
mod packet;
mod prolong;

use crate::hierarchy::{BrickValues, Level, Voxel};
use crate::index::{Found, Index, Region};

use number::Number;

pub(crate) use conforming::conforming;
pub use method::{Method, UnknownMethod};
pub use number::ValueAndGradient;
pub(crate) use packet::{AnySampler, LaneNumber, ValuesAndGradients, linear_weights, made_whole};
pub use packet::{PacketGradients, PacketPoints, PacketSampler, PacketSamples};

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

    pub(crate) fn index(&self) -> &'a Index {
        self.index
    }

    pub(crate) fn bricks(&self) -> &'a [BrickValues<T>] {
        self.bricks
    }

    /// What prolong has at a point of the domain, in cells of the finest level, from `level` and coarser ones alone:
    /// what AMR codes fill ghost cells with. `None` where none of them has a value.
    pub(crate) fn prolonged(&self, level: usize, point: [f64; 3]) -> Option<f64> {
        self.prolong(level, point)
    }

    /// The value at a world position; NaN outside the domain and in holes, and where a non-finite cell takes part.
    /// The domain's boundary belongs to it.
    pub fn sample_world(&self, point: [f64; 3]) -> f64 {
        self.cells_of_world(point).map_or(f64::NAN, |point| self.sample(point))
    }

    /// The value at a world position, just as [`sample_world`](Self::sample_world) gives it, with its gradient in the
    /// field's units per world length.
    ///
    /// The gradient is the exact derivative of the reconstructed function, weights included, also where levels meet:
    /// zero for [`Method::Nearest`]. The function has kinks where dual cells, octants and levels meet; a point on one
    /// has, along each axis, the slope towards its high side, on the domain's high boundary the one from inside. (Next
    /// to holes under fine cells values may jump at a kink; no slope there can be relied on.) Where the value is not
    /// finite, outside and in holes, the gradient is not a number, nor is a slope towards a non-finite cell.
    pub fn sample_world_with_gradient(&self, point: [f64; 3]) -> ValueAndGradient {
        let Some(point) = self.cells_of_world(point) else {
            return ValueAndGradient { value: f64::NAN, gradient: [f64::NAN; 3] };
        };
        let (region, point) = self.place(point);
        self.sample_in_with_gradient(region, point)
    }

    /// The value at a point of the domain, in cells of the finest level; one outside is moved to the boundary.
    pub fn sample(&self, point: [f64; 3]) -> f64 {
        let (region, point) = self.place(point);
        self.sample_in(region, point)
    }

    /// The value at a point, in cells of the finest level, that lies in `region` (its place in [`Index::regions`]); NaN
    /// in a hole.
    #[inline]
    pub fn sample_in(&self, region: usize, point: [f64; 3]) -> f64 {
        self.evaluate_in(region, point)
    }

    /// [`sample_in`](Self::sample_in) with the gradient, as
    /// [`sample_world_with_gradient`](Self::sample_world_with_gradient) has it: per world length.
    #[inline]
    pub fn sample_in_with_gradient(&self, region: usize, point: [f64; 3]) -> ValueAndGradient {
        let ValueAndGradient { value, gradient } = self.evaluate_in(region, point);
        let hierarchy = self.index.hierarchy();
        let cell_size = hierarchy.levels()[hierarchy.finest_level()].cell_size();
        let slope = |axis: usize| if value.is_finite() { gradient[axis] / cell_size[axis] } else { f64::NAN };
        ValueAndGradient { value, gradient: std::array::from_fn(slope) }
    }

    /// The region that holds a point of the domain, and the point; one outside is moved to the boundary.
    fn place(&self, point: [f64; 3]) -> (usize, [f64; 3]) {
        let domain = self.index.domain();
        let point = std::array::from_fn(|axis| point[axis].clamp(domain.low[axis] as f64, domain.high[axis] as f64));
        (self.index.find_region(self.cell_of(point)), point)
    }

    #[inline]
    fn evaluate_in<N: Number>(&self, region: usize, point: [f64; 3]) -> N {
        let region = &self.index.regions()[region];
        let Some(level) = region.finest_level() else { return N::constant(f64::NAN) };
        let one_level = match self.method {
            Method::Nearest | Method::Nodal => false,
            Method::Finest => level == self.index.hierarchy().finest_level(),
            _ => true,
        };
        if one_level && region.is_interior(point) {
            let value: N = self.trilinear(region, level, point);
            // A corner of weight zero does not take part, not even one that is not a number: the long way knows.
            if value.is_finite() {
                return value;
            }
        }
        self.evaluate(region, level, point)
    }

    fn evaluate<N: Number>(&self, region: &Region, level: usize, point: [f64; 3]) -> N {
        match self.method {
            Method::Nearest => N::constant(self.nearest(point)),
            Method::Finest => self.lerp(self.index.hierarchy().finest_level(), point).value,
            Method::Current => self.lerp(level, point).value,
            Method::Blend => self.blend(region, point),
            Method::Basis => self.basis(region, point),
            Method::Octant => self.octant(point),
            Method::Prolong => self.prolong(region.finest_in_reach(), point).unwrap_or(N::constant(f64::NAN)),
            Method::Nodal => self.nodal(region, level, point),
        }
    }

    /// The value of the leaf cell that contains the point.
    fn nearest(&self, point: [f64; 3]) -> f64 {
        self.index.find_leaf(self.cell_of(point)).map_or(f64::NAN, |leaf| self.value(&leaf))
    }

    /// Trilinear interpolation of the region's finest brick, around a point of the region's interior.
    #[inline]
    fn trilinear<N: Number>(&self, region: &Region, level: usize, point: [f64; 3]) -> N {
        let Some((_, place)) = self.index.finest_brick(region, level) else { return N::constant(f64::NAN) };
        let description = &self.index.hierarchy().levels()[level];
        let low = description.brick_at(place).low;
        let brick = &self.bricks[place];
        let mut base = [0; 3];
        let mut fraction = [N::constant(0.0); 3];
        for axis in 0..3 {
            let size = description.finest_cells()[axis] as f64;
            let position = point[axis] / size - low[axis] as f64 - 0.5;
            // Just below the interior's high face, rounding may reach it.
            let cell = (position as usize).min(brick.size()[axis] - 2);
            base[axis] = cell;
            fraction[axis] = N::along(axis, position - cell as f64, 1.0 / size);
        }
        let corners = brick.corners(base).map(|value| N::constant(value.to_f64()));
        let mix = |low: N, high: N, share: N| low + (high - low) * share;
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

    /// A world position in cells of the finest level; `None` outside the domain.
    fn cells_of_world(&self, point: [f64; 3]) -> Option<[f64; 3]> {
        let hierarchy = self.index.hierarchy();
        let [low, high] = hierarchy.bounds();
        // Compared in world units, so that the very corners that `bounds` reports are inside.
        let inside = (0..3).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]));
        inside.then(|| hierarchy.to_cells(hierarchy.finest_level(), point))
    }

    /// The cell of the finest level that contains a point of the domain.
    fn cell_of(&self, point: [f64; 3]) -> [i64; 3] {
        self.index.domain().clamp(point.map(|position| position.floor() as i64))
    }
}
