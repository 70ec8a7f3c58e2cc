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
use crate::simd::{Floats, Gather};

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
        let mut states = [LitState { light: lights[0], batch: Batch::nothing(simd) }; PACKETS];
        for packet in 1..PACKETS {
            states[packet].light = lights[packet];
        }
        march.collect(simd, packets, span, (&mut lit, &mut states), stack, statistics);
        for packet in 0..PACKETS {
            lights[packet] = states[packet].light;
        }
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

/// What packets have collected, and what of it is still to be lit.
#[derive(Clone, Copy)]
struct LitState<S: Gather> {
    light: Radiance<S>,
    batch: Batch<S>,
}

/// Intervals that are lit together: thin ones that follow one another hardly differ. Sums over all of them.
#[derive(Clone, Copy)]
struct Batch<S: Gather> {
    count: u32,
    /// Colours times opacities.
    color: [Floats<S>; 3],
    opacity: Floats<S>,
    /// Gradients and places, by opacity.
    gradient: [Floats<S>; 3],
    at: Floats<S>,
}

/// How many intervals are lit together at most, and how opaque one may be to wait for others.
const TOGETHER: u32 = 4;
const FAINT: f32 = 1.0 / 32.0;

impl<S: Gather> Batch<S> {
    #[inline(always)]
    fn nothing(simd: S) -> Self {
        let zero = Floats::splat(simd, 0.0);
        Self { count: 0, color: [zero; 3], opacity: zero, gradient: [zero; 3], at: zero }
    }
}

impl<S: Gather, M: Sloped, O: Occluders> Collector<S, M> for Lit<'_, S, O> {
    type State = LitState<S>;

    #[inline(always)]
    fn transmittance(state: &LitState<S>) -> Floats<S> {
        state.light.transmittance
    }

    #[inline(always)]
    fn enter(&mut self, simd: S, node: usize) {
        if let Some((lattices, occlusion)) = self.shadows {
            self.here = Some(lattices.get(simd, node, occlusion, self.stack, &mut self.statistics));
        }
    }

    #[inline(always)]
    fn leave(&mut self, simd: S, number: usize, state: &mut LitState<S>) {
        if state.batch.count > 0 {
            self.light(simd, number, state);
        }
    }

    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        number: usize,
        state: &mut LitState<S>,
        interval: &Interval<S>,
        ends: [&M::Sample<S>; 2],
        end: Floats<S>,
    ) {
        let Interval { glow, length, rays } = *interval;
        let Some(Absorbed { share, opacity, alpha }) =
            attenuate(simd, &mut state.light.transmittance, glow.extinction, length, rays)
        else {
            return;
        };
        let zero = Floats::splat(simd, 0.0);
        let batch = &mut state.batch;
        // What other rays have may be no number.
        let opacity = rays.select(opacity, zero);
        let gradient = M::gradient(simd, ends);
        // Most of the light comes from the front of what is dense.
        let behind = (alpha * alpha).mul_add(Floats::splat(simd, 0.2), Floats::splat(simd, 0.5));
        let at = end - length * behind;
        for axis in 0..3 {
            batch.color[axis] += rays.select(glow.emission[axis] * share, zero);
            batch.gradient[axis] += rays.select(gradient[axis] * opacity, zero);
        }
        batch.at += rays.select(at * opacity, zero);
        batch.opacity += opacity;
        batch.count += 1;
        if batch.count == TOGETHER || (rays & alpha.simd_gt(Floats::splat(simd, FAINT))).any_true() {
            self.light(simd, number, state);
        }
    }
}

impl<S: Gather, O: Occluders> Lit<'_, S, O> {
    /// Adds what comes to the eye from a packet's batch, and begins another one.
    #[inline(never)]
    fn light(&self, simd: S, number: usize, state: &mut LitState<S>) {
        simd.vectorize(
            #[inline(always)]
            || {
                let Batch { color, opacity, mut gradient, at, .. } = state.batch;
                state.batch = Batch::nothing(simd);
                let rays = opacity.simd_gt(Floats::splat(simd, 0.0));
                let inverse = Floats::splat(simd, 1.0) / opacity;
                let at = rays.select(at * inverse, at);
                for axis in 0..3 {
                    gradient[axis] *= inverse;
                }
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
                let reflected = self.lamps.reflect(simd, &reflector, &arriving, (color, opacity));
                for channel in 0..3 {
                    let sum = state.light.color[channel] + reflected[channel];
                    state.light.color[channel] = rays.select(sum, state.light.color[channel]);
                }
            },
        );
    }
}
