//! Where light meets the medium, and how much of it passes: delta tracking and ratio tracking.
//!
//! Both go from one tentative meeting to the next, as far apart as in a homogeneous medium of the majorant's extinction.
//! At each the medium's own extinction tells the odds that it was one: that makes both exact on average, however values
//! run in between (Woodcock et al. 1965; Novák, Selle, Jarosz, *Residual Ratio Tracking*, 2014).

use std::ops::ControlFlow;

use super::super::clip::Clips;
use super::super::surface::Layers;
use super::PathStatistics;
use super::majorants::Majorants;
use super::random::Random;
use crate::appearance::PreparedTransferFunction;
use crate::hierarchy::Voxel;
use crate::index::{NodeSpan, Ray};
use crate::layout::PaddedPoints;
use crate::reconstruction::Sampler;

/// A medium: what light meets.
pub(super) struct Medium<'a, T> {
    pub(super) sampler: Sampler<'a, T>,
    /// Where most values are found with no search.
    pub(super) padded: Option<&'a PaddedPoints<'a>>,
    pub(super) function: &'a PreparedTransferFunction,
    pub(super) majorants: &'a Majorants,
    pub(super) clips: &'a Clips,
}

/// What paths use one after the other: memory, and counters.
#[derive(Default)]
pub(super) struct Scratch {
    waiting: Vec<NodeSpan>,
    pub(super) layers: Layers,
    pub(super) statistics: PathStatistics,
}

/// A tentative meeting.
struct Tentative {
    /// How far along the ray.
    t: f64,
    value: f64,
    /// The medium's extinction over the majorant, 0 to 1.
    odds: f64,
}

/// A place where light is scattered, or comes from.
pub(super) struct Meeting {
    /// How far along the ray.
    pub(super) t: f64,
    /// In cells of the finest level.
    pub(super) place: [f64; 3],
    /// What the medium looks like there.
    pub(super) color: [f32; 3],
}

/// Where so little passes, it is left to chance whether it is worth to find out how much less.
const FAINT: f64 = 0.1;

impl<T: Voxel> Medium<'_, T> {
    /// Where light that goes along a ray meets the medium first. The ray's direction has length 1 in world units.
    pub(super) fn meet(&self, ray: Ray, random: &mut Random, scratch: &mut Scratch) -> Option<Meeting> {
        let mut met = None;
        self.track(ray, f64::INFINITY, random, scratch, |random, tentative| {
            if random.unit() < tentative.odds {
                met = Some(tentative);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        });
        met.map(|Tentative { t, value, .. }| Meeting {
            t,
            place: std::array::from_fn(|axis| ray.start[axis] + t * ray.direction[axis]),
            color: self.function.sample(value).color,
        })
    }

    /// How much light passes along a ray as far as `far`, on average over calls: 0 to 1.
    pub(super) fn transmittance(&self, ray: Ray, far: f64, random: &mut Random, scratch: &mut Scratch) -> f64 {
        let mut passing = 1.0;
        self.track(ray, far, random, scratch, |random, tentative| {
            passing *= 1.0 - tentative.odds;
            if passing < FAINT {
                passing = if random.unit() * FAINT < passing { FAINT } else { 0.0 };
            }
            if passing > 0.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        passing
    }

    /// Calls `visit` with every tentative meeting on a ray before `far`, until it breaks.
    #[inline]
    fn track(
        &self,
        ray: Ray,
        far: f64,
        random: &mut Random,
        scratch: &mut Scratch,
        mut visit: impl FnMut(&mut Random, Tentative) -> ControlFlow<()>,
    ) {
        let Scratch { waiting, statistics, .. } = scratch;
        // The optical depth, of the majorants, that is left until the next meeting.
        let mut depth = random.optical_depth();
        for (part, [enter, leave]) in self.majorants.walk(ray, [0.0, far], waiting) {
            let mut t = enter;
            loop {
                let next = t + depth / part.majorant;
                if next >= leave {
                    depth = (depth - (leave - t) * part.majorant).max(0.0);
                    break;
                }
                t = next;
                depth = random.optical_depth();
                let place = std::array::from_fn(|axis| ray.start[axis] + t * ray.direction[axis]);
                if self.clips.hides(place) {
                    continue;
                }
                let value = self.value(part.region, part.inside(place));
                let extinction = self.function.extinction_at(value).min(part.opaque);
                statistics.samples += 1;
                statistics.beyond_majorant += u64::from(extinction > part.majorant);
                let odds = (extinction / part.majorant).min(1.0);
                if visit(random, Tentative { t, value, odds }).is_break() {
                    return;
                }
            }
        }
    }

    /// The value at a place in a region.
    #[inline]
    fn value(&self, region: usize, place: [f64; 3]) -> f64 {
        let found = self.padded.and_then(|padded| padded.value(region, place));
        found.unwrap_or_else(|| self.sampler.sample_in(region, place))
    }
}
