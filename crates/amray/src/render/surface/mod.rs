//! Surfaces in the picture: rays go through what lies before a surface, take its light, and go on behind it.

mod coat;
mod find;
mod layers;
mod look;
mod plan;
mod probe;
mod shade;

use fearless_simd::prelude::*;

use super::clip::Clips;
use super::lit::{Lamps, Occluders, Occlusion};
use super::march::clear;
use super::packet::{PACKETS, Packets};
use super::traverse::{Span, Stack};
use super::{RenderStatistics, Trace};
use crate::appearance::Radiance;
use crate::layout::{PieceNode, RegionValues};
use crate::simd::{Floats, Gather};

use find::Seeker;
pub(super) use layers::Layers;
pub(super) use plan::SurfacePlan;
pub(super) use probe::{Probe, SurfacePoint};

/// How many surfaces a ray goes through at most.
const MOST: usize = 256;

/// The surfaces of a scene, over the values in which isosurfaces are found.
#[derive(Clone, Copy)]
pub(super) struct Surfaces<'a, V> {
    pub(super) plan: &'a SurfacePlan<'a>,
    pub(super) values: V,
    pub(super) pieces: &'a [PieceNode],
    pub(super) clips: &'a Clips,
}

/// An engine with surfaces in its way.
pub(super) struct WithSurfaces<'a, E, V, O> {
    pub(super) engine: &'a E,
    pub(super) surfaces: Surfaces<'a, V>,
    pub(super) lamps: &'a Lamps,
    /// `None` where all light arrives.
    pub(super) occlusion: Option<&'a Occlusion<'a, O>>,
}

impl<E: Trace, V: RegionValues + Copy, O: Occluders> Trace for WithSurfaces<'_, E, V, O> {
    type Scratch<S: Gather> = (E::Scratch<S>, (Stack<S>, Layers));

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        (scratch, (stack, layers)): &mut (E::Scratch<S>, (Stack<S>, Layers)),
        statistics: &mut RenderStatistics,
    ) {
        let reach = reach(simd, packets);
        let mut seeker = Seeker::new(simd, self.surfaces, packets, *span, stack);
        seeker.seek_meshes(simd, packets, &reach, layers);
        let mut part = *span;
        for _ in 0..MOST {
            let met = seeker.met;
            let mut meeting = met.rays;
            let mut any = false;
            for packet in 0..PACKETS {
                part.leave[packet] = span.leave[packet].min(met.at[packet]);
            }
            self.engine.trace_apart(simd, packets, &part, lights, scratch, statistics);
            for packet in 0..PACKETS {
                meeting[packet] &= clear(simd, lights[packet].transmittance);
                any |= meeting[packet].any_true();
                // Rays that meet nothing more are through.
                let behind = met.at[packet].max(span.enter[packet]);
                part.enter[packet] = meeting[packet].select(behind, Floats::splat(simd, f32::INFINITY));
            }
            if !any {
                return;
            }
            self.shade(simd, packets, (&met, &meeting, layers), lights, stack, statistics);
            for packet in 0..PACKETS {
                meeting[packet] &= clear(simd, lights[packet].transmittance);
            }
            seeker.go_on(simd, &meeting, packets, stack, Some(layers));
        }
    }
}

/// From the eye to infinity.
#[inline(always)]
fn reach<S: Gather>(simd: S, packets: &Packets<S>) -> Span<S> {
    let infinity = Floats::splat(simd, f32::INFINITY);
    let mut reach = Span { enter: [infinity; PACKETS], leave: [infinity; PACKETS] };
    for packet in 0..PACKETS {
        reach.enter[packet] = -packets[packet].entry;
    }
    reach
}
