//! What is found along rays, against many samples on them, one by one.

mod common;

use amray::Volume;
use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::Method;
use amray::render::{Engine, Layout, Reduction, RenderOptions, project, render};
use amray::scene::{Camera, CameraRay, Paint, Projection, Scene, Surface, Viewpoint};
use amray_testing::{Random, RandomMesh, Shape, noise};
use proptest::prelude::*;

use common::{METHODS, extinction, of_centers, volume};

const SIZE: [usize; 2] = [8, 8];

/// The values along a ray, between where it enters and leaves the domain.
struct Samples {
    /// Where the ray enters, and how far it is from one sample to the next; the first is half a step behind.
    enter: f64,
    step: f64,
    values: Vec<f64>,
}

impl Samples {
    /// About `density` samples per cell of the finest level.
    fn take(volume: &Volume, ray: CameraRay, density: f64) -> Self {
        let CameraRay { start, direction } = ray;
        let [low, high] = volume.hierarchy().bounds();
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let crossings = [low, high].map(|corner| (corner[axis] - start[axis]) / direction[axis]);
            enter = enter.max(crossings[0].min(crossings[1]));
            leave = leave.min(crossings[0].max(crossings[1]));
        }
        let levels = volume.hierarchy().levels();
        let cell = levels[levels.len() - 1].cell_size().into_iter().fold(f64::INFINITY, f64::min);
        let count = ((leave - enter).max(0.0) / cell * density).ceil() as usize;
        let step = (leave - enter) / count as f64;
        let at = |number: usize| enter + step * (number as f64 + 0.5);
        let points: Vec<_> = (0..count).map(|number| along(ray, at(number))).collect();
        Self { enter, step, values: volume.sample(&points) }
    }
}

fn along(CameraRay { start, direction }: CameraRay, at: f64) -> [f64; 3] {
    std::array::from_fn(|axis| start[axis] + at * direction[axis])
}

/// A random mesh and from where it is looked at: from outside or inside.
fn random_case(seed: u64) -> (Hierarchy, Viewpoint, Random) {
    let mut random = Random(seed);
    let hierarchy = RandomMesh::new(&mut random, Shape::any(seed)).cut(&mut random);
    let [low, high] = hierarchy.bounds();
    let mut viewpoint = Viewpoint::framing([low, high], 30.0, 1.0);
    let side = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let direction: [f64; 3] = std::array::from_fn(|_| random.unit() - 0.5);
    let distance = if random.chance(0.3) { 0.3 } else { 4.0 };
    viewpoint.eye = std::array::from_fn(|axis| viewpoint.target[axis] + direction[axis] * side * distance);
    viewpoint.projection = match random.chance(0.3) {
        true => Projection::Orthographic { height: 1.2 * side },
        false => Projection::Perspective { fovy: 25.0 },
    };
    (hierarchy, viewpoint, random)
}

/// How far surfaces are along rays, as the blue of a picture: a field that grows along the view, from 0 to 1 over what
/// lies between two distances.
struct Depth {
    field: Volume,
    function: TransferFunction,
    nearest: f64,
    farthest: f64,
}

impl Depth {
    fn new(volume: &Volume, camera: &Camera) -> Self {
        let [low, high] = volume.hierarchy().bounds();
        let (eye, ahead) = (camera.viewpoint().eye, camera.direction([0.0, 0.0, 1.0]));
        let along_view = move |point: [f64; 3]| (0..3).map(|axis| (point[axis] - eye[axis]) * ahead[axis]).sum::<f64>();
        // A cell more on every side: between centres values are linear.
        let size: [f64; 3] = std::array::from_fn(|axis| (high[axis] - low[axis]) / 2.0);
        let whole = IndexBox::new([-1; 3], [3; 3]);
        let level = LevelDescription { ratio: [1; 3], cell_size: size, domain: whole, bricks: vec![whole] };
        let field = of_centers(Hierarchy::new(low, vec![level]).unwrap(), Method::Current, along_view);
        let corners =
            (0..8).map(|corner| along_view(std::array::from_fn(|axis| [low, high][corner >> axis & 1][axis])));
        let (nearest, farthest) =
            corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let point = |value, blue| ColorPoint { value, color: [0.0, 0.0, blue] };
        let colors = vec![point(nearest, 0.0), point(farthest, 1.0)];
        let opacity = Opacity::Extinction(vec![OpacityPoint { value: nearest, opacity: 1.0 }]);
        let function = TransferFunction::new(Scale::Linear, colors, opacity).unwrap();
        Self { field, function, nearest, farthest }
    }

