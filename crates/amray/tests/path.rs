//! Path tracing: against closed forms, against random walks of its own, and against the other pictures of a scene.

mod common;

use amray::Volume;
use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::Method;
use amray::render::{Engine, Film, Layout, PathError, PathOptions, PathStatistics, PathTracer, RenderOptions, render};
use amray::scene::{Camera, Light, Lighting, Material, Paint, Projection, Scene, Shading, Surface, Viewpoint};
use amray_mesh::{Mesh, MeshDescription};
use amray_testing::{Random, RandomMesh, Shape, nested};

use common::{METHODS, extinction, front, oblique, of_centers, volume};

/// How many standard errors an estimate may be off.
const ERRORS: f64 = 4.0;
const WHITE: Light = Light::Ambient { color: [1.0; 3] };

fn scene(volume: &Volume, function: TransferFunction, viewpoint: Viewpoint, lights: Vec<Light>) -> Scene<'_> {
    let lighting = Lighting { lights, shading: Shading::Isotropic, ..Lighting::default() };
    Scene { lighting, ..Scene::new(volume, function, 0.01, Camera::new(viewpoint).unwrap()) }
}

fn square(side: usize, seed: u64) -> RenderOptions {
    RenderOptions { size: [side; 2], seed, ..RenderOptions::default() }
}

fn traced(scene: &Scene, options: RenderOptions, path: PathOptions, passes: usize) -> (Film, PathStatistics) {
    let mut tracer = PathTracer::new(scene, &options, &path).unwrap();
    tracer.accumulate(passes, &|_| {});
    let statistics = tracer.statistics();
    assert_eq!(statistics.paths, (options.size[0] * options.size[1] * passes) as u64);
    assert_eq!(statistics.beyond_majorant, 0);
    (tracer.film(), statistics)
}

/// The mean of a channel over a picture whose pixels are all alike, and its standard error.
fn mean_and_error(film: &Film, channel: usize) -> [f64; 2] {
    let values = film.pixels().iter().map(|pixel| f64::from(pixel[channel]));
    let count = film.pixels().len() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

fn assert_mean(film: &Film, channel: usize, expected: f64, what: &str) {
    let [mean, error] = mean_and_error(film, channel);
    // What single precision leaves of a mean without noise.
    let allowed = ERRORS * error + 1e-6;
    assert!((mean - expected).abs() < allowed, "{what}: {mean} +- {error} and not {expected}");
}

/// A medium with the same extinction everywhere, of a grey albedo.
fn grey(extinction: f64, albedo: f32) -> TransferFunction {
    let colors = vec![ColorPoint { value: 0.0, color: [albedo; 3] }];
    let points = vec![OpacityPoint { value: 0.0, opacity: extinction }];
    TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points)).unwrap()
}

/// All pixels look through the middle of the unit cube's upper face.
fn middle() -> Viewpoint {
    front(Projection::Orthographic { height: 1e-6 })
}

/// All of that face.
fn face() -> Viewpoint {
    front(Projection::Orthographic { height: 1.0 })
}

fn homogeneous(levels: usize) -> Volume {
    of_centers(nested(8, levels, 4), Method::Basis, |_| 0.5)
}

/// A layer across z, from 0 to 1, so wide that its sides are out of reach.
fn layer() -> Volume {
    let level = LevelDescription {
        ratio: [1; 3],
        cell_size: [1000.0, 1000.0, 0.125],
        domain: IndexBox::new([-2, -2, 0], [2, 2, 8]),
        bricks: vec![IndexBox::new([-2, -2, 0], [2, 2, 4]), IndexBox::new([-2, -2, 4], [2, 2, 8])],
    };
    of_centers(Hierarchy::new([0.0; 3], vec![level]).unwrap(), Method::Basis, |_| 0.5)
}

fn sun(direction: [f64; 3]) -> Light {
    Light::Directional { direction, color: [1.0; 3] }
}

/// Henyey and Greenstein's function over that of equal directions.
fn phase(g: f64, cosine: f64) -> f64 {
    (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5)
}

