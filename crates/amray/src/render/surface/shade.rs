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
use crate::simd::{Doubles, Floats, Gather, Integers, LANES, LaneSet, lanes_of, mask_of};

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
                let plan = self.surfaces.plan;
                let mut asked = [Asked::nothing(simd); PACKETS];
                let mut normals = [[zero; 3]; PACKETS];
                let mut own = [[Floats::splat(simd, 1.0); 4]; PACKETS];
                for packet in 0..PACKETS {
                    let lanes = lanes_of(meeting[packet]);
                    if lanes == 0 {
                        continue;
                    }
                    // A ray that meets nothing would be nowhere, and all planes are measured from the first ray's place.
                    let place = packets[packet].at(meeting[packet].select(met.at[packet], zero));
                    let met_here = (met.number[packet], lanes);
                    normals[packet] = plan.normals(simd, &place, met_here);
                    plan.of_meshes(simd, packet, (met_here, layers), (&mut normals[packet], &mut own[packet]));
                    normals[packet] = self.lamps.toward_eye(simd, &packets[packet], normals[packet]);
                    let off = plan.off(simd, met.at[packet]);
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
