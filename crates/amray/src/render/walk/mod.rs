//! Walks: a packet of rays goes through regions cell by cell, so that nothing along a ray is missed.
//!
//! Marching integrates and may leave cells out that hardly matter. A walk stops wherever the reconstruction may bend
//! sharply: in a brick's interior on the planes between dual cells, between which values run along a ray like a cubic;
//! in border zones, and where values jump from cell to cell, on the centres and faces of all cells in reach.

mod crossings;
mod cubic;
mod sums;

use fearless_simd::prelude::*;

use super::march::LocalRays;
use super::packet::{Masks, PACKETS, Packets};
use super::traverse::{Span, Stack, Visitor, traverse};
use super::visibility::{NodeLook, SeenLook};
use crate::index::Index;
use crate::layout::{PieceNode, RegionValues};
use crate::reconstruction::Method;
use crate::simd::{Doubles, Floats, Gather, Mask};

pub(super) use crossings::{Crossings, Levels};
pub(super) use sums::{Highest, Sums};

/// Everything that walks share.
pub(super) struct Walk<'a, V> {
    pub(super) values: V,
    pub(super) index: &'a Index,
    pub(super) pieces: &'a [PieceNode],
    /// Which nodes are walked through: [`NodeLook::Seen`].
    pub(super) looks: &'a [NodeLook],
    pub(super) method: Method,
}

/// What is done along the way.
pub(super) trait Steps<S: Gather, V: RegionValues> {
    /// Which of the rays go on at all.
    fn going(&self) -> &Masks<S>;

    /// A packet's `rays` come to a stretch.
    fn enter(&mut self, stretch: &Stretch<S, V>, packet: usize, rays: Mask<S>);

    /// They go on from one place to another, both told as lengths from the stretch's beginning.
    fn step(&mut self, stretch: &Stretch<S, V>, packet: usize, ends: [Floats<S>; 2], rays: Mask<S>);

    /// They pass over a node that is not walked through, from `at` on.
    fn pass(&mut self, simd: S, node: &PieceNode, packet: usize, at: Floats<S>, rays: Mask<S>);
}

/// The way of a packet's rays through one region.
pub(super) struct Stretch<'a, S: Gather, V> {
    pub(super) simd: S,
    values: &'a V,
    region: usize,
    /// Where it begins on the rays, and in the region's local coordinates; and how far a unit of length goes there.
    pub(super) begin: Floats<S>,
    start: [Floats<S>; 3],
    stride: [Floats<S>; 3],
    /// Where, in lengths from the beginning, the rays are in the pure box.
    pure: [Floats<S>; 2],
    /// What is surely in the region: beyond its faces, where rounding may take a point, other values may be known.
    inside: [Floats<S>; 2],
    /// How many planes there are to a cell, inside of the pure box and elsewhere.
    planes: [[Floats<S>; 3]; 2],
}

/// The nearest plane that a step goes to, over the distance of planes: what is nearer counts as being on it. Far from
/// where coordinates begin, single precision does not tell so well: then by so much of the coordinate.
const LEAST: f32 = 1e-4;
const LEAST_SHARE: f32 = 3e-7;

/// How far inside of a step, over its length, is right inside.
const BESIDE: f32 = 1e-3;

/// How far inside of its region a point is that surely is: by so much of the way to it, and in cells.
const ROUNDING: f32 = 2.5e-7;
const MARGIN: f32 = 1e-5;

