//! What of the rays goes through what no clip has cut away.

use fearless_simd::prelude::*;

use super::packet::{PACKETS, Packet, Packets};
use super::plane::Plane;
use super::traverse::Span;
use super::{RenderStatistics, Trace};
use crate::appearance::Radiance;
use crate::hierarchy::Hierarchy;
use crate::scene::Clip;
use crate::simd::{Floats, Gather};

/// The clips of a scene, in cells of the finest level.
#[derive(Default)]
pub(super) struct Clips {
    /// Nothing outside of this box is left.
    inside: Option<Corners>,
    /// Nothing before one of these planes is left.
    planes: Vec<Plane>,
    /// Nothing inside of one of these boxes is left.
    outside: Vec<Corners>,
}

/// The low and the high corner of a box.
type Corners = [[f64; 3]; 2];

impl Clips {
    pub(super) fn new(clips: &[Clip], hierarchy: &Hierarchy) -> Self {
        let corners = |corners: Corners| corners.map(|corner| hierarchy.to_cells(hierarchy.finest_level(), corner));
        let mut all = Self::default();
        for clip in clips {
            match *clip {
                Clip::Plane { point, normal } => all.planes.push(Plane::new(hierarchy, point, normal)),
                Clip::Inside(inside) => {
                    let [low, high] = corners(inside);
                    let [lowest, highest] = all.inside.unwrap_or([low, high]);
                    let low: [f64; 3] = std::array::from_fn(|axis| low[axis].max(lowest[axis]));
                    // Boxes that share nothing leave a box with no inside.
                    let high = std::array::from_fn(|axis| high[axis].min(highest[axis]).max(low[axis]));
                    all.inside = Some([low, high]);
                }
                Clip::Outside(outside) => all.outside.push(corners(outside)),
            }
        }
        all
    }

    /// Whether a place is cut away.
    pub(super) fn hides(&self, place: [f64; 3]) -> bool {
        let is_in = |[low, high]: &Corners| (0..3).all(|axis| (low[axis]..high[axis]).contains(&place[axis]));
        self.inside.as_ref().is_some_and(|inside| !is_in(inside))
            || self.planes.iter().any(|plane| !plane.is_beyond(place))
            || self.outside.iter().any(is_in)
    }

    /// Narrows what rays go through to what is inside, and beyond planes.
    #[inline(always)]
    pub(super) fn narrow<S: Gather>(&self, simd: S, packets: &Packets<S>, span: &mut Span<S>) {
        for packet in 0..PACKETS {
            let mut ends = [span.enter[packet], span.leave[packet]];
            if let Some([low, high]) = self.inside {
                let [enter, leave] = packets[packet].clip(simd, low, high);
                ends = [ends[0].max(enter), ends[1].min(leave)];
            }
            for plane in &self.planes {
                ends = plane.beyond(simd, &packets[packet], ends);
            }
            [span.enter[packet], span.leave[packet]] = ends;
        }
    }

    /// Where rays that are at `at` are next in no box that is cut away; `at` itself where they are in none.
    #[inline(always)]
    pub(super) fn exit<S: Gather>(&self, simd: S, packet: &Packet<S>, mut at: Floats<S>) -> Floats<S> {
        // Out of one box, rays may be in another one.
        for _ in &self.outside {
            for &[low, high] in &self.outside {
                let [enter, leave] = packet.clip(simd, low, high);
                let inside = at.simd_ge(enter) & at.simd_lt(leave);
                at = inside.select(leave, at);
            }
        }
        at
    }

    /// How many boxes are cut away.
    pub(super) fn holes(&self) -> usize {
        self.outside.len()
    }
}

/// The parts of rays that are not cut away, from the first one on.
pub(super) struct Parts<'a, S: Gather> {
    clips: &'a Clips,
    /// What is left.
    span: Span<S>,
    /// How many more there can be.
    most: usize,
}

impl<'a, S: Gather> Parts<'a, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, clips: &'a Clips, packets: &Packets<S>, span: &Span<S>) -> Self {
        let mut span = *span;
        clips.narrow(simd, packets, &mut span);
        Self { clips, span, most: clips.holes() + 1 }
    }

    /// The next part of each ray; empty where there is none.
    #[inline(always)]
    pub(super) fn next(&mut self, simd: S, packets: &Packets<S>) -> Option<Span<S>> {
        let Self { clips, span, most } = self;
        *most = most.checked_sub(1)?;
        let mut part = *span;
        let mut any = false;
        for packet in 0..PACKETS {
            let enter = clips.exit(simd, &packets[packet], span.enter[packet]);
            part.enter[packet] = enter;
            for &[low, high] in &clips.outside {
                let [hole, end] = packets[packet].clip(simd, low, high);
                let ahead = hole.simd_gt(enter) & hole.simd_lt(end);
                part.leave[packet] = ahead.select(part.leave[packet].min(hole), part.leave[packet]);
            }
            span.enter[packet] = part.leave[packet];
            any |= part.enter[packet].simd_lt(part.leave[packet]).any_true();
        }
        any.then_some(part)
    }
}

/// An engine that sees nothing of what is cut away.
pub(super) struct Clipped<'a, E> {
    pub(super) engine: &'a E,
    pub(super) clips: &'a Clips,
}

impl<E: Trace> Trace for Clipped<'_, E> {
    type Scratch<S: Gather> = E::Scratch<S>;

    #[inline(always)]
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        scratch: &mut E::Scratch<S>,
        statistics: &mut RenderStatistics,
    ) {
        let mut parts = Parts::new(simd, self.clips, packets, span);
        while let Some(part) = parts.next(simd, packets) {
            self.engine.trace_apart(simd, packets, &part, lights, scratch, statistics);
        }
    }
}