#[test]
fn a_homogeneous_cube_absorbs_exponentially() {
    for levels in [1, 3] {
        let volume = homogeneous(levels);
        for (seed, sigma) in [0.1, 1.0, 4.0].into_iter().enumerate() {
            let scene = scene(&volume, grey(sigma, 0.5), face(), Vec::new());
            let (film, _) = traced(&scene, square(24, seed as u64), PathOptions::default(), 60);
            assert_mean(&film, 3, 1.0 - (-sigma).exp(), &format!("{levels} levels, {sigma}"));
        }
    }
}

#[test]
fn a_varying_medium_absorbs_by_its_integral() {
    // The extinction is 8 z, and less: optical depths of 4 and 1. With few cells, light meets nothing half of the time.
    for cells in [8, 64] {
        let volume = of_centers(nested(cells, 1, 16), Method::Basis, |[_, _, z]| z);
        for (seed, depth) in [4.0f64, 1.0].into_iter().enumerate() {
            let what = format!("{cells} cells, optical depth {depth}");
            let points = [(0.0, 0.0), (1.0, 2.0 * depth)].map(|(value, opacity)| OpacityPoint { value, opacity });
            let colors = vec![ColorPoint { value: 0.0, color: [0.5; 3] }];
            let function = TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points.into())).unwrap();
            let scene = scene(&volume, function, middle(), vec![sun([0.0, 0.0, 1.0])]);
            let once = PathOptions { most_scatterings: 1, ..PathOptions::default() };
            let (film, _) = traced(&scene, square(32, seed as u64), once, 200);
            assert_mean(&film, 3, 1.0 - (-depth).exp(), &what);
            // Light from behind passes all of it, wherever it is scattered.
            assert_mean(&film, 0, 0.5 * depth * (-depth).exp(), &format!("{what}, from behind"));
        }
    }
}

#[test]
fn a_white_medium_in_white_light_cannot_be_seen() {
    let hierarchy = nested(8, 3, 4);
    let noisy = volume(hierarchy, Method::Basis, amray_testing::noise);
    let colors = vec![ColorPoint { value: 0.0, color: [1.0; 3] }];
    let points = [(0.0, 0.0), (0.4, 0.5), (0.5, 30.0), (1.0, 3.0)];
    let points = points.map(|(value, opacity)| OpacityPoint { value, opacity }).to_vec();
    let function = TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points)).unwrap();
    let scene = scene(&noisy, function, oblique(&noisy), vec![WHITE]);
    for anisotropy in [0.0, 0.8, -0.5] {
        let options = PathOptions { anisotropy, most_scatterings: usize::MAX, ..PathOptions::default() };
        let (film, statistics) = traced(&scene, square(12, 1), options, 10);
        assert!(statistics.scatterings > statistics.paths, "most are scattered more than once");
        // Every path brings all light in the end: over a white background the picture is white, with no noise at all.
        for &[red, green, blue, alpha] in film.pixels() {
            for channel in [red, green, blue] {
                assert!((channel + 1.0 - alpha - 1.0).abs() < 1e-5, "{anisotropy}: {channel}, {alpha}");
            }
        }
        // And few scatterings only take from that.
        let few = PathOptions { most_scatterings: 4, ..options };
        let (darker, _) = traced(&scene, square(12, 1), few, 10);
        let sum = |film: &Film| film.pixels().iter().map(|pixel| pixel[0]).sum::<f32>();
        assert!(sum(&darker) < 0.95 * sum(&film));
    }
}

