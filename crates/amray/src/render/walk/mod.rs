//! Walks: a packet of rays goes through regions cell by cell, so that nothing along a ray is missed.
//!
//! Marching integrates and may leave cells out that hardly matter. A walk stops wherever the reconstruction may bend
//! sharply: in a brick's interior on the planes between dual cells, between which values run along a ray like a cubic;
//! in border zones on planes half as far apart.

mod crossings;

use fearless_simd::prelude::*;

use super::march::LocalRays;
use super::packet::{Masks, PACKETS, Packets};
use super::traverse::{Span, Stack, Visitor, traverse};
use super::visibility::{NodeLook, SeenLook};
use crate::layout::{PieceNode, RegionValues};
use crate::simd::{Doubles, Floats, Gather, Mask};

pub(super) use crossings::{Crossings, Levels};

/// Everything that walks share.
pub(super) struct Walk<'a, V> {
    pub(super) values: V,
    pub(super) pieces: &'a [PieceNode],
    /// Which nodes are walked through: [`NodeLook::Seen`].
    pub(super) looks: &'a [NodeLook],
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
    /// Where, in lengths from the beginning, all rays are in the pure box.
    pure: [Floats<S>; 2],
}

/// The nearest plane that a step goes to, in cells: what is nearer counts as being on it.
const LEAST: f32 = 1e-3;

impl<S: Gather, V: RegionValues> Stretch<'_, S, V> {
    /// The values of `rays` at lengths from the beginning, which lie between two `ends` of a step.
    #[inline(always)]
    pub(super) fn values(&self, at: Floats<S>, [from, to]: [Floats<S>; 2], rays: Mask<S>) -> Floats<S> {
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

    /// Where the next step ends that begins at `from`.
    #[inline(always)]
    fn next(&self, from: Floats<S>, length: Floats<S>) -> Floats<S> {
        let simd = self.simd;
        let (one, least) = (Floats::splat(simd, 1.0), Floats::splat(simd, LEAST));
        let is_pure = from.simd_ge(self.pure[0]) & from.simd_lt(self.pure[1]);
        let planes = is_pure.select(one, one + one);
        let mut next = length;
        for axis in 0..3 {
            let (start, stride) = (self.start[axis] * planes, self.stride[axis] * planes);
            let place = from.mul_add(stride, start);
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
                let stretch = Stretch { simd, values, region, begin: enter, start, stride, pure };
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
