//! Volumes in the light of lamps: shading by the gradient, shadows, and ambient occlusion.

mod lamps;
mod lattice;
mod occlusion;

use fearless_simd::prelude::*;

use super::march::{Collector, Interval, March, Sloped};
use super::packet::{PACKETS, Packets};
use super::traverse::{Span, Stack};
use super::{RenderStatistics, Trace};
use crate::appearance::{Absorbed, Radiance, attenuate};
use crate::simd::{Floats, Gather, Mask};

pub(super) use lamps::{Lamps, Reflector};
use lattice::LightHere;
pub(super) use lattice::{Density, Lattices};
pub(super) use occlusion::{Arriving, Asked, Kind, Obstacles, Occluders, Occlusion};

/// Marches through a volume that reflects light.
pub(super) struct LitMarch<'a, M, O> {
    pub(super) march: March<'a, M>,
    pub(super) lamps: &'a Lamps,
    /// `None` where all light arrives.
    pub(super) shadows: Option<(&'a Lattices<'a>, &'a Occlusion<'a, O>)>,
}

impl<M: Sloped, O: Occluders> Trace for LitMarch<'_, M, O> {
    type Scratch<S: Gather> = [Stack<S>; 2];

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        [stack, inner_stack]: &mut [Stack<S>; 2],
        statistics: &mut RenderStatistics,
    ) {
        let Self { march, lamps, shadows } = self;
        let inner = RenderStatistics::default();
        let mut views = [lamps.view(simd, &packets[0]); PACKETS];
        for packet in 1..PACKETS {
            views[packet] = lamps.view(simd, &packets[packet]);
        }
        let need_places = shadows.is_some() || lamps.need_places();
        let mut lit = Lit {
            lamps,
            shadows: *shadows,
            here: None,
            packets,
            views,
            need_places,
            stack: inner_stack,
            statistics: inner,
        };
        march.collect(simd, packets, span, (&mut lit, lights), stack, statistics);
        statistics.secondary_rays += lit.statistics.secondary_rays;
        statistics.samples += lit.statistics.samples;
    }
}

/// Collects the light that a volume reflects.
struct Lit<'a, S: Gather, O> {
    lamps: &'a Lamps,
    shadows: Option<(&'a Lattices<'a>, &'a Occlusion<'a, O>)>,
    /// The light in the part of the volume that rays are in.
    here: Option<&'a LightHere>,
    packets: &'a Packets<S>,
    /// Toward the eye.
    views: [[Floats<S>; 3]; PACKETS],
    /// Whether it matters where points are.
    need_places: bool,
    stack: &'a mut Stack<S>,
    statistics: RenderStatistics,
}

impl<S: Gather, M: Sloped, O: Occluders> Collector<S, M> for Lit<'_, S, O> {
    type State = Radiance<S>;

    #[inline(always)]
    fn transmittance(state: &Radiance<S>) -> Floats<S> {
        state.transmittance
    }

    #[inline(always)]
    fn enter(&mut self, simd: S, node: usize) {
        if let Some((lattices, occlusion)) = self.shadows {
            self.here = Some(lattices.get(simd, node, occlusion, self.stack, &mut self.statistics));
        }
    }

    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        number: usize,
        light: &mut Radiance<S>,
        interval: &Interval<S>,
        ends: [&M::Sample<S>; 2],
        end: Floats<S>,
    ) {
        let Interval { glow, length, rays } = *interval;
        let Some(Absorbed { share, opacity, alpha }) =
            attenuate(simd, &mut light.transmittance, glow.extinction, length, rays)
        else {
            return;
        };
        let mut color = glow.emission;
        for channel in 0..3 {
            color[channel] *= share;
        }
        // Most of the light comes from the front of what is dense.
        let behind = (alpha * alpha).mul_add(Floats::splat(simd, 0.2), Floats::splat(simd, 0.5));
        let at = end - length * behind;
        let reflected = self.reflected(simd, number, (at, rays), M::gradient(simd, ends), (color, opacity));
        for channel in 0..3 {
            // What other rays have may be no number.
            let sum = light.color[channel] + reflected[channel];
            light.color[channel] = rays.select(sum, light.color[channel]);
        }
    }
}

impl<S: Gather, O: Occluders> Lit<'_, S, O> {
    /// What comes to the eye from a packet's `rays` at `at`, where the volume has a colour times its opacity.
    #[inline(never)]
    fn reflected(
        &self,
        simd: S,
        number: usize,
        (at, rays): (Floats<S>, Mask<S>),
        gradient: [Floats<S>; 3],
        (color, opacity): ([Floats<S>; 3], Floats<S>),
    ) -> [Floats<S>; 3] {
        simd.vectorize(
            #[inline(always)]
            || {
                let packet = &self.packets[number];
                let place = if self.need_places { packet.at(at) } else { packet.start };
                let mut arriving = match self.here {
                    Some(light) => light.arriving(simd, &place),
                    None => Arriving::all(simd),
                };
                if let (Some(here), Some((lattices, _))) = (self.here, self.shadows) {
                    // The interval may have begun in the part before.
                    let outside = rays & !here.holds(simd, &place);
                    if outside.any_true() {
                        arriving = lattices.elsewhere(simd, &place, outside, arriving);
                    }
                }
                let reflector = Reflector::of_volume(simd, self.views[number], self.lamps, place, gradient);
                self.lamps.reflect(simd, &reflector, &arriving, (color, opacity))
            },
        )
    }
}
