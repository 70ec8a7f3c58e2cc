//! Isosurfaces: where along its ray the reconstruction takes a value.
//!
//! How many of the values that are looked for lie below the field's value is the ray's rank. A ray meets an isosurface
//! exactly where its rank changes: at a root inside a region, or on a face over which values jump. Ranks are carried from
//! region to region, also over those that are not walked through, so that no ray slips through between two regions.

use fearless_simd::prelude::*;

use super::cubic::Cubic;
use super::{Steps, Stretch};
use crate::layout::{PieceNode, RegionValues};
use crate::render::packet::{Masks, PACKETS};
use crate::simd::{Floats, Gather, Integers, Mask};

/// The values of isosurfaces, normalised, lowest first.
#[derive(Clone, Copy)]
pub(in super::super) struct Levels<'a>(pub(in super::super) &'a [f32]);

/// The rank where there is no value.
const NOWHERE: i32 = -1;
/// How often a bracket is made smaller at most, by turns with a secant and in the middle.
const TURNS: usize = 32;
/// Where it is as small as this, over the step, or where a value is that much nearer to the level than those at both ends
/// were, that is enough. (Where values jump, none may be.)
const NARROW: f32 = 1e-4;
const NEAR: f32 = 1e-2;

impl Levels<'_> {
    /// How many levels lie below values.
    #[inline(always)]
    fn ranks<S: Gather>(self, simd: S, values: Floats<S>) -> Integers<S> {
        let one = Integers::splat(simd, 1);
        let mut ranks = Integers::splat(simd, 0);
        for level in self.0 {
            ranks = values.simd_gt(Floats::splat(simd, *level)).select(ranks + one, ranks);
        }
        values.simd_eq(values).select(ranks, Integers::splat(simd, NOWHERE))
    }

    /// The rank of all values in a range, where they have but one.
    pub(in super::super) fn rank_of_all(self, [low, high]: [f32; 2]) -> Option<i32> {
        let rank = |value: f32| self.0.iter().filter(|&&level| value > level).count() as i32;
        match low <= high {
            true => (rank(low) == rank(high)).then(|| rank(low)),
            false => Some(NOWHERE),
        }
    }

    /// The levels of these numbers.
    #[inline(always)]
    fn values<S: Gather>(self, simd: S, numbers: Integers<S>) -> Floats<S> {
        let mut values = Floats::splat(simd, 0.0);
        for (number, level) in self.0.iter().enumerate() {
            let here = numbers.simd_eq(Integers::splat(simd, number as i32));
            values = here.select(Floats::splat(simd, *level), values);
        }
        values
    }
}

/// Takes rays to the first isosurface ahead of them.
pub(in super::super) struct Crossings<'a, S: Gather> {
    levels: Levels<'a>,
    /// Rays that have not met one.
    going: Masks<S>,
    /// Rays that start on a surface: their rank is known, whatever rounding makes of the value there.
    starting: Masks<S>,
    ranks: [Integers<S>; PACKETS],
    /// The values at the ends of the last steps.
    last: [Floats<S>; PACKETS],
    /// Where the rays meet a surface, infinity where they do not; which one; and their rank behind it.
    pub(in super::super) at: [Floats<S>; PACKETS],
    pub(in super::super) level: [Integers<S>; PACKETS],
    pub(in super::super) behind: [Integers<S>; PACKETS],
}

/// The first change of rank in a step: between two places on it, both as shares of the step.
struct Bracket<S: Gather> {
    found: Mask<S>,
    ends: [Floats<S>; 2],
    values: [Floats<S>; 2],
    ranks: [Integers<S>; 2],
}

impl<'a, S: Gather> Crossings<'a, S> {
    /// Rays that `go`; those that are `starting` from a surface have these `ranks`.
    #[inline(always)]
    pub(in super::super) fn new(
        simd: S,
        levels: Levels<'a>,
        going: Masks<S>,
        (starting, ranks): (Masks<S>, [Integers<S>; PACKETS]),
    ) -> Self {
        let nowhere = Integers::splat(simd, NOWHERE);
        let mut carried = [nowhere; PACKETS];
        for packet in 0..PACKETS {
            carried[packet] = starting[packet].select(ranks[packet], nowhere);
        }
        Self {
            levels,
            going,
            starting,
            ranks: carried,
            last: [Floats::splat(simd, 0.0); PACKETS],
            at: [Floats::splat(simd, f32::INFINITY); PACKETS],
            level: [nowhere; PACKETS],
            behind: [nowhere; PACKETS],
        }
    }

