//! One picture: what all packets share, and the packets of one tile.

use super::march::{March, Marcher};
use super::packet::{Packet, SIDE};
use super::traverse::{Span, traverse};
use super::visibility::{NodeLook, Visibility};
use super::{RenderOptions, RenderStatistics};
use crate::appearance::Segments;
use crate::hierarchy::with_voxels;
use crate::index::Index;
use crate::padded::{Evaluator, Padded, PaddedField, PieceNode, Plan};
use crate::reconstruction::Sampler;
use crate::scene::{PicturePlane, Scene};
use crate::simd::{Doubles, Gather, InstructionSet, Kernel, LANES};

type Reference<'a> = Box<dyn Fn(usize, [f64; 3]) -> f64 + Sync + 'a>;

/// What a picture needs besides its rays.
pub(super) struct Frame<'a> {
    index: &'a Index,
    field: &'a PaddedField,
    plan: &'a Plan,
    reference: Reference<'a>,
    segments: Segments,
    pieces: &'a [PieceNode],
    looks: Vec<NodeLook>,
    plane: PicturePlane,
    options: RenderOptions,
    instructions: InstructionSet,
    /// What the seed becomes: from 0 to 1, and 0 for seed 0.
    phase: f64,
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
        let padded @ Padded { field, plan, pieces } = volume.padded();
        let function = scene.transfer_function.prepared(scene.unit_distance);
        let normalisation = field.normalisation;
        let segments = Segments::new(&function, normalisation.low, normalisation.scale.recip());
        let looks = Visibility::new(volume, padded, &function, &segments).looks();
        let reference: Reference = with_voxels!(volume.field().values(), bricks => {
            let sampler = Sampler::new(volume.index(), bricks, volume.method());
            Box::new(move |region, point| sampler.sample_in(region, point))
        });
        Self {
            index: volume.index(),
            field,
            plan,
            reference,
            segments,
            pieces,
            looks,
            plane: scene.camera.picture_plane(options.size),
            options: *options,
            instructions: InstructionSet::best(),
            // Neighbouring seeds land far apart; the golden ratio is left to a pixel's rays.
            phase: (options.seed % (1 << 32)) as f64 * std::f64::consts::SQRT_2 % 1.0,
        }
    }

    /// The tile's pixels, row by row.
    pub(super) fn tile(&self, tile: Tile) -> (Vec<[f32; 4]>, RenderStatistics) {
        self.instructions.run(TileKernel { frame: self, tile })
    }
}

struct TileKernel<'a> {
    frame: &'a Frame<'a>,
    tile: Tile,
}

impl Kernel for TileKernel<'_> {
    type Output = (Vec<[f32; 4]>, RenderStatistics);

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> Self::Output {
        let Self { frame, tile: Tile { corner, size } } = self;
        let march = March {
            evaluator: Evaluator { field: frame.field, plan: frame.plan, reference: &*frame.reference },
            segments: &frame.segments,
        };
        let domain = frame.index.domain();
        let [low, high] = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
        let count = frame.options.samples_per_pixel;
        let mut pixels = vec![[0.0; 4]; size[0] * size[1]];
        let mut statistics = RenderStatistics::default();
        let mut stack = Vec::with_capacity(64);
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
                let packet =
                    Packet::new(simd, frame.index, &frame.plane, pixels_at, shift, frame.options.samples_per_cell);
                let [enter, leave] = packet.clip(simd, low, high);
                let span = Span { enter, leave };
                let mut marcher = Marcher::new(simd, march, &packet, &span, statistics);
                traverse(simd, frame.pieces, &frame.looks, &packet, span, &mut stack, &mut marcher);
                statistics = marcher.statistics;
                let light = marcher.light();
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
