//! Projections: what a field amounts to along each ray of a picture, as a number.

use std::fmt;
use std::str::FromStr;

use fearless_simd::prelude::*;
use rayon::prelude::*;
use thiserror::Error;

use super::packet::{Masks, PACKETS, Packet, SIDE};
use super::traverse::{Span, Stack};
use super::value_image::ValueImage;
use super::walk::{Highest, Sums, Walk, looks};
use super::{Layout, TILE};
use crate::Volume;
use crate::hierarchy::Normalisation;
use crate::layout::{InPlace, PaddedValues, RegionValues};
use crate::scene::{Camera, PictureRays};
use crate::simd::{Doubles, Floats, Gather, InstructionSet, Kernel, LANES, Mask};

/// What becomes of the values along a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Reduction {
    /// Their integral over the length, in world units: the column density, where they are densities.
    #[default]
    Integral,
    /// The integral over the length on which there are values.
    Average,
    /// The highest one.
    Maximum,
    /// The lowest one.
    Minimum,
}

/// A name that no reduction has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no reduction {0:?}; there are integral, average, maximum and minimum")]
pub struct UnknownReduction(pub String);

impl Reduction {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Integral, Self::Average, Self::Maximum, Self::Minimum];
}

impl fmt::Display for Reduction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Integral => "integral",
            Self::Average => "average",
            Self::Maximum => "maximum",
            Self::Minimum => "minimum",
        })
    }
}

impl FromStr for Reduction {
    type Err = UnknownReduction;

    fn from_str(name: &str) -> Result<Self, UnknownReduction> {
        Self::ALL
            .into_iter()
            .find(|reduction| reduction.to_string() == name)
            .ok_or_else(|| UnknownReduction(name.into()))
    }
}

/// Projects a volume onto a picture of `size` pixels (width, height): takes the reduction of the reconstruction along
/// the ray through each pixel's centre, from the camera to infinity. Holes and cells that are no numbers do not take
/// part; a ray that meets nothing else has no value.
///
/// Between the planes of dual cells in a brick's interior the result is exact but for rounding; in border zones, where
/// the reconstruction is no polynomial, it is as good as cubics over half a cell are.
pub fn project(
    volume: &Volume,
    camera: &Camera,
    size: [usize; 2],
    reduction: Reduction,
    layout: Layout,
    progress: &(dyn Fn(f64) + Sync),
) -> ValueImage {
    let rays = &camera.picture_rays(size);
    let sampler = &volume.packet_sampler();
    let (index, method) = (volume.index(), volume.method());
    // Holes need not be walked through.
    let no_values = |range: [f32; 2]| (range[0] > range[1]).then_some(0);
    let values = match layout {
        Layout::Padded => {
            let padded = volume.padded();
            let values = PaddedValues::new(padded, sampler);
            let looks = looks(&padded.pieces, |node| no_values(node.range));
            let walk = Walk { values, index, pieces: &padded.pieces, looks: &looks, method };
            Projector { volume, rays, walk, reduction }.rows(size, progress)
        }
        Layout::InPlace => {
            let plan = volume.in_place();
            let looks = looks(&plan.pieces, |node| no_values(node.range));
            let walk = Walk { values: InPlace { plan, sampler }, index, pieces: &plan.pieces, looks: &looks, method };
            Projector { volume, rays, walk, reduction }.rows(size, progress)
        }
    };
    ValueImage { size, values }
}

struct Projector<'a, V> {
    volume: &'a Volume,
    rays: &'a PictureRays,
    walk: Walk<'a, V>,
    reduction: Reduction,
}

impl<V: RegionValues> Projector<'_, V> {
    /// The values of all pixels, row by row.
    fn rows(&self, size: [usize; 2], progress: &(dyn Fn(f64) + Sync)) -> Vec<f64> {
        let mut values = vec![0.0; size[0] * size[1]];
        let finished = std::sync::atomic::AtomicUsize::new(0);
        let strips = size[1].div_ceil(TILE);
        values.par_chunks_mut((TILE * size[0]).max(1)).enumerate().for_each(|(strip, values)| {
            InstructionSet::best().run(Strip { projector: self, width: size[0], top: strip * TILE, values });
            let finished = 1 + finished.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            progress(finished as f64 / strips as f64);
        });
        values
    }
}

