//! The surface that each ray meets next.

use fearless_simd::prelude::*;

use super::super::packet::{Masks, PACKETS, Packets};
use super::super::traverse::{Span, Stack};
use super::super::walk::{Crossings, Levels, Walk};
use super::Surfaces;
use super::layers::Layers;
use crate::layout::RegionValues;
use crate::simd::{Floats, Gather, Integers, LANES, Mask, lanes_of};

/// Where rays meet surfaces, and which ones; infinity where they meet none.
#[derive(Clone, Copy)]
pub(super) struct Met<S: Gather> {
    pub(super) rays: Masks<S>,
    pub(super) at: [Floats<S>; PACKETS],
    pub(super) number: [Integers<S>; PACKETS],
}

/// Looks for surfaces along packets of rays, one after the other.
pub(super) struct Seeker<'a, S: Gather, V> {
    surfaces: Surfaces<'a, V>,
    span: Span<S>,
    /// The nearest surfaces ahead.
    pub(super) met: Met<S>,
    /// The nearest isosurfaces ahead, and the rank behind them.
    isosurface: [Floats<S>; PACKETS],
    level: [Integers<S>; PACKETS],
    behind: [Integers<S>; PACKETS],
}

impl<'a, S: Gather, V: RegionValues + Copy> Seeker<'a, S, V> {
    /// Finds what rays meet first between the ends of `span`.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        surfaces: Surfaces<'a, V>,
        packets: &Packets<S>,
        mut span: Span<S>,
        stack: &mut Stack<S>,
    ) -> Self {
        surfaces.clips.narrow(simd, packets, &mut span);
        let (none, nowhere) = (Integers::splat(simd, -1), Floats::splat(simd, f32::INFINITY));
        let rays = [Mask::splat(simd, false); PACKETS];
        let met = Met { rays, at: [-nowhere; PACKETS], number: [none; PACKETS] };
        let (isosurface, level) = ([nowhere; PACKETS], [none; PACKETS]);
        let mut seeker = Self { surfaces, span, met, isosurface, level, behind: level };
        let mut inside = rays;
        for packet in 0..PACKETS {
            inside[packet] = span.enter[packet].simd_lt(span.leave[packet]);
        }
        seeker.seek(simd, &inside, &rays, packets, stack);
        seeker.nearest(simd, &inside, packets);
        seeker
    }

    /// Finds what `rays` meet behind what they have met.
    #[inline(always)]
    pub(super) fn go_on(
        &mut self,
        simd: S,
        rays: &Masks<S>,
        packets: &Packets<S>,
        stack: &mut Stack<S>,
        layers: Option<&mut Layers>,
    ) {
        let mut through = *rays;
        let count = Integers::splat(simd, self.surfaces.plan.levels.len() as i32);
        for packet in 0..PACKETS {
            through[packet] &= self.met.number[packet].simd_lt(count);
        }
        self.seek(simd, &through, &through, packets, stack);
        let met = self.met;
        self.nearest(simd, rays, packets);
        if let Some(layers) = layers {
            let first = Integers::splat(simd, self.surfaces.plan.first_mesh() as i32);
            for packet in 0..PACKETS {
                layers.pass(packet, lanes_of(rays[packet] & met.number[packet].simd_ge(first)));
            }
            self.nearest_layer(simd, rays, layers, &met);
        }
    }

    /// Finds what rays meet of meshes between the ends of `reach`.
    #[inline(always)]
    pub(super) fn seek_meshes(&mut self, simd: S, packets: &Packets<S>, reach: &Span<S>, layers: &mut Layers) {
        let plan = self.surfaces.plan;
        if plan.meshes.is_empty() {
            return;
        }
        let all = [Mask::splat(simd, true); PACKETS];
        for packet in 0..PACKETS {
            let ends = [reach.enter[packet], reach.leave[packet]];
            layers.find(plan, &packets[packet], packet, ends, u16::MAX);
        }
        let before = Met { at: [Floats::splat(simd, f32::NEG_INFINITY); PACKETS], ..self.met };
        self.nearest_layer(simd, &all, layers, &before);
    }

    /// The next layers of meshes, where they are nearer than what else is ahead; not before what rays have met.
    #[inline(always)]
    fn nearest_layer(&mut self, simd: S, rays: &Masks<S>, layers: &Layers, before: &Met<S>) {
        if self.surfaces.plan.meshes.is_empty() {
            return;
        }
        for packet in 0..PACKETS {
            let (mut at, mut number) = ([f32::INFINITY; LANES], [0; LANES]);
            for lane in 0..LANES {
                if let Some(layer) = layers.next(packet, lane) {
                    (at[lane], number[lane]) = (layer.at, layer.number);
                }
            }
            let at = Floats::from_slice(simd, &at).max(before.at[packet]);
            let met = &mut self.met;
            let other = met.rays[packet].select(met.at[packet], Floats::splat(simd, f32::INFINITY));
            let nearer = rays[packet] & at.simd_lt(other);
            met.at[packet] = nearer.select(at, other);
            met.number[packet] = nearer.select(Integers::from_slice(simd, &number), met.number[packet]);
            met.rays[packet] |= nearer;
        }
    }

    /// Looks for the next isosurfaces of `rays`, some of which are `starting` on one.
    #[inline(never)]
    fn seek(&mut self, simd: S, rays: &Masks<S>, starting: &Masks<S>, packets: &Packets<S>, stack: &mut Stack<S>) {
        let Surfaces { plan, values, pieces, clips } = self.surfaces;
        if plan.levels.is_empty() {
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                let (mut span, mut rays, mut starting) = (self.span, *rays, *starting);
                for packet in 0..PACKETS {
                    span.enter[packet] = starting[packet].select(self.met.at[packet], span.enter[packet]);
                }
                let method = plan.volume.method();
                let index = plan.volume.index();
                let walk = Walk { values, index, pieces, looks: &plan.looks, method };
                // What is found in a hole that is cut away does not count: on behind it.
                for _ in 0..=clips.holes() {
                    let mut crossings = Crossings::new(simd, Levels(&plan.levels), rays, (starting, self.behind));
                    walk.walk(simd, packets, &span, &mut crossings, stack);
                    let mut any = false;
                    for packet in 0..PACKETS {
                        let (found, at) = (rays[packet], crossings.at[packet]);
                        self.isosurface[packet] = found.select(at, self.isosurface[packet]);
                        self.level[packet] = found.select(crossings.level[packet], self.level[packet]);
                        self.behind[packet] = found.select(crossings.behind[packet], self.behind[packet]);
                        let exit = clips.exit(simd, &packets[packet], at);
                        rays[packet] = found & exit.simd_gt(at);
                        starting[packet] &= !rays[packet];
                        span.enter[packet] = rays[packet].select(exit, span.enter[packet]);
                        any |= rays[packet].any_true();
                    }
                    if !any {
                        return;
                    }
                }
            },
        );
    }

    /// The nearest surfaces of any kind, behind what `rays` have met.
    #[inline(always)]
    fn nearest(&mut self, simd: S, rays: &Masks<S>, packets: &Packets<S>) {
        let plan = self.surfaces.plan;
        for packet in 0..PACKETS {
            let (mut at, mut number) = (self.isosurface[packet], self.level[packet]);
            let ends = [self.span.enter[packet], self.span.leave[packet]];
            for (plane, nth) in plan.planes.iter().zip(plan.levels.len()..) {
                let place = plane.meets(simd, &packets[packet], ends);
                let is_left = self.surfaces.clips.exit(simd, &packets[packet], place).simd_eq(place);
                let nearer = place.simd_gt(self.met.at[packet]) & place.simd_lt(at) & is_left;
                at = nearer.select(place, at);
                number = nearer.select(Integers::splat(simd, nth as i32), number);
            }
            let met = &mut self.met;
            met.rays[packet] = rays[packet] & at.simd_lt(Floats::splat(simd, f32::INFINITY));
            met.at[packet] = rays[packet].select(at, Floats::splat(simd, f32::INFINITY));
            met.number[packet] = number;
        }
    }
}
