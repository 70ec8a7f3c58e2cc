//! One picture: what all packets share, and the packets of one tile.

use super::clip::{Clipped, Clips};
use super::lit::{Density, Lamps, Lattices, LitMarch, Obstacles, Occlusion};
use super::march::{Footprint, How, March, Single, Steep, lengths};
use super::packet::{PACKETS, Packet, SIDE};
use super::query::Query;
use super::surface::{SurfacePlan, Surfaces, WithSurfaces};
use super::traverse::Span;
use super::visibility::{NodeLook, Visibility, steps};
use super::{Engine, Layout, RenderOptions, RenderStatistics, Trace};
use crate::Volume;
use crate::appearance::{Radiance, Segments};
use crate::hierarchy::Level;
use crate::layout::{InPlace, InPlacePlan, Padded, PaddedValues, PieceNode, RegionValues};
use crate::reconstruction::AnySampler;
use crate::scene::{Lighting, PictureRays, Scene, Shading};
use crate::simd::{Doubles, Floats, Gather, InstructionSet, Kernel, LANES, Mask, SHORT_TABLES};
use fearless_simd::prelude::*;

/// What a picture needs besides its rays.
pub(super) struct Frame<'a> {
    volume: &'a Volume,
    segments: Segments,
    source: Source<'a>,
    /// Per level, the step over that on level 0; as long as a short table.
    steps: Vec<f32>,
    lamps: Lamps,
    /// Where light may not arrive: how much of it does.
    lattices: Option<Lattices<'a>>,
    lighting: &'a Lighting,
    surfaces: Option<SurfacePlan<'a>>,
    clips: Clips,
    /// Per level, the domain's longest side over the cell size.
    cells: Vec<[f32; 3]>,
    rays: PictureRays,
    options: RenderOptions,
    instructions: InstructionSet,
    /// What the seed becomes: from 0 to 1, and 0 for seed 0.
    phase: f64,
}

/// Where samples come from.
enum Source<'a> {
    /// Marching through a padded copy.
    Padded { padded: &'a Padded, looks: Vec<NodeLook>, sampler: AnySampler<'a> },
    /// Marching through values where they are.
    InPlace { plan: &'a InPlacePlan, looks: Vec<NodeLook>, sampler: AnySampler<'a> },
    /// Asking for every sample.
    Query(AnySampler<'a>),
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    pub(super) corner: [usize; 2],
    pub(super) size: [usize; 2],
}

impl<'a> Frame<'a> {
    pub(super) fn new(scene: &'a Scene<'a>, options: &RenderOptions) -> Self {
        let volume = scene.volume;
        let function = scene.transfer_function.prepared(scene.unit_distance);
        let normalisation = volume.normalisation();
        let segments = Segments::new(&function, normalisation.low, normalisation.scale.recip());
        let looks = |pieces| {
            let adaptive = options.adaptive;
            let is_lit = scene.lighting.dims_volumes();
            Visibility::new(volume, (pieces, normalisation), &function, &segments, adaptive, is_lit).looks()
        };
        let source = match options.engine {
            Engine::March(Layout::Padded) => {
                let padded = volume.padded();
                Source::Padded { padded, looks: looks(&padded.pieces), sampler: volume.packet_sampler() }
            }
            Engine::March(Layout::InPlace) => {
                let plan = volume.in_place();
                Source::InPlace { plan, looks: looks(&plan.pieces), sampler: volume.packet_sampler() }
            }
            Engine::Query => Source::Query(volume.packet_sampler()),
        };
        let mut steps: Vec<f32> = steps(volume.index()).into_iter().map(|step| step as f32).collect();
        let coarsest = steps[0];
        steps.resize(steps.len().next_multiple_of(SHORT_TABLES[0]), coarsest);
        let hierarchy = volume.hierarchy();
        let pieces = match &source {
            Source::Padded { padded, .. } => Some(&*padded.pieces),
            Source::InPlace { plan, .. } => Some(&*plan.pieces),
            Source::Query(_) => None,
        };
        let lattices = pieces.filter(|_| scene.lighting.dims_volumes()).map(|pieces| {
            let density = Density { pieces, normalisation, function };
            Lattices::new(volume.index(), vec![density], &scene.lighting, options.samples_per_cell)
        });
        let surfaces = pieces.and_then(|pieces| SurfacePlan::new(volume, &scene.surfaces, pieces));
        let cells = |level: &Level| level.cell_size().map(|size| (hierarchy.longest_side() / size) as f32);
        Self {
            volume,
            segments,
            source,
            steps,
            lamps: Lamps::new(&scene.lighting, hierarchy),
            lattices,
            lighting: &scene.lighting,
            surfaces,
            clips: Clips::new(&scene.clips, hierarchy),
            cells: hierarchy.levels().iter().map(cells).collect(),
            rays: scene.camera.picture_rays(options.size),
            options: *options,
            instructions: InstructionSet::best(),
            // Neighbouring seeds land far apart; the golden ratio is left to a pixel's rays.
            phase: (options.seed % (1 << 32)) as f64 * std::f64::consts::SQRT_2 % 1.0,
        }
    }