    /// Rays come to values of these ranks: where they had others, they meet a surface right there.
    #[inline(always)]
    fn arrive(&mut self, simd: S, packet: usize, at: Floats<S>, ranks: Integers<S>, rays: Mask<S>) {
        let starting = rays & self.starting[packet];
        self.starting[packet] &= !rays;
        let ranks = starting.select(self.ranks[packet], ranks);
        self.change(simd, packet, at, ranks, rays);
    }

    /// The rays' ranks change to these at `at`.
    #[inline(always)]
    fn change(&mut self, simd: S, packet: usize, at: Floats<S>, ranks: Integers<S>, rays: Mask<S>) {
        let before = self.ranks[packet];
        let (zero, one) = (Integers::splat(simd, 0), Integers::splat(simd, 1));
        let meeting = rays & before.simd_ge(zero) & ranks.simd_ge(zero) & ranks.simd_ne(before);
        self.ranks[packet] = rays.select(ranks, before);
        if meeting.any_true() {
            let rises = ranks.simd_gt(before);
            let level = rises.select(before, before - one);
            self.at[packet] = meeting.select(at, self.at[packet]);
            self.level[packet] = meeting.select(level, self.level[packet]);
            self.behind[packet] = meeting.select(rises.select(level + one, level), self.behind[packet]);
            self.going[packet] &= !meeting;
        }
    }
}

impl<S: Gather, V: RegionValues> Steps<S, V> for Crossings<'_, S> {
    #[inline(always)]
    fn going(&self) -> &Masks<S> {
        &self.going
    }

    #[inline(always)]
    fn enter(&mut self, stretch: &Stretch<S, V>, packet: usize, rays: Mask<S>) {
        let simd = stretch.simd;
        let zero = Floats::splat(simd, 0.0);
        let values = stretch.values(zero, [zero, zero], rays);
        self.last[packet] = values;
        self.arrive(simd, packet, stretch.begin, self.levels.ranks(simd, values), rays);
    }

    #[inline(always)]
    fn step(&mut self, stretch: &Stretch<S, V>, packet: usize, ends: [Floats<S>; 2], rays: Mask<S>) {
        let simd = stretch.simd;
        let (values, end) = stretch.of_step(self.last[packet], ends, rays);
        self.last[packet] = rays.select(end, self.last[packet]);
        let unknown = rays & self.ranks[packet].simd_lt(Integers::splat(simd, 0));
        self.ranks[packet] = unknown.select(self.levels.ranks(simd, values[0]), self.ranks[packet]);
        // The cubic through the values lies between the lowest and the highest of its Bezier points.
        let cubic = Cubic::through(simd, &values);
        let [low, high] = cubic.bounds(simd);
        let ranks = [self.levels.ranks(simd, low), self.levels.ranks(simd, high)];
        let is_same = ranks[0].simd_eq(ranks[1]) & ranks[0].simd_eq(self.ranks[packet]);
        let doubtful = rays & !(is_same & ranks[0].simd_ge(Integers::splat(simd, 0)));
        if doubtful.any_true() {
            self.look_closely(stretch, packet, ends, &values, &cubic, doubtful);
        }
    }

    #[inline(always)]
    fn pass(&mut self, simd: S, node: &PieceNode, packet: usize, at: Floats<S>, rays: Mask<S>) {
        let rank = self.levels.rank_of_all(node.range).unwrap_or(NOWHERE);
        self.arrive(simd, packet, at, Integers::splat(simd, rank), rays);
    }
}

