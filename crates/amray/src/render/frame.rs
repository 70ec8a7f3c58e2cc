//! One picture: what all packets share, and the packets of one tile.

use std::sync::Arc;

use super::clip::{Clipped, Clips};
use super::lit::{Density, Lamps, Lattices, LitMarch, Obstacles, Occluders, Occlusion};
use super::march::{Footprint, How, March, Several, Single, Sloped, Steep, lengths};
use super::packet::{PACKETS, Packet, SIDE};
use super::query::Query;
use super::surface::{SurfacePlan, Surfaces, WithSurfaces};
use super::traverse::Span;
use super::visibility::{NodeLook, SeenField, Visibility, steps};
use super::{Engine, Integration, Layout, RenderOptions, RenderStatistics, Trace};
use crate::Volume;
use crate::appearance::{PreparedTransferFunction, Radiance, Segments, TransferFunction};
use crate::hierarchy::Level;
use crate::layout::{EitherValues, InPlace, PaddedValues, RegionValues};
use crate::reconstruction::AnySampler;
use crate::scene::{Lighting, MOST_FIELDS, PictureRays, Scene, Shading, ShownField};
use crate::simd::{Doubles, Floats, Gather, InstructionSet, Kernel, LANES, Mask, SHORT_TABLES};
use fearless_simd::prelude::*;

/// What a picture needs besides its rays.
pub(super) struct Frame<'a> {
    volume: &'a Volume,
    /// The volume's, what is seen with it, and last what gives it its colours, if anything does.
    fields: Vec<ShownValues<'a>>,
    is_colored: bool,
    /// How the nodes of the fields' trees of pieces look: none for asking for every sample.
    looks: Vec<NodeLook>,
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

/// A field whose values rays look up.
struct ShownValues<'a> {
    volume: &'a Volume,
    function: PreparedTransferFunction,
    segments: Segments,
    sampler: AnySampler<'a>,
}

impl<'a> ShownValues<'a> {
    fn new(volume: &'a Volume, function: PreparedTransferFunction) -> Self {
        let normalisation = volume.normalisation();
        let segments = Segments::new(&function, normalisation.low, normalisation.scale.recip());
        Self { volume, function, segments, sampler: volume.packet_sampler() }
    }

