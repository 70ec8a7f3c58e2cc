//! Lights: what volumes in their light must look like, where that is known in closed form.

mod common;

use amray::Volume;
use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::reconstruction::Method;
use amray::render::{Engine, Film, Layout, RenderOptions, render};
use amray::scene::{AmbientOcclusion, Camera, Light, Lighting, Material, Projection, Scene, Shading, Viewpoint};
use amray_testing::{Random, RandomMesh, Shape, nested};

use common::{METHODS, extinction, front, largest, oblique, of_centers, picture, rms, volume};

/// Red of the colours in the middle of the range, and blue.
const HALF: f32 = 0.5;

fn lit(volume: &Volume, function: TransferFunction, viewpoint: Viewpoint, lighting: Lighting) -> Film {
    lit_with(volume, function, viewpoint, lighting, RenderOptions { size: [9, 9], ..RenderOptions::default() })
}

fn lit_with(
    volume: &Volume,
    function: TransferFunction,
    viewpoint: Viewpoint,
    lighting: Lighting,
    options: RenderOptions,
) -> Film {
    lighting.check().unwrap();
    let scene = Scene { lighting, ..Scene::new(volume, function, 0.01, Camera::new(viewpoint).unwrap()) };
    render(&scene, &options, &|_| {}).0
}

fn face() -> Viewpoint {
    front(Projection::Orthographic { height: 1.0 })
}

/// The picture's middle.
fn middle(film: &Film) -> [f32; 4] {
    film.pixels()[film.pixels().len() / 2]
}

fn shadowed(light: Light) -> Lighting {
    Lighting { lights: vec![light], shading: Shading::Isotropic, shadows: true, ambient_occlusion: None }
}

fn sun(direction: [f64; 3]) -> Light {
    Light::Directional { direction, color: [1.0; 3] }
}

/// A cube with the same value everywhere.
fn homogeneous(levels: usize) -> Volume {
    of_centers(nested(16, levels, 8), Method::Basis, |_| 0.5)
}

/// The integral of `light(t) sigma exp(-sigma t)` over the depth of the unit cube, by many midpoints.
fn collected(sigma: f64, light: impl Fn(f64) -> f64) -> f64 {
    let count = 20_000;
    let depth = |place: usize| (place as f64 + 0.5) / f64::from(count);
    (0..count as usize).map(depth).map(|t| light(t) * sigma * (-sigma * t).exp() / f64::from(count)).sum()
}

#[test]
fn all_light_from_everywhere_is_as_if_volumes_glowed() {
    let volume = of_centers(nested(16, 3, 8), Method::Basis, |[x, y, z]| x * y + 0.3 * z);
    let function = || extinction(&[(0.0, 0.0), (1.0, 20.0)]);
    let glowing = lit(&volume, function(), oblique(&volume), Lighting::default());
    let ambient = Lighting { shading: Shading::Isotropic, ..Lighting::default() };
    let film = lit(&volume, function(), oblique(&volume), ambient);
    assert!(largest(&glowing, &film) < 1e-5, "{}", largest(&glowing, &film));
}

