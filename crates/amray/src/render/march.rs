//! One ray: its samples on a lattice of steps, composited front to back.

use super::{RenderOptions, RenderStatistics};
use crate::appearance::PreparedTransferFunction;
use crate::hierarchy::{BrickValues, Voxel};
use crate::index::{Index, Ray, RegionSpan};
use crate::reconstruction::Sampler;
use crate::scene::{Camera, CameraRay, Scene};

/// What is still visible below this transmittance would change no 8-bit picture.
const OPAQUE: f32 = 1.0 / 4096.0;

/// Everything that the rays of a picture share.
pub(super) struct Marcher<'a, T> {
    index: &'a Index,
    sampler: Sampler<'a, T>,
    transfer_function: PreparedTransferFunction,
    /// Per region, whether any value in it is visible.
    visible: Vec<bool>,
    camera: Camera,
    options: RenderOptions,
    /// What the seed becomes: from 0 to 1, and 0 for seed 0.
    phase: f64,
}

/// What a ray has collected so far.
struct Light {
    color: [f32; 3],
    transmittance: f32,
}

/// A stretch of a ray through leaf cells of one level.
struct Run {
    level: usize,
    /// The length of a whole sample interval.
    step: f64,
    /// Where the next sample's interval starts.
    from: f64,
}

impl<'a, T: Voxel> Marcher<'a, T> {
    pub(super) fn new(scene: &Scene<'a>, bricks: &'a [BrickValues<T>], options: &RenderOptions) -> Self {
        let volume = scene.volume;
        let transfer_function = scene.transfer_function.prepared(scene.unit_distance);
        let visible = (0..volume.index().regions().len())
            .map(|region| {
                let [low, high] = volume.ranges().region(region).map(f64::from);
                low <= high && transfer_function.max_extinction(low, high) > 0.0
            })
            .collect();
        Self {
            index: volume.index(),
            sampler: Sampler::new(volume.index(), bricks, volume.method()),
            transfer_function,
            visible,
            camera: scene.camera,
            options: *options,
            // Neighbouring seeds land far apart; the golden ratio is left to a pixel's rays.
            phase: (options.seed % (1 << 32)) as f64 * std::f64::consts::SQRT_2 % 1.0,
        }
    }

    /// The mean of the pixel's rays: premultiplied RGBA.
    pub(super) fn pixel(&self, pixel: [usize; 2], statistics: &mut RenderStatistics) -> [f32; 4] {
        let count = self.options.samples_per_pixel;
        let mut sum = [0.0f32; 4];
        for number in 0..count {
            let place = place_in_pixel(number, count, self.phase);
            let position = std::array::from_fn(|axis| pixel[axis] as f64 + place[axis]);
            let shift = lattice_shift(pixel, self.phase + number as f64 * GOLDEN);
            let color = self.trace(&self.camera.ray(self.options.size, position), shift, statistics);
            sum = std::array::from_fn(|channel| sum[channel] + color[channel]);
        }
        sum.map(|channel| channel / count as f32)
    }

    /// Emission and absorption along the ray.
    ///
    /// Sample intervals are those of a lattice along the whole ray, shifted by `shift` of the coarsest step. A level's
    /// step is the coarsest one halved until it is no longer than a cell, so finer lattices contain the coarser ones.
    /// An interval is cut only where the leaf level changes: nothing is sampled twice or left out, and how a level is
    /// cut into bricks does not show.
    fn trace(&self, ray: &CameraRay, shift: f64, statistics: &mut RenderStatistics) -> [f32; 4] {
        statistics.rays += 1;
        let hierarchy = self.index.hierarchy();
        let cell_size = hierarchy.levels()[hierarchy.finest_level()].cell_size();
        let cells = Ray {
            start: hierarchy.to_cells(hierarchy.finest_level(), ray.start),
            direction: std::array::from_fn(|axis| ray.direction[axis] / cell_size[axis]),
        };
        let offset = shift * self.coarsest_step(ray);
        let mut light = Light { color: [0.0; 3], transmittance: 1.0 };
        let mut run: Option<Run> = None;
        let mut end = 0.0;
        for span in self.index.walk(cells, 0.0, f64::INFINITY) {
            end = span.leave;
            let level = self.index.regions()[span.region].finest_level();
            if run.as_ref().map(|run| run.level) != level {
                if let Some(ended) = run.take() {
                    self.add_sample(&mut light, &cells, [ended.from, span.enter], None, statistics);
                }
                run = level.map(|level| Run { level, step: self.step(ray, level), from: span.enter });
            }
            let Some(Run { step, from, .. }) = &mut run else { continue };
            let lattice = Lattice { offset, step: *step };
            if self.visible[span.region] {
                let mut to = lattice.after(*from);
                while to <= span.leave {
                    self.add_sample(&mut light, &cells, [*from, to], Some(&span), statistics);
                    if light.transmittance < OPAQUE {
                        return light.finished();
                    }
                    *from = to;
                    to = lattice.after(to);
                }
            } else {
                // An interval that begins in a visible region may have its middle there.
                let to = lattice.after(*from);
                if *from < span.enter && to <= span.leave {
                    self.add_sample(&mut light, &cells, [*from, to], None, statistics);
                    *from = to;
                }
                // Those that begin and end here need no look.
                if *from >= span.enter {
                    *from = from.max(lattice.last_up_to(span.leave));
                }
            }
        }
        if let Some(ended) = run {
            self.add_sample(&mut light, &cells, [ended.from, end], None, statistics);
        }
        light.finished()
    }

