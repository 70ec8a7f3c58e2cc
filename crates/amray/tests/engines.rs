//! Both engines, and both layouts, against each other and against light summed up along single rays in double precision.

mod common;

use amray::Volume;
use amray::appearance::{PreparedTransferFunction, TransferFunction};
use amray::hierarchy::{FieldValues, Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::{Method, Sampler};
use amray::render::{Engine, Film, Integration, Layout, RenderOptions};
use amray::scene::{Camera, Projection, Viewpoint};
use amray_testing::{Random, RandomMesh, Shape, nested, nested_cubes, noise};

use common::{METHODS, extinction, front, largest, oblique, of_centers, picture, rms, volume};

const ENGINES: [Engine; 3] = [Engine::March(Layout::Padded), Engine::March(Layout::InPlace), Engine::Query];

fn smooth([x, y, z]: [f64; 3]) -> f64 {
    0.5 + 0.25 * (7.0 * x + 2.0 * z).sin() * (5.0 * y).cos() + 0.25 * (6.0 * z + 3.0 * x).sin()
}

/// What a picture is taken of, and from where.
struct Shot<'a> {
    volume: &'a Volume,
    function: TransferFunction,
    viewpoint: Viewpoint,
}

impl Shot<'_> {
    fn film(&self, options: RenderOptions) -> Film {
        picture(self.volume, self.function.clone(), self.viewpoint, options)
    }

    fn camera(&self) -> Camera {
        Camera::new(self.viewpoint).unwrap()
    }

    /// What one pixel's ray sees, in `steps` equal steps through the domain, in double precision.
    fn reference(&self, size: [usize; 2], pixel: [usize; 2], steps: usize) -> [f64; 4] {
        let ray = self.camera().ray(size, pixel.map(|place| place as f64 + 0.5));
        let [low, high] = self.volume.hierarchy().bounds();
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let crossing = |place: f64| (place - ray.start[axis]) / ray.direction[axis];
            let (a, b) = (crossing(low[axis]), crossing(high[axis]));
            // Rays along an axis cross its planes nowhere, or are in one all the time.
            if ray.direction[axis] != 0.0 {
                (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
            } else if !(low[axis]..=high[axis]).contains(&ray.start[axis]) {
                return [0.0; 4];
            }
        }
        if enter >= leave {
            return [0.0; 4];
        }
        let FieldValues::F64(bricks) = self.volume.field().values() else { unreachable!("the fields hold f64") };
        let sampler = Sampler::new(self.volume.index(), bricks, self.volume.method());
        let function: PreparedTransferFunction = self.function.prepared(0.01);
        let length = (leave - enter) / steps as f64;
        let (mut color, mut transmittance) = ([0.0; 3], 1.0);
        for step in 0..steps {
            let at = enter + (step as f64 + 0.5) * length;
            let point = std::array::from_fn(|axis| ray.start[axis] + at * ray.direction[axis]);
            let sample = function.sample(sampler.sample_world(point));
            let alpha = 1.0 - (-sample.extinction * length).exp();
            for channel in 0..3 {
                color[channel] += transmittance * alpha * f64::from(sample.color[channel]);
            }
            transmittance *= 1.0 - alpha;
        }
        [color[0], color[1], color[2], 1.0 - transmittance]
    }

    /// Holds some pixels of a picture by every engine against the reference.
    fn check(&self, what: &str, options: RenderOptions, steps: usize, tolerance: f64) {
        let [width, height] = options.size;
        let films = ENGINES.map(|engine| self.film(RenderOptions { engine, ..options }));
        for place in (0..width * height).step_by(7) {
            let expected = self.reference(options.size, [place % width, place / width], steps);
            for (film, engine) in films.iter().zip(ENGINES) {
                let found = film.pixels()[place].map(f64::from);
                let error = (0..4).map(|channel| (found[channel] - expected[channel]).abs()).fold(0.0, f64::max);
                let same = error < tolerance;
                assert!(same, "{what}, {engine:?}, pixel {place}: {found:?}, not {expected:?}");
            }
        }
    }
}

fn small(samples_per_cell: f64) -> RenderOptions {
    RenderOptions { size: [24, 24], samples_per_cell, ..RenderOptions::default() }
}

fn whole(options: RenderOptions) -> RenderOptions {
    RenderOptions { adaptive: false, ..options }
}

fn is_finite(film: &Film) -> bool {
    film.pixels().as_flattened().iter().all(|channel| channel.is_finite())
}

fn random_mesh(seed: u64, shape: Shape) -> Hierarchy {
    let mut random = Random(seed);
    RandomMesh::new(&mut random, shape).cut(&mut random)
}

