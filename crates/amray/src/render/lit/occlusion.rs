//! How much light arrives: rays to the lights, and short ones all around.

use fearless_simd::prelude::*;

use super::super::RenderStatistics;
use super::super::clip::{Clips, Parts};
use super::super::march::{Dimming, March, Medium};
use super::super::packet::{Bundle, PACKETS, Packet, Packets};
use super::super::surface::Surfaces;
use super::super::traverse::{Span, Stack};
use super::lamps::{Lamps, Source, dot};
use crate::index::Index;
use crate::layout::RegionValues;
use crate::scene::{AmbientOcclusion, Lighting, SHADOW_LIGHTS};
use crate::simd::{Doubles, Floats, Gather, Mask};

/// What may lie between a point and a light.
pub(in super::super) trait Occluders: Sync {
    /// Dims light along packets of rays, between the ends of `reach`; those of `span` lie in the domain.
    fn dim<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span_and_reach: (&Span<S>, &Span<S>),
        through: &mut [Floats<S>; PACKETS],
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    );
}

/// A medium with surfaces in it.
pub(in super::super) struct Obstacles<'a, M, V> {
    pub(in super::super) march: March<'a, M>,
    pub(in super::super) surfaces: Option<Surfaces<'a, V>>,
    pub(in super::super) clips: &'a Clips,
}

impl<M: Medium, V: RegionValues + Copy> Occluders for Obstacles<'_, M, V> {
    #[inline(always)]
    fn dim<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        (span, reach): (&Span<S>, &Span<S>),
        through: &mut [Floats<S>; PACKETS],
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) {
        if let Some(surfaces) = &self.surfaces {
            surfaces.dim(simd, packets, (span, reach), through, stack);
        }
        let mut parts = Parts::new(simd, self.clips, packets, span);
        while let Some(part) = parts.next(simd, packets) {
            self.march.collect(simd, packets, &part, (&mut Dimming, &mut *through), stack, statistics);
        }
    }
}

/// Finds what of the light arrives.
pub(in super::super) struct Occlusion<'a, O> {
    pub(in super::super) occluders: O,
    index: &'a Index,
    sources: Vec<Source>,
    ambient: Option<AmbientOcclusion>,
    samples_per_cell: f64,
}

/// Points at which it is asked for.
#[derive(Clone, Copy)]
pub(in super::super) struct Asked<S: Gather> {
    pub(in super::super) rays: Mask<S>,
    /// In cells of the finest level.
    pub(in super::super) place: [Doubles<S>; 3],
    /// What is nearer than this throws no shadow.
    pub(in super::super) skipped: Floats<S>,
}

/// Light that is found out about together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Kind {
    /// The shares of the lights that cast shadows which arrive.
    Direct,
    /// What share of the ambient light is missing; and the mean of the directions that it is missing from, times that.
    Ambient,
}

/// How many numbers tell what arrives of any kind, at most.
pub(in super::super) const NUMBERS: usize = SHADOW_LIGHTS;
/// What arrives of one kind of light.
pub(in super::super) type Numbers<S> = [Floats<S>; NUMBERS];

/// What arrives of the light.
#[derive(Clone, Copy)]
pub(in super::super) struct Arriving<S: Gather> {
    pub(in super::super) direct: Numbers<S>,
    pub(in super::super) ambient: Numbers<S>,
}

impl<S: Gather> Asked<S> {
    #[inline(always)]
    pub(in super::super) fn nothing(simd: S) -> Self {
        let zero = Floats::splat(simd, 0.0);
        Self { rays: Mask::splat(simd, false), place: [Doubles::splat(simd, 0.0); 3], skipped: zero }
    }
}

impl<S: Gather> Arriving<S> {
    /// All light arrives.
    #[inline(always)]
    pub(in super::super) fn all(simd: S) -> Self {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        Self { direct: [one; NUMBERS], ambient: [zero; NUMBERS] }
    }

    /// `yes` where the mask is set, else `no`.
    #[inline(always)]
    pub(super) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        let mut selected = no;
        for number in 0..NUMBERS {
            selected.direct[number] = mask.select(yes.direct[number], no.direct[number]);
            selected.ambient[number] = mask.select(yes.ambient[number], no.ambient[number]);
        }
        selected
    }

    /// The share of the ambient light that arrives at a surface with a normal, which may be shorter than 1: the less it
    /// is a surface, the more light from behind it counts. (The first two orders of spherical harmonics; Ramamoorthi and
    /// Hanrahan 2001.)
    #[inline(always)]
    pub(super) fn of_ambient(&self, simd: S, normal: &[Floats<S>; 3]) -> Floats<S> {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let [missing, x, y, z] = self.ambient;
        let missing = dot(normal, &[x, y, z]).mul_add(Floats::splat(simd, 2.0), missing);
        (one - missing).max(zero).min(one)
    }
}