/// Rows of pixels from `top` on.
struct Strip<'a, V> {
    projector: &'a Projector<'a, V>,
    width: usize,
    top: usize,
    values: &'a mut [f64],
}

impl<V: RegionValues> Kernel for Strip<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) {
        let Self { projector, width, top, values } = self;
        let height = values.len() / width;
        let mut stack = Stack::default();
        for row in (0..height).step_by(SIDE) {
            for left in (0..width).step_by(SIDE * PACKETS) {
                let found = projector.packets(simd, [left, top + row], &mut stack);
                for (packet, found) in found.iter().enumerate() {
                    for (lane, found) in found.iter().enumerate() {
                        let (x, y) = (left + packet * SIDE + lane % SIDE, row + lane / SIDE);
                        if x < width && y < height {
                            values[y * width + x] = *found;
                        }
                    }
                }
            }
        }
    }
}

impl<V: RegionValues> Projector<'_, V> {
    /// The values of the pixels of packets side by side.
    #[inline(always)]
    fn packets<S: Gather>(&self, simd: S, corner: [usize; 2], stack: &mut Stack<S>) -> [[f64; LANES]; PACKETS] {
        let index = self.volume.index();
        let domain = index.domain();
        let [low, high] = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
        let mut packets = [self.packet(simd, corner); PACKETS];
        for packet in 1..PACKETS {
            packets[packet] = self.packet(simd, [corner[0] + packet * SIDE, corner[1]]);
        }
        let nowhere = Floats::splat(simd, 0.0);
        let mut span = Span { enter: [nowhere; PACKETS], leave: [nowhere; PACKETS] };
        let mut inside: Masks<S> = [Mask::splat(simd, false); PACKETS];
        for packet in 0..PACKETS {
            [span.enter[packet], span.leave[packet]] = packets[packet].clip(simd, low, high);
            inside[packet] = span.enter[packet].simd_lt(span.leave[packet]);
        }
        let mut found = [[f64::NAN; LANES]; PACKETS];
        let Normalisation { low, scale } = self.volume.normalisation();
        match self.reduction {
            Reduction::Integral | Reduction::Average => {
                let mut sums = Sums::new(simd, inside);
                self.walk.walk(simd, &packets, &span, &mut sums, stack);
                for packet in 0..PACKETS {
                    let (integrals, lengths) = (sums.integral[packet].store(), sums.length[packet].store());
                    for lane in (0..LANES).filter(|&lane| lengths[lane] > 0.0) {
                        let average = low + integrals[lane] / lengths[lane] / scale;
                        found[packet][lane] = match self.reduction {
                            Reduction::Average => average,
                            _ => average * lengths[lane],
                        };
                    }
                }
            }
            Reduction::Maximum | Reduction::Minimum => {
                let sign = if self.reduction == Reduction::Maximum { 1.0 } else { -1.0 };
                let mut steps = Highest::new(simd, inside, sign);
                self.walk.walk(simd, &packets, &span, &mut steps, stack);
                for packet in 0..PACKETS {
                    let highest: [f32; LANES] = steps.highest[packet].into();
                    for lane in (0..LANES).filter(|&lane| highest[lane].is_finite()) {
                        found[packet][lane] = low + f64::from(sign * highest[lane]) / scale;
                    }
                }
            }
        }
        found
    }

    /// The rays through the centres of pixels from `corner` on.
    #[inline(always)]
    fn packet<S: Gather>(&self, simd: S, corner: [usize; 2]) -> Packet<S> {
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            x[lane] = (corner[0] + lane % SIDE) as f64 + 0.5;
            y[lane] = (corner[1] + lane / SIDE) as f64 + 0.5;
        }
        let pixels = [Doubles::load(simd, &x), Doubles::load(simd, &y)];
        Packet::new(simd, self.volume.index(), self.rays, pixels, Doubles::splat(simd, 0.0), 1.0)
    }
}
