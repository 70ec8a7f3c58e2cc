//! Sixteen samples inside one region, from padded bricks and with no search.
#![allow(unsafe_code)] // Gathers read at computed places; every index is clamped into its brick before.

use fearless_simd::prelude::*;

use super::super::{RegionFrame, RegionValues, queried};
use super::plan::{Combination, OtherAxis, OtherBrick, PaddedBrick, Plan, RegionPlan};
use super::{FLAG, HOLE, Padded, PaddedField};
use crate::reconstruction::{AnySampler, LaneNumber, Method, linear_weights, made_whole};
use crate::simd::{Floats, Gather, Integers, Mask, Naturals};

/// Evaluates one method over one padded field; the values are units of the field's range.
#[derive(Clone, Copy)]
pub(crate) struct PaddedValues<'a> {
    pub(crate) field: &'a PaddedField,
    pub(crate) plan: &'a Plan,
    /// For borders of methods without a better way.
    pub(crate) sampler: &'a AnySampler<'a>,
}

impl<'a> PaddedValues<'a> {
    /// A padded copy's values; `sampler` is its volume's.
    pub(crate) fn new(Padded { field, plan, .. }: &'a Padded, sampler: &'a AnySampler<'a>) -> Self {
        Self { field, plan, sampler }
    }
}

/// Where sixteen points lie in a brick.
struct Places<S: Gather, N> {
    /// The cells at the low corners of the dual cells around the points, padding included.
    cells: [Integers<S>; 3],
    /// The weights of the low and of the high corners, per axis; slopes are per cell of the region.
    weights: [[N; 2]; 3],
}

impl<S: Gather, N: LaneNumber<S>> Places<S, N> {
    /// Of points in the brick's own padded coordinates.
    #[inline(always)]
    fn own(simd: S, point: [Floats<S>; 3]) -> Self {
        Self::moved(simd, point, [Floats::splat(simd, 1.0); 3])
    }

    /// Of points that have been moved to these, which have `slopes`, in the brick's own padded coordinates.
    #[inline(always)]
    fn moved(simd: S, point: [Floats<S>; 3], slopes: [Floats<S>; 3]) -> Self {
        let one = Floats::splat(simd, 1.0);
        let mut places = Self { cells: [Integers::splat(simd, 0); 3], weights: [[N::constant(one); 2]; 3] };
        for axis in 0..3 {
            places.cells[axis] = point[axis].to_int();
            let high = point[axis] - places.cells[axis].to_float::<Floats<S>>();
            places.weights[axis] = linear_weights(axis, [one - high, high], slopes[axis]);
        }
        places
    }

    /// Of points in a region's padded coordinates, in another brick.
    ///
    /// Beside holes, a mean may be over corners that all have little weight. So both hats are as exact as single
    /// precision can be, also next to 0: only the last step rounds.
    #[inline(always)]
    fn other(simd: S, other: &OtherBrick, point: [Floats<S>; 3]) -> Self {
        let zero = Floats::splat(simd, 0.0);
        let mut places = Self { cells: [Integers::splat(simd, 0); 3], weights: [[N::constant(zero); 2]; 3] };
        for axis in 0..3 {
            let OtherAxis { multiple, parts, origin, shift } = other.axes[axis];
            let share = Floats::splat(simd, parts.recip());
            let [multiple, parts] = [Floats::splat(simd, multiple), Floats::splat(simd, parts)];
            let [origin, shift] = [Floats::splat(simd, origin), Floats::splat(simd, shift)];
            let mut cell = point[axis].mul_add(multiple, shift).mul_add(share, origin).floor();
            let shift = (origin - cell).mul_add(parts, shift);
            let mut high = point[axis].mul_add(multiple, shift);
            let mut low = (zero - point[axis]).mul_add(multiple, parts - shift);
            // A point just below a centre may have been rounded up to it.
            let below = high.simd_lt(zero);
            cell = below.select(cell - Floats::splat(simd, 1.0), cell);
            (low, high) = (below.select(zero - high, low), below.select(parts + high, high));
            places.cells[axis] = cell.to_int();
            places.weights[axis] = linear_weights(axis, [low * share, high * share], multiple * share);
        }
        places
    }

