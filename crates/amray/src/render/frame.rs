//! One picture: what all packets share, and the packets of one tile.

use fearless_simd::prelude::*;

use super::march::{March, length_of};
use super::packet::{Packet, SIDE};
use super::query::Query;
use super::traverse::Span;
use super::visibility::{NodeLook, Visibility, steps};
use super::{Engine, Layout, RenderOptions, RenderStatistics, Trace};
use crate::Volume;
use crate::appearance::Segments;
use crate::hierarchy::{FieldValues, with_voxels};
use crate::layout::{InPlace, InPlacePlan, Padded, PaddedValues};
use crate::reconstruction::{PacketSampler, Sampler};
use crate::scene::{PicturePlane, Scene};
use crate::simd::{Doubles, Gather, InstructionSet, Kernel, LANES, SHORT_TABLES};

type Reference<'a> = Box<dyn Fn(usize, [f64; 3]) -> f64 + Sync + 'a>;

/// What a picture needs besides its rays.
pub(super) struct Frame<'a> {
    volume: &'a Volume,
    segments: Segments,
    source: Source<'a>,
    /// Per level, the step over that on level 0; as long as a short table.
    steps: Vec<f32>,
    plane: PicturePlane,
    options: RenderOptions,
    instructions: InstructionSet,
    /// What the seed becomes: from 0 to 1, and 0 for seed 0.
    phase: f64,
}

/// Where samples come from.
enum Source<'a> {
    /// Marching through a padded copy.
    Padded { padded: &'a Padded, looks: Vec<NodeLook>, reference: Reference<'a> },
    /// Marching through values where they are.
    InPlace { plan: &'a InPlacePlan, looks: Vec<NodeLook>, sampler: AnySampler<'a> },
    /// Asking for every sample.
    Query(AnySampler<'a>),
}

/// A sampler of either number type.
enum AnySampler<'a> {
    F32(PacketSampler<'a, f32>),
    F64(PacketSampler<'a, f64>),
}

impl<'a> AnySampler<'a> {
    fn new(volume: &'a Volume) -> Self {
        let (index, method, normalisation) = (volume.index(), volume.method(), volume.normalisation());
        match volume.field().values() {
            FieldValues::F32(bricks) => Self::F32(PacketSampler::new(index, bricks, method, normalisation)),
            FieldValues::F64(bricks) => Self::F64(PacketSampler::new(index, bricks, method, normalisation)),
        }
    }
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
            Visibility::new(volume, (pieces, normalisation), &function, &segments, adaptive).looks()
        };
        let source = match options.engine {
            Engine::March(Layout::Padded) => {
                let padded = volume.padded();
                let reference: Reference = with_voxels!(volume.field().values(), bricks => {
                    let sampler = Sampler::new(volume.index(), bricks, volume.method());
                    Box::new(move |region, point| sampler.sample_in(region, point))
                });
                Source::Padded { padded, looks: looks(&padded.pieces), reference }
            }
            Engine::March(Layout::InPlace) => {
                let plan = volume.in_place();
                Source::InPlace { plan, looks: looks(&plan.pieces), sampler: AnySampler::new(volume) }
            }
            Engine::Query => Source::Query(AnySampler::new(volume)),
        };
        let mut steps: Vec<f32> = steps(volume.index()).into_iter().map(|step| step as f32).collect();
        let coarsest = steps[0];
        steps.resize(steps.len().next_multiple_of(SHORT_TABLES[0]), coarsest);
        Self {
            volume,
            segments,
            source,
            steps,
            plane: scene.camera.picture_plane(options.size),
            options: *options,
            instructions: InstructionSet::best(),
            // Neighbouring seeds land far apart; the golden ratio is left to a pixel's rays.
            phase: (options.seed % (1 << 32)) as f64 * std::f64::consts::SQRT_2 % 1.0,
        }
    }

    /// The tile's pixels, row by row.
    pub(super) fn tile(&self, tile: Tile) -> (Vec<[f32; 4]>, RenderStatistics) {
        let segments = &self.segments;
        let integration = self.options.integration;
        match &self.source {
            Source::Padded { padded: Padded { field, plan, pieces }, looks, reference } => {
                let values = PaddedValues { field, plan, reference: &**reference };
                self.run(tile, &March { values, segments, pieces, looks, integration })
            }
            Source::InPlace { plan, looks, sampler } => {
                let pieces = &plan.pieces;
                match sampler {
                    AnySampler::F32(sampler) => {
                        let values = InPlace { plan, sampler };
                        self.run(tile, &March { values, segments, pieces, looks, integration })
                    }
                    AnySampler::F64(sampler) => {
                        let values = InPlace { plan, sampler };
                        self.run(tile, &March { values, segments, pieces, looks, integration })
                    }
                }
            }
            Source::Query(sampler) => {
                let steps = &self.steps;
                match sampler {
                    AnySampler::F32(sampler) => self.run(tile, &Query { sampler, segments, integration, steps }),
                    AnySampler::F64(sampler) => self.run(tile, &Query { sampler, segments, integration, steps }),
                }
            }
        }
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
        let mut pixels = vec![[0.0; 4]; size[0] * size[1]];
        let mut statistics = RenderStatistics::default();
        let mut scratch = E::Scratch::<S>::default();
        for (top, left) in (0..size[1]).step_by(SIDE).flat_map(|y| (0..size[0]).step_by(SIDE).map(move |x| (y, x))) {
            for number in 0..count {
                let place = place_in_pixel(number, count, frame.phase);
                let phase = frame.phase + number as f64 * GOLDEN;
                let (mut x, mut y, mut shift) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
                for lane in 0..LANES {
                    let column = (corner[0] + left + lane % SIDE) as f64;
                    let row = (corner[1] + top + lane / SIDE) as f64;
                    x[lane] = column + place[0];
                    y[lane] = row + place[1];
                    shift[lane] = lattice_shift([column, row], phase);
                }
                let pixels_at = [Doubles::load(simd, &x), Doubles::load(simd, &y)];
                let shift = Doubles::load(simd, &shift);
                let packet = Packet::new(simd, index, &frame.plane, pixels_at, shift, frame.options.samples_per_cell);
                let [enter, leave] = packet.clip(simd, low, high);
                let span = Span { enter, leave };
                statistics.ray_length += length_of(simd, &span, enter.simd_lt(leave));
                let light = engine.trace(simd, &packet, &span, &mut scratch, &mut statistics);
                for lane in 0..LANES {
                    let (x, y) = (left + lane % SIDE, top + lane / SIDE);
                    if x < size[0] && y < size[1] {
                        statistics.rays += 1;
                        let pixel = &mut pixels[y * size[0] + x];
                        let alpha = 1.0 - light.transmittance[lane];
                        let color = [light.color[0][lane], light.color[1][lane], light.color[2][lane], alpha];
                        for (sum, channel) in pixel.iter_mut().zip(color) {
                            *sum += channel / count as f32;
                        }
                    }
                }
            }
        }
        (pixels, statistics)
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