impl<S: Gather, V: RegionValues> Stretch<'_, S, V> {
    /// The values of `rays` at lengths from the beginning, which lie between two `ends` of a step.
    #[inline(always)]
    pub(super) fn values(&self, at: Floats<S>, [from, to]: [Floats<S>; 2], rays: Mask<S>) -> Floats<S> {
        let at = at.max(self.inside[0]).min(self.inside[1]);
        let mut point = self.start;
        for axis in 0..3 {
            point[axis] = at.mul_add(self.stride[axis], self.start[axis]);
        }
        let outside = rays & (from.simd_lt(self.pure[0]) | to.simd_gt(self.pure[1]));
        if outside.any_true() {
            self.values.anywhere(self.simd, self.region, point, rays)
        } else {
            self.values.pure(self.simd, self.region, point)
        }
    }

    /// The values at the ends and the thirds of a step, and what is known of its end for the next one, as `last` was of
    /// this one's beginning. Where there is no value on the planes at its ends, that right inside of them counts.
    #[inline(always)]
    fn of_step(&self, last: Floats<S>, ends: [Floats<S>; 2], rays: Mask<S>) -> ([Floats<S>; 4], Floats<S>) {
        let [from, to] = ends;
        let length = to - from;
        let third = length * Floats::splat(self.simd, 1.0 / 3.0);
        let end = self.values(to, ends, rays);
        let mut values = [last, self.values(from + third, ends, rays), self.values(to - third, ends, rays), end];
        let off = length * Floats::splat(self.simd, BESIDE);
        for (number, beside) in [(0, from + off), (3, to - off)] {
            let unknown = rays & !values[number].is_finite();
            if unknown.any_true() {
                values[number] = unknown.select(self.values(beside, ends, rays), values[number]);
            }
        }
        (values, end)
    }

    /// Where the next step ends that begins at `from`.
    #[inline(always)]
    fn next(&self, from: Floats<S>, length: Floats<S>) -> Floats<S> {
        let simd = self.simd;
        let one = Floats::splat(simd, 1.0);
        let is_pure = from.simd_ge(self.pure[0]) & from.simd_lt(self.pure[1]);
        let mut next = length;
        for axis in 0..3 {
            let planes = is_pure.select(self.planes[0][axis], self.planes[1][axis]);
            let (start, stride) = (self.start[axis] * planes, self.stride[axis] * planes);
            let place = from.mul_add(stride, start);
            let least = place.abs().mul_add(Floats::splat(simd, LEAST_SHARE), Floats::splat(simd, LEAST));
            let up = (place + least).floor() + one;
            let down = (place - least).ceil() - one;
            let plane = stride.simd_gt(Floats::splat(simd, 0.0)).select(up, down);
            let at = (plane - start) / stride;
            // A ray along the planes never meets one.
            next = at.simd_gt(from).select(next.min(at), next);
        }
        // The pure box begins and ends on planes, but single precision may tell otherwise.
        let [enter, leave] = self.pure;
        next = (from.simd_lt(enter) & next.simd_gt(enter)).select(enter, next);
        (from.simd_lt(leave) & next.simd_gt(leave)).select(leave, next)
    }
}

impl<V: RegionValues> Walk<'_, V> {
    /// Takes packets from one end of `span` to the other.
    #[inline(always)]
    pub(super) fn walk<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        steps: &mut impl Steps<S, V>,
        stack: &mut Stack<S>,
    ) {
        let begun = [Mask::splat(simd, false); PACKETS];
        let mut walker = Walker { simd, walk: self, packets, steps, begun };
        traverse(simd, self.pieces, self.looks, packets, *span, stack, &mut walker);
    }
}

struct Walker<'a, S: Gather, V, T> {
    simd: S,
    walk: &'a Walk<'a, V>,
    packets: &'a Packets<S>,
    steps: &'a mut T,
    /// Nothing has to be ended where nothing is of interest.
    begun: Masks<S>,
}

impl<S: Gather, V: RegionValues, T: Steps<S, V>> Visitor<S> for Walker<'_, S, V, T> {
    #[inline(always)]
    fn going(&self) -> &Masks<S> {
        self.steps.going()
    }

    #[inline(always)]
    fn begun(&self) -> &Masks<S> {
        &self.begun
    }

    #[inline(always)]
    fn skip(&mut self, node: usize, span: &Span<S>, rays: &Masks<S>) {
        for packet in 0..PACKETS {
            if rays[packet].any_true() {
                self.steps.pass(self.simd, &self.walk.pieces[node], packet, span.enter[packet], rays[packet]);
            }
        }
    }

    #[inline(always)]
    fn visit(&mut self, (node, region): (usize, usize), look: Option<&SeenLook>, span: &Span<S>, rays: &Masks<S>) {
        if look.is_none() || self.walk.values.frame(region).level.is_none() {
            self.skip(node, span, rays);
            return;
        }
        for packet in 0..PACKETS {
            if rays[packet].any_true() {
                self.through(packet, region, [span.enter[packet], span.leave[packet]], rays[packet]);
            }
        }
    }
}

