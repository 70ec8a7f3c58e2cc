//! What lights make of surfaces and of volumes: Blinn and Phong's reflection, sixteen points at a time.

use fearless_simd::prelude::*;

use super::super::packet::Packet;
use super::occlusion::Arriving;
use crate::hierarchy::Hierarchy;
use crate::scene::{Light, Lighting, Material, SHADOW_LIGHTS, Shading};
use crate::simd::{Doubles, Floats, Gather, exp2, log2};

/// All lights of a picture.
pub(in super::super) struct Lamps {
    /// The sum of the ambient lights.
    ambient: [f32; 3],
    lamps: Vec<Lamp>,
    /// Of the volumes.
    material: Material,
    /// Of the finest level; and over the domain's longest side, so that squares of lengths are no large numbers.
    cell_size: [f64; 3],
    relative_size: [f64; 3],
}

/// A light that comes from somewhere.
struct Lamp {
    color: [f32; 3],
    source: Source,
    /// The place among those that cast shadows.
    shadow: Option<usize>,
}

/// Where light comes from.
#[derive(Clone, Copy)]
pub(super) enum Source {
    Eye,
    /// Against this direction, of length 1.
    Far([f64; 3]),
    /// A place in cells of the finest level, and at what distance over the longest side the light has its colour.
    Near([f64; 3], Option<f64>),
}

/// Sixteen points that reflect light.
pub(in super::super) struct Reflector<S: Gather> {
    material: Material,
    /// Where they are, in cells of the finest level.
    place: [Doubles<S>; 3],
    /// Toward the eye.
    view: [Floats<S>; 3],
    /// Of length 1, on the eye's side.
    normal: [Floats<S>; 3],
    /// How much the points are like a surface, 0 to 1; the rest reflects alike in all directions.
    strength: Floats<S>,
}

/// The gradient that is half a surface: so much of the transfer function over the domain's longest side.
const HALF_GRADIENT: f32 = 0.25;

impl Lamps {
    pub(in super::super) fn new(lighting: &Lighting, hierarchy: &Hierarchy) -> Self {
        let finest = hierarchy.finest_level();
        let cell_size = hierarchy.levels()[finest].cell_size();
        let (mut ambient, mut lamps, mut shadows) = ([0.0; 3], Vec::new(), 0..SHADOW_LIGHTS);
        for light in &lighting.lights {
            let source = match *light {
                Light::Ambient { color } => {
                    (0..3).for_each(|channel| ambient[channel] += color[channel]);
                    continue;
                }
                Light::Headlight { .. } => Source::Eye,
                Light::Directional { direction, .. } => {
                    let length = direction.map(|part| part * part).iter().sum::<f64>().sqrt();
                    Source::Far(direction.map(|part| -part / length))
                }
                Light::Point { position, reach, .. } => Source::Near(
                    hierarchy.to_cells(finest, position),
                    reach.map(|reach| reach / hierarchy.longest_side()),
                ),
            };
            let shadow = if lighting.shadows && light.casts_shadows() { shadows.next() } else { None };
            lamps.push(Lamp { color: light.color(), source, shadow });
        }
        Self {
            ambient,
            lamps,
            material: match lighting.shading {
                Shading::Gradient(material) => material,
                Shading::Emissive | Shading::Isotropic => Material::default(),
            },
            cell_size,
            relative_size: cell_size.map(|size| size / hierarchy.longest_side()),
        }
    }

    /// The sources that cast shadows, in the order of their places.
    pub(super) fn shadow_sources(&self) -> Vec<Source> {
        self.lamps.iter().filter(|lamp| lamp.shadow.is_some()).map(|lamp| lamp.source).collect()
    }

