//! What is cut away from a picture, whatever is in it, and pictures all around.

mod common;

use amray::Volume;
use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::reconstruction::Method;
use amray::render::{Engine, Film, Layout, PathOptions, PathTracer, RenderOptions, render};
use amray::scene::{Camera, CameraRay, Clip, Light, Lighting, Paint, Projection, Scene, Shading, Surface, Viewpoint};
use amray_mesh::{Mesh, MeshDescription};
use amray_testing::{Random, nested};

use common::{extinction, front, oblique, of_centers};

/// How much of a uniform volume is seen where nothing is cut away, per unit of length.
const EXTINCTION: f64 = 1.5;

fn is_left(clips: &[Clip], point: [f64; 3]) -> bool {
    let is_in = |[low, high]: [[f64; 3]; 2]| (0..3).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis]);
    clips.iter().all(|clip| match *clip {
        Clip::Plane { point: on, normal } => {
            (0..3).map(|axis| normal[axis] * (point[axis] - on[axis])).sum::<f64>() >= 0.0
        }
        Clip::Inside(corners) => is_in(corners),
        Clip::Outside(corners) => !is_in(corners),
    })
}

/// A few clips of any kind that reach into the unit cube.
fn random_clips(random: &mut Random) -> Vec<Clip> {
    let cube = [[0.0; 3], [1.0; 3]];
    let corners = |random: &mut Random| {
        let (a, b) = (random.point([[-0.2; 3], [0.6; 3]]), random.point([[0.1; 3], [0.8; 3]]));
        [a, [a[0] + b[0], a[1] + b[1], a[2] + b[2]]]
    };
    (0..random.integer(1, 5))
        .map(|_| match random.integer(0, 6) {
            0 => Clip::Plane { point: random.point(cube), normal: random.point([[-1.0; 3], [1.0; 3]]) },
            1 => Clip::Plane { point: random.point(cube), normal: [0.0, -2.0, 0.0] },
            2 => {
                let [low, high] = corners(random);
                Clip::Inside([low, high.map(|place| place + 0.3)])
            }
            _ => Clip::Outside(corners(random)),
        })
        .collect()
}

/// The cube from 0 to 1 in three levels.
fn cube(method: Method, function: impl Fn([f64; 3]) -> f64) -> Volume {
    let hierarchy = nested(8, 3, 4);
    let [low, high] = hierarchy.bounds();
    assert_eq!((low, high), ([0.0; 3], [1.0; 3]));
    of_centers(hierarchy, method, function)
}

const SIZE: usize = 24;

fn options(engine: Engine) -> RenderOptions {
    RenderOptions { size: [SIZE; 2], engine, ..RenderOptions::default() }
}

fn picture(scene: &Scene, engine: Engine) -> Film {
    render(scene, &options(engine), &|_| {}).0
}

const ENGINES: [Engine; 3] = [Engine::March(Layout::Padded), Engine::March(Layout::InPlace), Engine::Query];

/// The length of a ray inside of the cube that is left, from many points.
fn length_left(clips: &[Clip], CameraRay { start, direction }: CameraRay) -> f64 {
    const STEPS: usize = 20_000;
    let length = 10.0 / STEPS as f64;
    let at = |step: usize| -> [f64; 3] {
        std::array::from_fn(|axis| start[axis] + direction[axis] * (step as f64 + 0.5) * length)
    };
    let is_seen = |point: [f64; 3]| point.iter().all(|place| (0.0..1.0).contains(place)) && is_left(clips, point);
    (0..STEPS).filter(|&step| is_seen(at(step))).count() as f64 * length
}

fn viewpoints(volume: &Volume) -> [Viewpoint; 3] {
    let inside = Viewpoint { eye: [0.4, 0.45, 0.5], projection: Projection::Panorama, ..oblique(volume) };
    [oblique(volume), oblique(volume).orthographic(), inside]
}

