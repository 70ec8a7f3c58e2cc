//! Surfaces along single rays, as paths meet them.

use std::ops::ControlFlow;

use fearless_simd::prelude::*;

use super::super::packet::{Bundle, PACKETS, Packet, Packets};
use super::super::traverse::{Span, Stack};
use super::find::{Met, Seeker};
use super::layers::Layers;
use super::{MOST, Surfaces};
use crate::index::Ray;
use crate::layout::EitherValues;
use crate::scene::Material;
use crate::simd::{Doubles, Floats, Gather, InstructionSet, Kernel, LaneSet, Mask, lanes_of, mask_of};

/// Looks for surfaces along one ray at a time.
pub(in super::super) struct Probe<'a> {
    pub(in super::super) surfaces: Surfaces<'a, EitherValues<'a>>,
    pub(in super::super) instructions: InstructionSet,
}

/// A point of a surface on a ray.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct SurfacePoint {
    /// How far along the ray.
    pub(in super::super) at: f64,
    /// How far off the surface, in cells of the finest level, rays start that go on from here.
    pub(in super::super) off: f64,
    pub(in super::super) color: [f32; 3],
    pub(in super::super) opacity: f32,
    /// In world space, of any length, on any side; all 0 where there is none.
    pub(in super::super) normal: [f32; 3],
    /// How the surface reflects; without, it shows its colour.
    pub(in super::super) material: Option<Material>,
    /// Whether it dims light.
    pub(in super::super) casts_shadows: bool,
}

impl Probe<'_> {
    /// Visits the surfaces that a ray meets before `far`, nearest first, until `visit` breaks. The ray's direction has
    /// length 1 in world units.
    pub(in super::super) fn meet(
        &self,
        ray: Ray,
        far: f64,
        layers: &mut Layers,
        visit: &mut dyn FnMut(SurfacePoint) -> ControlFlow<()>,
    ) {
        self.instructions.run(Meet { ray: OneRay { probe: self, ray, far }, layers, visit });
    }

    /// How much light passes the surfaces on a ray before `far`.
    pub(in super::super) fn transmittance(&self, ray: Ray, far: f64) -> f64 {
        self.instructions.run(Dim(OneRay { probe: self, ray, far }))
    }
}

/// A ray that is alone in its packets.
struct OneRay<'a> {
    probe: &'a Probe<'a>,
    ray: Ray,
    far: f64,
}

/// The first ray of the first packet.
const FIRST: LaneSet = 1;

impl OneRay<'_> {
    /// Packets whose first ray goes somewhere, where that is in the domain, and where it is at all.
    #[inline(always)]
    fn packets<S: Gather>(&self, simd: S) -> (Packets<S>, [Span<S>; 2]) {
        let Self { probe, ray, far } = self;
        let index = probe.surfaces.plan.volume.index();
        let hierarchy = index.hierarchy();
        let size = hierarchy.levels()[hierarchy.finest_level()].cell_size();
        let mut bundle = Bundle::nothing(simd);
        for axis in 0..3 {
            bundle.start[axis] = Doubles::splat(simd, ray.start[axis]);
            bundle.parts[axis] = Doubles::splat(simd, ray.direction[axis] * size[axis]);
        }
        let packets = [Packet::along(simd, index, bundle, Doubles::splat(simd, 0.5), 1.0); PACKETS];
        let domain = index.domain();
        let [low, high] = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
        let (first, infinity) = (mask_of(simd, FIRST), Floats::splat(simd, f32::INFINITY));
        let mut reach = Span { enter: [infinity; PACKETS], leave: [-infinity; PACKETS] };
        let mut span = reach;
        let from = -packets[0].entry;
        let to = Floats::splat(simd, *far as f32) + from;
        let [enter, leave] = packets[0].clip(simd, low, high);
        reach.enter[0] = first.select(from, infinity);
        reach.leave[0] = first.select(to, -infinity);
        span.enter[0] = first.select(enter.max(from), infinity);
        span.leave[0] = first.select(leave.min(to), -infinity);
        (packets, [span, reach])
    }
}

struct Meet<'a> {
    ray: OneRay<'a>,
    layers: &'a mut Layers,
    visit: &'a mut dyn FnMut(SurfacePoint) -> ControlFlow<()>,
}

impl Kernel for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) {
        let Self { ray, layers, visit } = self;
        let (packets, [span, reach]) = ray.packets(simd);
        let (surfaces, mut stack) = (ray.probe.surfaces, Stack::default());
        let mut seeker = Seeker::new(simd, surfaces, &packets, span, &mut stack);
        seeker.seek_meshes(simd, &packets, &reach, layers);
        let mut going = [Mask::splat(simd, false); PACKETS];
        going[0] = mask_of(simd, FIRST);
        for _ in 0..MOST {
            if lanes_of(seeker.met.rays[0]) & FIRST == 0 {
                return;
            }
            if visit(surfaces.point(simd, &packets[0], &seeker.met, layers)).is_break() {
                return;
            }
            seeker.go_on(simd, &going, &packets, &mut stack, Some(layers));
        }
    }
}

struct Dim<'a>(OneRay<'a>);

impl Kernel for Dim<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> f64 {
        let (packets, [span, reach]) = self.0.packets(simd);
        let mut through = [Floats::splat(simd, 1.0); PACKETS];
        self.0.probe.surfaces.dim(simd, &packets, (&span, &reach), &mut through, &mut Stack::default());
        through[0][0].into()
    }
}

impl Surfaces<'_, EitherValues<'_>> {
    /// What the first ray of the first packet has met.
    #[inline(always)]
    fn point<S: Gather>(&self, simd: S, packet: &Packet<S>, met: &Met<S>, layers: &Layers) -> SurfacePoint {
        let plan = self.plan;
        let place = packet.at(met.at[0]);
        let met_here = (met.number[0], FIRST);
        let mut normals = plan.normals(simd, &place, met_here);
        let mut colors = [Floats::splat(simd, 1.0); 4];
        plan.of_meshes(simd, 0, (met_here, layers), (&mut normals, &mut colors));
        let coat = &plan.coats[met.number[0][0] as usize];
        coat.color(simd, &place, FIRST, &mut colors);
        let [red, green, blue, alpha] = colors;
        SurfacePoint {
            at: f64::from(met.at[0][0]) + f64::from(packet.entry[0]),
            off: plan.off(simd, met.at[0])[0].into(),
            color: [red[0], green[0], blue[0]],
            opacity: alpha[0],
            normal: [normals[0][0], normals[1][0], normals[2][0]],
            material: coat.material,
            casts_shadows: coat.casts_shadows,
        }
    }
}