    /// Which of the points have all their corners in the padded brick.
    #[inline(always)]
    fn inside(&self, simd: S, brick: &PaddedBrick) -> Mask<S> {
        let mut inside = Mask::splat(simd, true);
        for axis in 0..3 {
            // As naturals, what is below zero is above the highest cell.
            let natural: Naturals<S> = self.cells[axis].bitcast();
            inside &= natural.simd_le(Naturals::splat(simd, brick.values[axis] as u32));
        }
        inside
    }
}

impl OtherBrick {
    /// Which of the points may lie in its reach.
    #[inline(always)]
    fn is_near<S: Gather>(&self, simd: S, point: [Floats<S>; 3]) -> Mask<S> {
        let [low, high] = &self.reach;
        let mut near = Mask::splat(simd, true);
        for axis in 0..3 {
            near &= point[axis].simd_gt(Floats::splat(simd, low[axis]));
            near &= point[axis].simd_lt(Floats::splat(simd, high[axis]));
        }
        near
    }
}

/// What one brick knows of sixteen samples.
struct Share<S: Gather, N> {
    /// The sum of hats times values.
    sum: N,
    /// The sum of hats.
    weight: N,
    /// Whether any cell is flagged whose hat takes part.
    flagged: Mask<S>,
    /// Whether any cell is flagged whose hat is above 0.
    flagged_weight: Mask<S>,
    /// The sum of the hats of cells that are not: exactly 0 where there are none.
    missing: N,
}

/// Which corners count.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Count {
    /// All that exist.
    Existing,
    /// Flagged ones.
    Flagged,
}

/// Points that have found their brick of a level: bricks of one level hold the same there.
struct Found<S: Gather> {
    level: u8,
    points: Mask<S>,
}

impl<S: Gather> Found<S> {
    #[inline(always)]
    fn none(simd: S) -> Self {
        Self { level: u8::MAX, points: Mask::splat(simd, false) }
    }
}

/// Levels on top of each other, from the finest down.
struct Layers<N> {
    sum: N,
    /// The weight that is left for coarser levels.
    left: N,
    /// The value of the coarsest level so far that has flagged corners.
    coarsest: N,
}

impl<N> Layers<N> {
    #[inline(always)]
    fn none<S: Gather>(simd: S) -> Self
    where
        N: LaneNumber<S>,
    {
        let zero = N::constant(Floats::splat(simd, 0.0));
        Self { sum: zero, left: N::constant(Floats::splat(simd, 1.0)), coarsest: zero }
    }

    /// Puts a level below the others, for those `inside` its brick's reach.
    #[inline(always)]
    fn add<S: Gather>(&mut self, simd: S, share: Share<S, N>, inside: Mask<S>)
    where
        N: LaneNumber<S>,
    {
        let value = share.sum / share.weight;
        let takes = inside & share.flagged;
        let actual = N::constant(Floats::splat(simd, 1.0)) - share.missing;
        self.sum = N::select(takes, (self.left * actual).weigh(value, self.sum), self.sum);
        self.left = N::select(takes, share.missing * self.left, self.left);
        self.coarsest = N::select(inside & share.flagged_weight, value, self.coarsest);
    }
}

impl RegionValues for PaddedValues<'_> {
    #[inline(always)]
    fn frame(&self, region: usize) -> &RegionFrame {
        &self.plan.regions[region].frame
    }

    #[inline(always)]
    fn finest_cells(&self, level: u8) -> &[f64; 3] {
        &self.plan.finest_cells[usize::from(level)]
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        self.field.is_finite
    }

    #[inline(always)]
    fn in_pure<S: Gather, N: LaneNumber<S>>(&self, simd: S, region: usize, point: [Floats<S>; 3]) -> N {
        let region = &self.plan.regions[region];
        match self.plan.method {
            Method::Nearest => N::constant(self.nearest(simd, &region.brick, point)),
            Method::Finest => {
                // Most points are moved onto a cell's centre: what is beside it has no weight, and may be a hole.
                let [point, slopes] = self.onto_finest(simd, region, point);
                let places = Places::moved(simd, point, slopes);
                let share: Share<S, N> = self.share(simd, &region.brick, places, Count::Existing);
                share.sum / share.weight
            }
            _ => {
                let places = Places::own(simd, point);
                let [[_, x], [_, y], [_, z]] = places.weights;
                N::trilinear(&self.corners(simd, &region.brick, &places), [x, y, z])
            }
        }
    }

    #[inline(always)]
    fn in_region<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        region: usize,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> N {
        let plan = &self.plan.regions[region];
        match self.plan.combination {
            Combination::Single if self.plan.method == Method::Nearest => {
                N::constant(self.nearest(simd, &plan.brick, point))
            }
            Combination::Single => {
                let share: Share<S, N> = self.share(simd, &plan.brick, Places::own(simd, point), Count::Existing);
                share.sum / share.weight
            }
            Combination::Basis => self.basis(simd, plan, point, active),
            Combination::Layered => self.layered(simd, plan, point, active),
            Combination::Queried => {
                let size = self.finest_cells(plan.frame.level.unwrap_or(0));
                queried(simd, self.sampler, (&plan.frame, size, &self.plan.places[region]), point, active)
            }
        }
    }
}

