//! Packets of points in a field of either number type.

use super::{LaneNumber, PacketPoints, PacketSampler, Samples};
use crate::hierarchy::{FieldValues, Normalisation};
use crate::index::Index;
use crate::reconstruction::Method;
use crate::simd::{Floats, Gather, Mask};

/// A [`PacketSampler`] of either number type.
pub(crate) enum AnySampler<'a> {
    F32(PacketSampler<'a, f32>),
    F64(PacketSampler<'a, f64>),
}

impl<'a> AnySampler<'a> {
    pub(crate) fn new(index: &'a Index, values: &'a FieldValues, method: Method, normalisation: Normalisation) -> Self {
        match values {
            FieldValues::F32(bricks) => Self::F32(PacketSampler::new(index, bricks, method, normalisation)),
            FieldValues::F64(bricks) => Self::F64(PacketSampler::new(index, bricks, method, normalisation)),
        }
    }

    /// As [`PacketSampler::sample`].
    #[inline(always)]
    pub(crate) fn sample<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        points: &PacketPoints,
        active: Mask<S>,
    ) -> Samples<S, N> {
        match self {
            Self::F32(sampler) => sampler.sample(simd, points, active),
            Self::F64(sampler) => sampler.sample(simd, points, active),
        }
    }

    /// As [`PacketSampler::in_brick`].
    #[inline(always)]
    pub(crate) fn in_brick<S: Gather, N: LaneNumber<S>>(&self, simd: S, brick: usize, point: [Floats<S>; 3]) -> N {
        match self {
            Self::F32(sampler) => sampler.in_brick(simd, brick, point),
            Self::F64(sampler) => sampler.in_brick(simd, brick, point),
        }
    }

    /// As [`PacketSampler::is_packed`].
    pub(crate) fn is_packed(&self) -> bool {
        match self {
            Self::F32(sampler) => sampler.is_packed(),
            Self::F64(sampler) => sampler.is_packed(),
        }
    }
}