/// A random mesh; every other camera is orthographic.
fn random_view(seed: u64, method: Method) -> (Volume, Viewpoint) {
    let volume = volume(random_mesh(seed, Shape::any(seed)), method, noise);
    let view = oblique(&volume);
    (volume, if seed.is_multiple_of(2) { view } else { view.orthographic() })
}

/// Where a point would be if the hierarchy filled the unit cube.
fn in_unit_cube(hierarchy: &Hierarchy, point: [f64; 3]) -> [f64; 3] {
    let [low, high] = hierarchy.bounds();
    std::array::from_fn(|axis| (point[axis] - low[axis]) / (high[axis] - low[axis]))
}

/// Whether values jump, or change within a finest cell: where between two samples they do is not known.
fn jumps(method: Method) -> bool {
    matches!(method, Method::Nearest | Method::Current | Method::Finest)
}

/// How far pictures of noise may differ whose samples lie elsewhere: in proportion to the step where values jump, else
/// to its square.
fn sampling_error(jumps: bool, samples_per_cell: f64) -> f64 {
    if jumps { 0.128 / samples_per_cell } else { 0.15 / samples_per_cell.powi(2) }
}

#[test]
fn engines_agree_on_random_meshes() {
    for seed in 0..12 {
        for method in METHODS {
            let (volume, viewpoint) = random_view(seed, method);
            let shot = Shot { volume: &volume, function: extinction(&[(0.0, 0.02), (1.0, 0.3)]), viewpoint };
            // A query's step fits the cell that it comes from; next to a hole it counts for half.
            let jumps = jumps(method) || Shape::any(seed).holes;
            for samples in [4.0, 16.0, 64.0] {
                let films = ENGINES.map(|engine| shot.film(whole(RenderOptions { engine, ..small(samples) })));
                let [layouts, engines] = [largest(&films[0], &films[1]), largest(&films[0], &films[2])];
                // Rounding may put a sample on a face into either cell.
                let rounding = if method == Method::Nearest { sampling_error(true, samples) } else { 1e-5 };
                let same = f64::from(layouts) < rounding && f64::from(engines) < sampling_error(jumps, samples);
                assert!(same, "seed {seed}, {method}, {samples} samples: layouts {layouts}, engines {engines}");
            }
        }
    }
}

#[test]
fn pictures_of_random_meshes_are_those_of_single_rays() {
    for seed in 0..8 {
        for method in METHODS {
            let (volume, viewpoint) = random_view(seed, method);
            let shot = Shot { volume: &volume, function: extinction(&[(0.0, 0.02), (1.0, 0.3)]), viewpoint };
            // At holes, and where values jump, light is off by up to half a step: with nearest on every face.
            let samples = if method == Method::Nearest { 128.0 } else { 32.0 };
            shot.check(&format!("seed {seed}, {method}"), whole(small(samples)), 1500, 4e-3);
        }
    }
}

#[test]
fn what_is_spared_is_not_seen() {
    let with_holes = random_mesh(3, Shape { base: [12, 16], holes: true, ..Shape::default() });
    for method in METHODS {
        // Bends along diagonals alone.
        let twisted = of_centers(nested(16, 3, 8), method, |[x, y, z]| (x * y + z) / 2.0);
        let nested = of_centers(nested(8, 3, 4), method, smooth);
        let holes = of_centers(with_holes.clone(), method, |point| smooth(in_unit_cube(&with_holes, point)));
        let noises = [3, 5, 6].map(|seed| random_view(seed, method));
        let mut shots = vec![
            Shot { volume: &nested, function: extinction(&[(0.5, 0.0), (1.0, 12.0)]), viewpoint: oblique(&nested) },
            // Faint enough for long steps.
            Shot { volume: &holes, function: extinction(&[(0.4, 0.05), (1.0, 0.1)]), viewpoint: oblique(&holes) },
        ];
        let function = extinction(&[(0.2, 0.0), (0.6, 40.0), (0.8, 0.0)]);
        shots.push(Shot { volume: &twisted, function, viewpoint: oblique(&twisted) });
        for (volume, viewpoint) in &noises {
            let function = extinction(&[(0.6, 0.0), (0.9, 3.0), (1.0, 0.0)]);
            shots.push(Shot { volume, function, viewpoint: *viewpoint });
        }
        for (number, shot) in shots.iter().enumerate() {
            for layout in [Layout::Padded, Layout::InPlace] {
                // Pixels are smaller than cells.
                let options = RenderOptions { engine: Engine::March(layout), size: [64, 64], ..small(4.0) };
                let error = rms(&shot.film(options), &shot.film(whole(options)));
                assert!(error < 1e-3, "{method}, {layout:?}, shot {number}: {error}");
            }
        }
    }
}

