//! A packet's way through one region: where its samples lie in the region's own coordinates.

use fearless_simd::prelude::*;

use super::super::packet::Packet;
use crate::layout::RegionFrame;
use crate::simd::{Doubles, Floats, Gather};

/// How wide a pixel is, in world units over the samples per cell: at the eye, and by how much more per distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Footprint {
    pub(in super::super) near: f32,
    pub(in super::super) growth: f32,
    /// By what power of two steps are longer at least.
    pub(in super::super) least: f32,
}

impl Footprint {
    /// No steps are longer than cells ask for.
    pub(in super::super) const NONE: Self = Self { near: 0.0, growth: 0.0, least: 1.0 };
    /// Shadows are softer than what casts them.
    pub(in super::super) const OCCLUDERS: Self = Self { least: 2.0, ..Self::NONE };

    /// The highest power of two by which a step can be longer and still fit the pixel.
    #[inline(always)]
    pub(super) fn longer(self, step: f32, distance: f32) -> f32 {
        let times = (self.near + self.growth * distance) / step;
        // Without its fraction a number is the power of two below.
        let fitting =
            if (2.0..f32::MAX).contains(&times) { f32::from_bits(times.to_bits() & 0x7f80_0000) } else { 1.0 };
        fitting.max(self.least)
    }
}

/// A packet on its way through one region.
#[derive(Clone, Copy)]
pub(super) struct Course<S: Gather> {
    /// The first point, in the region's local coordinates, and how far a step goes.
    pub(super) start: [Floats<S>; 3],
    pub(super) stride: [Floats<S>; 3],
    /// How many samples each ray takes, and the most of them.
    pub(super) counts: Floats<S>,
    pub(super) most: f32,
    pub(super) first_at: Doubles<S>,
    pub(super) step: Floats<S>,
    /// How far it is from the last sample to the next.
    pub(super) length: Floats<S>,
    /// From the first to the last step at which all rays are in the region's pure box.
    pub(super) pure: [f32; 2],
}

impl<S: Gather> Course<S> {
    /// Of no rays.
    #[inline(always)]
    pub(super) fn none(simd: S) -> Self {
        let zero = Floats::splat(simd, 0.0);
        let nowhere = Doubles::splat(simd, 0.0);
        Self {
            start: [zero; 3],
            stride: [zero; 3],
            counts: zero,
            most: 0.0,
            first_at: nowhere,
            step: zero,
            length: zero,
            pure: [0.0; 2],
        }
    }
}

/// Rays in a region's padded coordinates: scale * (start + t * direction) - low.
pub(in super::super) struct LocalRays<'a, S: Gather> {
    packet: &'a Packet<S>,
    frame: &'a RegionFrame,
    /// Cells of the finest level per cell of the region's.
    size: &'a [f64; 3],
    scale: [f64; 3],
}

impl<'a, S: Gather> LocalRays<'a, S> {
    /// A packet in a region with this frame, whose cells are so many of the finest level's.
    #[inline(always)]
    pub(in super::super) fn new(packet: &'a Packet<S>, frame: &'a RegionFrame, size: &'a [f64; 3]) -> Self {
        Self { packet, frame, size, scale: [size[0].recip(), size[1].recip(), size[2].recip()] }
    }

    #[inline(always)]
    pub(in super::super) fn at(&self, simd: S, at: Doubles<S>) -> [Floats<S>; 3] {
        let mut point = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            let cells = at.mul_add(self.packet.direction[axis], self.packet.start[axis]);
            let scale = Doubles::splat(simd, self.scale[axis]);
            point[axis] = cells.mul_add(scale, Doubles::splat(simd, -self.frame.low[axis])).to_floats();
        }
        point
    }

    /// How far a step goes.
    #[inline(always)]
    pub(in super::super) fn stride(&self, simd: S, step: Floats<S>) -> [Floats<S>; 3] {
        let mut stride = [step; 3];
        for axis in 0..3 {
            stride[axis] *= self.packet.direction[axis].to_floats() * Floats::splat(simd, self.scale[axis] as f32);
        }
        stride
    }

    /// From where to where the rays are in the region's pure box, counted from 0 at `start`, `rate` per length.
    #[inline(always)]
    pub(in super::super) fn pure(&self, simd: S, start: &[Floats<S>; 3], rate: Floats<S>) -> [Floats<S>; 2] {
        let (zero, infinity) = (Floats::splat(simd, 0.0), Floats::splat(simd, f32::INFINITY));
        let (mut enter, mut leave) = (zero, infinity);
        if self.frame.is_pure {
            return [enter, leave];
        }
        for axis in 0..3 {
            let inverse = self.packet.inverse[axis] * rate * Floats::splat(simd, self.size[axis] as f32);
            let a = (Floats::splat(simd, self.frame.pure[0][axis]) - start[axis]) * inverse;
            let b = (Floats::splat(simd, self.frame.pure[1][axis]) - start[axis]) * inverse;
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        [enter, leave]
    }

    /// The steps, counted from 0 at `start`, at which all rays are inside the region's pure box; `rate` are steps per
    /// length.
    #[inline(always)]
    pub(super) fn pure_steps(&self, simd: S, start: &[Floats<S>; 3], rate: Floats<S>, counts: Floats<S>) -> [f32; 2] {
        if self.frame.is_pure {
            return [0.0, f32::INFINITY];
        }
        let (zero, infinity) = (Floats::splat(simd, 0.0), Floats::splat(simd, f32::INFINITY));
        let [enter, leave] = self.pure(simd, start, rate);
        // Rays that are through before they get there, or before they leave, do not matter.
        let enter = enter.min(counts);
        let leave = leave.simd_ge(counts - Floats::splat(simd, 1.0)).select(infinity, leave);
        let used = counts.simd_gt(zero);
        [simd.reduce_max_f32x16(used.select(enter, zero)), simd.reduce_min_f32x16(used.select(leave, infinity))]
    }
}