impl<S: Gather> Crossings<'_, S> {
    /// Finds the first change of rank in a step.
    #[inline(never)]
    fn look_closely<V: RegionValues>(
        &mut self,
        stretch: &Stretch<S, V>,
        packet: usize,
        ends: [Floats<S>; 2],
        values: &[Floats<S>; 4],
        cubic: &Cubic<S>,
        rays: Mask<S>,
    ) {
        let simd = stretch.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let [from, to] = ends;
                let length = to - from;
                let bracket = self.bracket(stretch, packet, (from, length, ends), values, cubic, rays);
                let at = if bracket.found.any_true() {
                    stretch.begin + from + length * self.root(stretch, (from, length, ends), &bracket)
                } else {
                    from
                };
                let end = self.levels.ranks(simd, values[3]);
                self.change(simd, packet, at, bracket.found.select(bracket.ranks[1], end), rays);
            },
        );
    }

    /// The first two neighbours, among a step's samples and the cubic's extremes, between which the rank changes.
    #[inline(always)]
    fn bracket<V: RegionValues>(
        &self,
        stretch: &Stretch<S, V>,
        packet: usize,
        (from, length, ends): (Floats<S>, Floats<S>, [Floats<S>; 2]),
        values: &[Floats<S>; 4],
        cubic: &Cubic<S>,
        rays: Mask<S>,
    ) -> Bracket<S> {
        let simd = stretch.simd;
        let zero = Floats::splat(simd, 0.0);
        // Surfaces that are touched twice in a step show at the extremes alone.
        let extremes = cubic.extremes(simd);
        let mut values_there = extremes;
        for extreme in 0..2 {
            values_there[extreme] = stretch.values(extremes[extreme].mul_add(length, from), ends, rays);
        }
        let (mut last, mut last_value, mut last_ranks) = (zero, values[0], self.ranks[packet]);
        let nowhere = Mask::splat(simd, false);
        let mut bracket = Bracket { found: nowhere, ends: [zero; 2], values: [zero; 2], ranks: [last_ranks; 2] };
        for third in 1..=3 {
            let end = Floats::splat(simd, third as f32 / 3.0);
            let candidates = [
                (extremes[0], values_there[0], extremes[0].simd_gt(last) & extremes[0].simd_lt(end)),
                (extremes[1], values_there[1], extremes[1].simd_gt(last) & extremes[1].simd_lt(end)),
                (end, values[third], rays),
            ];
            for (place, value, is_there) in candidates {
                let ranks = self.levels.ranks(simd, value);
                let nothing = Integers::splat(simd, 0);
                let known = ranks.simd_ge(nothing) & last_ranks.simd_ge(nothing);
                let found = rays & is_there & known & ranks.simd_ne(last_ranks) & !bracket.found;
                if found.any_true() {
                    bracket.found |= found;
                    bracket.ends = [found.select(last, bracket.ends[0]), found.select(place, bracket.ends[1])];
                    bracket.values =
                        [found.select(last_value, bracket.values[0]), found.select(value, bracket.values[1])];
                    bracket.ranks = [found.select(last_ranks, bracket.ranks[0]), found.select(ranks, bracket.ranks[1])];
                }
                last = is_there.select(place, last);
                last_value = is_there.select(value, last_value);
                last_ranks = is_there.select(ranks, last_ranks);
            }
        }
        bracket
    }

    /// Where in the brackets, as a share of the step, values cross the first level. By turns a secant, which soon is
    /// close where values are smooth, and the middle, which halves what is left where they jump.
    #[inline(always)]
    fn root<V: RegionValues>(
        &self,
        stretch: &Stretch<S, V>,
        (from, length, step): (Floats<S>, Floats<S>, [Floats<S>; 2]),
        bracket: &Bracket<S>,
    ) -> Floats<S> {
        let simd = stretch.simd;
        let (half, zero) = (Floats::splat(simd, 0.5), Floats::splat(simd, 0.0));
        let [before, behind] = bracket.ranks;
        let rises = behind.simd_gt(before);
        let number = rises.select(before, before - Integers::splat(simd, 1));
        let level = self.levels.values(simd, number);
        // Below 0 before the surface, not below it behind.
        let one = Floats::splat(simd, 1.0);
        let sign = rises.select(one, -one);
        let [mut low, mut high] = bracket.ends;
        let least = Floats::splat(simd, f32::MIN_POSITIVE);
        let mut low_value = ((bracket.values[0] - level) * sign).min(-least);
        let mut high_value = ((bracket.values[1] - level) * sign).max(least);
        let near = (-low_value).min(high_value) * Floats::splat(simd, NEAR);
        for turn in 0..TURNS {
            let is_wide = (high - low).simd_gt(Floats::splat(simd, NARROW));
            let is_far = (-low_value).min(high_value).simd_gt(near);
            if (bracket.found & is_wide & is_far).all_false() {
                break;
            }
            let share = if turn % 2 == 0 { low_value / (low_value - high_value) } else { half };
            let middle = share.max(zero).min(one).mul_add(high - low, low);
            let value = (stretch.values(middle.mul_add(length, from), step, bracket.found) - level) * sign;
            let is_before = value.simd_lt(zero);
            low = is_before.select(middle, low);
            low_value = is_before.select(value, low_value);
            high = is_before.select(high, middle);
            high_value = is_before.select(high_value, value.max(least));
        }
        (low_value / (low_value - high_value)).mul_add(high - low, low)
    }
}
