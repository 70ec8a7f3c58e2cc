//! How values lie in memory for marching, and how regions are sampled there with no search: padded copies of all bricks,
//! or the values where they are.

mod either;
mod in_place;
mod normalisation;
mod padded;
mod pieces;
#[cfg(test)]
mod tests;

use crate::hierarchy::IndexBox;
use crate::index::Index;
use crate::reconstruction::{AnySampler, LaneNumber, ValuesAndGradients};
use crate::simd::{Floats, Gather, LANES, Mask};

pub(crate) use either::EitherValues;
pub(crate) use in_place::{InPlace, InPlacePlan};
pub(crate) use normalisation::normalisation;
pub use padded::padded_bytes;
pub(crate) use padded::{Padded, PaddedField, PaddedPoints, PaddedValues};
pub(crate) use pieces::PieceNode;

/// Where [`Engine::March`](crate::render::Engine::March) has its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layout {
    /// In a copy in single precision, each brick with one more cell on every side: fastest.
    Padded,
    /// Where the field has them, for data larger than memory.
    InPlace,
}

/// Where a region lies in the brick that is its finest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RegionFrame {
    /// The level of the region's leaf cells; `None` in a hole.
    pub(crate) level: Option<u8>,
    /// Where local coordinates are 0, in cells of that level; they count in cells, too.
    pub(crate) low: [f64; 3],
    /// The box, in local coordinates, in which the brick alone is enough; [`NO_BOX`] where there is none.
    pub(crate) pure: [[f32; 3]; 2],
    /// Whether that is all of the region.
    pub(crate) is_pure: bool,
}

/// A box that no ray meets before its end.
pub(crate) const NO_BOX: [[f32; 3]; 2] = [[f32::INFINITY; 3]; 2];

/// The first and last places of each region along each axis, in cells of the finest level: points that rounding has
/// moved over a region's face, to where there may be a hole, are moved back.
fn region_places(index: &Index) -> Vec<[[f64; 3]; 2]> {
    // Positions of packets are exact to less than this.
    const NEAREST: f64 = 1e-6;
    let places = |cells: &IndexBox| [cells.low.map(|cell| cell as f64), cells.high.map(|cell| cell as f64 - NEAREST)];
    index.region_boxes().iter().map(places).collect()
}

/// What there is at `active` points in a region's local coordinates, by queries, which know of all bricks; given the
/// region's frame, the size of its cells and its places.
#[inline(never)]
fn queried<S: Gather, N: LaneNumber<S>>(
    simd: S,
    sampler: &AnySampler,
    (frame, size, [first, last]): (&RegionFrame, &[f64; 3], &[[f64; 3]; 2]),
    point: [Floats<S>; 3],
    active: Mask<S>,
) -> N {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut points = [[0.0; LANES]; 3];
            for axis in 0..3 {
                let lanes: [f32; LANES] = point[axis].into();
                for lane in 0..LANES {
                    let place = (f64::from(lanes[lane]) + frame.low[axis]) * size[axis];
                    points[axis][lane] = place.max(first[axis]).min(last[axis]);
                }
            }
            sampler.sample::<S, N>(simd, &points, active).values.per_cells(size)
        },
    )
}

/// Samples a field region by region, sixteen points at a time. Values are normalised; gradients are those of the
/// normalised values along each axis, per cell of the region's level, exact wherever there is one: next to holes a finite
/// value may have none.
pub(crate) trait RegionValues: Sync {
    /// Where a region lies.
    fn frame(&self, region: usize) -> &RegionFrame;

    /// Cells of the finest level per cell of `level`.
    fn finest_cells(&self, level: u8) -> &[f64; 3];

    /// Whether all values are known to be finite.
    fn is_finite(&self) -> bool;

    /// What there is at points of the region's pure box, in its local coordinates.
    fn in_pure<S: Gather, N: LaneNumber<S>>(&self, simd: S, region: usize, point: [Floats<S>; 3]) -> N;

    /// What there is at `active` points anywhere in the region.
    fn in_region<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        region: usize,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> N;

    /// The values at points of the region's pure box, in its local coordinates.
    #[inline(always)]
    fn pure<S: Gather>(&self, simd: S, region: usize, point: [Floats<S>; 3]) -> Floats<S> {
        self.in_pure(simd, region, point)
    }

    /// The values at `active` points anywhere in the region. Far more code than in the pure box: all marchers share it.
    #[inline(never)]
    fn anywhere<S: Gather>(&self, simd: S, region: usize, point: [Floats<S>; 3], active: Mask<S>) -> Floats<S> {
        simd.vectorize(
            #[inline(always)]
            || self.in_region(simd, region, point, active),
        )
    }

    /// [`pure`](Self::pure) with the gradients.
    #[inline(always)]
    fn pure_with_gradient<S: Gather>(&self, simd: S, region: usize, point: [Floats<S>; 3]) -> ValuesAndGradients<S> {
        self.in_pure(simd, region, point)
    }

    /// [`anywhere`](Self::anywhere) with the gradients.
    #[inline(never)]
    fn anywhere_with_gradient<S: Gather>(
        &self,
        simd: S,
        region: usize,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> ValuesAndGradients<S> {
        simd.vectorize(
            #[inline(always)]
            || self.in_region(simd, region, point, active),
        )
    }
}