#[test]
fn steps_of_a_pixel_converge() {
    // Where pixels are larger than cells, steps are as long as pixels.
    for method in METHODS {
        let (volume, viewpoint) = random_view(5, method);
        let function = extinction(&[(0.6, 0.0), (0.9, 3.0), (1.0, 0.0)]);
        let shot = Shot { volume: &volume, function, viewpoint };
        for samples in [4.0, 16.0, 64.0] {
            let error = rms(&shot.film(small(samples)), &shot.film(whole(small(samples))));
            assert!(error > 0.0 && error < sampling_error(jumps(method), samples), "{method}, {samples}: {error}");
        }
    }
}

#[test]
fn homogeneous_cubes_are_exact() {
    let volume = of_centers(nested(8, 3, 4), Method::Basis, |_| 0.5);
    let projection = Projection::Orthographic { height: 1.0 };
    let shot = Shot { volume: &volume, function: extinction(&[(0.5, 2.5)]), viewpoint: front(projection) };
    let expected = 1.0 - (-2.5f32).exp();
    for engine in ENGINES {
        for samples_per_cell in [0.01, 0.3, 1.0, 3.7, 1000.0] {
            // Odd sizes: packets and tiles stick out.
            let options = RenderOptions { size: [3, 35], samples_per_cell, engine, ..RenderOptions::default() };
            for &[red, _, blue, alpha] in shot.film(options).pixels() {
                assert!((alpha - expected).abs() < 1e-5, "{engine:?}, {samples_per_cell}: {alpha}");
                assert!((red - 0.5 * expected).abs() < 1e-5 && (blue - 0.5 * expected).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn eyes_inside_and_on_the_faces_of_bricks() {
    let volume = of_centers(nested(8, 3, 4), Method::Basis, smooth);
    let perspective = Projection::Perspective { fovy: 60.0 };
    for eye in [[0.5; 3], [0.5, 0.5, 0.75], [0.41, 0.63, 0.52], [0.5, 0.0, 0.5], [0.5, 0.5, 4.0], [0.25, 0.5, 1.0]] {
        for target in [[0.5, 0.5, -1.0], [0.1, 0.2, -1.0]] {
            let viewpoint = Viewpoint { eye, target, ..front(perspective) };
            let shot = Shot { volume: &volume, function: extinction(&[(0.2, 0.0), (1.0, 9.0)]), viewpoint };
            shot.check(&format!("from {eye:?} to {target:?}"), whole(small(8.0)), 3000, 1e-3);
        }
    }
}

#[test]
fn rays_along_axes_and_in_planes_between_bricks() {
    let volume = of_centers(nested(8, 3, 4), Method::Basis, smooth);
    // 14 pixels over 14 of 16 cells, shifted by half a pixel: every ray lies in planes between cells, some in brick faces.
    let projection = Projection::Orthographic { height: 0.875 };
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            for shift in [0.0, 1.0 / 32.0] {
                let (mut eye, mut up) = ([0.5 + shift; 3], [0.0; 3]);
                let mut target = eye;
                eye[axis] = 0.5 + 2.0 * sign;
                target[axis] = 0.5;
                up[(axis + 1) % 3] = 1.0;
                let viewpoint = Viewpoint { eye, target, up, projection };
                let shot = Shot { volume: &volume, function: extinction(&[(0.2, 0.0), (1.0, 9.0)]), viewpoint };
                let options = RenderOptions { size: [14, 14], ..whole(small(8.0)) };
                shot.check(&format!("along {axis}, {sign}, {shift}"), options, 3000, 2e-3);
            }
        }
    }
}

#[test]
fn holes_and_not_a_number_are_empty() {
    let level = LevelDescription {
        ratio: [1; 3],
        cell_size: [0.125; 3],
        domain: IndexBox::new([0; 3], [8; 3]),
        bricks: vec![IndexBox::new([0, 0, 6], [8; 3]), IndexBox::new([0; 3], [8, 8, 2])],
    };
    let hole = of_centers(Hierarchy::new([0.0; 3], vec![level]).unwrap(), Method::Basis, |_| 0.5);
    let gap = of_centers(
        nested(8, 1, 4),
        Method::Nearest,
        |[_, _, z]| {
            if (0.25..0.75).contains(&z) { f64::NAN } else { 0.5 }
        },
    );
    let viewpoint = front(Projection::Orthographic { height: 1.0 });
    let expected = 1.0 - (-1.0f32).exp();
    for (volume, tolerance) in [(&hole, 1e-5), (&gap, 2e-3)] {
        let shot = Shot { volume, function: extinction(&[(0.5, 2.0)]), viewpoint };
        for engine in ENGINES {
            let film = shot.film(RenderOptions { engine, ..small(64.0) });
            let [.., alpha] = film.pixels()[77];
            assert!((alpha - expected).abs() < tolerance, "{engine:?}: {alpha}, not {expected}");
        }
    }
    let speckled = volume(nested(8, 3, 4), Method::Basis, |level, cell| {
        let value = noise(level, cell);
        if value < 0.05 { f64::NAN } else { value }
    });
    let function = extinction(&[(0.0, 1.0), (1.0, 5.0)]);
    let shot = Shot { volume: &speckled, function, viewpoint: oblique(&speckled) };
    shot.check("speckled", whole(small(32.0)), 3000, 0.02);
}

#[test]
fn thin_shells_keep_their_opacity() {
    let distance = |[x, y, z]: [f64; 3]| ((x - 0.5f64).powi(2) + (y - 0.5).powi(2) + (z - 0.5).powi(2)).sqrt();
    let volume = of_centers(nested(16, 2, 8), Method::Basis, distance);
    // A shell a tenth of a cell thick.
    let function = extinction(&[(0.37, 0.0), (0.373, 150.0), (0.376, 0.0)]);
    let shot = Shot { volume: &volume, function, viewpoint: oblique(&volume) };
    let mean = |integration, engine, samples_per_cell| {
        let size = [48, 48];
        let film = shot.film(RenderOptions { size, integration, engine, samples_per_cell, ..RenderOptions::default() });
        film.pixels().iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / film.pixels().len() as f64
    };
    for engine in ENGINES {
        let exact = mean(Integration::Preintegrated, engine, 32.0);
        let coarse = mean(Integration::Preintegrated, engine, 1.0);
        assert!((coarse - exact).abs() < 0.01 * exact, "{engine:?}: {coarse}, not {exact}");
        let missed = mean(Integration::AtSamples, engine, 1.0);
        assert!((missed - exact).abs() > 0.05 * exact, "{engine:?}: {missed} beside {exact}");
    }
}

#[test]
fn threads_tiles_and_sizes_do_not_matter() {
    let volume = of_centers(nested(8, 3, 4), Method::Basis, smooth);
    let shot = Shot { volume: &volume, function: extinction(&[(0.3, 0.0), (1.0, 12.0)]), viewpoint: oblique(&volume) };
    for engine in ENGINES {
        for size in [[1, 1], [33, 5], [3, 67], [66, 34]] {
            let options = RenderOptions { size, engine, ..RenderOptions::default() };
            let films = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| shot.film(options))
            });
            assert_eq!(films[0], films[1], "{engine:?}, {size:?}");
            assert!(is_finite(&films[0]));
        }
    }
    // Packets do not know of each other: the middle of a wide picture is a narrower one.
    for engine in ENGINES {
        let film = |width| shot.film(RenderOptions { size: [width, 20], engine, ..whole(small(8.0)) });
        let (wide, narrow) = (film(41), film(35));
        for (row, line) in narrow.pixels().chunks(35).enumerate() {
            for (column, pixel) in line.iter().enumerate() {
                let other = wide.pixels()[row * 41 + column + 3];
                assert!((0..4).all(|channel| (pixel[channel] - other[channel]).abs() < 2e-3), "{engine:?}");
            }
        }
    }
}

