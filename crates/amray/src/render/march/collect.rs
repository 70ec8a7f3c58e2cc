//! What rays make of the intervals that they pass.

use fearless_simd::prelude::*;

use super::medium::{Interval, Medium};
use crate::appearance::{Radiance, attenuate};
use crate::simd::{Floats, Gather, Mask};

/// What is still visible below this transmittance would change no 8-bit picture.
const OPAQUE: f32 = 1.0 / 4096.0;

/// Takes in what packets of rays pass, front to back.
pub(in super::super) trait Collector<S: Gather, M: Medium> {
    /// What changes with every interval.
    type State: Copy;

    /// What is left of the light behind.
    fn transmittance(state: &Self::State) -> Floats<S>;

    /// Adds intervals of the packet `number` between two samples, which end at `end`.
    fn add(
        &mut self,
        simd: S,
        number: usize,
        state: &mut Self::State,
        interval: &Interval<S>,
        ends: [&M::Sample<S>; 2],
        end: Floats<S>,
    );

    /// Rays come to a node of the tree of pieces in which something is seen.
    fn enter(&mut self, simd: S, node: usize);

    /// The packet `number` leaves the node that was entered last, perhaps for good: what was put off is added.
    fn leave(&mut self, simd: S, number: usize, state: &mut Self::State);

    /// Rays through which something behind can be seen.
    #[inline(always)]
    fn clear(simd: S, state: &Self::State) -> Mask<S> {
        clear(simd, Self::transmittance(state))
    }
}

/// Where something behind can be seen.
#[inline(always)]
pub(in super::super) fn clear<S: Gather>(simd: S, transmittance: Floats<S>) -> Mask<S> {
    transmittance.simd_ge(Floats::splat(simd, OPAQUE))
}

/// A volume that glows.
pub(in super::super) struct Glowing;

impl<S: Gather, M: Medium> Collector<S, M> for Glowing {
    type State = Radiance<S>;

    #[inline(always)]
    fn transmittance(state: &Radiance<S>) -> Floats<S> {
        state.transmittance
    }

    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        _: usize,
        state: &mut Radiance<S>,
        interval: &Interval<S>,
        _: [&M::Sample<S>; 2],
        _: Floats<S>,
    ) {
        state.add(simd, &interval.glow, interval.length, interval.rays);
    }

    #[inline(always)]
    fn enter(&mut self, _: S, _: usize) {}

    #[inline(always)]
    fn leave(&mut self, _: S, _: usize, _: &mut Self::State) {}
}

/// How much light comes through: rays to lights.
pub(in super::super) struct Dimming;

impl<S: Gather, M: Medium> Collector<S, M> for Dimming {
    type State = Floats<S>;

    #[inline(always)]
    fn transmittance(state: &Floats<S>) -> Floats<S> {
        *state
    }

    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        _: usize,
        state: &mut Floats<S>,
        interval: &Interval<S>,
        _: [&M::Sample<S>; 2],
        _: Floats<S>,
    ) {
        attenuate(simd, state, interval.glow.extinction, interval.length, interval.rays);
    }

    #[inline(always)]
    fn enter(&mut self, _: S, _: usize) {}

    #[inline(always)]
    fn leave(&mut self, _: S, _: usize, _: &mut Self::State) {}
}
