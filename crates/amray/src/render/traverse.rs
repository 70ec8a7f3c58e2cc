//! A packet's way through the tree, front to back.

use fearless_simd::prelude::*;

use super::packet::Packet;
use crate::index::{Index, Node};
use crate::simd::{Floats, Gather, Mask};

/// Where each ray of a packet is in a node, or was left to wait there.
#[derive(Clone, Copy)]
pub(super) struct Span<S: Gather> {
    pub(super) enter: Floats<S>,
    pub(super) leave: Floats<S>,
}

/// What a packet does on its way.
pub(super) trait Visitor<S: Gather> {
    /// Which of the rays that pass a node have anything to do there.
    fn wanted(&mut self, node: usize, span: &Span<S>, rays: Mask<S>) -> Mask<S>;

    /// The packet passes a region.
    fn visit(&mut self, region: usize, span: &Span<S>, rays: Mask<S>);
}

/// Nodes that wait for a packet to come back to them.
pub(super) type Stack<S> = Vec<(usize, Span<S>)>;

/// Takes the packet through all regions between `span`'s ends, each ray in its order.
#[inline(always)]
pub(super) fn traverse<S: Gather>(
    simd: S,
    index: &Index,
    packet: &Packet<S>,
    span: Span<S>,
    stack: &mut Stack<S>,
    visitor: &mut impl Visitor<S>,
) {
    let nodes = index.nodes();
    stack.clear();
    stack.push((0, span));
    while let Some((mut node, mut span)) = stack.pop() {
        loop {
            let rays = visitor.wanted(node, &span, span.enter.simd_lt(span.leave));
            if rays.all_false() {
                break;
            }
            match nodes[node] {
                Node::Leaf(region) => {
                    visitor.visit(region as usize, &span, rays);
                    break;
                }
                Node::Inner { axis, plane, high } => {
                    let (change, low_first) = packet.change(simd, usize::from(axis), plane as f64);
                    let (near, far) = if low_first { (node + 1, high as usize) } else { (high as usize, node + 1) };
                    let [stays, goes] = [rays & change.simd_gt(span.enter), rays & change.simd_lt(span.leave)];
                    if stays.all_false() {
                        span.enter = span.enter.max(change);
                        node = far;
                        continue;
                    }
                    if goes.any_true() {
                        stack.push((far, Span { enter: span.enter.max(change), ..span }));
                    }
                    span.leave = span.leave.min(change);
                    node = near;
                }
            }
        }
    }
}