/// The octants in which rays around a point go, one after the other: any four in a row from the first or the fifth on
/// point evenly in all directions.
const OCTANTS: [usize; 8] = [0, 3, 5, 6, 7, 4, 2, 1];

impl<'a, O: Occluders> Occlusion<'a, O> {
    pub(in super::super) fn new(
        occluders: O,
        index: &'a Index,
        lamps: &Lamps,
        lighting: &Lighting,
        samples_per_cell: f64,
    ) -> Self {
        let ambient = lighting.ambient_occlusion;
        Self { occluders, index, sources: lamps.shadow_sources(), ambient, samples_per_cell }
    }

    /// How many numbers tell what arrives of a kind of light.
    pub(super) fn tables(&self, kind: Kind) -> usize {
        match kind {
            Kind::Direct => self.sources.len(),
            Kind::Ambient if self.ambient.is_some() => 4,
            Kind::Ambient => 0,
        }
    }

    /// What arrives of a kind of light at points.
    #[inline(always)]
    pub(in super::super) fn arriving<S: Gather>(
        &self,
        simd: S,
        kind: Kind,
        asked: &[Asked<S>; PACKETS],
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) -> [Numbers<S>; PACKETS] {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let mut arriving = [[zero; NUMBERS]; PACKETS];
        match kind {
            Kind::Direct => {
                for (light, source) in self.sources.iter().enumerate() {
                    let (rays, far) = self.to_light(simd, source, asked);
                    let through = self.through(simd, asked, &rays, far, stack, statistics);
                    for number in 0..PACKETS {
                        arriving[number][light] = through[number];
                    }
                }
            }
            Kind::Ambient => {
                let Some(AmbientOcclusion { rays: count, distance }) = self.ambient else { return arriving };
                for ray in 0..count {
                    let (rays, directions) = self.around(simd, ray, asked);
                    let mut far = [Floats::splat(simd, distance as f32); PACKETS];
                    for number in 0..PACKETS {
                        far[number] -= rays[number].entry;
                    }
                    let through = self.through(simd, asked, &rays, far, stack, statistics);
                    for number in 0..PACKETS {
                        let missing = (one - through[number]) * Floats::splat(simd, (count as f32).recip());
                        arriving[number][0] += missing;
                        for axis in 0..3 {
                            let sum = directions[number][axis].mul_add(missing, arriving[number][1 + axis]);
                            arriving[number][1 + axis] = sum;
                        }
                    }
                }
            }
        }
        arriving
    }

    /// What comes through along rays, which end at `far`.
    #[inline(never)]
    fn through<S: Gather>(
        &self,
        simd: S,
        asked: &[Asked<S>; PACKETS],
        rays: &Packets<S>,
        far: [Floats<S>; PACKETS],
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) -> [Floats<S>; PACKETS] {
        simd.vectorize(
            #[inline(always)]
            || {
                let domain = self.index.domain();
                let [low, high] = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
                let zero = Floats::splat(simd, 0.0);
                let mut reach = Span { enter: [zero; PACKETS], leave: far };
                let mut span = reach;
                for number in 0..PACKETS {
                    let Asked { rays: active, skipped, .. } = asked[number];
                    reach.enter[number] = -rays[number].entry;
                    if rays[number].comes_from_eye() {
                        reach.leave[number] -= skipped;
                    } else {
                        reach.enter[number] += skipped;
                    }
                    reach.leave[number] = active.select(reach.leave[number], reach.enter[number]);
                    let [enter, leave] = rays[number].clip(simd, low, high);
                    span.enter[number] = enter.max(reach.enter[number]);
                    span.leave[number] = leave.min(reach.leave[number]);
                    statistics.secondary_rays += u64::from(active.to_bitmask().count_ones());
                }
                let mut through = [Floats::splat(simd, 1.0); PACKETS];
                self.occluders.dim(simd, rays, (&span, &reach), &mut through, stack, statistics);
                through
            },
        )
    }

