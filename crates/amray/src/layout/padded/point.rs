//! One sample at a time, with no search.

use fearless_simd::prelude::*;

use super::plan::Combination;
use super::{Padded, PaddedValues};
use crate::Volume;
use crate::layout::RegionValues;
use crate::reconstruction::{AnySampler, Method};
use crate::simd::{Floats, Gather, InstructionSet, Kernel, LANES, Mask};

/// Samples a padded copy at single points.
pub(crate) struct PaddedPoints<'a> {
    padded: &'a Padded,
    sampler: AnySampler<'a>,
    instructions: InstructionSet,
}

impl<'a> PaddedPoints<'a> {
    /// Of a volume's padded copy.
    pub(crate) fn new(volume: &'a Volume) -> Self {
        Self { padded: volume.padded(), sampler: volume.packet_sampler(), instructions: InstructionSet::best() }
    }

    /// The value at a point of a region, in cells of the finest level. `None` where the copy does not tell, or where
    /// it is not finite.
    #[inline]
    pub(crate) fn value(&self, region: usize, point: [f64; 3]) -> Option<f64> {
        let Padded { field, plan, .. } = self.padded;
        if matches!(plan.method, Method::Nearest | Method::Finest) {
            return None;
        }
        let frame = &plan.regions[region].frame;
        let size = &plan.finest_cells[usize::from(frame.level?)];
        let local: [f64; 3] = std::array::from_fn(|axis| point[axis] / size[axis] - frame.low[axis]);
        let [low, high] = &frame.pure;
        let is_pure = (0..3).all(|axis| (f64::from(low[axis])..=f64::from(high[axis])).contains(&local[axis]));
        let number = if is_pure {
            self.trilinear(region, local)
        } else if plan.combination == Combination::Queried {
            return None;
        } else {
            let values = PaddedValues { field, plan, sampler: &self.sampler };
            f64::from(self.instructions.run(Anywhere { values, region, point: local.map(|place| place as f32) }))
        };
        number.is_finite().then(|| field.normalisation.undo_exactly(number))
    }

    /// Where the region's brick alone is enough, in its padded coordinates.
    #[inline]
    fn trilinear(&self, region: usize, point: [f64; 3]) -> f64 {
        let brick = &self.padded.plan.regions[region].brick;
        let strides = [1, brick.strides[0] as usize, brick.strides[1] as usize];
        let (mut base, mut shares) = (0, [0.0; 3]);
        for axis in 0..3 {
            let cell = (point[axis] as usize).min(brick.values[axis] as usize);
            base += cell * strides[axis];
            shares[axis] = point[axis] - cell as f64;
        }
        let values = self.padded.field.brick(brick);
        let mix = |low: f64, high: f64, share: f64| low + (high - low) * share;
        let along_x = |start: usize| mix(f64::from(values[start]), f64::from(values[start + 1]), shares[0]);
        let along_y = |start: usize| mix(along_x(start), along_x(start + strides[1]), shares[1]);
        mix(along_y(base), along_y(base + strides[2]), shares[2])
    }
}

/// One point anywhere in a region, in its padded coordinates: as the first of sixteen.
struct Anywhere<'a> {
    values: PaddedValues<'a>,
    region: usize,
    point: [f32; 3],
}

impl Kernel for Anywhere<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> f32 {
        let mut point = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            point[axis] = Floats::splat(simd, self.point[axis]);
        }
        let values: [f32; LANES] = self.values.anywhere(simd, self.region, point, Mask::from_bitmask(simd, 1)).into();
        values[0]
    }
}