    /// The tile's pixels, row by row.
    pub(super) fn tile(&self, tile: Tile) -> (Vec<[f32; 4]>, RenderStatistics) {
        match &self.source {
            Source::Padded { padded: Padded { field, plan, pieces }, looks, sampler } => {
                let values = PaddedValues { field, plan, sampler };
                self.march(tile, values, (pieces, looks))
            }
            Source::InPlace { plan, looks, sampler } => {
                let values = InPlace { plan, sampler };
                self.march(tile, values, (&plan.pieces, looks))
            }
            Source::Query(sampler) => {
                let Self { segments, steps, options: RenderOptions { integration, .. }, .. } = self;
                let integration = *integration;
                match sampler {
                    AnySampler::F32(sampler) => {
                        self.run(tile, &self.clipped(&Query { sampler, segments, integration, steps }))
                    }
                    AnySampler::F64(sampler) => {
                        self.run(tile, &self.clipped(&Query { sampler, segments, integration, steps }))
                    }
                }
            }
        }
    }

    fn march<V: RegionValues + Copy>(
        &self,
        tile: Tile,
        values: V,
        (pieces, looks): (&[PieceNode], &[NodeLook]),
    ) -> (Vec<[f32; 4]>, RenderStatistics) {
        let RenderOptions { integration, adaptive, samples_per_cell, .. } = self.options;
        let footprint = if adaptive { self.rays.footprint(samples_per_cell) } else { Footprint::NONE };
        let how = How { segments: &self.segments, integration, is_finite: values.is_finite() };
        let single = Single { values, how };
        let march = March { medium: single, pieces, looks, footprint };
        let clips = &self.clips;
        let surfaces = self.surfaces.as_ref().map(|plan| Surfaces { plan, values, pieces, clips });
        let occlusion = self.lighting.may_be_missing().then(|| {
            let march = March { medium: single, pieces, looks, footprint: Footprint::OCCLUDERS };
            let obstacles = Obstacles { march, surfaces, clips };
            Occlusion::new(obstacles, self.volume.index(), &self.lamps, self.lighting, samples_per_cell)
        });
        let occlusion = occlusion.as_ref();
        let (lamps, shadows) = (&self.lamps, self.lattices.as_ref().zip(occlusion));
        match self.lighting.shading {
            Shading::Emissive => self.among(tile, &march, surfaces, occlusion),
            Shading::Isotropic => self.among(tile, &LitMarch { march, lamps, shadows }, surfaces, occlusion),
            Shading::Gradient(_) => {
                let march = March { medium: Steep { single, cells: &self.cells }, pieces, looks, footprint };
                self.among(tile, &LitMarch { march, lamps, shadows }, surfaces, occlusion)
            }
        }
    }

    /// Runs an engine, among surfaces if there are any.
    fn among<E: Trace, V: RegionValues + Copy>(
        &self,
        tile: Tile,
        engine: &E,
        surfaces: Option<Surfaces<V>>,
        occlusion: Option<&Occlusion<Obstacles<V>>>,
    ) -> (Vec<[f32; 4]>, RenderStatistics) {
        let engine = &self.clipped(engine);
        match surfaces {
            Some(surfaces) => self.run(tile, &WithSurfaces { engine, surfaces, lamps: &self.lamps, occlusion }),
            None => self.run(tile, engine),
        }
    }

    /// An engine that sees nothing of what is cut away.
    fn clipped<'b, E>(&'b self, engine: &'b E) -> Clipped<'b, E> {
        Clipped { engine, clips: &self.clips }
    }

    fn run<E: Trace>(&self, tile: Tile, engine: &E) -> (Vec<[f32; 4]>, RenderStatistics) {
        self.instructions.run(TileKernel { frame: self, engine, tile })
    }
}

struct TileKernel<'a, E> {
    frame: &'a Frame<'a>,
    engine: &'a E,
    tile: Tile,
}

