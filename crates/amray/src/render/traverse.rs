//! A packet's way through the tree of pieces, front to back.

use fearless_simd::prelude::*;

use super::packet::{Masks, PACKETS, Packets};
use super::visibility::{NodeLook, SeenLook};
use crate::layout::PieceNode;
use crate::simd::{Floats, Gather, Mask};

/// Where each ray is in a node, or was left to wait there, packet by packet.
#[derive(Clone, Copy)]
pub(super) struct Span<S: Gather> {
    pub(super) enter: [Floats<S>; PACKETS],
    pub(super) leave: [Floats<S>; PACKETS],
}

/// What packets do on their way.
pub(super) trait Visitor<S: Gather> {
    /// Which of the rays go on at all.
    fn going(&self) -> &Masks<S>;

    /// Which of the rays come from where something is seen, and have to end that where nothing is.
    fn begun(&self) -> &Masks<S>;

    /// Rays pass a node in which nothing is seen.
    fn skip(&mut self, node: usize, span: &Span<S>, rays: &Masks<S>);

    /// The packets go through a node that lies in a region, which is seen or not.
    fn visit(&mut self, node_and_region: (usize, usize), look: Option<&SeenLook>, span: &Span<S>, rays: &Masks<S>);
}

/// Nodes that wait for the packets to come back to them.
pub(super) type Stack<S> = Vec<(usize, Span<S>)>;

/// Takes the packets through all regions between `span`'s ends, each ray in its order.
#[inline(always)]
pub(super) fn traverse<S: Gather>(
    simd: S,
    nodes: &[PieceNode],
    looks: &[NodeLook],
    packets: &Packets<S>,
    span: Span<S>,
    stack: &mut Stack<S>,
    visitor: &mut impl Visitor<S>,
) {
    let none = Mask::splat(simd, false);
    stack.clear();
    stack.push((0, span));
    while let Some((mut place, mut span)) = stack.pop() {
        loop {
            let node = &nodes[place];
            let look = &looks[place];
            let mut rays = [none; PACKETS];
            for packet in 0..PACKETS {
                rays[packet] = span.enter[packet].simd_lt(span.leave[packet]) & visitor.going()[packet];
            }
            if *look == NodeLook::Hidden {
                let mut ending = rays;
                for packet in 0..PACKETS {
                    ending[packet] &= visitor.begun()[packet];
                    rays[packet] &= !visitor.begun()[packet];
                }
                visitor.skip(place, &span, &rays);
                rays = ending;
            }
            if none_of(&rays) {
                break;
            }
            match (look, node.region, node.cut) {
                (NodeLook::Seen(look), Some(region), _) => {
                    visitor.visit((place, region as usize), Some(look), &span, &rays);
                    break;
                }
                (NodeLook::Hidden, Some(region), _) | (_, Some(region), None) => {
                    visitor.visit((place, region as usize), None, &span, &rays);
                    break;
                }
                (_, _, Some(cut)) => {
                    let (axis, plane) = (usize::from(cut.axis), cut.plane as f64);
                    let (low, high) = (place + 1, cut.high as usize);
                    let (near, far) = if packets[0].is_low_first(axis, plane) { (low, high) } else { (high, low) };
                    let (mut stays, mut goes) = (rays, rays);
                    let (mut before, mut beyond) = (span, span);
                    for packet in 0..PACKETS {
                        let change = packets[packet].change(simd, axis, plane);
                        stays[packet] &= change.simd_gt(span.enter[packet]);
                        goes[packet] &= change.simd_lt(span.leave[packet]);
                        before.leave[packet] = span.leave[packet].min(change);
                        beyond.enter[packet] = span.enter[packet].max(change);
                    }
                    if none_of(&stays) {
                        span = beyond;
                        place = far;
                        continue;
                    }
                    if !none_of(&goes) {
                        stack.push((far, beyond));
                    }
                    span = before;
                    place = near;
                }
                (_, None, None) => break,
            }
        }
    }
}

#[inline(always)]
fn none_of<S: Gather>(masks: &Masks<S>) -> bool {
    let mut any = masks[0];
    for packet in 1..PACKETS {
        any |= masks[packet];
    }
    any.all_false()
}