/// What a homogeneous unit cube sends back and through of light from everywhere, where it is seen along z: by walks that
/// know nothing of trees, majorants or roulette.
fn walked(sigma: f64, albedo: f64, g: f64, random: &mut Random) -> f64 {
    let mut place = [random.unit(), random.unit(), 1.0];
    let mut direction = [0.0, 0.0, -1.0];
    let mut carried = 1.0;
    loop {
        let step = -(1.0 - random.unit()).ln() / sigma;
        for axis in 0..3 {
            place[axis] += step * direction[axis];
        }
        if place.iter().any(|part| !(0.0..=1.0).contains(part)) {
            return if carried == 1.0 { 0.0 } else { carried };
        }
        carried *= albedo;
        // A direction by rejection: its cosine is as likely as the function says.
        direction = loop {
            let next: [f64; 3] = random.point([[-1.0; 3], [1.0; 3]]);
            let length = next.iter().map(|part| part * part).sum::<f64>().sqrt();
            if !(1e-3..=1.0).contains(&length) {
                continue;
            }
            let next = next.map(|part| part / length);
            let cosine: f64 = (0..3).map(|axis| next[axis] * direction[axis]).sum();
            if random.unit() * phase(g, g.signum()) < phase(g, cosine) {
                break next;
            }
        };
    }
}

#[test]
fn a_cube_in_white_light_is_as_bright_as_random_walks_find_it() {
    let volume = homogeneous(2);
    for (seed, (sigma, albedo, g)) in [(3.0, 0.9f64, 0.0), (8.0, 0.7, 0.6), (5.0, 0.99, -0.4)].into_iter().enumerate() {
        // Half of the albedo is the transfer function's.
        let scene = scene(&volume, grey(sigma, albedo.sqrt() as f32), face(), vec![WHITE]);
        let path = PathOptions { anisotropy: g, albedo: albedo.sqrt(), ..PathOptions::default() };
        let (film, _) = traced(&scene, square(32, seed as u64), path, 100);
        let mut random = Random(seed as u64);
        let count = 100_000;
        let walks: Vec<f64> = (0..count).map(|_| walked(sigma, albedo, g, &mut random)).collect();
        let mean = walks.iter().sum::<f64>() / f64::from(count);
        let variance = walks.iter().map(|walk| (walk - mean).powi(2)).sum::<f64>() / f64::from(count);
        // Pixels differ from the cube's sides to its middle, so noise alone is less than this error.
        let [found, error] = mean_and_error(&film, 0);
        let error = (error * error + variance / f64::from(count)).sqrt();
        assert!((found - mean).abs() < ERRORS * error, "{sigma}, {albedo}, {g}: {found} and not {mean} +- {error}");
        assert!(error < 0.02 * mean);
    }
}

/// Chandrasekhar's H-function of isotropic scattering at 1, *Radiative Transfer* (1950), chapter V, by iteration.
fn h_at_one(albedo: f64) -> f64 {
    let count = 400;
    let cosines: Vec<f64> = (0..count).map(|place| (place as f64 + 0.5) / count as f64).collect();
    // The form that converges also for an albedo of 1: 1 / H = sqrt(1 - albedo) + albedo / 2 int m H(m) / (mu + m) dm.
    let next = |mu: f64, h: &[f64]| {
        let integral: f64 = cosines.iter().zip(h).map(|(m, h)| m * h / (mu + m) / count as f64).sum();
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * integral)
    };
    let mut h = vec![1.0; count];
    for _ in 0..200 {
        let renewed: Vec<f64> = cosines.iter().map(|&mu| next(mu, &h)).collect();
        h = h.iter().zip(&renewed).map(|(old, new)| (old + new) / 2.0).collect();
    }
    next(1.0, &h)
}

#[test]
fn a_deep_layer_reflects_the_sun_as_chandrasekhar_says() {
    assert!((h_at_one(1.0) - 2.9078).abs() < 2e-3, "the table's value, and not {}", h_at_one(1.0));
    let volume = layer();
    for (seed, albedo) in [0.3f32, 0.8, 0.95].into_iter().enumerate() {
        let view = Viewpoint { eye: [0.0, 0.0, 4.0], target: [0.0; 3], ..middle() };
        // 40 deep: nothing comes back from the bottom. From above along the view, reflected light is half of
        // albedo H(1)^2, for a light that makes a thin medium as bright as its albedo.
        let scene = scene(&volume, grey(40.0, albedo), view, vec![sun([0.0, 0.0, -1.0])]);
        let (film, _) = traced(&scene, square(32, seed as u64), PathOptions::default(), 60);
        let albedo = f64::from(albedo);
        assert_mean(&film, 0, albedo / 2.0 * h_at_one(albedo).powi(2), &format!("albedo {albedo}"));
    }
}