    /// Adds what the interval emits and absorbs, as its middle tells. `span` is the region that the ray is in, if the
    /// middle may lie in it.
    fn add_sample(
        &self,
        light: &mut Light,
        cells: &Ray,
        [from, to]: [f64; 2],
        span: Option<&RegionSpan>,
        statistics: &mut RenderStatistics,
    ) {
        if to <= from {
            return;
        }
        statistics.samples += 1;
        let middle = (from + to) / 2.0;
        let point = std::array::from_fn(|axis| cells.start[axis] + middle * cells.direction[axis]);
        let value = match span {
            Some(span) if span.enter <= middle => self.sampler.sample_in(span.region, point),
            _ => self.sampler.sample(point),
        };
        let sample = self.transfer_function.sample(value);
        let alpha = sample.alpha(to - from);
        for (sum, channel) in light.color.iter_mut().zip(sample.color) {
            *sum += light.transmittance * alpha * channel;
        }
        light.transmittance *= 1.0 - alpha;
    }

    /// The step on level 0: how far the ray goes through a cell's width, whatever its proportions.
    fn coarsest_step(&self, ray: &CameraRay) -> f64 {
        self.cell_length(ray, 0) / self.options.samples_per_cell
    }

    fn step(&self, ray: &CameraRay, level: usize) -> f64 {
        // Rounding must not halve a step that fits exactly.
        const SLACK: f64 = 1e-6;
        let halvings = (self.cell_length(ray, 0) / self.cell_length(ray, level)).log2() - SLACK;
        self.coarsest_step(ray) / halvings.ceil().max(0.0).exp2()
    }

    fn cell_length(&self, ray: &CameraRay, level: usize) -> f64 {
        let cell_size = self.index.hierarchy().levels()[level].cell_size();
        (0..3).map(|axis| (ray.direction[axis] / cell_size[axis]).powi(2)).sum::<f64>().sqrt().recip()
    }
}

/// The ends of the sample intervals of one step along a ray.
struct Lattice {
    offset: f64,
    step: f64,
}

impl Lattice {
    /// The first end beyond `place`; infinite where steps are too small for the numbers.
    fn after(&self, place: f64) -> f64 {
        let number = ((place - self.offset) / self.step).floor() + 1.0;
        [number, number + 1.0]
            .into_iter()
            .map(|number| self.offset + number * self.step)
            .find(|end| *end > place)
            .unwrap_or(f64::INFINITY)
    }

    /// The last end that is not beyond `place`.
    fn last_up_to(&self, place: f64) -> f64 {
        self.offset + ((place - self.offset) / self.step).floor() * self.step
    }
}