impl<E: Trace> Kernel for TileKernel<'_, E> {
    type Output = (Vec<[f32; 4]>, RenderStatistics);

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> Self::Output {
        let Self { frame, engine, tile: Tile { corner, size } } = self;
        let index = frame.volume.index();
        let domain = index.domain();
        let [low, high] = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
        let count = frame.options.samples_per_pixel;
        let weight = (count as f32).recip();
        let mut pixels = vec![[0.0; 4]; size[0] * size[1]];
        let mut statistics = RenderStatistics::default();
        let mut scratch = E::Scratch::<S>::default();
        let lefts = (0..size[0]).step_by(SIDE * PACKETS);
        for (top, left) in (0..size[1]).step_by(SIDE).flat_map(|top| lefts.clone().map(move |left| (top, left))) {
            for number in 0..count {
                let mut packets = [frame.packet(simd, [corner[0] + left, corner[1] + top], number); PACKETS];
                for packet in 1..PACKETS {
                    let left = corner[0] + left + packet * SIDE;
                    packets[packet] = frame.packet(simd, [left, corner[1] + top], number);
                }
                let nowhere = Floats::splat(simd, 0.0);
                let mut span = Span { enter: [nowhere; PACKETS], leave: [nowhere; PACKETS] };
                let mut inside = [Mask::splat(simd, false); PACKETS];
                for packet in 0..PACKETS {
                    [span.enter[packet], span.leave[packet]] = packets[packet].clip(simd, low, high);
                    inside[packet] = span.enter[packet].simd_lt(span.leave[packet]);
                }
                statistics.ray_length += f64::from(simd.reduce_sum_f32x16(lengths(simd, &span, &inside)));
                let mut lights = [Radiance::none(simd); PACKETS];
                engine.trace_apart(simd, &packets, &span, &mut lights, &mut scratch, &mut statistics);
                for packet in 0..PACKETS {
                    let Radiance { color: [red, green, blue], transmittance } = lights[packet];
                    let alpha = Floats::splat(simd, 1.0) - transmittance;
                    let mut channels = [[0.0; LANES]; 4];
                    for (lanes, channel) in channels.iter_mut().zip([red, green, blue, alpha]) {
                        *lanes = (channel * Floats::splat(simd, weight)).into();
                    }
                    for lane in 0..LANES {
                        let (x, y) = (left + packet * SIDE + lane % SIDE, top + lane / SIDE);
                        if x < size[0] && y < size[1] {
                            statistics.rays += 1;
                            for (sum, channel) in pixels[y * size[0] + x].iter_mut().zip(&channels) {
                                *sum += channel[lane];
                            }
                        }
                    }
                }
            }
        }
        (pixels, statistics)
    }
}

impl PictureRays {
    /// How wide pixels are, over the samples per cell.
    fn footprint(&self, samples_per_cell: f64) -> Footprint {
        let [near, growth] = match self {
            Self::Plane { start, direction } => [start, direction].map(|vectors| vectors[1].length()),
            Self::Panorama(panorama) => [0.0, panorama.pixel_angle()],
        };
        let width = |width: f64| (width / samples_per_cell) as f32;
        Footprint { near: width(near), growth: width(growth), least: 1.0 }
    }
}

impl Frame<'_> {
    /// The rays `number` of the pixels from `corner` on.
    #[inline(always)]
    fn packet<S: Gather>(&self, simd: S, corner: [usize; 2], number: usize) -> Packet<S> {
        let place = place_in_pixel(number, self.options.samples_per_pixel, self.phase);
        let phase = self.phase + number as f64 * GOLDEN;
        let (mut x, mut y, mut shift) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let (column, row) = ((corner[0] + lane % SIDE) as f64, (corner[1] + lane / SIDE) as f64);
            x[lane] = column + place[0];
            y[lane] = row + place[1];
            shift[lane] = lattice_shift([column, row], phase);
        }
        let pixels = [Doubles::load(simd, &x), Doubles::load(simd, &y)];
        let shift = Doubles::load(simd, &shift);
        let samples_per_cell = self.options.samples_per_cell;
        Packet::new(simd, self.volume.index(), &self.rays, pixels, shift, samples_per_cell)
    }
}

/// Steps of this length cover a unit interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Where the ray `number` of `count` passes a pixel: the centre, or points that cover it evenly from `phase` on (the R2
/// sequence of Roberts, 2018, built on the plastic number).
fn place_in_pixel(number: usize, count: usize, phase: f64) -> [f64; 2] {
    if count == 1 {
        return [0.5, 0.5];
    }
    const PLASTIC: f64 = 1.324_717_957_244_746;
    [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)].map(|step| (0.5 + phase + number as f64 * step).fract())
}

/// By how much of a step a pixel's lattice is shifted: neighbours differ as much as they can, so that what banding
/// there is becomes fine noise (interleaved gradient noise, Jimenez 2014).
#[inline(always)]
fn lattice_shift([x, y]: [f64; 2], phase: f64) -> f64 {
    let fraction = |value: f64| value - value.floor();
    let gradient = fraction(0.067_110_56 * x + 0.005_837_15 * y);
    fraction(fraction(52.982_918_9 * gradient) + phase)
}