/// The integral of `light(t) sigma exp(-sigma t)` over the depth of the unit cube.
fn collected(sigma: f64, light: impl Fn(f64) -> f64) -> f64 {
    let count = 20_000;
    let depth = |place: usize| (place as f64 + 0.5) / f64::from(count);
    (0..count as usize).map(depth).map(|t| light(t) * sigma * (-sigma * t).exp() / f64::from(count)).sum()
}

#[test]
fn light_that_is_scattered_once_comes_in_closed_form() {
    let (sigma, albedo, g) = (2.0, 0.5f32, 0.5);
    let volume = homogeneous(2);
    let once = PathOptions { anisotropy: g, most_scatterings: 1, ..PathOptions::default() };
    let expect = |what: &str, light: Light, expected: f64| {
        let scene = scene(&volume, grey(sigma, albedo), middle(), vec![light]);
        let (film, _) = traced(&scene, square(32, 5), once, 60);
        assert_mean(&film, 0, f64::from(albedo) * expected, what);
    };
    let through = |length: f64| (-sigma * length).exp();
    expect("from the eye's side", sun([0.0, 0.0, -3.0]), phase(g, -1.0) * collected(sigma, through));
    expect("against the eye", sun([0.0, 0.0, 1.0]), phase(g, 1.0) * collected(sigma, |t| through(1.0 - t)));
    expect("across", sun([1.0, 0.0, 0.0]), phase(g, 0.0) * collected(sigma, |_| through(0.5)));
    expect("headlight", Light::Headlight { color: [1.0; 3] }, phase(g, -1.0) * collected(sigma, through));
    for reach in [None, Some(0.2)] {
        let position = [0.5, 0.5, 0.3];
        let light = |t: f64| {
            let (distance, cosine) = ((0.7 - t).abs(), (0.7 - t).signum());
            let falloff = reach.map_or(1.0, |reach: f64| (reach / distance).min(1.0).powi(2));
            phase(g, cosine) * falloff * through(distance)
        };
        let point = Light::Point { position, color: [1.0; 3], reach };
        expect("a point inside", point, collected(sigma, light));
    }
    // Outside of the volume, half a side above it.
    let point = Light::Point { position: [0.5, 0.5, 1.5], color: [1.0; 3], reach: Some(1.0) };
    let falloff = |t: f64| (1.0 / (0.5 + t)).min(1.0).powi(2);
    expect("a point outside", point, phase(g, -1.0) * collected(sigma, |t| falloff(t) * through(t)));
    // Seen in perspective, the headlight shines from the eye.
    let eye = Viewpoint { eye: [0.5, 0.5, 0.75], ..front(Projection::Perspective { fovy: 1e-6 }) };
    let lights = vec![Light::Headlight { color: [1.0; 3] }];
    let inside = scene(&volume, grey(sigma, albedo), Viewpoint { target: [0.5, 0.5, 0.0], ..eye }, lights);
    let (film, _) = traced(&inside, square(32, 6), once, 60);
    // Twice through what lies between: half of 1 - exp(-2 sigma 0.75).
    let expected = 0.5 * (1.0 - (-2.0 * sigma * 0.75f64).exp());
    assert_mean(&film, 0, f64::from(albedo) * phase(g, -1.0) * expected, "the eye inside");
}