    /// What reflectors of a colour (times their opacity) and an opacity send to the eye of the light that arrives.
    #[inline(always)]
    pub(in super::super) fn reflect<S: Gather>(
        &self,
        simd: S,
        reflector: &Reflector<S>,
        arriving: &Arriving<S>,
        (color, opacity): ([Floats<S>; 3], Floats<S>),
    ) -> [Floats<S>; 3] {
        let (zero, one, strength) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0), reflector.strength);
        let Material { ambient, diffuse, specular, specular_power } = reflector.material;
        let mut normal = reflector.normal;
        for axis in 0..3 {
            normal[axis] *= strength;
        }
        let share = strength.mul_add(Floats::splat(simd, ambient - 1.0), one) * arriving.of_ambient(simd, &normal);
        let mut sum = [zero; 3];
        for channel in 0..3 {
            sum[channel] = color[channel] * share * Floats::splat(simd, self.ambient[channel]);
        }
        let facing = dot(&reflector.normal, &reflector.view);
        for lamp in &self.lamps {
            let (toward, falloff) = match lamp.source {
                Source::Eye => (reflector.view, one),
                Source::Far(toward) => {
                    let mut lanes = reflector.view;
                    for axis in 0..3 {
                        lanes[axis] = Floats::splat(simd, toward[axis] as f32);
                    }
                    (lanes, one)
                }
                Source::Near(place, reach) => self.toward(simd, &reflector.place, place, reach),
            };
            let arrives = lamp.shadow.map_or(falloff, |light| falloff * arriving.direct[light]);
            // Of the light and of the middle between it and the eye: light from the eye has both in one.
            let (mut cosine, mut middle) = (facing.abs(), facing.abs());
            if !matches!(lamp.source, Source::Eye) {
                cosine = dot(&reflector.normal, &toward);
                // Both sides of a surface reflect, but not what comes from behind it.
                let front = (cosine * facing).simd_ge(zero);
                cosine = front.select(cosine.abs(), zero);
                if specular > 0.0 {
                    let mut half = toward;
                    for axis in 0..3 {
                        half[axis] += reflector.view[axis];
                    }
                    let length = dot(&half, &half).max(Floats::splat(simd, f32::MIN_POSITIVE)).sqrt();
                    middle = front.select((dot(&reflector.normal, &half) / length).abs(), zero);
                }
            }
            let share = strength.mul_add(cosine.mul_add(Floats::splat(simd, diffuse), -one), one) * arrives;
            let mut highlight = zero;
            if specular > 0.0 {
                highlight = powered(simd, middle, specular_power) * strength * opacity * arrives * specular;
            }
            for channel in 0..3 {
                let reflected = color[channel].mul_add(share, highlight);
                sum[channel] = reflected.mul_add(Floats::splat(simd, lamp.color[channel]), sum[channel]);
            }
        }
        sum
    }

    /// The directions from places to a point, and by how much its light has fallen off there.
    #[inline(always)]
    fn toward<S: Gather>(
        &self,
        simd: S,
        from: &[Doubles<S>; 3],
        to: [f64; 3],
        reach: Option<f64>,
    ) -> ([Floats<S>; 3], Floats<S>) {
        let mut toward = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            let size = Doubles::splat(simd, self.relative_size[axis]);
            toward[axis] = ((Doubles::splat(simd, to[axis]) - from[axis]) * size).to_floats();
        }
        let square = dot(&toward, &toward).max(Floats::splat(simd, f32::MIN_POSITIVE));
        let inverse = Floats::splat(simd, 1.0) / square.sqrt();
        for axis in 0..3 {
            toward[axis] *= inverse;
        }
        let one = Floats::splat(simd, 1.0);
        // In reach the light is no brighter: no point burns out.
        let falloff = reach.map_or(one, |reach| (Floats::splat(simd, (reach * reach) as f32) / square).min(one));
        (toward, falloff)
    }
}

