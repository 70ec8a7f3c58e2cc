//! Several fields seen together: against sums along rays, and against one field where both must be the same.

mod common;

use amray::Volume;
use amray::appearance::{PreparedTransferFunction, TransferFunction};
use amray::hierarchy::Field;
use amray::reconstruction::Method;
use amray::render::{Engine, Film, Layout, PathError, PathOptions, PathTracer, RenderOptions, render};
use amray::scene::{
    AmbientOcclusion, Camera, CameraRay, Light, Lighting, MOST_FIELDS, Material, Scene, Shading, ShownField,
};
use amray_testing::{Random, RandomMesh, Shape, nested};

use common::{METHODS, extinction, largest, oblique, of_centers};

const SIZE: usize = 16;
const LAYOUTS: [Layout; 2] = [Layout::Padded, Layout::InPlace];

/// Another field of the same mesh, from its values at cell centres or nodes.
fn beside(volume: &Volume, function: impl Fn([f64; 3]) -> f64) -> Volume {
    let hierarchy = volume.hierarchy();
    let centering = volume.field().centering();
    let value =
        |level, cell: [i64; 3]| function(hierarchy.to_world(level, cell.map(|index| index as f64 + centering.place())));
    let field = Field::centered_from_fn("other", centering, hierarchy, value);
    Volume::new(volume.index().clone(), field, volume.method())
}

fn shown(volume: &Volume, transfer_function: TransferFunction) -> ShownField<'_> {
    ShownField { volume, transfer_function }
}

fn scene(volume: &Volume, function: TransferFunction) -> Scene<'_> {
    Scene::new(volume, function, 0.01, Camera::new(oblique(volume)).unwrap())
}

fn picture(scene: &Scene, layout: Layout, samples_per_cell: f64) -> Film {
    let engine = Engine::March(layout);
    let options = RenderOptions { size: [SIZE; 2], engine, samples_per_cell, ..RenderOptions::default() };
    render(scene, &options, &|_| {}).0
}

/// What a ray brings, from many points on it.
fn summed(scene: &Scene, CameraRay { start, direction }: CameraRay) -> [f32; 4] {
    const STEPS: usize = 6000;
    let [low, high] = scene.volume.hierarchy().bounds();
    let middle: [f64; 3] = std::array::from_fn(|axis| (low[axis] + high[axis]) / 2.0 - start[axis]);
    let size: f64 = (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f64>().sqrt();
    let center: f64 = (0..3).map(|axis| middle[axis] * direction[axis]).sum();
    let length = size / STEPS as f64;
    let at = |step: usize| center - size / 2.0 + (step as f64 + 0.5) * length;
    let points: Vec<[f64; 3]> =
        (0..STEPS).map(|step| std::array::from_fn(|axis| start[axis] + direction[axis] * at(step))).collect();
    let prepared = |field: &ShownField| -> (Vec<f64>, PreparedTransferFunction) {
        (field.volume.sample(&points), field.transfer_function.prepared(scene.unit_distance))
    };
    let first = ShownField { volume: scene.volume, transfer_function: scene.transfer_function.clone() };
    let seen: Vec<_> = std::iter::once(&first).chain(&scene.overlays).map(prepared).collect();
    let colors = scene.colors.as_ref().map(prepared);
    let (mut light, mut transmittance) = ([0.0; 3], 1.0);
    for step in 0..STEPS {
        let (mut total, mut emission) = (0.0, [0.0; 3]);
        for (number, (values, function)) in seen.iter().enumerate() {
            let mut sample = function.sample(values[step]);
            if let (0, Some((values, colors))) = (number, &colors) {
                match values[step].is_finite() {
                    true => sample.color = colors.sample(values[step]).color,
                    false => sample.extinction = 0.0,
                }
            }
            total += sample.extinction;
            (0..3).for_each(|channel| emission[channel] += sample.extinction * f64::from(sample.color[channel]));
        }
        if total > 0.0 {
            let through = (-total * length).exp();
            (0..3).for_each(|channel| light[channel] += transmittance * (1.0 - through) * emission[channel] / total);
            transmittance *= through;
        }
    }
    let [red, green, blue] = light.map(|channel| channel as f32);
    [red, green, blue, 1.0 - transmittance as f32]
}

fn check(scene: &Scene, tolerance: f32) {
    for layout in LAYOUTS {
        let film = picture(scene, layout, 16.0);
        for y in 0..SIZE {
            for x in 0..SIZE {
                let expected = summed(scene, scene.camera.ray([SIZE; 2], [x as f64 + 0.5, y as f64 + 0.5]));
                let found = film.pixels()[y * SIZE + x];
                let is_near = (0..4).all(|channel| (found[channel] - expected[channel]).abs() <= tolerance);
                let method = scene.volume.method();
                assert!(is_near, "{method}, {layout:?}, {x}, {y}: {found:?}, not {expected:?}");
            }
        }
    }
}

/// Three fields and how they look.
fn fields(volume: &Volume) -> (Volume, Volume, [TransferFunction; 3]) {
    let functions = [
        extinction(&[(0.2, 0.0), (0.6, 8.0), (0.8, 0.0)]),
        extinction(&[(0.5, 0.0), (0.9, 20.0)]),
        extinction(&[(0.0, 5.0), (0.3, 0.0)]),
    ];
    (beside(volume, |[_, y, _]| y), beside(volume, |[x, y, z]| (x - y) * z + 0.3), functions)
}

#[test]
fn fields_add_up_along_rays() {
    for method in METHODS {
        let volume = of_centers(nested(16, 3, 8), method, |[x, y, z]| (x * y + z) / 2.0);
        let (second, third, [one, two, three]) = fields(&volume);
        let overlays = vec![shown(&second, two), shown(&third, three)];
        let tolerance = if matches!(method, Method::Nearest | Method::Finest) { 2e-2 } else { 6e-3 };
        check(&Scene { overlays: overlays.clone(), ..scene(&volume, one.clone()) }, tolerance);
        let colors = Some(shown(&second, extinction(&[(0.0, 3.0)])));
        check(&Scene { overlays, colors, ..scene(&volume, one) }, tolerance);
    }
}

#[test]
fn fields_add_up_on_any_mesh() {
    for seed in 0..6 {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape::any(seed)).cut(&mut random);
        let [low, high] = mesh.bounds();
        let share = move |point: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|axis| (point[axis] - low[axis]) / (high[axis] - low[axis]))
        };
        let longest = mesh.longest_side();
        // Each field has cells without a number elsewhere.
        let cut = |value: f64, place: f64| if place < 0.1 { f64::NAN } else { value };
        let volume = of_centers(mesh, Method::Basis, |point| cut(share(point)[0], share(point)[1]));
        let second = beside(&volume, |point| cut(share(point)[1], share(point)[2]));
        let third = beside(&volume, |point| cut(share(point)[2] / 2.0, share(point)[0]));
        let dense = |low: f64, high: f64| extinction(&[(0.0, low / longest), (1.0, high / longest)]);
        let overlays = vec![shown(&second, dense(0.0, 2.0))];
        let colors = Some(shown(&third, dense(1.0, 1.0)));
        check(&Scene { overlays, colors, ..scene(&volume, dense(2.0, 0.0)) }, 2e-2);
    }
}