#[test]
fn rays_go_through_what_is_left() {
    let volume = cube(Method::Basis, |_| 0.5);
    let function = extinction(&[(0.0, EXTINCTION), (1.0, EXTINCTION)]);
    let mut random = Random(5);
    for number in 0..12 {
        let clips = random_clips(&mut random);
        for viewpoint in viewpoints(&volume) {
            let camera = Camera::new(viewpoint).unwrap();
            let scene = Scene { clips: clips.clone(), ..Scene::new(&volume, function.clone(), 0.01, camera) };
            let films = ENGINES.map(|engine| picture(&scene, engine));
            for y in 0..SIZE {
                for x in 0..SIZE {
                    let length = length_left(&clips, camera.ray([SIZE; 2], [x as f64 + 0.5, y as f64 + 0.5]));
                    let expected = 1.0 - (-EXTINCTION * length).exp();
                    for (film, engine) in films.iter().zip(ENGINES) {
                        let found = f64::from(film.pixels()[y * SIZE + x][3]);
                        // Each end of a part is found to half a step.
                        let near = (found - expected).abs() < 5e-3;
                        assert!(near, "{number}, {engine:?}, {x}, {y}: {found}, not {expected}; {clips:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn paths_go_through_what_is_left() {
    let volume = cube(Method::Basis, |_| 0.5);
    let function = extinction(&[(0.0, EXTINCTION), (1.0, EXTINCTION)]);
    let clips = vec![
        Clip::Outside([[0.2, 0.2, 0.5], [0.9, 0.9, 0.8]]),
        Clip::Plane { point: [0.5; 3], normal: [1.0, 0.5, 0.25] },
    ];
    let camera = Camera::new(oblique(&volume)).unwrap();
    let scene = Scene { clips, ..Scene::new(&volume, function, 0.01, camera) };
    let marched = picture(&scene, ENGINES[0]);
    let mut tracer = PathTracer::new(&scene, &options(ENGINES[0]), &PathOptions::default()).unwrap();
    tracer.accumulate(256, &|_| {});
    let mean = |film: &Film| film.pixels().iter().map(|pixel| f64::from(pixel[3])).sum::<f64>() / (SIZE * SIZE) as f64;
    let (expected, found) = (mean(&marched), mean(&tracer.film()));
    // 576 pixels of 256 paths, each there or not: 1.3e-3 is one standard error at the most; and pixels are points here,
    // areas there.
    assert!((found - expected).abs() < 5e-3 && expected > 0.1, "{found}, not {expected}");
}

const CENTER: [f64; 3] = [0.5; 3];
const RADIUS: f64 = 0.4;

/// Where a ray meets a sphere, not where it only grazes it: there what cells make of it may be missed.
fn on_sphere(CameraRay { start, direction }: CameraRay) -> Option<[[f64; 3]; 2]> {
    let from: [f64; 3] = std::array::from_fn(|axis| start[axis] - CENTER[axis]);
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| a[axis] * b[axis]).sum::<f64>();
    let middle = -dot(from, direction);
    let square = RADIUS * RADIUS - dot(from, from) + middle * middle;
    let half = (square > 0.02).then(|| square.sqrt())?;
    Some([middle - half, middle + half].map(|t| std::array::from_fn(|axis| start[axis] + t * direction[axis])))
}

#[test]
fn isosurfaces_and_slices_are_cut() {
    let volume = cube(Method::Prolong, |point| {
        (0..3).map(|axis| (point[axis] - CENTER[axis]).powi(2)).sum::<f64>().sqrt() - RADIUS
    });
    let camera = Camera::new(oblique(&volume)).unwrap();
    let slice = |point, normal| Surface::slice(point, normal, Paint::Plain([1.0; 3]));
    let sphere = Surface::isosurface(0.0, Paint::Plain([1.0; 3]));
    let mut random = Random(11);
    let mut counts = [0; 2];
    for _ in 0..24 {
        let clips = random_clips(&mut random);
        let (point, normal) = (random.point([[0.3; 3], [0.7; 3]]), random.point([[-1.0; 3], [1.0; 3]]));
        for (kind, surface) in [sphere.clone(), slice(point, normal)].into_iter().enumerate() {
            let scene = Scene::new(&volume, extinction(&[(0.0, 0.0)]), 0.01, camera);
            let film = picture(
                &Scene { clips: clips.clone(), surfaces: vec![surface], ..scene },
                ENGINES[random.integer(0, 1) as usize],
            );
            for y in 0..SIZE {
                for x in 0..SIZE {
                    let ray = camera.ray([SIZE; 2], [x as f64 + 0.5, y as f64 + 0.5]);
                    let places = if kind == 0 {
                        let Some(places) = on_sphere(ray) else { continue };
                        places.to_vec()
                    } else {
                        let along = |vector: [f64; 3]| (0..3).map(|axis| normal[axis] * vector[axis]).sum::<f64>();
                        let t = (along(point) - along(ray.start)) / along(ray.direction);
                        let place = std::array::from_fn(|axis| ray.start[axis] + t * ray.direction[axis]);
                        if !place.iter().all(|part: &f64| (0.0..1.0).contains(part)) {
                            continue;
                        }
                        vec![place]
                    };
                    // Whether a place is left must not be near to change: cells are no spheres, to 0.02.
                    let near =
                        |place: [f64; 3], shift: [f64; 3]| std::array::from_fn(|axis| place[axis] + 0.02 * shift[axis]);
                    let shifts = (0..27).map(|shift| [shift % 3 - 1, shift / 3 % 3 - 1, shift / 9 - 1].map(f64::from));
                    let is_clear = |place: [f64; 3]| {
                        let left = is_left(&clips, place);
                        shifts.clone().all(|shift| is_left(&clips, near(place, shift)) == left)
                    };
                    if !places.iter().all(|place| is_clear(*place)) {
                        continue;
                    }
                    let expected = places.iter().any(|place| is_left(&clips, *place));
                    let found = film.pixels()[y * SIZE + x][3];
                    assert_eq!(found > 0.5, expected, "kind {kind} at {x}, {y}: {found}; {clips:?}");
                    counts[usize::from(expected)] += 1;
                }
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 500), "{counts:?}");
}

#[test]
fn what_is_cut_away_throws_no_shadow() {
    let volume = cube(Method::Basis, |_| 0.5);
    let corner = |x: f64, y: f64| [x, y, -0.5];
    let vertices = vec![corner(-2.0, -2.0), corner(3.0, -2.0), corner(3.0, 3.0), corner(-2.0, 3.0)];
    let floor =
        Mesh::new(MeshDescription { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Default::default() }).unwrap();
    let lights = vec![Light::Directional { direction: [0.0, 0.0, -1.0], color: [1.0; 3] }];
    let lighting = Lighting { lights, shading: Shading::Isotropic, shadows: true, ambient_occlusion: None };
    let camera = Camera::new(front(Projection::Orthographic { height: 1.0 })).unwrap();
    let lit = |clips: Vec<Clip>| {
        let surfaces = vec![Surface::mesh(&floor)];
        let colors = vec![ColorPoint { value: 0.0, color: [0.0; 3] }];
        let points = vec![OpacityPoint { value: 0.0, opacity: 30.0 }];
        let function = TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points)).unwrap();
        let scene =
            Scene { clips, surfaces, lighting: lighting.clone(), ..Scene::new(&volume, function, 0.01, camera) };
        picture(&scene, ENGINES[0]).pixels()[SIZE / 2 * SIZE + SIZE / 4][0]
    };
    let (nothing, half) = ([[0.0; 3], [0.0, 1.0, 1.0]], [[-1.0, -1.0, -1.0], [0.5, 2.0, 2.0]]);
    let open = lit(vec![Clip::Inside(nothing)]);
    // The half that is looked at is cut away; the light comes straight down.
    assert!((lit(vec![Clip::Outside(half)]) - open).abs() < 1e-5 && open > 0.5, "{open}");
    // A black lid above the hole is left.
    let hole = [[-1.0; 3], [0.5, 2.0, 0.8]];
    assert!(lit(vec![Clip::Outside(hole)]) < 0.01);
}