#[test]
fn steps_of_any_length_end() {
    let (random, viewpoint) = random_view(8, Method::Basis);
    let cubes = volume(nested_cubes(20), Method::Basis, noise);
    let shots = [
        Shot { volume: &random, function: extinction(&[(0.0, 0.02), (1.0, 0.3)]), viewpoint },
        Shot { volume: &cubes, function: extinction(&[(0.0, 0.2), (1.0, 3.0)]), viewpoint: oblique(&cubes) },
    ];
    for shot in shots {
        for engine in ENGINES {
            for samples_per_cell in [0.01, 1000.0] {
                let size = [5, 5];
                let film = shot.film(RenderOptions { size, engine, ..small(samples_per_cell) });
                assert!(is_finite(&film) && film.pixels()[12][3] > 0.1, "{engine:?}, {samples_per_cell}");
            }
        }
    }
}

#[test]
fn far_eyes_see_as_sharply_as_near_ones() {
    let volume = of_centers(nested(8, 3, 4), Method::Basis, smooth);
    let function = || extinction(&[(0.2, 0.0), (1.0, 9.0)]);
    for distance in [10.0, 1e3, 1e6] {
        let fovy = 2.0 * (0.9f64 / distance).atan().to_degrees();
        for projection in [Projection::Perspective { fovy }, Projection::Orthographic { height: 1.8 }] {
            let eye = [0.5 + 0.6 * distance, 0.5 - 0.5 * distance, 0.5 + 0.62 * distance];
            let viewpoint = Viewpoint { eye, target: [0.5; 3], up: [0.0, 1.0, 0.0], projection };
            let shot = Shot { volume: &volume, function: function(), viewpoint };
            shot.check(&format!("from {distance}, {projection:?}"), whole(small(8.0)), 3000, 1e-3);
        }
    }
}