#[test]
fn a_homogeneous_cube_dims_the_light_that_goes_through_it() {
    for levels in [1, 3] {
        let volume = homogeneous(levels);
        for sigma in [1.0, 5.0] {
            let film = |direction| lit(&volume, extinction(&[(0.5, sigma)]), face(), shadowed(sun(direction)));
            // Along the view, against it, and across it: the ray through the middle is half a cube away from the side.
            // The length to the light at depth t is the first number and t times the second one.
            let cases = [([0.0, 0.0, -1.0], [0.0, 1.0]), ([0.0, 0.0, 1.0], [1.0, -1.0]), ([1.0, 0.0, 0.0], [0.5, 0.0])];
            for (direction, [length, slope]) in cases {
                let expected = HALF * collected(sigma, |t| (-sigma * (length + slope * t)).exp()) as f32;
                let [red, _, blue, alpha] = middle(&film(direction));
                // Light is interpolated between points with up to a quarter of optical depth between them.
                let error = (red / expected - 1.0).abs();
                assert!(error < 0.01, "{levels} levels, {sigma}, {direction:?}: {red} and not {expected}");
                assert!((blue - red).abs() < 1e-5 && (alpha - (1.0 - (-sigma as f32).exp())).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn a_point_light_inside_is_dimmed_and_falls_off() {
    let (sigma, reach) = (2.0, 0.1);
    let volume = homogeneous(2);
    let position = [0.5, 0.5, 0.3];
    for light_reach in [None, Some(reach)] {
        let light = Light::Point { position, color: [1.0; 3], reach: light_reach };
        // The light falls off steeply along the steps beside it.
        let samples_per_cell = if light_reach.is_some() { 4.0 } else { 1.0 };
        let options = RenderOptions { size: [9, 9], samples_per_cell, ..RenderOptions::default() };
        let film = lit_with(&volume, extinction(&[(0.5, sigma)]), face(), shadowed(light), options);
        let expected = HALF
            * collected(sigma, |t| {
                let distance = (1.0 - t - position[2]).abs();
                let falloff = light_reach.map_or(1.0, |reach| (reach * reach / (distance * distance)).min(1.0));
                falloff * (-sigma * distance).exp()
            }) as f32;
        let [red, ..] = middle(&film);
        assert!((red / expected - 1.0).abs() < 0.02, "{light_reach:?}: {red} and not {expected}");
    }
}

#[test]
fn near_matter_keeps_ambient_light_away() {
    let (sigma, distance) = (4.0, 0.05);
    let volume = homogeneous(2);
    for rays in [4, 16] {
        let lighting = Lighting {
            lights: vec![Light::Ambient { color: [1.0; 3] }],
            shading: Shading::Isotropic,
            shadows: false,
            ambient_occlusion: Some(AmbientOcclusion { rays, distance }),
        };
        let film = lit(&volume, extinction(&[(0.5, sigma)]), face(), lighting);
        let whole = collected(sigma, |_| 1.0);
        // Less is missing within the distance of the face that is seen.
        let bounds =
            [(-sigma * distance).exp(), (-sigma * distance * 0.85).exp()].map(|share| (share * whole) as f32 * HALF);
        let [red, ..] = middle(&film);
        assert!(bounds[0] < red && red < bounds[1], "{rays} rays: {red} outside of {bounds:?}");
    }
}

#[test]
fn a_slope_reflects_like_a_surface() {
    // The gradient leans by 60 degrees: away from the eye, which looks down z.
    let (sine, cosine) = (0.75f64.sqrt(), 0.5);
    let volume = of_centers(nested(16, 2, 8), Method::Prolong, |[x, _, z]| 0.4 * (x * sine + z * cosine));
    let material = Material { specular: 0.0, ..Material::default() };
    let function = || {
        let points = [(0.2, 0.0), (0.25, 9.0), (0.33, 0.0)].map(|(value, opacity)| OpacityPoint { value, opacity });
        let colors = vec![ColorPoint { value: 0.0, color: [1.0; 3] }];
        TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points.into())).unwrap()
    };
    let film = |light, shading| {
        let lighting = Lighting { lights: vec![light], shading, ..Lighting::default() };
        middle(&lit(&volume, function(), face(), lighting))
    };
    let whole = film(Light::Headlight { color: [1.0; 3] }, Shading::Isotropic)[0];
    let shading = Shading::Gradient(material);
    // In units of the range the gradient is about 1 over the domain: nearly all of a surface.
    let range = volume.leaf_range().unwrap();
    let slope = 0.4 / (range[1] - range[0]);
    let strength = slope * slope / (slope * slope + 0.0625);
    let expect = |film: [f32; 4], cosine: f64| {
        let expected = whole * (1.0 - strength + strength * cosine) as f32;
        assert!((film[0] - expected).abs() < 0.01, "{film:?} and not {expected}");
    };
    expect(film(Light::Headlight { color: [1.0; 3] }, shading), cosine);
    expect(film(sun([-sine, 0.0, -cosine]), shading), 1.0);
    // From the back of the slope, which the eye does not see.
    expect(film(sun([sine, 0.0, cosine]), shading), 0.0);
    expect(film(sun([0.0, 1.0, 0.0]), shading), 0.0);
    // Ambient light does not know where surfaces face.
    expect(film(Light::Ambient { color: [1.0; 3] }, shading), 1.0);
    // Seen from below, the other side reflects.
    let below = Viewpoint { eye: [0.5, 0.5, -4.0], ..face() };
    let lighting = Lighting { lights: vec![sun([sine, 0.0, cosine])], shading, ..Lighting::default() };
    expect(middle(&lit(&volume, function(), below, lighting)), 1.0);
}

#[test]
fn highlights_have_the_light_s_colour() {
    let volume = of_centers(nested(16, 2, 8), Method::Basis, |[_, _, z]| z);
    let film = |specular| {
        let shading = Shading::Gradient(Material { specular, ..Material::default() });
        let lights = vec![Light::Headlight { color: [0.0, 1.0, 0.0] }];
        let function = extinction(&[(0.3, 0.0), (0.35, 9.0), (0.7, 0.0)]);
        middle(&lit(&volume, function, face(), Lighting { lights, shading, ..Lighting::default() }))
    };
    let (matt, shiny) = (film(0.0), film(0.5));
    assert!((shiny[1] - matt[1] - 0.5 * shiny[3] * 0.94).abs() < 0.02, "{matt:?} {shiny:?}");
    assert_eq!([shiny[0], shiny[2]], [matt[0], matt[2]]);
}

#[test]
fn what_is_opaque_throws_a_shadow() {
    // A dense ball above a dense floor, the sun above them.
    let ball = |[x, y, z]: [f64; 3]| {
        let radius = ((x - 0.5).powi(2) + (y - 0.7).powi(2) + (z - 0.5).powi(2)).sqrt();
        if radius < 0.15 || y < 0.2 { 1.0 } else { 0.0 }
    };
    let volume = of_centers(nested(32, 2, 8), Method::Basis, ball);
    let function = extinction(&[(0.5, 0.0), (0.6, 400.0)]);
    let view =
        Viewpoint { eye: [0.5, 3.0, 2.0], target: [0.5, 0.2, 0.5], ..front(Projection::Perspective { fovy: 30.0 }) };
    let options = RenderOptions { size: [64, 64], ..RenderOptions::default() };
    let film = |shadows| {
        let lighting = Lighting { shadows, ..shadowed(sun([0.0, -1.0, 0.0])) };
        lit_with(&volume, function.clone(), view, lighting, options)
    };
    let (dark, bright) = (film(true), film(false));
    let camera = Camera::new(view).unwrap();
    // Where pixels see the floor, by whether the ball is above.
    let mut counts = [0; 2];
    for (place, (dark, bright)) in dark.pixels().iter().zip(bright.pixels()).enumerate() {
        let ray = camera.ray(options.size, [(place % 64) as f64 + 0.5, (place / 64) as f64 + 0.5]);
        let t = (0.2 - ray.start[1]) / ray.direction[1];
        let [x, z] = [0, 2].map(|axis| ray.start[axis] + t * ray.direction[axis]);
        let from_axis = ((x - 0.5).powi(2) + (z - 0.5).powi(2)).sqrt();
        let passes_ball = {
            let to_center = [0.5 - ray.start[0], 0.7 - ray.start[1], 0.5 - ray.start[2]];
            let along: f64 = (0..3).map(|axis| to_center[axis] * ray.direction[axis]).sum();
            let square: f64 = to_center.iter().map(|part| part * part).sum::<f64>() - along * along;
            square.sqrt() < 0.2
        };
        if t < 0.0 || passes_ball || !(0.05..0.95).contains(&x) || !(0.05..0.95).contains(&z) {
            continue;
        }
        let share = dark[2] / bright[2];
        if from_axis < 0.1 {
            assert!(share < 0.05, "under the ball {share}");
            counts[0] += 1;
        } else if from_axis > 0.25 {
            assert!(share > 0.9, "beside the ball {share}");
            counts[1] += 1;
        }
    }
    assert!(counts[0] > 10 && counts[1] > 100, "{counts:?}");
}

/// All lights, all that they do.
fn everything() -> Lighting {
    Lighting {
        lights: vec![
            Light::Ambient { color: [0.3; 3] },
            Light::Headlight { color: [0.2; 3] },
            sun([0.3, -0.5, -1.0]),
            Light::Point { position: [0.4, 0.6, 0.5], color: [0.5; 3], reach: Some(0.2) },
        ],
        shading: Shading::Gradient(Material::default()),
        shadows: true,
        ambient_occlusion: Some(AmbientOcclusion { rays: 5, distance: 0.2 }),
    }
}

#[test]
fn every_method_and_layout_is_lit_on_any_mesh() {
    let functions = || extinction(&[(0.2, 0.0), (0.6, 30.0), (0.7, 2.0)]);
    for seed in 0..6 {
        let mut random = Random(seed);
        let hierarchy = RandomMesh::new(&mut random, Shape::any(seed)).cut(&mut random);
        let values = |level: usize, cell: [i64; 3]| match amray_testing::noise(level, cell) {
            value if value > 0.98 => f64::NAN,
            value => value,
        };
        for method in METHODS {
            let volume = volume(hierarchy.clone(), method, values);
            let view = oblique(&volume);
            // Inside, too.
            let [low, high] = volume.hierarchy().bounds();
            let eye = std::array::from_fn(|axis| 0.4 * low[axis] + 0.6 * high[axis]);
            let inside = Viewpoint { eye, target: low, ..view };
            for viewpoint in [view, inside] {
                let film = |layout, lighting| {
                    let options =
                        RenderOptions { size: [16, 16], engine: Engine::March(layout), ..RenderOptions::default() };
                    lit_with(&volume, functions(), viewpoint, lighting, options)
                };
                let [padded, in_place] = [Layout::Padded, Layout::InPlace].map(|layout| film(layout, everything()));
                let open = Lighting { shadows: false, ambient_occlusion: None, ..everything() };
                let open = film(Layout::Padded, open);
                for (lit, open) in padded.pixels().iter().zip(open.pixels()) {
                    assert!(lit.iter().all(|channel| channel.is_finite() && *channel >= 0.0));
                    assert_eq!(lit[3], open[3], "seed {seed}, {method}: light changes no opacity");
                    assert!((0..3).all(|channel| lit[channel] <= open[channel] + 1e-5), "{lit:?} {open:?}");
                }
                assert!(in_place.pixels().as_flattened().iter().all(|channel| channel.is_finite()));
            }
        }
    }
}

#[test]
fn threads_do_not_change_what_is_lit() {
    let volume = of_centers(nested(16, 3, 8), Method::Basis, |[x, y, z]| (9.0 * x).sin() * (7.0 * y).cos() + z);
    let film = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let options = RenderOptions { size: [96, 96], ..RenderOptions::default() };
            let function = extinction(&[(0.2, 0.0), (0.6, 30.0)]);
            lit_with(&volume, function, oblique(&volume), everything(), options)
        })
    };
    assert_eq!(film(1), film(4));
}

