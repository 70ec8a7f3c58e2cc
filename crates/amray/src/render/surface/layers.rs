//! Where rays meet meshes, one ray at a time.

use amray_mesh::{Hit, Mesh, Ray};

use super::super::packet::{PACKETS, Packet};
use super::plan::SurfacePlan;
use crate::simd::{Floats, Gather, LANES, LaneSet};

/// A mesh in a scene.
pub(super) struct MeshPlan<'a> {
    pub(super) mesh: &'a Mesh,
    /// Whether nothing is seen through it.
    pub(super) is_opaque: bool,
}

/// What a ray meets of meshes, nearest first.
#[derive(Default)]
pub(in super::super) struct Layers {
    /// Of all rays of all packets.
    layers: Vec<Vec<Layer>>,
    /// How many of them each ray has passed.
    passed: [[usize; LANES]; PACKETS],
    hits: Vec<Hit>,
}

#[derive(Clone, Copy)]
pub(super) struct Layer {
    pub(super) at: f32,
    /// The surface's number.
    pub(super) number: i32,
    pub(super) hit: Hit,
}

impl Layers {
    /// Finds all that the `lanes` of packets meet between the ends of their reach.
    #[inline(always)]
    pub(super) fn find<S: Gather>(
        &mut self,
        plan: &SurfacePlan,
        packet: &Packet<S>,
        number: usize,
        ends: [Floats<S>; 2],
        lanes: LaneSet,
    ) {
        self.layers.resize_with(PACKETS * LANES, Vec::new);
        self.passed[number] = [0; LANES];
        let rays = plan.rays(packet, ends);
        for lane in 0..LANES {
            let layers = &mut self.layers[number * LANES + lane];
            layers.clear();
            if lanes >> lane & 1 == 0 {
                continue;
            }
            for (mesh, number) in plan.meshes.iter().zip(plan.first_mesh()..) {
                let layer = |hit: Hit| Layer { at: hit.t as f32, number: number as i32, hit };
                if mesh.is_opaque {
                    layers.extend(mesh.mesh.nearest(&rays[lane]).map(layer));
                } else {
                    mesh.mesh.hits(&rays[lane], &mut self.hits);
                    layers.extend(self.hits.iter().copied().map(layer));
                }
            }
            layers.sort_by(|a, b| a.hit.t.total_cmp(&b.hit.t));
        }
    }

    /// The next layer of a packet's ray.
    pub(super) fn next(&self, packet: usize, lane: usize) -> Option<&Layer> {
        self.layers[packet * LANES + lane].get(self.passed[packet][lane])
    }

    /// Goes on behind the next layers of some lanes.
    pub(super) fn pass(&mut self, packet: usize, lanes: LaneSet) {
        for (lane, passed) in self.passed[packet].iter_mut().enumerate() {
            *passed += usize::from(lanes >> lane & 1);
        }
    }
}

impl SurfacePlan<'_> {
    /// A packet's rays in world space, between ends of theirs.
    #[inline(always)]
    pub(super) fn rays<S: Gather>(&self, packet: &Packet<S>, [from, to]: [Floats<S>; 2]) -> [Ray; LANES] {
        let [start, direction] = [packet.start, packet.direction];
        let start = [start[0].store(), start[1].store(), start[2].store()];
        let direction = [direction[0].store(), direction[1].store(), direction[2].store()];
        let (from, to): ([f32; LANES], [f32; LANES]) = (from.into(), to.into());
        let hierarchy = self.volume.hierarchy();
        let finest = hierarchy.finest_level();
        let size = hierarchy.levels()[finest].cell_size();
        std::array::from_fn(|lane| Ray {
            origin: hierarchy.to_world(finest, std::array::from_fn(|axis| start[axis][lane])),
            direction: std::array::from_fn(|axis| direction[axis][lane] * size[axis]),
            from: from[lane].into(),
            to: to[lane].into(),
        })
    }
}
