//! From rays to pixels: emission and absorption along each ray, tile by tile on all cores, into a film.

mod axes;
mod clip;
mod film;
mod frame;
mod lit;
mod march;
mod packet;
mod path;
mod plane;
mod project;
mod query;
mod slice;
mod surface;
mod traverse;
mod value_image;
mod visibility;
mod walk;

use std::ops::Add;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::appearance::Radiance;
use crate::scene::Scene;
use crate::simd::Gather;

pub use crate::layout::{Layout, padded_bytes};
pub use axes::draw_axes;
pub use film::Film;
pub use path::{PathError, PathOptions, PathStatistics, PathTracer};
pub use project::{Reduction, UnknownReduction, project};
pub use slice::{Axis, Slice, UnknownAxis};
pub use value_image::ValueImage;

use frame::{Frame, Tile};
use packet::{PACKETS, Packets};
use traverse::Span;

/// Pixels per side of a tile: the unit of work that threads share out.
const TILE: usize = 32;

/// How a picture is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Samples per cell width along a ray, above 0; more are more exact and slower.
    pub samples_per_cell: f64,
    /// Rays per pixel, at least 1.
    pub samples_per_pixel: usize,
    /// Chooses the noise that decorrelates neighbouring pixels.
    pub seed: u64,
    /// How rays find their samples.
    pub engine: Engine,
    /// How light follows from samples.
    pub integration: Integration,
    /// Whether [`Engine::March`] spares what changes nothing that could be seen: samples where the transfer function
    /// makes all values invisible, and short steps where values and transfer function hardly change along a long one.
    /// Otherwise every cell is sampled, as [`Engine::Query`] does.
    pub adaptive: bool,
}

/// How rays find their samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Engine {
    /// Front to back through the regions of the index, in each of them with no search.
    March(Layout),
    /// The paper's design: the tree is asked anew for every sample. Slower, and what marching is measured against. Volumes
    /// glow, whatever light there is.
    Query,
}

/// How light follows from samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integration {
    /// Exactly, for values that run linearly between samples: no part of the transfer function is missed, however far it
    /// changes from one sample to the next.
    #[default]
    Preintegrated,
    /// The transfer function at the value midway between two samples holds for the whole interval.
    AtSamples,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            size: [1024, 1024],
            samples_per_cell: 1.0,
            samples_per_pixel: 1,
            seed: 0,
            engine: Engine::March(Layout::Padded),
            integration: Integration::Preintegrated,
            adaptive: true,
        }
    }
}

/// What a rendering took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStatistics {
    /// Rays that were followed.
    pub rays: u64,
    /// Rays to lights, and around points.
    pub secondary_rays: u64,
    /// Values that were reconstructed.
    pub samples: u64,
    /// How many of them came from one brick alone.
    pub interior_samples: u64,
    /// How often a packet of rays came to a region, or a piece of it.
    pub region_visits: u64,
    /// The length of all rays inside the domain, in world units.
    pub ray_length: f64,
    /// How much of it was passed over because nothing there is seen.
    pub skipped_length: f64,
}

impl Add for RenderStatistics {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            secondary_rays: self.secondary_rays + other.secondary_rays,
            samples: self.samples + other.samples,
            interior_samples: self.interior_samples + other.interior_samples,
            region_visits: self.region_visits + other.region_visits,
            ray_length: self.ray_length + other.ray_length,
            skipped_length: self.skipped_length + other.skipped_length,
        }
    }
}

/// What rays have in common with paths: those from the eye and to lights, and samples.
impl From<PathStatistics> for RenderStatistics {
    fn from(paths: PathStatistics) -> Self {
        let PathStatistics { paths: rays, light_rays, samples, .. } = paths;
        Self { rays, secondary_rays: light_rays, samples, ..Self::default() }
    }
}

/// An engine: follows packets of rays, side by side.
trait Trace: Sync {
    /// Memory that packets use one after the other.
    type Scratch<S: Gather>: Default;

    /// Adds to `lights` what the packets' rays collect between the ends of `span`.
    fn trace<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        scratch: &mut Self::Scratch<S>,
        statistics: &mut RenderStatistics,
    );

    /// [`trace`](Self::trace) as code of its own: engines are large.
    #[inline(never)]
    fn trace_apart<S: Gather>(
        &self,
        simd: S,
        packets: &Packets<S>,
        span: &Span<S>,
        lights: &mut [Radiance<S>; PACKETS],
        scratch: &mut Self::Scratch<S>,
        statistics: &mut RenderStatistics,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.trace(simd, packets, span, lights, scratch, statistics),
        );
    }
}

/// Renders a scene.
///
/// The picture does not depend on the number of threads. `progress` is told the share that is done,
/// 0 to 1, from several threads.
///
/// # Panics
/// Where the scene's unit distance is not a positive finite number, and where its fields are more than [`MOST_FIELDS`](crate::scene::MOST_FIELDS) or
/// not of one index and method.
pub fn render(scene: &Scene, options: &RenderOptions, progress: &(dyn Fn(f64) + Sync)) -> (Film, RenderStatistics) {
    let [width, height] = options.size;
    let tiles: Vec<Tile> = (0..height)
        .step_by(TILE)
        .flat_map(|y| (0..width).step_by(TILE).map(move |x| [x, y]))
        .map(|corner| Tile { corner, size: [TILE.min(width - corner[0]), TILE.min(height - corner[1])] })
        .collect();
    let frame = Frame::new(scene, options);
    let film = Mutex::new(Film::new(options.size));
    let finished = AtomicUsize::new(0);
    let statistics = tiles
        .par_iter()
        .map(|&tile| {
            let (pixels, statistics) = frame.tile(tile);
            // Held for a copy only: a panic elsewhere leaves no half-written tile that anyone would see.
            film.lock().unwrap_or_else(PoisonError::into_inner).put_tile(tile.corner, tile.size[0], &pixels);
            progress((finished.fetch_add(1, Ordering::Relaxed) + 1) as f64 / tiles.len() as f64);
            statistics
        })
        .reduce(RenderStatistics::default, RenderStatistics::add);
    (film.into_inner().unwrap_or_else(PoisonError::into_inner), statistics)
}