    /// What decides which of the values are visible.
    fn visible(&self, layout: Layout) -> SeenField<'_> {
        SeenField {
            function: &self.function,
            segments: &self.segments,
            pieces: self.volume.pieces(layout),
            normalisation: self.volume.normalisation(),
        }
    }

    /// The values of a layout under the transfer function.
    fn either(&self, layout: Layout, integration: Integration) -> Single<'_, EitherValues<'_>> {
        self.seen(EitherValues::new(self.volume, layout, &self.sampler), integration)
    }

    /// The values under the transfer function.
    fn seen<V: RegionValues>(&self, values: V, integration: Integration) -> Single<'_, V> {
        let how = How { segments: &self.segments, integration, is_finite: values.is_finite() };
        Single { values, how }
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
        check_fields(scene);
        let prepared = |function: &TransferFunction| function.prepared(scene.unit_distance);
        let mut fields = vec![ShownValues::new(volume, prepared(&scene.transfer_function))];
        let overlays = scene.overlays.iter();
        fields.extend(overlays.map(|field| ShownValues::new(field.volume, prepared(&field.transfer_function))));
        let layout = match options.engine {
            Engine::March(layout) => Some(layout),
            Engine::Query => None,
        };
        let dims_volumes = scene.lighting.dims_volumes();
        let looks = layout.map_or_else(Vec::new, |layout| {
            let seen = fields.iter().map(|field| field.visible(layout)).collect();
            Visibility::new(volume, seen, scene.colors.is_some(), options.adaptive, dims_volumes).looks()
        });
        let mut steps: Vec<f32> = steps(volume.index()).into_iter().map(|step| step as f32).collect();
        let coarsest = steps[0];
        steps.resize(steps.len().next_multiple_of(SHORT_TABLES[0]), coarsest);
        let hierarchy = volume.hierarchy();
        let lattices = layout.filter(|_| dims_volumes).map(|layout| {
            let density = |ShownValues { volume, function, .. }: &ShownValues<'a>| Density {
                pieces: volume.pieces(layout),
                normalisation: volume.normalisation(),
                function: function.clone(),
            };
            let densities = fields.iter().map(density).collect();
            Lattices::new(volume.index(), densities, &scene.lighting, options.samples_per_cell)
        });
        // No extinction of its own.
        fields.extend(scene.colors.iter().map(|field| {
            let function = prepared(&field.transfer_function.colors_alone());
            ShownValues::new(field.volume, function)
        }));
        let surfaces = layout.and_then(|layout| SurfacePlan::new(volume, &scene.surfaces, volume.pieces(layout)));
        let cells = |level: &Level| level.cell_size().map(|size| (hierarchy.longest_side() / size) as f32);
        Self {
            volume,
            fields,
            is_colored: scene.colors.is_some(),
            looks,
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
        let field = &self.fields[0];
        let ShownValues { volume, segments, sampler, .. } = field;
        match self.options.engine {
            Engine::March(layout) if self.fields.len() > 1 => self.march_several(tile, layout),
            Engine::March(Layout::Padded) => self.march(tile, field, PaddedValues::new(volume.padded(), sampler)),
            Engine::March(Layout::InPlace) => self.march(tile, field, InPlace { plan: volume.in_place(), sampler }),
            Engine::Query => {
                let (steps, integration) = (&self.steps, self.options.integration);
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
        field: &ShownValues,
        values: V,
    ) -> (Vec<[f32; 4]>, RenderStatistics) {
        let single = field.seen(values, self.options.integration);
        self.shade(tile, single, Steep { single, cells: &self.cells }, values)
    }

    fn march_several(&self, tile: Tile, layout: Layout) -> (Vec<[f32; 4]>, RenderStatistics) {
        let fields: Vec<_> = self.fields.iter().map(|field| field.either(layout, self.options.integration)).collect();
        let several = Several { fields: &fields, is_colored: self.is_colored, cells: None };
        self.shade(tile, several, Several { cells: Some(&self.cells), ..several }, fields[0].values)
    }

    /// Marches through a medium as it is lit: `plain` where gradients do not matter, or `steep`. Isosurfaces are found in
    /// `values`.
    fn shade<M: Sloped + Copy, V: RegionValues + Copy>(
        &self,
        tile: Tile,
        plain: M,
        steep: impl Sloped,
        values: V,
    ) -> (Vec<[f32; 4]>, RenderStatistics) {
        let Self { looks, clips, lamps, options: RenderOptions { engine, adaptive, samples_per_cell, .. }, .. } = self;
        let Engine::March(layout) = *engine else { unreachable!("only marching has looks") };
        let pieces = self.volume.pieces(layout);
        let footprint = if *adaptive { self.rays.footprint(*samples_per_cell) } else { Footprint::NONE };
        let march = March { medium: plain, pieces, looks, footprint };
        let surfaces = self.surfaces.as_ref().map(|plan| Surfaces { plan, values, pieces, clips });
        let occlusion = self.lighting.may_be_missing().then(|| {
            let march = March { medium: plain, pieces, looks, footprint: Footprint::OCCLUDERS };
            let obstacles = Obstacles { march, surfaces, clips };
            Occlusion::new(obstacles, self.volume.index(), lamps, self.lighting, *samples_per_cell)
        });
        let occlusion = occlusion.as_ref();
        let shadows = self.lattices.as_ref().zip(occlusion);
        match self.lighting.shading {
            Shading::Emissive => self.among(tile, &march, surfaces, occlusion),
            Shading::Isotropic => self.among(tile, &LitMarch { march, lamps, shadows }, surfaces, occlusion),
            Shading::Gradient(_) => {
                let march = March { medium: steep, pieces, looks, footprint };
                self.among(tile, &LitMarch { march, lamps, shadows }, surfaces, occlusion)
            }
        }
    }

    /// Runs an engine, among surfaces if there are any.
    fn among<E: Trace, V: RegionValues + Copy, O: Occluders>(
        &self,
        tile: Tile,
        engine: &E,
        surfaces: Option<Surfaces<V>>,
        occlusion: Option<&Occlusion<O>>,
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

/// Finds fields that cannot be shown together.
fn check_fields(scene: &Scene) {
    let others: Vec<&ShownField> = scene.overlays.iter().chain(&scene.colors).collect();
    assert!(others.len() < MOST_FIELDS, "{} fields beside the volume, at most {}", others.len(), MOST_FIELDS - 1);
    for ShownField { volume, .. } in others {
        let is_alike = Arc::ptr_eq(volume.index(), scene.volume.index()) && volume.method() == scene.volume.method();
        assert!(is_alike, "field {} has another index or method than the volume", volume.field().name());
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