#[test]
fn many_lights_add_up() {
    let volume = homogeneous(2);
    let lights = [
        sun([0.3, -0.4, -1.0]),
        Light::Point { position: [0.2, 0.3, 0.9], color: [0.2, 0.0, 3.0], reach: Some(0.1) },
        Light::Ambient { color: [0.1, 0.2, 0.3] },
        Light::Ambient { color: [0.3, 0.2, 0.1] },
        Light::Headlight { color: [0.0; 3] },
    ];
    let film = |lights: &[Light], seed| {
        let scene = scene(&volume, grey(4.0, 0.8), middle(), lights.to_vec());
        traced(&scene, square(32, seed), PathOptions { anisotropy: 0.3, ..PathOptions::default() }, 60).0
    };
    let all = film(&lights, 0);
    let single: Vec<Film> = (0..5).map(|place| film(&lights[place..=place], 1 + place as u64)).collect();
    for channel in 0..3 {
        let [mean, error] = mean_and_error(&all, channel);
        let sums = single.iter().map(|film| mean_and_error(film, channel));
        let (sum, square) =
            sums.fold((0.0, error * error), |(sum, square), [mean, error]| (sum + mean, square + error * error));
        assert!((mean - sum).abs() < ERRORS * square.sqrt(), "channel {channel}: {mean} and not {sum}");
    }
}

/// What must hold of two pictures of which the first one has noise: per channel no mean differs, and no pixel.
fn assert_alike(noisy: &Film, exact: &Film, passes: usize, what: &str) {
    let count = noisy.pixels().len() as f64;
    for channel in 0..4 {
        let (mut sum, mut variances) = (0.0, 0.0);
        for (found, expected) in noisy.pixels().iter().zip(exact.pixels()) {
            let difference = f64::from(found[channel] - expected[channel]);
            // A path brings a colour of at most 1, or nothing.
            let alpha = f64::from(expected[3]);
            let variance = (alpha * (1.0 - alpha) + f64::from(expected[channel]) * alpha).min(0.25) / passes as f64;
            // How pixels are covered, and the other picture's steps.
            let allowed = 6.0 * (variance + 1e-6).sqrt() + 4e-3;
            assert!(difference.abs() < allowed, "{what}: {found:?} and not {expected:?}");
            sum += difference;
            variances += variance;
        }
        let (mean, error) = (sum / count, variances.sqrt() / count);
        assert!(mean.abs() < ERRORS * error + 5e-4, "{what}, channel {channel}: off by {mean}, error {error}");
    }
}

#[test]
fn what_glows_looks_as_marched_on_any_mesh_with_every_method() {
    for seed in 0..4 {
        let mut random = Random(seed);
        let hierarchy = RandomMesh::new(&mut random, Shape::any(seed)).cut(&mut random);
        let values = |level: usize, cell: [i64; 3]| match amray_testing::noise(level, cell) {
            value if value > 0.97 => f64::NAN,
            value => value,
        };
        for method in METHODS {
            let volume = volume(hierarchy.clone(), method, values);
            let longest = volume.hierarchy().longest_side();
            let function = extinction(&[(0.2, 0.0), (0.6, 12.0 / longest), (0.7, 1.0 / longest)]);
            let mut scene = scene(&volume, function, oblique(&volume), vec![WHITE]);
            scene.lighting.shading = Shading::Emissive;
            // Where values jump, marching is off by a share of a step.
            let samples_per_cell = if matches!(method, Method::Nearest | Method::Finest) { 64.0 } else { 8.0 };
            let marching = RenderOptions { samples_per_pixel: 64, samples_per_cell, adaptive: false, ..square(12, 0) };
            let (marched, _) = render(&scene, &marching, &|_| {});
            for layout in [Layout::Padded, Layout::InPlace] {
                let options = RenderOptions { engine: Engine::March(layout), ..square(12, seed) };
                let (film, _) = traced(&scene, options, PathOptions::default(), 300);
                assert_alike(&film, &marched, 300, &format!("seed {seed}, {method}, {layout:?}"));
            }
        }
    }
}