#[test]
fn light_converges_with_the_samples() {
    let volume = of_centers(nested(32, 2, 8), Method::Basis, |[x, y, z]| (9.0 * x).sin() * (7.0 * y).cos() + z);
    let film = |samples_per_cell| {
        let options = RenderOptions { size: [48, 48], samples_per_cell, ..RenderOptions::default() };
        lit_with(&volume, extinction(&[(0.2, 0.0), (0.6, 10.0)]), oblique(&volume), everything(), options)
    };
    let [one, two, eight] = [1.0, 2.0, 8.0].map(film);
    let errors = [rms(&one, &eight), rms(&two, &eight)];
    assert!(errors[1] < errors[0] && errors[0] < 0.01, "{errors:?}");
}

#[test]
fn an_empty_picture_stays_empty() {
    let volume = of_centers(nested(8, 2, 4), Method::Basis, |[x, ..]| x);
    let film = lit(&volume, extinction(&[(0.0, 0.0)]), oblique(&volume), everything());
    assert!(film.pixels().iter().all(|pixel| *pixel == [0.0; 4]));
    let hidden = picture(
        &volume,
        extinction(&[(0.0, 0.0)]),
        oblique(&volume),
        RenderOptions { size: [9, 9], ..RenderOptions::default() },
    );
    assert_eq!(film, hidden);
}
