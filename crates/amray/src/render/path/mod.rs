//! Path tracing: light that is scattered in a volume any number of times, exact on average.
//!
//! A path starts at the eye and goes on from meeting to meeting with the medium. What it brings is what the picture
//! shows, on average over all paths; nothing is approximated, but noise fades only with the root of their number.

mod lights;
mod majorants;
mod phase;
mod random;
mod tracking;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use super::clip::Clips;
use super::surface::{Probe, SurfacePlan, SurfacePoint, Surfaces};
use super::{Engine, Film, Layout, RenderOptions};
use crate::Volume;
use crate::appearance::PreparedTransferFunction;
use crate::hierarchy::{Voxel, with_voxels};
use crate::index::Ray;
use crate::layout::{EitherValues, PaddedPoints};
use crate::reconstruction::Sampler;
use crate::scene::{LightingError, PictureRays, Scene, Shading};
use crate::simd::InstructionSet;

use lights::Lights;
use majorants::Majorants;
use phase::{HenyeyGreenstein, Scatterer};
use random::Random;
use tracking::{Medium, Meeting, Scratch};

/// How light is scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// The mean cosine of the angle by which light is turned (the parameter of Henyey and Greenstein's phase function),
    /// between -1, back, and 1, straight on; at 0 all directions are alike.
    pub anisotropy: f64,
    /// How much of the light that meets the medium is scattered, 0 to 1, times the transfer function's colour; the rest
    /// is absorbed.
    pub albedo: f64,
    /// How often light is scattered at most. Only white, dense volumes are too dark with few: where nothing is absorbed,
    /// a surface sends back 20 % of white light after more than 64 times, 5 % after more than 1000. Elsewhere light that
    /// has become faint ends by chance, which costs nothing on average.
    pub most_scatterings: usize,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { anisotropy: 0.0, albedo: 1.0, most_scatterings: 1000 }
    }
}

/// What cannot be traced.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PathError {
    /// The phase function has no such parameter.
    #[error("anisotropy is {0}, expected a number between -1 and 1, both excluded")]
    Anisotropy(f64),
    /// A medium that scatters less than nothing, or more than it meets.
    #[error("albedo is {0}, expected a number from 0 to 1")]
    Albedo(f64),
    /// Other fields beside the volume.
    #[error("the scene shows several fields, expected one: paths know no others yet")]
    SeveralFields,
    /// A light that cannot be.
    #[error(transparent)]
    Lighting(#[from] LightingError),
}

/// What paths took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PathStatistics {
    /// Paths from the eye.
    pub paths: u64,
    /// How often they were scattered.
    pub scatterings: u64,
    /// Rays to lights.
    pub light_rays: u64,
    /// Values that were reconstructed.
    pub samples: u64,
    /// How many of them were denser than the index knew: 0, or the picture is too thin there.
    pub beyond_majorant: u64,
}