#[test]
fn shadows_of_light_that_is_scattered_once_are_as_marched() {
    let volume =
        of_centers(nested(16, 2, 8), Method::Basis, |[x, y, z]| 0.5 + 0.5 * (9.0 * x).sin() * (7.0 * y).cos() * z);
    let function = extinction(&[(0.3, 0.0), (1.0, 8.0)]);
    let mut scene = scene(&volume, function, oblique(&volume), vec![sun([0.3, 0.6, -1.0])]);
    scene.lighting.shadows = true;
    let once = PathOptions { most_scatterings: 1, ..PathOptions::default() };
    let (film, _) = traced(&scene, square(16, 0), once, 400);
    let options = RenderOptions { samples_per_pixel: 64, samples_per_cell: 4.0, ..square(16, 0) };
    assert_alike(&film, &render(&scene, &options, &|_| {}).0, 400, "shadows");
}

/// All kinds of light, some of them inside.
fn everything(volume: &Volume) -> Vec<Light> {
    let [low, high] = volume.hierarchy().bounds();
    let inside = |share: f64| std::array::from_fn(|axis| low[axis] + share * (high[axis] - low[axis]));
    vec![
        Light::Ambient { color: [0.3; 3] },
        Light::Headlight { color: [0.2; 3] },
        sun([0.3, -0.5, -1.0]),
        Light::Point { position: inside(0.4), color: [0.5; 3], reach: Some(0.2) },
        Light::Point { position: inside(0.5), color: [0.5; 3], reach: None },
    ]
}

#[test]
fn no_sample_exceeds_its_majorant_on_any_mesh_with_every_method() {
    for seed in 0..12 {
        let mut random = Random(seed);
        let hierarchy = RandomMesh::new(&mut random, Shape::any(seed)).cut(&mut random);
        let values = |level: usize, cell: [i64; 3]| match amray_testing::noise(level, cell) {
            value if value > 0.95 => [f64::NAN, f64::INFINITY][seed as usize % 2],
            // Far from 0, the last digits of a value matter.
            value => 1e6 + value,
        };
        for method in METHODS {
            let volume = volume(hierarchy.clone(), method, values);
            let longest = volume.hierarchy().longest_side();
            // Steep, with steps, and opaque at last.
            let points = [(0.1, 0.0), (0.2, 0.01), (0.3, 0.01), (0.3, 0.2), (0.5, 0.0), (0.9, 0.3), (0.9, 1.0)];
            let points = points.map(|(value, opacity)| OpacityPoint { value: 1e6 + value, opacity }).to_vec();
            let colors = vec![ColorPoint { value: 1e6, color: [0.9; 3] }];
            let function = TransferFunction::new(Scale::Linear, colors, Opacity::PerUnitDistance(points)).unwrap();
            let view = oblique(&volume);
            let [low, high] = volume.hierarchy().bounds();
            let eye = std::array::from_fn(|axis| 0.4 * low[axis] + 0.6 * high[axis]);
            let inside = Viewpoint { eye, target: low, ..view };
            for (layout, viewpoint) in [(Layout::Padded, view), (Layout::Padded, inside), (Layout::InPlace, inside)] {
                let mut scene = scene(&volume, function.clone(), viewpoint, everything(&volume));
                scene.unit_distance = longest / 50.0;
                scene.lighting.shading = Shading::Gradient(Material::default());
                let path = PathOptions { anisotropy: 0.6, most_scatterings: 20, ..PathOptions::default() };
                let options = RenderOptions { engine: Engine::March(layout), ..square(8, seed) };
                // `traced` asserts it.
                let (film, _) = traced(&scene, options, path, 4);
                for pixel in film.pixels() {
                    assert!(pixel.iter().all(|channel| channel.is_finite() && *channel >= 0.0), "{method}: {pixel:?}");
                }
            }
        }
    }
}