impl<S: Gather, V: RegionValues, T: Steps<S, V>> Walker<'_, S, V, T> {
    /// Takes a packet's `rays` through a region.
    #[inline(never)]
    fn through(&mut self, packet: usize, region: usize, [enter, leave]: [Floats<S>; 2], rays: Mask<S>) {
        let simd = self.simd;
        simd.vectorize(
            #[inline(always)]
            || {
                let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
                let values = &self.walk.values;
                let frame = values.frame(region);
                let size = values.finest_cells(frame.level.unwrap_or(0));
                let local = LocalRays::new(&self.packets[packet], frame, size);
                let start = local.at(simd, Doubles::from_floats(enter));
                let stride = local.stride(simd, one);
                let length = leave - enter;
                let pure = local.pure(simd, &start, one);
                let (mut planes, plan) = ([[one; 3]; 2], self.walk.planes(region, frame.level));
                for (planes, counts) in planes.iter_mut().zip(plan) {
                    for axis in 0..3 {
                        planes[axis] = Floats::splat(simd, counts[axis]);
                    }
                }
                let fastest = stride[0].abs().max(stride[1].abs()).max(stride[2].abs());
                let rounding = (leave.abs() + enter.abs()) * Floats::splat(simd, ROUNDING);
                let margin = (rounding + Floats::splat(simd, MARGIN) / fastest).min(length * Floats::splat(simd, 0.5));
                let inside = [margin, length - margin];
                let stretch = Stretch { simd, values, region, begin: enter, start, stride, pure, inside, planes };
                self.steps.enter(&stretch, packet, rays);
                let mut from = zero;
                let mut rays = rays & self.steps.going()[packet];
                while rays.any_true() {
                    let to = stretch.next(from, length);
                    self.steps.step(&stretch, packet, [from, to], rays);
                    from = rays.select(to, from);
                    rays &= to.simd_lt(length) & self.steps.going()[packet];
                }
            },
        );
    }
}

impl<V> Walk<'_, V> {
    /// How many planes there are to a cell of a region of `level`: inside of its pure box, and elsewhere, where values
    /// may bend at centres and faces of all levels in reach.
    fn planes(&self, region: usize, level: Option<u8>) -> [[f32; 3]; 2] {
        let levels = self.index.hierarchy().levels();
        let own = levels[usize::from(level.unwrap_or(0))].finest_cells();
        let halves = |finest: usize| {
            let cells = levels[finest].finest_cells();
            std::array::from_fn(|axis| 2.0 * own[axis] as f32 / cells[axis] as f32)
        };
        match self.method {
            Method::Nearest => [[2.0; 3]; 2],
            // Values run between the finest level's cells everywhere.
            Method::Finest => [halves(levels.len() - 1); 2],
            _ => [[1.0; 3], halves(self.index.regions()[region].finest_in_reach())],
        }
    }
}

/// The looks of all nodes, where some are all `alike` in what matters, and need not be walked through, and others are not.
pub(super) fn looks(pieces: &[PieceNode], alike: impl Fn(&PieceNode) -> Option<i32>) -> Vec<NodeLook> {
    let seen = NodeLook::Seen(SeenLook::default());
    let mut looks = vec![NodeLook::Hidden; pieces.len()];
    // Children follow their parents.
    for (place, node) in pieces.iter().enumerate().rev() {
        looks[place] = match node.cut {
            None if alike(node).is_some() => NodeLook::Hidden,
            None => seen,
            Some(cut) => {
                let children = [place + 1, cut.high as usize];
                let [low, high] = children.map(|child| alike(&pieces[child]));
                match children.map(|child| looks[child]) {
                    [NodeLook::Hidden, NodeLook::Hidden] if low == high => NodeLook::Hidden,
                    [NodeLook::Seen(_), NodeLook::Seen(_)] if node.region.is_some() => seen,
                    _ => NodeLook::Mixed,
                }
            }
        };
    }
    looks
}
