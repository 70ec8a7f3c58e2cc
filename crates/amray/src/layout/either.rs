//! Values in one layout or the other, where that is not worth code for each.

use super::{InPlace, Layout, PaddedValues, RegionFrame, RegionValues};
use crate::Volume;
use crate::reconstruction::{AnySampler, LaneNumber, ValuesAndGradients};
use crate::simd::{Floats, Gather, Mask};

/// The values of a volume, wherever they are.
#[derive(Clone, Copy)]
pub(crate) enum EitherValues<'a> {
    Padded(PaddedValues<'a>),
    InPlace(InPlace<'a>),
}

impl<'a> EitherValues<'a> {
    /// A volume's values; `sampler` is the volume's.
    pub(crate) fn new(volume: &'a Volume, layout: Layout, sampler: &'a AnySampler<'a>) -> Self {
        match layout {
            Layout::Padded => Self::Padded(PaddedValues::new(volume.padded(), sampler)),
            Layout::InPlace => Self::InPlace(InPlace { plan: volume.in_place(), sampler }),
        }
    }
}

impl RegionValues for EitherValues<'_> {
    #[inline(always)]
    fn frame(&self, region: usize) -> &RegionFrame {
        match self {
            Self::Padded(values) => values.frame(region),
            Self::InPlace(values) => values.frame(region),
        }
    }

    #[inline(always)]
    fn finest_cells(&self, level: u8) -> &[f64; 3] {
        match self {
            Self::Padded(values) => values.finest_cells(level),
            Self::InPlace(values) => values.finest_cells(level),
        }
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        match self {
            Self::Padded(values) => values.is_finite(),
            Self::InPlace(values) => values.is_finite(),
        }
    }

    #[inline(always)]
    fn in_pure<S: Gather, N: LaneNumber<S>>(&self, simd: S, region: usize, point: [Floats<S>; 3]) -> N {
        match self {
            Self::Padded(values) => values.in_pure(simd, region, point),
            Self::InPlace(values) => values.in_pure(simd, region, point),
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
        match self {
            Self::Padded(values) => values.in_region(simd, region, point, active),
            Self::InPlace(values) => values.in_region(simd, region, point, active),
        }
    }

    // Both layouts' code is there already.
    #[inline(always)]
    fn anywhere<S: Gather>(&self, simd: S, region: usize, point: [Floats<S>; 3], active: Mask<S>) -> Floats<S> {
        match self {
            Self::Padded(values) => values.anywhere(simd, region, point, active),
            Self::InPlace(values) => values.anywhere(simd, region, point, active),
        }
    }

    #[inline(always)]
    fn anywhere_with_gradient<S: Gather>(
        &self,
        simd: S,
        region: usize,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> ValuesAndGradients<S> {
        match self {
            Self::Padded(values) => values.anywhere_with_gradient(simd, region, point, active),
            Self::InPlace(values) => values.anywhere_with_gradient(simd, region, point, active),
        }
    }
}