#[test]
fn a_field_in_parts_is_as_the_whole() {
    let volume = of_centers(nested(16, 3, 8), Method::Basis, |[x, y, z]| (x * y + z) / 2.0);
    let function = extinction(&[(0.2, 0.0), (0.6, 40.0), (0.8, 0.0)]);
    let sun = Light::Directional { direction: [-1.0, -0.5, -1.0], color: [0.8; 3] };
    let lights = vec![sun, Light::Headlight { color: [0.4; 3] }];
    let occlusion = Some(AmbientOcclusion { rays: 4, distance: 0.2 });
    let isotropic = Lighting { lights: lights.clone(), shading: Shading::Isotropic, ..Lighting::default() };
    let shaded = Lighting { shading: Shading::Gradient(Material::default()), ..isotropic.clone() };
    let shadowed = Lighting { shadows: true, ambient_occlusion: occlusion, ..shaded.clone() };
    for lighting in [Lighting::default(), isotropic, shaded, shadowed] {
        for layout in LAYOUTS {
            let whole = Scene { lighting: lighting.clone(), ..scene(&volume, function.clone()) };
            let quarter = function.scaled_opacity(0.25);
            let overlays = vec![shown(&volume, quarter.clone()); MOST_FIELDS - 1];
            let parts = Scene { overlays, transfer_function: quarter, ..whole.clone() };
            let colors = Some(shown(&volume, function.clone()));
            let colored = Scene { colors, ..whole.clone() };
            let hidden = vec![shown(&volume, function.scaled_opacity(0.0))];
            let with_hidden = Scene { overlays: hidden, ..whole.clone() };
            let expected = picture(&whole, layout, 2.0);
            // Steps are chosen by the sum of what may be wrong, so parts have no longer ones.
            for (what, found, tolerance) in [
                ("parts", picture(&parts, layout, 2.0), 4e-3),
                ("coloured by itself", picture(&colored, layout, 2.0), 1e-2),
                ("beside what is hidden", picture(&with_hidden, layout, 2.0), 1e-5),
            ] {
                let difference = largest(&found, &expected);
                assert!(difference <= tolerance, "{what}, {layout:?}, {lighting:?}: {difference}");
            }
        }
    }
}

#[test]
#[should_panic(expected = "another index or method")]
fn fields_of_other_meshes_are_refused() {
    let [volume, other] = [16, 8].map(|base| of_centers(nested(base, 2, 8), Method::Basis, |_| 0.5));
    let function = extinction(&[(0.5, 1.0)]);
    let overlays = vec![shown(&other, function.clone())];
    picture(&Scene { overlays, ..scene(&volume, function) }, Layout::Padded, 1.0);
}

#[test]
fn paths_are_for_one_field() {
    let volume = of_centers(nested(8, 1, 8), Method::Basis, |_| 0.5);
    let function = extinction(&[(0.5, 1.0)]);
    let colors = Some(shown(&volume, function.clone()));
    let scene = Scene { colors, ..scene(&volume, function) };
    let options = RenderOptions { size: [SIZE; 2], ..RenderOptions::default() };
    let problem = PathTracer::new(&scene, &options, &PathOptions::default()).err();
    assert_eq!(problem, Some(PathError::SeveralFields));
}