impl PaddedValues<'_> {
    /// sum(hat v) / sum(hat) over the leaf cells of all bricks that take part.
    #[inline(always)]
    fn basis<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        region: &RegionPlan,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> N {
        let Share { mut sum, mut weight, .. } =
            self.share::<S, N>(simd, &region.brick, Places::own(simd, point), Count::Flagged);
        let zero = N::constant(Floats::splat(simd, 0.0));
        let [finer, coarser] = self.plan.others(region);
        let mut found = Found::none(simd);
        for other in finer.iter().chain(coarser) {
            if let Some((share, inside)) = self.share_of(simd, other, point, active, &mut found, Count::Flagged) {
                sum = sum + N::select(inside, share.sum, zero);
                weight = weight + N::select(inside, share.weight, zero);
            }
        }
        sum / weight
    }

    /// From fine to coarse, each level takes what its flagged corners carry of the weight that is left; the coarsest
    /// with flagged corners takes the rest.
    #[inline(always)]
    fn layered<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        region: &RegionPlan,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> N {
        let mut layers = Layers::<N>::none(simd);
        let [finer, coarser] = self.plan.others(region);
        let mut found = Found::none(simd);
        for other in finer {
            if let Some((share, inside)) = self.share_of(simd, other, point, active, &mut found, Count::Existing) {
                layers.add(simd, share, inside);
            }
        }
        layers.add(simd, self.share(simd, &region.brick, Places::own(simd, point), Count::Existing), active);
        for other in coarser {
            let open = layers.left.takes_part() & active;
            if open.all_false() {
                break;
            }
            if let Some((share, inside)) = self.share_of(simd, other, point, open, &mut found, Count::Existing) {
                layers.add(simd, share, inside);
            }
        }
        // Where nothing is left, not even a coarser value that is no number counts.
        let Layers { sum, left, coarsest } = layers;
        N::select(left.takes_part(), left.weigh(coarsest, sum), sum)
    }

    /// What a brick of another level contributes at those of the `open` points that lie in its reach and have found no
    /// brick of its level before, and which these are; `None` where there are none.
    #[inline(always)]
    fn share_of<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        other: &OtherBrick,
        point: [Floats<S>; 3],
        open: Mask<S>,
        found: &mut Found<S>,
        count: Count,
    ) -> Option<(Share<S, N>, Mask<S>)> {
        if found.level != other.level {
            *found = Found { level: other.level, ..Found::none(simd) };
        }
        let near = other.is_near(simd, point) & open & !found.points;
        if near.all_false() {
            return None;
        }
        let places = Places::other(simd, other, point);
        let inside = places.inside(simd, &other.brick) & near;
        if inside.all_false() {
            return None;
        }
        found.points |= inside;
        Some((self.share(simd, &other.brick, places, count), inside))
    }

    /// The cells that contain the points.
    #[inline(always)]
    fn nearest<S: Gather>(&self, simd: S, brick: &PaddedBrick, point: [Floats<S>; 3]) -> Floats<S> {
        let half = Floats::splat(simd, 0.5);
        let one = Integers::splat(simd, 1);
        // Where rounding has led over the brick's low face there may be a hole; `offset` sees to the high one.
        let mut cell = [one; 3];
        for axis in 0..3 {
            cell[axis] = (point[axis] + half).to_int::<Integers<S>>().max(one);
        }
        let offset = offset(simd, brick, cell);
        // SAFETY: `offset` clamps into the brick.
        unsafe { simd.gather(self.field.values().add(brick.start), offset) }
    }

    /// Moves points so that trilinear interpolation of the region's cells gives that of the finest level, whose virtual
    /// corners copy them: the value changes within half a finest cell of a face only. Also returns how fast the points
    /// move with those that they come from.
    #[inline(always)]
    fn onto_finest<S: Gather>(&self, simd: S, region: &RegionPlan, point: [Floats<S>; 3]) -> [[Floats<S>; 3]; 2] {
        let size = self.plan.finest_cells[usize::from(region.frame.level.unwrap_or(0))];
        let (half, zero) = (Floats::splat(simd, 0.5), Floats::splat(simd, 0.0));
        let (mut moved, mut slopes) = (point, point);
        for axis in 0..3 {
            let ratio = Floats::splat(simd, size[axis] as f32);
            let cell = (point[axis] + half).floor();
            // In this order nothing is rounded before it is multiplied.
            let inside = (point[axis] - cell + half) * ratio;
            let (below, above) = (inside - half, inside - ratio + half);
            moved[axis] = cell + below.min(zero) + above.max(zero);
            slopes[axis] = (below.simd_lt(zero) | above.simd_ge(zero)).select(ratio, zero);
        }
        [moved, slopes]
    }

    /// What a brick contributes at points.
    #[inline(always)]
    fn share<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        brick: &PaddedBrick,
        places: Places<S, N>,
        count: Count,
    ) -> Share<S, N> {
        let corners = self.corners(simd, brick, &places);
        let zero = N::constant(Floats::splat(simd, 0.0));
        let (mut sum, mut weight, mut missing) = (zero, zero, zero);
        let (mut flagged, mut flagged_weight) = (Mask::splat(simd, false), Mask::splat(simd, false));
        for corner in 0..8 {
            let hat = N::hat(&places.weights, corner);
            let value = corners[corner];
            let bits: Naturals<S> = value.bitcast();
            let flag = (bits & Naturals::splat(simd, FLAG)).simd_eq(Naturals::splat(simd, FLAG));
            let counts = match count {
                Count::Existing => bits.simd_ne(Naturals::splat(simd, HOLE)) & hat.takes_part(),
                Count::Flagged => flag & hat.takes_part(),
            };
            sum = N::select(counts, hat.weigh_values(value, sum), sum);
            weight = N::select(counts, weight + hat, weight);
            if count == Count::Existing {
                flagged |= flag & counts;
                flagged_weight |= flag & counts & hat.values().simd_gt(0.0);
                missing = N::select(flag, missing, missing + hat);
            }
        }
        if N::HAS_SLOPES {
            // Flagged cells may be there that have a slope alone.
            missing = made_whole(simd, !flagged_weight, missing);
        }
        Share { sum, weight, flagged, flagged_weight, missing }
    }

    /// The eight values around each point, x fastest.
    #[inline(always)]
    fn corners<S: Gather, N>(&self, simd: S, brick: &PaddedBrick, places: &Places<S, N>) -> [Floats<S>; 8] {
        let offset = offset(simd, brick, places.cells);
        let (row, slice) = (brick.strides[0] as isize, brick.strides[1] as isize);
        // SAFETY: `offset` clamps into the brick, whose padding holds the neighbours; the values end with one more.
        let pairs = unsafe {
            let base = self.field.values().add(brick.start);
            [
                simd.gather_pairs(base, offset),
                simd.gather_pairs(base.offset(row), offset),
                simd.gather_pairs(base.offset(slice), offset),
                simd.gather_pairs(base.offset(row + slice), offset),
            ]
        };
        let [[a, b], [c, d], [e, f], [g, h]] = pairs;
        [a, b, c, d, e, f, g, h]
    }
}

/// The distance of cells from the brick's first value; cells outside are moved inside, so that a dual cell starts there.
#[inline(always)]
fn offset<S: Gather>(simd: S, brick: &PaddedBrick, cell: [Integers<S>; 3]) -> Integers<S> {
    let mut clamped = cell;
    for axis in 0..3 {
        // As naturals, what is below zero is above the highest cell.
        let natural: Naturals<S> = cell[axis].bitcast();
        clamped[axis] = natural.min(Naturals::splat(simd, brick.values[axis] as u32)).bitcast();
    }
    let (row, slice) = (Integers::splat(simd, brick.strides[0]), Integers::splat(simd, brick.strides[1]));
    clamped[0] + clamped[1] * row + clamped[2] * slice
}