/// Traces paths through a scene, pass by pass; the picture is there after each.
///
/// A volume with [`Shading::Emissive`] glows and scatters nothing: the picture is that of [`render`](super::render).
/// Otherwise it scatters all light by the same phase function, also with [`Shading::Gradient`]; the albedo is the transfer
/// function's colour. [`Light::Ambient`](crate::scene::Light::Ambient) surrounds the scene: the eye sees it scattered by
/// the volume, where it looks past the volume the film is transparent. Over a background of the ambient light's colour the
/// picture is what one would see. The other lights are seen by what they light, and always throw shadows.
///
/// Surfaces reflect the diffuse part of their [`Material`](crate::scene::Material) alike in all directions (Lambert) and
/// have no highlights; without one they show their colours. Light passes them as their opacities say, straight on. A lamp's
/// colour is how bright what it lights becomes, be it a white medium that scatters alike in all directions or a white
/// surface that faces it, as in pictures without scattered light.
///
/// Cells that are not a number are empty. Extinctions beyond 64 per cell width count as that.
///
/// ```
/// # use std::sync::Arc;
/// # use amray::Volume;
/// # use amray::appearance::{ColorMap, Opacity, OpacityPoint, Scale, TransferFunction};
/// # use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
/// # use amray::index::Index;
/// # use amray::reconstruction::Method;
/// use amray::render::{PathOptions, PathTracer, RenderOptions};
/// use amray::scene::{Camera, Scene, Shading, Viewpoint};
///
/// # let level = LevelDescription {
/// #     ratio: [1; 3],
/// #     cell_size: [0.125; 3],
/// #     domain: IndexBox::new([0; 3], [8; 3]),
/// #     bricks: vec![IndexBox::new([0; 3], [8; 3])],
/// # };
/// # let hierarchy = Arc::new(Hierarchy::new([0.0; 3], vec![level])?);
/// # let field = Field::from_fn("x", &hierarchy, |_, cell| cell[0] as f64 / 7.0);
/// # let volume = Volume::new(Arc::new(Index::build(hierarchy)), field, Method::Basis);
/// # let opacity = Opacity::Extinction(vec![OpacityPoint { value: 0.0, opacity: 20.0 }]);
/// # let function = TransferFunction::from_color_map(ColorMap::Viridis, [0.0, 1.0], Scale::Linear, opacity)?;
/// # let camera = Camera::new(Viewpoint::framing(volume.hierarchy().bounds(), 30.0, 1.0))?;
/// let mut scene = Scene::new(&volume, function, 0.01, camera);
/// scene.lighting.shading = Shading::Isotropic;
/// let options = RenderOptions { size: [16, 16], ..RenderOptions::default() };
/// let mut tracer = PathTracer::new(&scene, &options, &PathOptions { anisotropy: 0.4, ..PathOptions::default() })?;
/// while tracer.passes() < 8 {
///     tracer.accumulate(4, &|_| {});
///     let film = tracer.film(); // Less noisy each time.
/// }
/// # assert!(tracer.film().pixels()[8 * 16 + 8][3] > 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PathTracer<'a> {
    view: View<'a>,
    /// By pixel, the sums of what all paths brought: red, green, blue and opacity.
    sums: Vec<[f64; 4]>,
    passes: usize,
    statistics: PathStatistics,
}

/// What all paths share.
struct View<'a> {
    volume: &'a Volume,
    /// Where values are found with no search.
    padded: Option<PaddedPoints<'a>>,
    function: PreparedTransferFunction,
    majorants: Majorants,
    lights: Lights,
    /// Whether the volume glows, and scatters nothing.
    is_emissive: bool,
    rays: PictureRays,
    clips: Clips,
    surfaces: Option<SurfacePlan<'a>>,
    layout: Layout,
    instructions: InstructionSet,
    size: [usize; 2],
    seed: u64,
    /// Of the finest level, in world units.
    cell_size: DVec3,
    options: PathOptions,
}

/// What a ray has met.
enum Met {
    Medium(Meeting),
    Surface(SurfacePoint),
}

/// From how many scatterings on chance decides which paths go on: as often as they have light left.
const CERTAIN: usize = 4;

impl<'a> PathTracer<'a> {
    /// No path yet. Of `options` the size and the seed count, and the engine's layout: a padded copy is faster, values in
    /// place need no copy.
    ///
    /// # Errors
    /// [`PathError`] for what cannot be.
    ///
    /// # Panics
    /// Where the scene's unit distance is not a positive finite number.
    pub fn new(scene: &'a Scene<'a>, options: &RenderOptions, path: &PathOptions) -> Result<Self, PathError> {
        if !(path.anisotropy > -1.0 && path.anisotropy < 1.0) {
            return Err(PathError::Anisotropy(path.anisotropy));
        }
        if !(0.0..=1.0).contains(&path.albedo) {
            return Err(PathError::Albedo(path.albedo));
        }
        if scene.colors.is_some() || !scene.overlays.is_empty() {
            return Err(PathError::SeveralFields);
        }
        scene.lighting.check()?;
        let volume = scene.volume;
        let hierarchy = volume.hierarchy();
        let function = scene.transfer_function.prepared(scene.unit_distance);
        let layout = match options.engine {
            Engine::March(layout) => layout,
            Engine::Query => Layout::InPlace,
        };
        let pieces = volume.pieces(layout);
        let view = View {
            volume,
            padded: (layout == Layout::Padded).then(|| PaddedPoints::new(volume)),
            majorants: Majorants::new(volume, pieces, &function),
            function,
            lights: Lights::new(scene, hierarchy),
            is_emissive: scene.lighting.shading == Shading::Emissive,
            rays: scene.camera.picture_rays(options.size),
            clips: Clips::new(&scene.clips, hierarchy),
            surfaces: SurfacePlan::new(volume, &scene.surfaces, pieces),
            layout,
            instructions: InstructionSet::best(),
            size: options.size,
            seed: options.seed,
            cell_size: DVec3::from_array(hierarchy.levels()[hierarchy.finest_level()].cell_size()),
            options: *path,
        };
        let sums = vec![[0.0; 4]; options.size[0] * options.size[1]];
        Ok(Self { view, sums, passes: 0, statistics: PathStatistics::default() })
    }

