//! The light of surfaces, and what of other light they let through.

use amray_mesh::Hit;
use fearless_simd::prelude::*;

use super::super::RenderStatistics;
use super::super::lit::{Arriving, Asked, Kind, Occluders, Reflector};
use super::super::march::clear;
use super::super::packet::{Masks, PACKETS, Packet, Packets};
use super::super::traverse::{Span, Stack};
use super::find::{Met, Seeker};
use super::layers::Layers;
use super::plan::SurfacePlan;
use super::{MOST, Surfaces, WithSurfaces};
use crate::appearance::Radiance;
use crate::layout::RegionValues;
use crate::simd::{Doubles, Floats, Gather, Integers, LANES, LaneSet, Mask, lanes_of, mask_of};

/// How far off its surface, in cells of the finest level, a ray to a light starts; and by how much of the way to it.
const OFF: f32 = 1e-2;
const ROUNDING: f32 = 1e-6;

impl<E, V: RegionValues + Copy, O: Occluders> WithSurfaces<'_, E, V, O> {
    /// Adds the light of the surfaces that rays are `meeting`, and takes what they hide.
    #[inline(never)]
    pub(super) fn shade<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        (met, meeting, layers): (&Met<S>, &Masks<S>, &Layers),
        lights: &mut [Radiance<S>; PACKETS],
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let zero = Floats::splat(simd, 0.0);
                let mut asked = [Asked::nothing(simd); PACKETS];
                let mut normals = [[zero; 3]; PACKETS];
                let mut own = [[Floats::splat(simd, 1.0); 4]; PACKETS];
                for packet in 0..PACKETS {
                    let lanes = lanes_of(meeting[packet]);
                    if lanes == 0 {
                        continue;
                    }
                    let place = packets[packet].at(met.at[packet]);
                    let met_here = (met.number[packet], lanes);
                    normals[packet] = self.normals(simd, &place, met_here);
                    self.of_meshes(simd, packet, (met_here, layers), (&mut normals[packet], &mut own[packet]));
                    normals[packet] = self.lamps.toward_eye(simd, &packets[packet], normals[packet]);
                    let off = met.at[packet].abs() * Floats::splat(simd, ROUNDING / self.cell_size());
                    let off = off + Floats::splat(simd, OFF.max(2.0 * self.precision() / self.cell_size()));
                    asked[packet] = Asked { rays: meeting[packet], place, skipped: zero };
                    for axis in 0..3 {
                        asked[packet].place[axis] = place[axis] + Doubles::from_floats(normals[packet][axis] * off);
                    }
                }
                let mut arriving = [Arriving::all(simd); PACKETS];
                if let Some(occlusion) = self.occlusion {
                    let direct = occlusion.arriving(simd, Kind::Direct, &asked, stack, statistics);
                    let ambient = occlusion.arriving(simd, Kind::Ambient, &asked, stack, statistics);
                    for packet in 0..PACKETS {
                        arriving[packet] = Arriving { direct: direct[packet], ambient: ambient[packet] };
                    }
                }
                for packet in 0..PACKETS {
                    let (light, lanes) = (&mut lights[packet], lanes_of(meeting[packet]));
                    if lanes != 0 {
                        let place = packets[packet].at(met.at[packet]);
                        let met = (met.number[packet], lanes, &own[packet]);
                        self.add(simd, &packets[packet], (&place, &normals[packet]), met, &arriving[packet], light);
                    }
                }
            },
        );
    }

    /// The longest side of a cell of the finest level.
    fn cell_size(&self) -> f32 {
        let hierarchy = self.surfaces.plan.volume.hierarchy();
        hierarchy.levels()[hierarchy.finest_level()].cell_size().into_iter().fold(0.0, f64::max) as f32
    }

    /// How far meshes may be from where they are met, in world units.
    fn precision(&self) -> f32 {
        self.surfaces.plan.meshes.iter().map(|mesh| mesh.mesh.precision()).fold(0.0, f64::max) as f32
    }

    /// Puts the normals and colours of meshes that lanes meet into those that are there.
    #[inline(always)]
    fn of_meshes<S: Gather>(
        &self,
        simd: S,
        packet: usize,
        ((numbers, lanes), layers): ((Integers<S>, LaneSet), &Layers),
        (normals, colors): (&mut [Floats<S>; 3], &mut [Floats<S>; 4]),
    ) {
        let first = Integers::splat(simd, self.surfaces.plan.first_mesh() as i32);
        let meshes = lanes_of(numbers.simd_ge(first)) & lanes;
        for lane in (0..LANES).filter(|lane| meshes >> lane & 1 == 1) {
            if let Some(layer) = layers.next(packet, lane) {
                for axis in 0..3 {
                    normals[axis][lane] = layer.hit.normal[axis];
                }
                for channel in 0..4 {
                    colors[channel][lane] = layer.hit.color[channel];
                }
            }
        }
    }

    /// Across isosurfaces and slices, in world space, of any length.
    #[inline(always)]
    fn normals<S: Gather>(
        &self,
        simd: S,
        place: &[Doubles<S>; 3],
        (numbers, lanes): (Integers<S>, LaneSet),
    ) -> [Floats<S>; 3] {
        let plan = self.surfaces.plan;
        let zero = Floats::splat(simd, 0.0);
        let mut normals = [zero; 3];
        let rays = mask_of(simd, lanes);
        let isosurfaces = rays & numbers.simd_lt(Integers::splat(simd, plan.levels.len() as i32));
        if isosurfaces.any_true() {
            normals = self.rise(simd, place, isosurfaces);
        }
        for (nth, coat) in plan.coats.iter().enumerate() {
            if let Some(normal) = coat.normal {
                let here = numbers.simd_eq(Integers::splat(simd, nth as i32));
                for axis in 0..3 {
                    normals[axis] = here.select(Floats::splat(simd, normal[axis]), normals[axis]);
                }
            }
        }
        normals
    }

    /// How the values at places rise from one leaf cell before them to one behind, in world space: as between cells'
    /// centres, where VTK takes normals from. The gradient itself jumps from cell to cell; this does not.
    #[inline(always)]
    fn rise<S: Gather>(&self, simd: S, place: &[Doubles<S>; 3], rays: Mask<S>) -> [Floats<S>; 3] {
        let plan = self.surfaces.plan;
        let hierarchy = plan.volume.hierarchy();
        let levels = hierarchy.levels();
        let middle = [place[0].store(), place[1].store(), place[2].store()];
        let here = plan.sampler.sample::<S, Floats<S>>(simd, &middle, rays);
        let found: [i32; LANES] = here.levels.into();
        let mut rise = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            let (mut low, mut high, mut inverse) = (middle, middle, [0.0; LANES]);
            for lane in 0..LANES {
                let level = &levels[found[lane].max(0) as usize];
                let cell = level.finest_cells()[axis] as f64;
                low[axis][lane] -= cell;
                high[axis][lane] += cell;
                inverse[lane] = (levels[0].cell_size()[0] / level.cell_size()[axis]) as f32;
            }
            let low = plan.sampler.sample::<S, Floats<S>>(simd, &low, rays).values;
            let high = plan.sampler.sample::<S, Floats<S>>(simd, &high, rays).values;
            // Next to where there is no value, the other side tells it.
            let (before, behind) = (here.values - low, high - here.values);
            let before = before.is_finite().select(before, behind);
            let behind = behind.is_finite().select(behind, before);
            rise[axis] = (before + behind) * Floats::from_slice(simd, &inverse);
        }
        rise
    }

    /// Adds a packet's light.
    #[inline(always)]
    fn add<S: Gather>(
        &self,
        simd: S,
        packet: &Packet<S>,
        (place, normal): (&[Doubles<S>; 3], &[Floats<S>; 3]),
        (numbers, lanes, own): (Integers<S>, LaneSet, &[Floats<S>; 4]),
        arriving: &Arriving<S>,
        light: &mut Radiance<S>,
    ) {
        let plan = self.surfaces.plan;
        let all: [i32; LANES] = numbers.into();
        let mut left = lanes;
        while left != 0 {
            let number = all[left.trailing_zeros() as usize];
            let here = numbers.simd_eq(Integers::splat(simd, number)) & mask_of(simd, left);
            left &= !lanes_of(here);
            let coat = &plan.coats[number as usize];
            let mut parts = *own;
            coat.color(simd, place, lanes_of(here), &mut parts);
            let [red, green, blue, alpha] = parts;
            let opacity = light.transmittance * alpha;
            let mut color = [red * opacity, green * opacity, blue * opacity];
            if let Some(material) = coat.material {
                let reflector = Reflector::of_surface(simd, packet, self.lamps, material, (*place, *normal));
                color = self.lamps.reflect(simd, &reflector, arriving, (color, opacity));
            }
            for channel in 0..3 {
                light.color[channel] = here.select(light.color[channel] + color[channel], light.color[channel]);
            }
            light.transmittance = here.select(light.transmittance - opacity, light.transmittance);
        }
    }
}