    /// How far along a ray a pixel says that the surface is.
    fn of_pixel(&self, camera: &Camera, ray: CameraRay, [_, _, blue, alpha]: [f32; 4]) -> Option<f64> {
        let ahead = camera.direction([0.0, 0.0, 1.0]);
        let depth = self.nearest + (self.farthest - self.nearest) * f64::from(blue);
        let product = |vector: [f64; 3]| (0..3).map(|axis| vector[axis] * ahead[axis]).sum::<f64>();
        let eye: [f64; 3] = std::array::from_fn(|axis| ray.start[axis] - camera.viewpoint().eye[axis]);
        (alpha > 0.5).then(|| (depth - product(eye)) / product(ray.direction))
    }
}

/// A point and those a little beside it.
fn beside(point: [f64; 3], distance: f64) -> impl Iterator<Item = [f64; 3]> {
    (0..27usize).map(move |number| {
        std::array::from_fn(|axis| point[axis] + distance * [0.0, -1.0, 1.0][number / 3usize.pow(axis as u32) % 3])
    })
}

/// The samples between which a ray first crosses `level`, both of which have values.
fn first_crossing(values: &[f64], level: f64) -> Option<usize> {
    let crosses = |pair: &[f64]| !pair[0].is_nan() && !pair[1].is_nan() && (pair[0] > level) != (pair[1] > level);
    values.windows(2).position(crosses)
}

