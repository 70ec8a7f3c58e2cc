//! The dual cells of one level around the points of a packet: eight corners, their hats and their closest existing
//! cells.

use fearless_simd::prelude::*;

use super::{LaneNumber, Packet, PacketSampler, linear_weights, made_whole};
use crate::hierarchy::Voxel;
use crate::index::{DualDescent, PlaneLanes};
use crate::simd::{Doubles, Floats, Gather, Integers, LaneSet, Mask, lanes_of, mask_of};

/// Beside 1, single precision does not see weights up to this one.
pub(super) const NO_WEIGHT: f32 = f32::EPSILON / 2.0;

/// What is known of dual cells. Corners count x + 2 y + 4 z, 0 low and 1 high per axis; sets of lanes are per corner.
pub(super) struct DualCells<S: Gather, N> {
    /// The weights of the low and the high side, per axis; beside holes either may be all that a mean has, so both are
    /// as exact as can be.
    pub(super) weights: [[N; 2]; 3],
    /// The logical cells of each side, moved into the domain.
    pub(super) cells: [[Integers<S>; 2]; 3],
    /// The closest existing cells' values; 0 where there is none, or no weight.
    pub(super) values: [Floats<S>; 8],
    /// The corner carries weight, or begins to where there are slopes.
    pub(super) weighty: [LaneSet; 8],
    /// ... and has a closest existing cell.
    pub(super) existing: [LaneSet; 8],
    /// ... which is an actual cell of the level.
    pub(super) actual: [LaneSet; 8],
    /// ... and no finer level covers its centre.
    pub(super) uncovered: [LaneSet; 8],
    /// The logical cell lay in the domain to begin with.
    pub(super) in_domain: [LaneSet; 8],
}

/// The trilinear values of one level.
pub(super) struct Lerp<N> {
    /// The hat-weighted mean of the corners' closest existing cells; NaN where no corner has one.
    pub(super) values: N,
    /// The share of the weight that virtual corners carry: 0 to 1, and exactly 0 where there are none.
    pub(super) missing: N,
    /// Where actual corners carry weight, or begin to where there are slopes.
    pub(super) any_actual: LaneSet,
    /// Where actual corners carry weight.
    pub(super) any_weight: LaneSet,
}

impl<T: Voxel> PacketSampler<'_, T> {
    /// The dual cells of `level` around the points of `lanes`.
    #[inline(always)]
    pub(super) fn dual_cells<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        level: usize,
        points: &[Doubles<S>; 3],
        lanes: LaneSet,
    ) -> DualCells<S, N> {
        let lattice = &self.levels[level];
        let zero = Integers::splat(simd, 0);
        let mut cells = [[zero; 2]; 3];
        let mut weights = [[N::constant(Floats::splat(simd, 0.0)); 2]; 3];
        let (mut planes, mut in_domain) = (PlaneLanes::default(), PlaneLanes::default());
        for axis in 0..3 {
            let position = lattice.position::<S, N>(simd, axis, points[axis], self.domain[axis][0], -0.5);
            let (base, rest) = position.split(simd);
            let low = (Doubles::splat(simd, 1.0) - (position - position.floor())).to_floats();
            // What has no weight has none whether slopes are asked for or not.
            let sides = [rest.simd_lt(1.0), rest.simd_gt(NO_WEIGHT)];
            let nothing = Floats::splat(simd, 0.0);
            let (low, rest) = (sides[0].select(low, nothing), sides[1].select(rest, nothing));
            weights[axis] = linear_weights(axis, [low, rest], Floats::splat(simd, lattice.scale(axis) as f32));
            let mut weighty = [Mask::splat(simd, true); 2];
            if !N::HAS_SLOPES {
                weighty = sides;
            }
            for side in 0..2 {
                let cell = base + side as i32;
                cells[axis][side] = cell.max(zero).min(Integers::splat(simd, lattice.last(axis)));
                planes.0[axis][side] = lanes & lanes_of(weighty[side]);
                in_domain.0[axis][side] = lanes_of(cell.simd_eq(cells[axis][side]));
            }
        }
        let mut dual = self.read_dual_cells(simd, level, weights, cells, planes);
        dual.in_domain = in_domain.corners();
        dual
    }

    /// Finds and reads the `cells` of `level` where the `planes` through them meet; those that are looked at lie in the
    /// domain.
    #[inline(always)]
    pub(super) fn read_dual_cells<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        level: usize,
        weights: [[N; 2]; 3],
        cells: [[Integers<S>; 2]; 3],
        planes: PlaneLanes,
    ) -> DualCells<S, N> {
        let weighty = planes.corners();
        let mut dual = DualCells {
            weights,
            cells,
            values: [Floats::splat(simd, 0.0); 8],
            weighty,
            existing: [0; 8],
            actual: [0; 8],
            uncovered: [0; 8],
            in_domain: weighty,
        };
        let mut centers = cells;
        for axis in 0..3 {
            for side in 0..2 {
                centers[axis][side] = self.levels[level].center(axis, cells[axis][side]);
            }
        }
        let mut descent = DualDescent::new(planes);
        while let Some((region, planes)) = descent.next(simd, self.index, &centers) {
            let region = &self.index.regions()[region];
            let Some((found, brick)) = self.index.finest_brick(region, level) else { continue };
            let here = planes.corners();
            let brick = &self.bricks[brick];
            if found == level {
                brick.read_corners(simd, &cells, &here, &self.normalisation, &mut dual.values);
            } else {
                let lattice = &self.levels[found];
                let mut coarser = centers;
                for axis in 0..3 {
                    for side in 0..2 {
                        coarser[axis][side] = lattice.holding(simd, axis, centers[axis][side]);
                    }
                }
                brick.read_corners(simd, &coarser, &here, &self.normalisation, &mut dual.values);
            }
            let covered = region.finest_level() > Some(level);
            for corner in 0..8 {
                dual.existing[corner] |= here[corner];
                dual.actual[corner] |= if found == level { here[corner] } else { 0 };
                dual.uncovered[corner] |= if found == level && !covered { here[corner] } else { 0 };
            }
        }
        dual
    }

    /// Takes the trilinear values of `level` for `lanes`.
    #[inline(always)]
    pub(super) fn lerp_at<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        level: usize,
        lanes: LaneSet,
        packet: &mut Packet<S, N>,
    ) {
        let values = self.dual_cells::<S, N>(simd, level, &packet.points, lanes).mean(simd);
        packet.values = N::select(mask_of(simd, lanes), values, packet.values);
    }
}

