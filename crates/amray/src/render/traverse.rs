//! A packet's way through the tree of pieces, front to back.

use fearless_simd::prelude::*;

use super::packet::Packet;
use super::visibility::{NodeLook, SeenLook};
use crate::layout::PieceNode;
use crate::simd::{Floats, Gather, Mask};

/// Where each ray of a packet is in a node, or was left to wait there.
#[derive(Clone, Copy)]
pub(super) struct Span<S: Gather> {
    pub(super) enter: Floats<S>,
    pub(super) leave: Floats<S>,
}

/// What a packet does on its way.
pub(super) trait Visitor<S: Gather> {
    /// Which of the rays go on at all.
    fn going(&self) -> Mask<S>;

    /// Which of the rays come from where something is seen, and have to end that where nothing is.
    fn begun(&self) -> Mask<S>;

    /// Rays pass a node in which nothing is seen.
    fn skip(&mut self, span: &Span<S>, rays: Mask<S>);

    /// The packet goes through a part of a region, which is seen or not.
    fn visit(&mut self, region: usize, look: Option<&SeenLook>, span: &Span<S>, rays: Mask<S>);
}

/// Nodes that wait for a packet to come back to them.
pub(super) type Stack<S> = Vec<(usize, Span<S>)>;

/// Takes the packet through all regions between `span`'s ends, each ray in its order.
#[inline(always)]
pub(super) fn traverse<S: Gather>(
    simd: S,
    nodes: &[PieceNode],
    looks: &[NodeLook],
    packet: &Packet<S>,
    span: Span<S>,
    stack: &mut Stack<S>,
    visitor: &mut impl Visitor<S>,
) {
    stack.clear();
    stack.push((0, span));
    while let Some((mut place, mut span)) = stack.pop() {
        loop {
            let mut rays = span.enter.simd_lt(span.leave) & visitor.going();
            let node = &nodes[place];
            let look = &looks[place];
            if *look == NodeLook::Hidden {
                visitor.skip(&span, rays & !visitor.begun());
                rays &= visitor.begun();
            }
            if rays.all_false() {
                break;
            }
            match (look, node.region, node.cut) {
                (NodeLook::Seen(look), Some(region), _) => {
                    visitor.visit(region as usize, Some(look), &span, rays);
                    break;
                }
                (NodeLook::Hidden, Some(region), _) | (_, Some(region), None) => {
                    visitor.visit(region as usize, None, &span, rays);
                    break;
                }
                (_, _, Some(cut)) => {
                    let (change, low_first) = packet.change(simd, usize::from(cut.axis), cut.plane as f64);
                    let (low, high) = (place + 1, cut.high as usize);
                    let (near, far) = if low_first { (low, high) } else { (high, low) };
                    let [stays, goes] = [rays & change.simd_gt(span.enter), rays & change.simd_lt(span.leave)];
                    if stays.all_false() {
                        span.enter = span.enter.max(change);
                        place = far;
                        continue;
                    }
                    if goes.any_true() {
                        stack.push((far, Span { enter: span.enter.max(change), ..span }));
                    }
                    span.leave = span.leave.min(change);
                    place = near;
                }
                (_, None, None) => break,
            }
        }
    }
}