    /// Traces `passes` more paths through each pixel.
    ///
    /// The picture depends neither on the number of threads nor on how passes are shared out over calls. `progress` is
    /// told the share that is done, 0 to 1, from several threads.
    pub fn accumulate(&mut self, passes: usize, progress: &(dyn Fn(f64) + Sync)) {
        let [width, height] = self.view.size;
        if self.sums.is_empty() {
            return;
        }
        let (view, passes) = (&self.view, self.passes..self.passes + passes);
        let finished = AtomicUsize::new(0);
        let statistics = with_voxels!(view.volume.field().values(), bricks => {
            let sampler = Sampler::new(view.volume.index(), bricks, view.volume.method());
            let medium = Medium {
                sampler,
                padded: view.padded.as_ref(),
                function: &view.function,
                majorants: &view.majorants,
                clips: &view.clips,
            };
            let row = |scratch: &mut Scratch, (y, sums): (usize, &mut [[f64; 4]])| {
                scratch.statistics = PathStatistics::default();
                for (x, sum) in sums.iter_mut().enumerate() {
                    for pass in passes.clone() {
                        let random = Random::new(view.seed, (y * width + x) as u64, pass as u64);
                        let brought = view.path(&medium, [x, y], random, scratch);
                        (0..4).for_each(|channel| sum[channel] += brought[channel]);
                    }
                }
                progress((finished.fetch_add(1, Ordering::Relaxed) + 1) as f64 / height as f64);
                scratch.statistics
            };
            let rows = self.sums.par_chunks_mut(width).enumerate().map_init(Scratch::default, row);
            rows.reduce(PathStatistics::default, PathStatistics::and)
        });
        self.passes = passes.end;
        self.statistics = self.statistics.and(statistics);
    }

    /// How many paths have gone through each pixel.
    pub fn passes(&self) -> usize {
        self.passes
    }

    /// The mean of all passes; transparent before the first one.
    pub fn film(&self) -> Film {
        let mut film = Film::new(self.view.size);
        let weight = (self.passes.max(1) as f64).recip();
        let pixels: Vec<_> = self.sums.iter().map(|sum| sum.map(|channel| (channel * weight) as f32)).collect();
        if !pixels.is_empty() {
            film.put_tile([0, 0], self.view.size[0], &pixels);
        }
        film
    }

    /// What all passes took.
    pub fn statistics(&self) -> PathStatistics {
        self.statistics
    }
}

impl PathStatistics {
    fn and(self, other: Self) -> Self {
        Self {
            paths: self.paths + other.paths,
            scatterings: self.scatterings + other.scatterings,
            light_rays: self.light_rays + other.light_rays,
            samples: self.samples + other.samples,
            beyond_majorant: self.beyond_majorant + other.beyond_majorant,
        }
    }
}

