//! Planes of any direction, in cells of the finest level.

use fearless_simd::prelude::*;

use super::packet::Packet;
use crate::hierarchy::Hierarchy;
use crate::simd::{Doubles, Floats, Gather};

/// A plane: places in cells of the finest level whose product with `across` is `offset`.
pub(super) struct Plane {
    pub(super) across: [f64; 3],
    pub(super) offset: f64,
}

/// By how much of itself a length may be off.
const ROUNDING: f32 = 1e-6;

impl Plane {
    /// The plane through a point, both in world units.
    pub(super) fn new(hierarchy: &Hierarchy, point: [f64; 3], normal: [f64; 3]) -> Self {
        let finest = hierarchy.finest_level();
        let size = hierarchy.levels()[finest].cell_size();
        let place = hierarchy.to_cells(finest, point);
        let across: [f64; 3] = std::array::from_fn(|axis| normal[axis] * size[axis]);
        Self { across, offset: (0..3).map(|axis| across[axis] * place[axis]).sum() }
    }

    /// How far before the plane rays start, and how fast they go away from it.
    #[inline(always)]
    fn approach<S: Gather>(&self, simd: S, packet: &Packet<S>) -> [Floats<S>; 2] {
        let (mut distance, mut speed) = (Doubles::splat(simd, -self.offset), Doubles::splat(simd, 0.0));
        for axis in 0..3 {
            let across = Doubles::splat(simd, self.across[axis]);
            distance = packet.start[axis].mul_add(across, distance);
            speed = packet.direction[axis].mul_add(across, speed);
        }
        [distance.to_floats(), speed.to_floats()]
    }

    /// Where rays meet the plane inside of the domain, which they enter and leave at these ends; infinity elsewhere.
    #[inline(always)]
    pub(super) fn meets<S: Gather>(&self, simd: S, packet: &Packet<S>, [enter, leave]: [Floats<S>; 2]) -> Floats<S> {
        let [distance, speed] = self.approach(simd, packet);
        let at = -(distance / speed);
        // A slice on the domain's very face is inside.
        let nearly = (leave + Floats::splat(simd, 1.0)) * Floats::splat(simd, ROUNDING);
        let inside = at.simd_ge(enter - nearly) & at.simd_le(leave + nearly) & enter.simd_lt(leave);
        inside.select(at.max(enter).min(leave), Floats::splat(simd, f32::INFINITY))
    }

    /// The part of rays that is on the plane's far side, where `across` points to.
    #[inline(always)]
    pub(super) fn beyond<S: Gather>(
        &self,
        simd: S,
        packet: &Packet<S>,
        [enter, leave]: [Floats<S>; 2],
    ) -> [Floats<S>; 2] {
        let zero = Floats::splat(simd, 0.0);
        let [distance, speed] = self.approach(simd, packet);
        let at = -(distance / speed);
        let never = speed.simd_eq(zero) & distance.simd_lt(zero);
        let enter = speed.simd_gt(zero).select(enter.max(at), enter);
        let leave = speed.simd_lt(zero).select(leave.min(at), leave);
        [enter, never.select(enter, leave)]
    }

    /// Whether a place is on the far side.
    pub(super) fn is_beyond(&self, place: [f64; 3]) -> bool {
        (0..3).map(|axis| self.across[axis] * place[axis]).sum::<f64>() >= self.offset
    }
}