    /// Rays between points and a light, and how far they go.
    #[inline(always)]
    fn to_light<S: Gather>(
        &self,
        simd: S,
        source: &Source,
        asked: &[Asked<S>; PACKETS],
    ) -> (Packets<S>, [Floats<S>; PACKETS]) {
        let mut bundles = [Bundle::nothing(simd); PACKETS];
        let mut far = [Floats::splat(simd, f32::INFINITY); PACKETS];
        let hierarchy = self.index.hierarchy();
        let size = hierarchy.levels()[hierarchy.finest_level()].cell_size();
        for number in 0..PACKETS {
            let (place, bundle) = (&asked[number].place, &mut bundles[number]);
            match *source {
                Source::Eye => {}
                Source::Far(toward) => {
                    bundle.start = *place;
                    for axis in 0..3 {
                        bundle.parts[axis] = Doubles::splat(simd, toward[axis]);
                    }
                }
                // From the light, for all rays then come from one point.
                Source::Near(light, _) => {
                    bundle.is_parallel = false;
                    for axis in 0..3 {
                        let size = Doubles::splat(simd, size[axis] / hierarchy.longest_side());
                        bundle.start[axis] = Doubles::splat(simd, light[axis]);
                        bundle.parts[axis] = (place[axis] - bundle.start[axis]) * size;
                    }
                }
            }
        }
        let rays = self.rays(simd, bundles);
        if let Source::Near(..) = source {
            for number in 0..PACKETS {
                far[number] = rays[number].distance_to(simd, &asked[number].place, size);
            }
        }
        (rays, far)
    }

    /// The ray number `ray` around each point: all of them go into one octant, so that they meet planes in one order.
    #[inline(always)]
    fn around<S: Gather>(
        &self,
        simd: S,
        ray: usize,
        asked: &[Asked<S>; PACKETS],
    ) -> (Packets<S>, [[Floats<S>; 3]; PACKETS]) {
        let octant = OCTANTS[ray % OCTANTS.len()];
        let mut bundles = [Bundle::nothing(simd); PACKETS];
        let mut directions = [[Floats::splat(simd, 0.0); 3]; PACKETS];
        // The same directions at all points: light is smooth from one to the next.
        let direction = in_octant(0.5, ray);
        for number in 0..PACKETS {
            bundles[number].start = asked[number].place;
            for axis in 0..3 {
                let part = if octant >> axis & 1 == 0 { direction[axis] } else { -direction[axis] };
                bundles[number].parts[axis] = Doubles::splat(simd, part);
                directions[number][axis] = Floats::splat(simd, part as f32);
            }
        }
        (self.rays(simd, bundles), directions)
    }

    #[inline(always)]
    fn rays<S: Gather>(&self, simd: S, bundles: [Bundle<S>; PACKETS]) -> Packets<S> {
        let shift = Doubles::splat(simd, 0.5);
        let mut rays = [Packet::along(simd, self.index, bundles[0], shift, self.samples_per_cell); PACKETS];
        for number in 1..PACKETS {
            rays[number] = Packet::along(simd, self.index, bundles[number], shift, self.samples_per_cell);
        }
        rays
    }
}

/// A direction in the octant of positive ones, of length 1; evenly spread over shifts of 0 to 1 and over rays.
#[inline(always)]
fn in_octant(shift: f64, ray: usize) -> [f64; 3] {
    // The R2 sequence of Roberts (2018), started at a place that the pixel's shift tells.
    const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
    let number = ray as f64;
    // Not along a plane between octants, on which the ray would be in either.
    let inside = |fraction: f64| fraction.fract().clamp(1e-6, 1.0 - 1e-6);
    let height = inside(shift + number * STEPS[0]);
    let angle = inside(shift * 61.0 + number * STEPS[1]) * std::f64::consts::FRAC_PI_2;
    let radius = (1.0 - height * height).sqrt();
    [radius * angle.cos(), radius * angle.sin(), height]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_around_a_point_are_even() {
        let count = 4096u32;
        let mut mean = [0.0; 3];
        for place in 0..count {
            let direction = in_octant((f64::from(place) * 0.618_033_988_75).fract(), place as usize % 4);
            assert!((direction.iter().map(|part| part * part).sum::<f64>() - 1.0).abs() < 1e-12);
            (0..3).for_each(|axis| mean[axis] += direction[axis] / f64::from(count));
        }
        // The centroid of an octant of the sphere.
        assert!(mean.iter().all(|part| (part - 0.5).abs() < 0.02), "{mean:?}");
    }
}