/// The integral of the reconstruction, to 1e-4 of itself, of a field as simulations have them: with waves a few cells long.
#[test]
fn column_densities_are_exact() {
    const PIXELS: usize = 5;
    // Densities in physical units, far from 1.
    const SCALE: f64 = 3e-24;
    let mut counted = 0;
    for seed in 0..4 {
        let (hierarchy, viewpoint, _) = random_case(seed);
        let camera = Camera::new(viewpoint).unwrap();
        let side = hierarchy.longest_side();
        let density = |point: [f64; 3]| {
            let [x, y, z] = point.map(|place| 20.0 * place / side);
            SCALE * (1.0 + 0.6 * (x + 0.3 * y).sin() * (y - 0.5 * z).cos())
        };
        for method in METHODS {
            let volume = of_centers(hierarchy.clone(), method, density);
            for layout in [Layout::Padded, Layout::InPlace] {
                let image = project(&volume, &camera, [PIXELS; 2], Reduction::Integral, layout, &|_| {});
                for (place, found) in image.values.into_iter().enumerate() {
                    let center = [place % PIXELS, place / PIXELS].map(|pixel| pixel as f64 + 0.5);
                    let Samples { step, values, .. } = Samples::take(&volume, camera.ray([PIXELS; 2], center), 500.0);
                    let known = || values.iter().copied().filter(|value| value.is_finite());
                    let expected = known().sum::<f64>() * step;
                    let jumps = matches!(method, Method::Nearest | Method::Current | Method::Blend);
                    // Where values jump, or begin and end at holes, it is the samples that are off, by what is between two.
                    let of_samples = if jumps || known().count() < values.len() { 3.0 * step * SCALE } else { 0.0 };
                    if known().count() == 0 {
                        continue;
                    }
                    let error = (found - expected).abs();
                    let most = 1e-4 * expected + of_samples;
                    assert!(
                        error < most,
                        "seed {seed}, {method}, {layout:?}, pixel {place}: off by {error:e} of {expected:e}"
                    );
                    counted += 1;
                }
            }
        }
    }
    assert!(counted > 300, "{counted}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn isosurfaces_are_the_first_ones_on_their_rays(seed: u64) {
        const LEVEL: f64 = 0.37;
        let (hierarchy, viewpoint, _) = random_case(seed);
        let camera = Camera::new(viewpoint).unwrap();
        for method in METHODS {
            let volume = volume(hierarchy.clone(), method, noise);
            let depth = Depth::new(&volume, &camera);
            let paint = Paint::Field(&depth.field, depth.function.clone());
            let surface = Surface { material: None, ..Surface::isosurface(LEVEL, paint) };
            let scene =
                Scene { surfaces: vec![surface], ..Scene::new(&volume, extinction(&[(0.0, 0.0)]), 1.0, camera) };
            for layout in [Layout::Padded, Layout::InPlace] {
                let options = RenderOptions { size: SIZE, engine: Engine::March(layout), ..RenderOptions::default() };
                let (film, _) = render(&scene, &options, &|_| {});
                for (place, pixel) in film.pixels().iter().enumerate() {
                    let center = [place % SIZE[0], place / SIZE[0]].map(|pixel| pixel as f64 + 0.5);
                    let ray = camera.ray(SIZE, center);
                    let Samples { enter, step, values } = Samples::take(&volume, ray, 24.0);
                    let first = first_crossing(&values, LEVEL).map(|number| enter + step * (number as f64 + 0.5));
                    let found = depth.of_pixel(&camera, ray, *pixel);
                    let place = || format!("{method}, {layout:?}, pixel {center:?}: {found:?} and {first:?}, step {step}");
                    // Depths are colours in single precision, and where values jump, a walk halves a step to 1e-4.
                    let coarsest = volume.hierarchy().levels()[0].cell_size().into_iter().fold(0.0, f64::max);
                    let rounding = 3e-6 * (depth.farthest - depth.nearest) + 1e-6 * enter.abs() + 1e-4 * coarsest;
                    // A walk may miss what is left of a cell very near to its edge, over which values jump.
                    let is_sliver = first_crossing(&values, LEVEL)
                        .is_some_and(|number| first_crossing(&values[number + 1..], LEVEL) == Some(0));
                    if is_sliver && matches!(method, Method::Nearest | Method::Current | Method::Blend) {
                        continue;
                    }
                    let Some(found) = found else {
                        prop_assert!(first.is_none(), "missed: {}", place());
                        continue;
                    };
                    let is_first = first.is_some_and(|first| {
                        (first - rounding..=first + step + rounding).contains(&found)
                    });
                    if !is_first {
                        let number = first_crossing(&values, LEVEL).unwrap_or(0);
                        // Or it may go along a face, within rounding of either side.
                        let before = values[number] > LEVEL;
                        let is_along_face = first.is_some_and(|first| {
                            (1..10).all(|tenth| {
                                let at = first + step + (found - first - step) * f64::from(tenth) / 10.0;
                                let points: Vec<_> = beside(along(ray, at), rounding).collect();
                                volume.sample(&points).iter().any(|value| (*value > LEVEL) == before)
                            })
                        });
                        if is_along_face {
                            continue;
                        }
                        prop_assert!(first.is_none_or(|first| found < first), "not the first: {}", place());
                        // Between two samples, or within rounding beside the ray, the surface is met twice.
                        let near: Vec<_> = (-64..=64)
                            .map(|number| along(ray, found + f64::from(number) / 32.0 * (step / 8.0 + rounding)))
                            .flat_map(|point| beside(point, rounding))
                            .collect();
                        let values = volume.sample(&near);
                        let touches = values.iter().any(|value| (value - LEVEL).abs() < 5e-3)
                            || values.iter().any(|&value| value > LEVEL) && values.iter().any(|&value| value < LEVEL);
                        prop_assert!(touches, "nothing there: {}", place());
                    }
                }
            }
        }
    }

    #[test]
    fn projections_are_those_of_many_samples(seed: u64) {
        let (hierarchy, viewpoint, _) = random_case(seed);
        let camera = Camera::new(viewpoint).unwrap();
        for method in METHODS {
            let volume = volume(hierarchy.clone(), method, |level, cell| match noise(level, cell) {
                value if seed.is_multiple_of(2) && value < 0.03 => f64::NAN,
                value => value,
            });
            let samples: Vec<Samples> = (0..SIZE[0] * SIZE[1])
                .map(|place| [place % SIZE[0], place / SIZE[0]].map(|pixel| pixel as f64 + 0.5))
                .map(|center| Samples::take(&volume, camera.ray(SIZE, center), 24.0))
                .collect();
            for layout in [Layout::Padded, Layout::InPlace] {
                for reduction in Reduction::ALL {
                    let image = project(&volume, &camera, SIZE, reduction, layout, &|_| {});
                    for (place, (&found, Samples { step, values, .. })) in image.values.iter().zip(&samples).enumerate() {
                        let known = || values.iter().copied().filter(|value| value.is_finite());
                        let (count, sum) = (known().count(), known().sum::<f64>());
                        let highest = known().fold(f64::NEG_INFINITY, f64::max);
                        let lowest = known().fold(f64::INFINITY, f64::min);
                        let what = || format!("{method}, {layout:?}, {reduction}, pixel {place}: {found} of {count}");
                        if count < 24 {
                            continue;
                        }
                        let jumps = matches!(method, Method::Nearest | Method::Current | Method::Blend);
                        // Where values jump, samples are as far off as they are apart, every few cells.
                        let length = step * count as f64;
                        let (expected, tolerance) = match reduction {
                            Reduction::Integral => (sum * step, 2e-3 * length + 3.0 * step),
                            Reduction::Average => (sum / count as f64, 2e-3 + 3.0 * step / length),
                            // Samples may miss corners of cells, which may have any value; and right before there is
                            // no value any more, one may be nearer to that than a walk's.
                            Reduction::Maximum | Reduction::Minimum if jumps || count < values.len() => (found, 0.0),
                            Reduction::Maximum => (highest, 2e-2),
                            Reduction::Minimum => (lowest, 2e-2),
                        };
                        prop_assert!((found - expected).abs() <= tolerance, "{}, not {expected}", what());
                        // Walks take planes that are very near to each other for one.
                        let is_beyond = match reduction {
                            _ if count < values.len() => false,
                            Reduction::Maximum => found < highest - 2e-3,
                            Reduction::Minimum => found > lowest + 2e-3,
                            _ => false,
                        };
                        prop_assert!(!is_beyond, "{}: within {highest} and {lowest}", what());
                    }
                }
            }
        }
    }
}