impl Light {
    fn finished(&self) -> [f32; 4] {
        let [red, green, blue] = self.color;
        [red, green, blue, 1.0 - self.transmittance]
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
fn lattice_shift([x, y]: [usize; 2], phase: f64) -> f64 {
    let gradient = (0.067_110_56 * x as f64 + 0.005_837_15 * y as f64).fract();
    ((52.982_918_9 * gradient).fract() + phase).fract()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::Volume;
    use crate::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
    use crate::hierarchy::{Field, FieldValues, Hierarchy, IndexBox, LevelDescription};
    use crate::reconstruction::Method;
    use crate::scene::Viewpoint;

    /// Two levels of small bricks.
    fn volume(method: Method) -> Volume {
        let part = |low: i64, high: i64| IndexBox::new([low; 3], [high; 3]);
        let split = |cells: IndexBox| {
            cells.coarsened([4; 3]).iter().map(|corner| IndexBox::new(corner, corner.map(|i| i + 1)).refined([4; 3]))
        };
        let level = |ratio, size: i64, bricks: IndexBox| LevelDescription {
            ratio: [ratio; 3],
            cell_size: [1.0 / size as f64; 3],
            domain: part(0, size),
            bricks: split(bricks).collect(),
        };
        let levels = vec![level(1, 16, part(0, 16)), level(2, 32, part(8, 20))];
        let hierarchy = Arc::new(Hierarchy::new([0.0; 3], levels).unwrap());
        let field = Field::from_fn("value", &hierarchy, |level, [i, j, k]| {
            // The distance from a corner, so that a shell of it is visible.
            let [x, y, z] = [i, j, k].map(|index| index as f64 / (16 << level) as f64);
            (x * x + y * y + z * z).sqrt()
        });
        Volume::new(Arc::new(Index::build(hierarchy)), field, method)
    }

    /// A shell of the distance that `volume` holds.
    fn shell(volume: &Volume) -> Scene<'_> {
        let peak = |value, opacity| OpacityPoint { value, opacity };
        let opacity = Opacity::Extinction(vec![peak(0.6, 0.0), peak(0.65, 90.0), peak(0.7, 0.0)]);
        let colors = vec![ColorPoint { value: 0.0, color: [1.0, 0.5, 0.2] }];
        Scene {
            volume,
            transfer_function: TransferFunction::new(Scale::Linear, colors, opacity).unwrap(),
            unit_distance: 0.01,
            camera: Camera::new(Viewpoint::framing([[0.0; 3], [1.0; 3]], 30.0, 1.0)).unwrap(),
        }
    }

    #[test]
    fn skipping_what_is_invisible_changes_nothing() {
        for (method, samples_per_cell) in Method::ALL.into_iter().flat_map(|m| [0.2, 1.0, 3.0].map(|rate| (m, rate))) {
            let volume = volume(method);
            let FieldValues::F64(bricks) = volume.field().values() else { unreachable!("the field was made of f64") };
            let scene = shell(&volume);
            let options = RenderOptions { size: [40, 40], samples_per_cell, ..RenderOptions::default() };
            let skipping = Marcher::new(&scene, bricks, &options);
            let skipped = skipping.visible.iter().filter(|visible| !**visible).count();
            assert!(skipped > skipping.visible.len() / 4, "{skipped} of {} regions", skipping.visible.len());
            let mut thorough = Marcher::new(&scene, bricks, &options);
            thorough.visible.fill(true);
            let [mut few, mut many] = [RenderStatistics::default(); 2];
            for pixel in (0..1600).map(|number| [number % 40, number / 40]) {
                let [with, without] = [skipping.pixel(pixel, &mut few), thorough.pixel(pixel, &mut many)];
                let same = with.iter().zip(without).all(|(a, b)| (a - b).abs() < 1e-6);
                assert!(same, "{method}, {samples_per_cell} samples per cell, {pixel:?}: {with:?} and {without:?}");
            }
            // Intervals longer than a brick are seldom within one.
            let most = if samples_per_cell < 1.0 { many.samples } else { many.samples * 3 / 4 };
            assert!(few.samples < most, "{} of {} samples", few.samples, many.samples);
        }
    }

    #[test]
    fn tiny_steps_end() {
        let volume = volume(Method::Current);
        let FieldValues::F64(bricks) = volume.field().values() else { unreachable!("the field was made of f64") };
        let options = RenderOptions { size: [1, 1], samples_per_cell: 1e17, ..RenderOptions::default() };
        let marcher = Marcher::new(&shell(&volume), bricks, &options);
        // Steps that no longer move a number are none at all.
        assert!(marcher.pixel([0, 0], &mut RenderStatistics::default())[3].is_finite());
    }
}
