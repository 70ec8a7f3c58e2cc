//! What is known of each segment, in tables that lanes look up together.

use fearless_simd::prelude::*;

use crate::simd::{Floats, Gather, Integers, SHORT_TABLES};

/// How many numbers there are of a segment.
pub(super) const KINDS: usize = 16;

/// Where a segment starts.
pub(super) const START: usize = 0;
/// Where it starts; extinction there, and its slope; red, green and blue times extinction there, with slope and
/// curvature.
pub(super) const SLOPES: [usize; 12] = [START, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
/// The integrals of extinction and of red, green and blue times extinction up to the segment's start.
pub(super) const INTEGRALS: [usize; 4] = [12, 13, 14, 15];

/// Tables of equal length, one per kind.
#[derive(Clone, Debug)]
pub(super) enum Tables {
    /// Kept in a register each.
    Sixteen(Box<[[f32; SHORT_TABLES[0]]; KINDS]>),
    /// Kept in two registers each.
    ThirtyTwo(Box<[[f32; SHORT_TABLES[1]]; KINDS]>),
    Long(Box<[Vec<f32>; KINDS]>),
}

impl Tables {
    /// The tables of segments, in their order.
    pub(super) fn new(segments: &[[f32; KINDS]]) -> Self {
        match segments.len() {
            count if count <= SHORT_TABLES[0] => Self::Sixteen(Box::new(short(segments))),
            count if count <= SHORT_TABLES[1] => Self::ThirtyTwo(Box::new(short(segments))),
            _ => {
                Self::Long(Box::new(std::array::from_fn(|kind| segments.iter().map(|segment| segment[kind]).collect())))
            }
        }
    }

    /// A table; what is beyond the last segment is infinite.
    pub(super) fn table(&self, kind: usize) -> &[f32] {
        match self {
            Self::Sixteen(tables) => &tables[kind],
            Self::ThirtyTwo(tables) => &tables[kind],
            Self::Long(tables) => &tables[kind],
        }
    }

    /// The numbers of several kinds of the same segments.
    #[inline(always)]
    pub(super) fn look_up<S: Gather, const COUNT: usize>(
        &self,
        simd: S,
        kinds: [usize; COUNT],
        segment: Integers<S>,
    ) -> [Floats<S>; COUNT] {
        let mut found = [Floats::splat(simd, 0.0); COUNT];
        match self {
            Self::Sixteen(tables) => {
                for place in 0..COUNT {
                    found[place] = simd.look_up_16(&tables[kinds[place]], segment);
                }
            }
            Self::ThirtyTwo(tables) => {
                for place in 0..COUNT {
                    found[place] = simd.look_up_32(&tables[kinds[place]], segment);
                }
            }
            Self::Long(tables) => {
                for place in 0..COUNT {
                    found[place] = simd.look_up(&tables[kinds[place]], segment);
                }
            }
        }
        found
    }
}

fn short<const LENGTH: usize>(segments: &[[f32; KINDS]]) -> [[f32; LENGTH]; KINDS] {
    std::array::from_fn(|kind| {
        std::array::from_fn(|place| segments.get(place).map_or(f32::INFINITY, |segment| segment[kind]))
    })
}