#[test]
fn holes_and_not_a_number_are_empty() {
    let level = LevelDescription {
        ratio: [1; 3],
        cell_size: [0.25; 3],
        domain: IndexBox::new([0; 3], [4; 3]),
        bricks: vec![IndexBox::new([0, 0, 2], [4; 3])],
    };
    let half = of_centers(Hierarchy::new([0.0; 3], vec![level]).unwrap(), Method::Basis, |_| 0.5);
    let (film, _) =
        traced(&scene(&half, grey(2.0, 1.0), face(), vec![WHITE]), square(32, 0), PathOptions::default(), 30);
    assert_mean(&film, 3, 1.0 - (-1.0f64).exp(), "only the upper half is there");
    let nothing = of_centers(nested(8, 2, 4), Method::Basis, |_| f64::NAN);
    let scene = scene(&nothing, grey(2.0, 1.0), face(), vec![WHITE]);
    assert_eq!(traced(&scene, square(5, 0), PathOptions::default(), 2).0, Film::new([5, 5]));
}

#[test]
fn the_picture_depends_on_the_seed_alone() {
    let volume = volume(nested(8, 3, 4), Method::Blend, amray_testing::noise);
    let scene = scene(&volume, extinction(&[(0.3, 0.0), (1.0, 20.0)]), oblique(&volume), everything(&volume));
    let film = |threads: usize, seed, calls: &[usize]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let options = RenderOptions { size: [23, 17], seed, ..RenderOptions::default() };
            let mut tracer = PathTracer::new(&scene, &options, &PathOptions::default()).unwrap();
            calls.iter().for_each(|&passes| tracer.accumulate(passes, &|_| {}));
            assert_eq!(tracer.passes(), 6);
            (tracer.film(), tracer.statistics())
        })
    };
    let one = film(1, 0, &[6]);
    assert_eq!(one, film(3, 0, &[6]));
    assert_eq!(one, film(2, 0, &[1, 3, 2]));
    assert_ne!(one, film(1, 1, &[6]));
}

#[test]
fn an_opaque_medium_is_a_surface() {
    // All that is above one half is opaque; it is met within a small part of a cell.
    let volume = of_centers(nested(32, 1, 8), Method::Basis, |[_, _, z]| 1.0 - z);
    let points = [(0.5, 0.0), (0.5, 1.0)].map(|(value, opacity)| OpacityPoint { value, opacity }).to_vec();
    let colors = vec![ColorPoint { value: 0.0, color: [1.0; 3] }];
    let function = TransferFunction::new(Scale::Linear, colors, Opacity::PerUnitDistance(points)).unwrap();
    let scene = scene(&volume, function, face(), vec![WHITE]);
    let (film, _) = traced(&scene, square(8, 0), PathOptions::default(), 8);
    assert!(film.pixels().iter().all(|pixel| pixel[3] == 1.0));
    assert_eq!(traced(&scene, square(0, 0), PathOptions::default(), 8).0, Film::new([0, 0]));
}

/// What reflects all light, alike in all directions.
const MATT: Material = Material { ambient: 1.0, diffuse: 1.0, specular: 0.0, specular_power: 1.0 };

fn matt(surface: Surface) -> Surface {
    Surface { material: Some(MATT), ..surface }
}

/// Half of a wall across x within the unit cube, as high as the cube.
fn wall(color: [f32; 4]) -> Mesh {
    let positions = [[0.4, 0.0, 0.0], [0.4, 1.0, 0.0], [0.4, 1.0, 1.0], [0.4, 0.0, 1.0]];
    let mesh = MeshDescription {
        vertices: positions.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        colors: Some(vec![color; 4]),
        normals: None,
    };
    Mesh::new(mesh).unwrap()
}

const LAYOUTS: [Engine; 2] = [Engine::March(Layout::Padded), Engine::March(Layout::InPlace)];