/// Trilinear interpolation between eight corners, all of which count.
#[inline(always)]
pub(super) fn interpolate<S: Gather, N: LaneNumber<S>>(simd: S, corners: &[Floats<S>; 8], weights: &[[N; 2]; 3]) -> N {
    let [[_, x], [_, y], [_, z]] = *weights;
    let values = N::trilinear(corners, [x, y, z]);
    let finite = values.all_finite();
    if !N::HAS_SLOPES || finite.all_true() {
        return values;
    }
    // A corner that is no number takes part only in what it has weight in, the value or a slope.
    N::select(finite, values, weighted_mean(simd, corners, &[LaneSet::MAX; 8], weights))
}

/// The hat-weighted mean of those corners that count in each lane; NaN where none does.
#[inline(always)]
fn weighted_mean<S: Gather, N: LaneNumber<S>>(
    simd: S,
    corners: &[Floats<S>; 8],
    counting: &[LaneSet; 8],
    weights: &[[N; 2]; 3],
) -> N {
    let zero = N::constant(Floats::splat(simd, 0.0));
    let (mut sum, mut weight) = (zero, zero);
    for corner in 0..8 {
        let counts = mask_of(simd, counting[corner]);
        let hat = N::hat(weights, corner);
        sum = N::select(counts, hat.weigh_values(corners[corner], sum), sum);
        weight = N::select(counts, weight + hat, weight);
    }
    sum / weight
}

impl<S: Gather, N: LaneNumber<S>> DualCells<S, N> {
    /// The weight that the corners of these lanes carry.
    #[inline(always)]
    pub(super) fn weight(&self, simd: S, corners: &[LaneSet; 8]) -> N {
        let mut weight = N::constant(Floats::splat(simd, 0.0));
        for corner in 0..8 {
            let hat = N::hat(&self.weights, corner);
            weight = N::select(mask_of(simd, corners[corner]), weight + hat, weight);
        }
        weight
    }

    /// The hat-weighted mean of the corners that exist; NaN where none does.
    #[inline(always)]
    pub(super) fn mean(&self, simd: S) -> N {
        if self.existing == self.weighty {
            return interpolate(simd, &self.values, &self.weights);
        }
        let mean = weighted_mean(simd, &self.values, &self.existing, &self.weights);
        if !N::HAS_SLOPES {
            return mean;
        }
        // Between equal corners there is no slope at all, however steep the weights are.
        let mut incomplete = 0;
        for corner in 0..8 {
            incomplete |= self.weighty[corner] & !self.existing[corner];
        }
        N::select(mask_of(simd, incomplete), mean, interpolate(simd, &self.values, &self.weights))
    }

    #[inline(always)]
    pub(super) fn lerp(&self, simd: S) -> Lerp<N> {
        let mut missing = N::constant(Floats::splat(simd, 0.0));
        if self.virtual_corners() != 0 {
            let mut corners = self.weighty;
            for (corner, actual) in corners.iter_mut().zip(self.actual) {
                *corner &= !actual;
            }
            missing = self.weight(simd, &corners);
            if N::HAS_SLOPES {
                // Actual corners may be there that have a slope alone.
                missing = made_whole(simd, !mask_of(simd, self.any_weight()), missing);
            }
        }
        Lerp { values: self.mean(simd), missing, any_actual: self.any_actual(), any_weight: self.any_weight() }
    }

    /// The lanes with corners that are actual cells.
    #[inline(always)]
    pub(super) fn any_actual(&self) -> LaneSet {
        let [a, b, c, d, e, f, g, h] = self.actual;
        a | b | c | d | e | f | g | h
    }

    /// The lanes with corners that are actual cells and carry weight.
    #[inline(always)]
    pub(super) fn any_weight(&self) -> LaneSet {
        let mut lanes = 0;
        for corner in 0..8 {
            lanes |= match N::HAS_SLOPES {
                true => self.actual[corner] & lanes_of(N::hat(&self.weights, corner).values().simd_gt(0.0)),
                false => self.actual[corner],
            };
        }
        lanes
    }

    /// The lanes with corners of weight that are no actual cells.
    #[inline(always)]
    pub(super) fn virtual_corners(&self) -> LaneSet {
        let mut lanes = 0;
        for corner in 0..8 {
            lanes |= self.weighty[corner] & !self.actual[corner];
        }
        lanes
    }
}