impl<V: RegionValues + Copy> Surfaces<'_, V> {
    /// Dims light along packets of rays, between the ends of `span`.
    #[inline(never)]
    pub(in super::super) fn dim<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        (span, reach): (&Span<S>, &Span<S>),
        through: &mut [Floats<S>; PACKETS],
        stack: &mut Stack<S>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                if !self.plan.meshes.is_empty() {
                    for packet in 0..PACKETS {
                        self.plan.dim(simd, &packets[packet], (packet, reach), &mut through[packet]);
                    }
                }
                if self.plan.first_mesh() == 0 {
                    return;
                }
                let mut seeker = Seeker::new(simd, *self, packets, *span, stack);
                for _ in 0..MOST {
                    let mut going = seeker.met.rays;
                    let mut any = false;
                    for packet in 0..PACKETS {
                        for (number, coat) in self.plan.coats.iter().enumerate() {
                            let here = seeker.met.number[packet].simd_eq(Integers::splat(simd, number as i32));
                            let less = through[packet] * Floats::splat(simd, coat.transparency());
                            through[packet] = (here & going[packet]).select(less, through[packet]);
                        }
                        going[packet] &= clear(simd, through[packet]);
                        any |= going[packet].any_true();
                    }
                    if !any {
                        return;
                    }
                    seeker.go_on(simd, &going, packets, stack, None);
                }
            },
        );
    }
}

impl SurfacePlan<'_> {
    /// Dims the light of a packet's rays that goes through meshes.
    #[inline(always)]
    fn dim<S: Gather>(&self, simd: S, packet: &Packet<S>, (number, reach): (usize, &Span<S>), through: &mut Floats<S>) {
        let rays = self.rays(packet, [reach.enter[number], reach.leave[number]]);
        let going = lanes_of(clear(simd, *through) & reach.enter[number].simd_lt(reach.leave[number]));
        let mut lanes: [f32; LANES] = (*through).into();
        for lane in (0..LANES).filter(|lane| going >> lane & 1 == 1) {
            let meshes = self.meshes.iter().zip(&self.coats[self.first_mesh()..]);
            for (mesh, coat) in meshes.filter(|(_, coat)| coat.casts_shadows) {
                let alpha = |hit: &Hit| coat.alpha(hit.color[3]);
                lanes[lane] *= match mesh.is_opaque {
                    true => f32::from(u8::from(!mesh.mesh.is_hit(&rays[lane]))),
                    false => mesh.mesh.transmittance(&rays[lane], alpha) as f32,
                };
            }
        }
        *through = Floats::from_slice(simd, &lanes);
    }
}