#[test]
fn white_surfaces_in_white_light_cannot_be_seen() {
    let volume = of_centers(nested(16, 3, 8), Method::Basis, |point| {
        0.5 - point.iter().map(|place| (place - 0.5f64).powi(2)).sum::<f64>().sqrt()
    });
    let mesh = wall([1.0; 4]);
    for engine in LAYOUTS {
        for glowing in [false, true] {
            // A medium that scatters all light, or none of it.
            let function = if glowing { grey(0.0, 1.0) } else { grey(3.0, 1.0) };
            let lighting = Lighting {
                lights: vec![WHITE],
                shading: if glowing { Shading::Emissive } else { Shading::Isotropic },
                ..Lighting::default()
            };
            let surfaces = vec![
                matt(Surface::isosurface(0.25, Paint::Plain([1.0; 3]))),
                matt(Surface::slice([0.5; 3], [0.0, 1.0, 2.0], Paint::Plain([1.0; 3]))),
                Surface { opacity: 0.5, ..matt(Surface::mesh(&mesh)) },
            ];
            let mut scene = scene(&volume, function, oblique(&volume), Vec::new());
            (scene.lighting, scene.surfaces) = (lighting, surfaces);
            let (film, _) = traced(&scene, RenderOptions { engine, ..square(16, 0) }, PathOptions::default(), 64);
            let mut seen = 0;
            for pixel in film.pixels() {
                // All that arrives is what is there without anything.
                let errors = ERRORS * 0.01;
                assert!((pixel[0] - pixel[3]).abs() < errors as f32, "{engine:?}, {glowing}: {pixel:?}");
                seen += u32::from(pixel[3] > 0.99);
            }
            assert!(seen > 10, "{seen}");
        }
    }
}

#[test]
fn surfaces_in_the_sun_are_as_marched() {
    let volume = of_centers(nested(16, 3, 8), Method::Basis, |point| {
        0.5 - point.iter().map(|place| (place - 0.5f64).powi(2)).sum::<f64>().sqrt()
    });
    let translucent = wall([0.9, 0.5, 0.2, 0.6]);
    let isosurface = || Surface { opacity: 0.7, ..matt(Surface::isosurface(0.2, Paint::Plain([0.2, 0.6, 0.9]))) };
    let slice = || matt(Surface::slice([0.5; 3], [0.3, 0.2, 1.0], Paint::Plain([0.5, 0.9, 0.4])));
    let plain = Surface::slice([0.5; 3], [0.3, 0.2, 1.0], Paint::Field(&volume, extinction(&[(0.0, 1.0)])));
    for (number, surfaces) in [vec![slice()], vec![matt(Surface::mesh(&translucent))], vec![isosurface()], vec![plain]]
        .into_iter()
        .enumerate()
    {
        // The volume is black: it only dims light, and surfaces as these see little of one another.
        let mut scene = scene(&volume, grey(2.0, 0.0), oblique(&volume), vec![sun([-1.0, 0.4, -1.5])]);
        scene.lighting.shadows = true;
        scene.surfaces = surfaces;
        let options = square(16, 0);
        let path = PathOptions { most_scatterings: 1, ..PathOptions::default() };
        let marching = RenderOptions { samples_per_pixel: 64, samples_per_cell: 2.0, ..options };
        let (exact, _) = render(&scene, &marching, &|_| {});
        for engine in LAYOUTS {
            let (film, _) = traced(&scene, RenderOptions { engine, ..options }, path, 256);
            assert_alike(&film, &exact, 256, &format!("surface {number}, {engine:?}"));
        }
    }
}

#[test]
fn impossible_options_are_refused() {
    let volume = homogeneous(1);
    let scene = scene(&volume, grey(1.0, 1.0), face(), vec![sun([0.0; 3])]);
    let error = |path| PathTracer::new(&scene, &square(4, 0), &path).err().unwrap();
    for anisotropy in [1.0, -1.0, 2.0, f64::INFINITY] {
        assert_eq!(error(PathOptions { anisotropy, ..PathOptions::default() }), PathError::Anisotropy(anisotropy));
    }
    for albedo in [-0.1, 1.1] {
        assert_eq!(error(PathOptions { albedo, ..PathOptions::default() }), PathError::Albedo(albedo));
    }
    let nan = PathOptions { anisotropy: f64::NAN, ..PathOptions::default() };
    assert!(matches!(error(nan), PathError::Anisotropy(_)));
    assert!(matches!(error(PathOptions::default()), PathError::Lighting(_)));
}
