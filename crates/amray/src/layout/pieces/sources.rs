//! What pieces are like in a padded copy, and where values stay in place.

use super::block::Block;
use super::{PieceNode, Source};
use crate::hierarchy::{BrickValues, Centering, IndexBox, Normalisation, Voxel};
use crate::index::{Index, ValueRanges};
use crate::layout::RegionFrame;
use crate::layout::padded::{NOT_FINITE, PaddedBrick, PaddedField, Padding, Plan};

/// Pieces of a padded copy, which holds all values that samples touch.
pub(in crate::layout) struct PaddedPieces<'a> {
    pub(in crate::layout) ranges: &'a ValueRanges,
    pub(in crate::layout) plan: &'a Plan,
    pub(in crate::layout) field: &'a PaddedField,
}

impl Source for PaddedPieces<'_> {
    fn frame(&self, region: usize) -> &RegionFrame {
        &self.plan.regions[region].frame
    }

    #[inline(always)]
    fn piece(&self, region: usize, cells: &IndexBox, size: [i64; 3]) -> PieceNode {
        let plan = &self.plan.regions[region];
        let ends = local(&plan.frame, cells, size);
        let mut piece = PieceNode::NOTHING;
        self.widen(&plan.brick, ends, 1.0, &mut piece);
        if plan.frame.is_pure || is_inside(&plan.frame, ends) {
            return piece;
        }
        if !self.plan.is_complete() {
            piece.range = self.ranges.region(region).map(|value| self.field.normalisation.apply(value.into()));
            return piece;
        }
        for other in self.plan.others(plan).into_iter().flatten() {
            let moved =
                |point: [f64; 3]| -> [f64; 3] { std::array::from_fn(|axis| other.axes[axis].apply(point[axis])) };
            // Second differences grow with the square of a cell's size.
            let finer = other.axes.iter().map(|axis| axis.multiple / axis.parts).fold(0.0, f32::max);
            self.widen(&other.brick, ends.map(moved), finer * finer, &mut piece);
        }
        piece
    }
}

impl PaddedPieces<'_> {
    /// By the values of a brick that samples between two places can touch.
    #[inline(always)]
    fn widen(&self, brick: &PaddedBrick, [low, high]: [[f64; 3]; 2], scale: f32, piece: &mut PieceNode) {
        let end = |axis: usize| (high[axis].floor().min(f64::from(brick.values[axis])) + 2.0).max(0.0) as usize;
        let block = Block {
            values: self.field.brick(brick),
            strides: brick.strides.map(|stride| stride as usize),
            looked: [low.map(|low| low.floor().max(0.0) as usize), [end(0), end(1), end(2)]],
            // Padding has no neighbours on all sides, and is some other piece's cell.
            inner: [[1; 3], brick.values.map(|cells| cells as usize + 1)],
            is_finite: self.field.is_finite,
            flagged_only: Padding::of(self.plan.method) == Padding::Leaves,
        };
        block.widen(scale, piece);
    }
}

/// Pieces of bricks that stay where they are.
pub(in crate::layout) struct BrickPieces<'a, T> {
    pub(in crate::layout) index: &'a Index,
    pub(in crate::layout) ranges: &'a ValueRanges,
    pub(in crate::layout) normalisation: Normalisation,
    pub(in crate::layout) centering: Centering,
    /// Per region, where it lies, and its finest brick.
    pub(in crate::layout) frames: &'a [RegionFrame],
    pub(in crate::layout) places: &'a [u32],
    pub(in crate::layout) bricks: &'a [BrickValues<T>],
}

impl<T: Voxel> Source for BrickPieces<'_, T> {
    fn frame(&self, region: usize) -> &RegionFrame {
        &self.frames[region]
    }

    #[inline(always)]
    fn piece(&self, region: usize, cells: &IndexBox, size: [i64; 3]) -> PieceNode {
        let (frame, place) = (&self.frames[region], self.places[region] as usize);
        let level = usize::from(frame.level.unwrap_or(0));
        let brick = self.index.hierarchy().levels()[level].brick_at(place);
        // The piece's values and one more on each side, as far as the brick has them.
        let around = self.centering.values_of(&cells.coarsened(size)).grown([1; 3]);
        let own = around.intersection(&self.centering.values_of(&brick));
        let mut values = Vec::with_capacity(own.cells() as usize);
        self.bricks[place].for_each_in(brick.low, &own, |value| {
            let value = self.normalisation.apply(value.to_f64());
            values.push(if value.is_finite() { value } else { f32::from_bits(NOT_FINITE) });
        });
        let sides = own.size().map(|cells| cells as usize);
        let block = Block {
            values: &values,
            strides: [sides[0], sides[0] * sides[1]],
            looked: [[0; 3], sides],
            inner: [[1; 3], sides.map(|side| side.saturating_sub(1))],
            is_finite: false,
            flagged_only: false,
        };
        let mut piece = PieceNode::NOTHING;
        block.widen(1.0, &mut piece);
        let inside = is_inside(frame, local(frame, cells, size));
        // Nodes on a brick's face, where values bend, are inside.
        let ends_on_nodes = self.centering == Centering::Nodes && own != around;
        if !inside {
            piece.range = self.ranges.region(region).map(|value| self.normalisation.apply(value.into()));
        }
        if sides.iter().any(|&side| side < 3) {
            // Nothing is known of how values go on: each of six second differences is at most twice the range.
            piece.roughness = piece.roughness.max(12.0 * (piece.range[1] - piece.range[0]).max(0.0));
        } else if ends_on_nodes || !inside && self.meets_other_levels(level, cells, size) {
            // Across the face, values of smaller or larger cells are about as far away as the brick's own.
            piece.roughness += block.steepest();
        }
        piece
    }
}

impl<T> BrickPieces<'_, T> {
    /// Whether cells of other levels, or holes, are in reach of a part of a region of `level`.
    fn meets_other_levels(&self, level: usize, cells: &IndexBox, size: [i64; 3]) -> bool {
        let mut meets = false;
        let around = cells.grown(size).intersection(&self.index.domain());
        self.index.for_each_region_in(&around, &mut |other, _| {
            meets |= self.index.regions()[other].finest_level() != Some(level);
        });
        meets
    }
}

/// The corners of a part of a region, in cells of the finest level, in the region's local coordinates.
#[inline(always)]
fn local(frame: &RegionFrame, cells: &IndexBox, size: [i64; 3]) -> [[f64; 3]; 2] {
    [cells.low, cells.high]
        .map(|corner| std::array::from_fn(|axis| corner[axis] as f64 / size[axis] as f64 - frame.low[axis]))
}

/// Whether one brick alone is enough between two places.
#[inline(always)]
fn is_inside(frame: &RegionFrame, [low, high]: [[f64; 3]; 2]) -> bool {
    (0..3).all(|axis| f64::from(frame.pure[0][axis]) <= low[axis] && high[axis] <= f64::from(frame.pure[1][axis]))
}