impl View<'_> {
    /// What one path through a pixel brings: red, green, blue, and 1 where it meets the volume.
    fn path<T: Voxel>(
        &self,
        medium: &Medium<T>,
        [x, y]: [usize; 2],
        mut random: Random,
        scratch: &mut Scratch,
    ) -> [f64; 4] {
        scratch.statistics.paths += 1;
        let (mut place, mut direction) = self.first_ray([x as f64 + random.unit(), y as f64 + random.unit()]);
        let mut light = DVec3::ZERO;
        // How much of what arrives at the path's end comes to the eye.
        let mut carried = DVec3::ONE;
        for scatterings in 0.. {
            let ray = self.ray(place, direction);
            let Some(met) = self.next(medium, ray, scatterings == 0, &mut random, scratch) else {
                if scatterings == 0 {
                    return [0.0; 4];
                }
                light += carried * self.lights.ambient;
                break;
            };
            let (color, scatterer) = match met {
                Met::Medium(Meeting { color, .. }) if self.is_emissive => (color, None),
                Met::Medium(Meeting { color, place: met, .. }) => {
                    place = met;
                    carried *= self.options.albedo;
                    (color, Some(Scatterer::Medium(HenyeyGreenstein(self.options.anisotropy))))
                }
                Met::Surface(SurfacePoint { color, material: None, .. }) => (color, None),
                Met::Surface(SurfacePoint { at, off, color, normal, material: Some(material), .. }) => {
                    let normal = facing(normal, direction);
                    place = std::array::from_fn(|axis| ray.start[axis] + at * ray.direction[axis] + off * normal[axis]);
                    carried *= f64::from(material.diffuse);
                    (color, Some(Scatterer::Surface(normal)))
                }
            };
            carried *= DVec3::from_array(color.map(f64::from));
            let Some(scatterer) = scatterer else {
                light += carried;
                break;
            };
            if scatterings == self.options.most_scatterings || carried == DVec3::ZERO {
                break;
            }
            scratch.statistics.scatterings += 1;
            light += carried * self.direct_light(medium, place, (direction, scatterer), &mut random, scratch);
            if scatterings >= CERTAIN {
                let odds = carried.max_element().min(1.0);
                if random.unit() >= odds {
                    break;
                }
                carried /= odds;
            }
            direction = scatterer.scatter(direction, &mut random);
        }
        [light.x, light.y, light.z, 1.0]
    }

    /// What a ray meets first: of translucent surfaces by chance, as often as they are opaque. What only the eye sees is
    /// met by rays from it.
    fn next<T: Voxel>(
        &self,
        medium: &Medium<T>,
        ray: Ray,
        is_from_eye: bool,
        random: &mut Random,
        scratch: &mut Scratch,
    ) -> Option<Met> {
        let meeting = medium.meet(ray, random, scratch);
        let mut met = None;
        if let Some(probe) = self.probe() {
            let far = meeting.as_ref().map_or(f64::INFINITY, |meeting| meeting.t);
            probe.meet(ray, far, &mut scratch.layers, &mut |point| {
                if (is_from_eye || point.casts_shadows) && random.unit() < f64::from(point.opacity) {
                    met = Some(Met::Surface(point));
                    return ControlFlow::Break(());
                }
                ControlFlow::Continue(())
            });
        }
        met.or(meeting.map(Met::Medium))
    }

    fn probe(&self) -> Option<Probe<'_>> {
        self.surfaces.as_ref().map(|plan| Probe {
            surfaces: Surfaces {
                plan,
                values: EitherValues::new(self.volume, self.layout, &plan.sampler),
                pieces: self.volume.pieces(self.layout),
                clips: &self.clips,
            },
            instructions: self.instructions,
        })
    }

    /// The light that is scattered from one of the lights against `direction`, on average over the choice of lights.
    fn direct_light<T: Voxel>(
        &self,
        medium: &Medium<T>,
        place: [f64; 3],
        (direction, scatterer): (DVec3, Scatterer),
        random: &mut Random,
        scratch: &mut Scratch,
    ) -> DVec3 {
        let Some(seen) = self.lights.choose(place, random) else { return DVec3::ZERO };
        let brightness = scatterer.brightness(direction, seen.toward);
        if brightness == 0.0 {
            return DVec3::ZERO;
        }
        scratch.statistics.light_rays += 1;
        let ray = self.ray(place, seen.toward);
        let passing = self.probe().map_or(1.0, |probe| probe.transmittance(ray, seen.distance));
        if passing == 0.0 {
            return DVec3::ZERO;
        }
        seen.color * brightness * passing * medium.transmittance(ray, seen.distance, random, scratch)
    }

    /// Where a path starts, in cells of the finest level, and its direction, of length 1 in world units.
    fn first_ray(&self, pixel: [f64; 2]) -> ([f64; 3], DVec3) {
        let hierarchy = self.volume.hierarchy();
        let [start, direction] = self.rays.at(pixel);
        (hierarchy.to_cells(hierarchy.finest_level(), start.to_array()), direction.normalize())
    }

    /// The ray along which places are as far apart as in world units.
    fn ray(&self, start: [f64; 3], direction: DVec3) -> Ray {
        Ray { start, direction: (direction / self.cell_size).to_array() }
    }
}

/// A normal of length 1 on the side that a direction comes from, along one of any length.
fn facing(normal: [f32; 3], direction: DVec3) -> DVec3 {
    let normal = DVec3::from_array(normal.map(f64::from)).try_normalize().unwrap_or(-direction);
    if normal.dot(direction) > 0.0 { -normal } else { normal }
}