impl<S: Gather> Reflector<S> {
    /// Points of a volume, in cells of the finest level, seen from these directions of length 1, where the transfer function's position has a
    /// gradient per longest side of the domain; where it is 0, they reflect alike in all directions.
    #[inline(always)]
    pub(super) fn of_volume(
        simd: S,
        view: [Floats<S>; 3],
        lamps: &Lamps,
        place: [Doubles<S>; 3],
        gradient: [Floats<S>; 3],
    ) -> Self {
        let (normal, square) = toward(simd, &view, gradient);
        let half = Floats::splat(simd, HALF_GRADIENT * HALF_GRADIENT);
        Self { material: lamps.material, place, view, normal, strength: square / (square + half) }
    }

    /// Points of surfaces on a packet's rays, with their normals of length 1; where these are 0, the surface faces the
    /// eye.
    #[inline(always)]
    pub(in super::super) fn of_surface(
        simd: S,
        packet: &Packet<S>,
        lamps: &Lamps,
        material: Material,
        (place, normal): ([Doubles<S>; 3], [Floats<S>; 3]),
    ) -> Self {
        Self { material, place, view: lamps.view(simd, packet), normal, strength: Floats::splat(simd, 1.0) }
    }
}

impl Lamps {
    /// Whether it matters where points are: not for light from the eye and from far away.
    pub(super) fn need_places(&self) -> bool {
        self.lamps.iter().any(|lamp| matches!(lamp.source, Source::Near(..)))
    }

    /// Directions to the eye.
    #[inline(always)]
    pub(super) fn view<S: Gather>(&self, simd: S, packet: &Packet<S>) -> [Floats<S>; 3] {
        let mut view = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            view[axis] = packet.direction[axis].to_floats() * Floats::splat(simd, -self.cell_size[axis] as f32);
        }
        view
    }

    /// Normals of length 1 on the eye's side, along directions of any length; where one is 0 or no number, toward the eye.
    #[inline(always)]
    pub(in super::super) fn toward_eye<S: Gather>(
        &self,
        simd: S,
        packet: &Packet<S>,
        directions: [Floats<S>; 3],
    ) -> [Floats<S>; 3] {
        let view = self.view(simd, packet);
        let (mut normals, square) = toward(simd, &view, directions);
        for axis in 0..3 {
            normals[axis] = square.simd_gt(Floats::splat(simd, 0.0)).select(normals[axis], view[axis]);
        }
        normals
    }
}

/// Directions made 1 long and turned to the side of others, and the squares of the lengths that they had; 0 where that
/// is no number.
#[inline(always)]
fn toward<S: Gather>(simd: S, side: &[Floats<S>; 3], directions: [Floats<S>; 3]) -> ([Floats<S>; 3], Floats<S>) {
    let (mut normal, zero) = (directions, Floats::splat(simd, 0.0));
    let square = dot(&normal, &normal);
    let square = square.simd_lt(Floats::splat(simd, f32::MAX)).select(square, zero);
    let inverse = Floats::splat(simd, 1.0) / square.max(Floats::splat(simd, f32::MIN_POSITIVE)).sqrt();
    let inverse = square.simd_gt(zero).select(inverse, zero);
    let behind = dot(&normal, side).simd_lt(zero);
    let inverse = behind.select(-inverse, inverse);
    for axis in 0..3 {
        normal[axis] = inverse.simd_eq(zero).select(zero, normal[axis] * inverse);
    }
    (normal, square)
}

/// Numbers from 0 to 1 to a power above 0, by squaring where that is enough.
#[inline(always)]
fn powered<S: Gather>(simd: S, mut base: Floats<S>, power: f32) -> Floats<S> {
    for squarings in 0..8 {
        if power == (1 << squarings) as f32 {
            for _ in 0..squarings {
                base *= base;
            }
            return base;
        }
    }
    exp2(simd, log2(simd, base.max(Floats::splat(simd, 1e-6))) * Floats::splat(simd, power))
}

#[inline(always)]
pub(super) fn dot<S: Gather>(a: &[Floats<S>; 3], b: &[Floats<S>; 3]) -> Floats<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}
