//! Surfaces: where they are met, and how they look, where that is known in closed form.

mod common;

use amray::Volume;
use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::Method;
use amray::render::{Engine, Film, Layout, RenderOptions, render};
use amray::scene::{Camera, Light, Lighting, Material, Paint, Projection, Scene, Shading, Surface, Viewpoint};
use amray_mesh::{Mesh, MeshDescription};
use amray_testing::Random;

use common::{METHODS, extinction, of_centers};

/// The unit cube in four levels that refine some blocks of the level below, at random, where a sphere passes: most of
/// them on one side, few on the other, so that there is room inside levels, too.
fn random_hierarchy(seed: u64, [center, radius]: [f64; 2]) -> Hierarchy {
    const BASE: i64 = 24;
    const BLOCK: i64 = 4;
    let mut random = Random(seed);
    let whole = IndexBox::new([0; 3], [BASE; 3]);
    let level = |ratio: i64, cells: i64, bricks| LevelDescription {
        ratio: [ratio; 3],
        cell_size: [(cells as f64).recip(); 3],
        domain: IndexBox::new([0; 3], [cells; 3]),
        bricks,
    };
    let mut levels = vec![level(1, BASE, vec![whole])];
    let mut cells = BASE;
    for _ in 1..4 {
        let size = (cells as f64).recip();
        let mut finer = Vec::new();
        for brick in levels[levels.len() - 1].bricks.clone() {
            for block in brick.coarsened([BLOCK; 3]).iter() {
                let low = block.map(|index| index * BLOCK);
                let middle = low.map(|index| (index as f64 + BLOCK as f64 / 2.0) * size - center);
                let distance = middle.iter().map(|part| part * part).sum::<f64>().sqrt() - radius;
                let share = if middle[0] > 0.0 { 0.9 } else { 0.15 };
                if distance.abs() < BLOCK as f64 * size && random.chance(share) {
                    finer.push(IndexBox::new(low, low.map(|index| index + BLOCK)).refined([2; 3]));
                }
            }
        }
        cells *= 2;
        levels.push(level(2, cells, finer));
    }
    Hierarchy::new([0.0; 3], levels).unwrap()
}

const CENTER: f64 = 0.5;
const RADIUS: f64 = 0.37;
const SIZE: usize = 512;

fn distance(point: [f64; 3]) -> f64 {
    point.map(|part| (part - CENTER) * (part - CENTER)).iter().sum::<f64>().sqrt() - RADIUS
}

fn face() -> Camera {
    let projection = Projection::Orthographic { height: 1.0 };
    let (eye, target) = ([0.5, 0.5, 3.0], [0.5; 3]);
    Camera::new(Viewpoint { eye, target, up: [0.0, 1.0, 0.0], projection }).unwrap()
}

fn picture(scene: &Scene, size: usize, layout: Layout) -> Film {
    let options = RenderOptions { size: [size; 2], engine: Engine::March(layout), ..RenderOptions::default() };
    render(scene, &options, &|_| {}).0
}

/// A scene with surfaces in a volume of which nothing is seen.
fn bare<'a>(volume: &'a Volume, surfaces: Vec<Surface<'a>>, camera: Camera) -> Scene<'a> {
    Scene { surfaces, ..Scene::new(volume, extinction(&[(0.0, 0.0)]), 0.01, camera) }
}

/// Three lights, red, green and blue, from the front and all sides: the colours of what is white tell its normal.
fn normals_as_colors() -> (Lighting, [[f64; 3]; 3]) {
    let toward: [[f64; 3]; 3] = std::array::from_fn(|light| {
        let angle = light as f64 * std::f64::consts::TAU / 3.0;
        let (across, ahead) = (0.2f64, 0.96f64.sqrt());
        [across * angle.cos(), across * angle.sin(), ahead]
    });
    let light = |number: usize| {
        let mut color = [0.0; 3];
        color[number] = 1.0;
        Light::Directional { direction: toward[number].map(|part| -part), color }
    };
    let lights = (0..3).map(light).collect();
    (Lighting { lights, shading: Shading::Emissive, shadows: false, ambient_occlusion: None }, toward)
}

/// The normal that gives these products with three directions (Cramer's rule).
fn normal_of(products: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let volume: f64 = (0..3).map(|axis| a[axis] * cross(b, c)[axis]).sum();
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    std::array::from_fn(|axis| (0..3).map(|part| products[part] * parts[part][axis]).sum::<f64>() / volume)
}

const MATTE: Material = Material { ambient: 0.0, diffuse: 1.0, specular: 0.0, specular_power: 1.0 };

fn sphere<'a>() -> Surface<'a> {
    Surface { material: Some(MATTE), ..Surface::isosurface(0.0, Paint::Plain([1.0; 3])) }
}

/// Whether all cells near a point are of its level: those as far away as two of its own, and those that another level
/// could make itself felt from: half a cell of the coarsest level, and the one that normals look beyond.
fn is_inside_its_level(volume: &Volume, point: [f64; 3]) -> bool {
    let hierarchy = volume.hierarchy();
    let finest = hierarchy.finest_level();
    let level_at = |point| {
        let cell = hierarchy.to_cells(finest, point).map(|place| place.floor() as i64);
        volume.index().find_leaf(cell).map(|leaf| leaf.level)
    };
    let Some(level) = level_at(point) else { return false };
    let size = hierarchy.levels()[level].cell_size()[0];
    let near = (2.0 * size).max(hierarchy.levels()[0].cell_size()[0] / 2.0 + 1.5 * size);
    (0..27).all(|number: usize| {
        let beside =
            std::array::from_fn(|axis| point[axis] + near * [0.0, -1.0, 1.0][number / 3usize.pow(axis as u32) % 3]);
        level_at(beside) == Some(level)
    })
}

#[test]
fn every_ray_that_must_hit_a_sphere_does_and_normals_are_right() {
    const COARSEST: f64 = 1.0 / 24.0;
    // Between cells' centres the reconstruction takes chords for arcs.
    let chord = 3.0 / 8.0 * COARSEST * COARSEST / RADIUS;
    for (seed, layout) in [(1, Layout::Padded), (2, Layout::Padded), (3, Layout::InPlace)] {
        for method in [Method::Current, Method::Blend, Method::Basis, Method::Octant, Method::Prolong] {
            let volume = of_centers(random_hierarchy(seed, [CENTER, RADIUS]), method, distance);
            let (lighting, toward) = normals_as_colors();
            let film = picture(&Scene { lighting, ..bare(&volume, vec![sphere()], face()) }, SIZE, layout);
            // Where levels meet, the other methods do not even keep linear fields: see the page on methods.
            let is_linear = matches!(method, Method::Octant | Method::Prolong);
            let tolerance = if is_linear { chord } else { COARSEST / 2.0 };
            let mut compared = 0;
            for (place, pixel) in film.pixels().iter().enumerate() {
                let [x, y] = [place % SIZE, place / SIZE].map(|pixel| (pixel as f64 + 0.5) / SIZE as f64 - 0.5);
                let (y, from_axis) = (-y, x.hypot(y));
                let is_hit = pixel[3] == 1.0;
                assert!(is_hit || pixel[3] == 0.0, "{method}: {pixel:?}");
                assert!(is_hit || from_axis > RADIUS - tolerance, "{method}, {seed}: no hit at {from_axis}");
                assert!(!is_hit || from_axis < RADIUS + tolerance, "{method}, {seed}: a hit at {from_axis}");
                if from_axis > 0.9 * RADIUS {
                    continue;
                }
                let height = (RADIUS * RADIUS - from_axis * from_axis).sqrt();
                if is_inside_its_level(&volume, [CENTER + x, CENTER + y, CENTER + height]) {
                    let found = normal_of([0, 1, 2].map(|channel| f64::from(pixel[channel])), toward);
                    let product: f64 = (0..3).map(|axis| found[axis] * [x, y, height][axis] / RADIUS).sum();
                    let length = found.iter().map(|part| part * part).sum::<f64>().sqrt();
                    let angle = (product / length).min(1.0).acos().to_degrees();
                    assert!(angle < 1.0, "{method}, {seed}: {angle} degrees at {:?}", [x, y]);
                    compared += 1;
                }
            }
            assert!(compared > 1000, "{method}, {seed}: {compared}");
        }
    }
}

/// A volume in which a function of the first coordinate has kinks, so that rays along it meet all levels' centres.
fn slab(method: Method, function: impl Fn(f64) -> f64) -> Volume {
    of_centers(random_hierarchy(5, [CENTER, RADIUS]), method, move |[_, _, z]| function(z))
}

#[test]
fn translucent_isosurfaces_are_met_in_their_order() {
    let volume = slab(Method::Prolong, |z| z);
    let isosurface =
        |value, color, opacity| Surface { opacity, material: None, ..Surface::isosurface(value, Paint::Plain(color)) };
    // From above: green before red before blue, whatever order they are given in; the last is opaque.
    let surfaces = vec![
        isosurface(0.5, [1.0, 0.0, 0.0], 0.5),
        isosurface(0.2, [0.0, 0.0, 1.0], 1.0),
        isosurface(0.7, [0.0, 1.0, 0.0], 0.25),
    ];
    let film = picture(&bare(&volume, surfaces, face()), 64, Layout::Padded);
    for pixel in &film.pixels()[..64 * 64] {
        for (found, expected) in pixel.iter().zip([0.75 * 0.5, 0.25, 0.75 * 0.5, 1.0]) {
            assert!((found - expected).abs() < 1e-6, "{pixel:?}");
        }
    }
}

#[test]
fn a_volume_before_and_behind_a_surface_is_seen_through_it() {
    for method in METHODS {
        let volume = slab(method, |_| 0.5);
        let function = extinction(&[(0.0, 1.0), (1.0, 1.0)]);
        let paint = Paint::Plain([1.0; 3]);
        let surface = Surface { opacity: 0.5, ..Surface::slice([0.5, 0.5, 0.75], [0.0, 0.0, -2.0], paint) };
        let scene = Scene { surfaces: vec![surface], ..Scene::new(&volume, function, 0.01, face()) };
        let film = picture(&scene, 16, Layout::Padded);
        let alpha = 1.0 - 0.5 * (-1.0f32).exp();
        for pixel in film.pixels() {
            assert!((pixel[3] - alpha).abs() < 1e-5, "{method}: {pixel:?}, not {alpha}");
            // Red is 0.5 all over in the volume, 1 on the slice.
            let (near, far) = ((-0.25f32).exp(), (-0.75f32).exp());
            let red = 0.5 * (1.0 - near) + near * 0.5 + near * 0.5 * 0.5 * (1.0 - far);
            assert!((pixel[0] - red).abs() < 1e-5, "{method}: {pixel:?}, not {red}");
        }
    }
}

#[test]
fn slices_show_the_colors_of_a_field() {
    let volume = of_centers(random_hierarchy(7, [CENTER, RADIUS]), Method::Prolong, |[x, y, _]| 0.7 * x + 0.3 * y);
    let function = extinction(&[(0.0, 1.0), (1.0, 1.0)]);
    let slice = Surface::slice([0.5; 3], [0.2, 0.3, 1.0], Paint::Field(&volume, function.clone()));
    let film = picture(&bare(&volume, vec![slice], face()), 128, Layout::Padded);
    let prepared = function.prepared(1.0);
    for (place, pixel) in film.pixels().iter().enumerate() {
        let [x, y] = [place % 128, place / 128].map(|pixel| (pixel as f64 + 0.5) / 128.0);
        // Beside the domain's faces values stay as they are at the outermost centres.
        if [x, y].iter().any(|place| !(1.0 / 24.0..23.0 / 24.0).contains(place)) {
            continue;
        }
        let expected = prepared.sample(0.7 * x + 0.3 * (1.0 - y)).color;
        let is_there = (0..3).all(|channel| (pixel[channel] - expected[channel]).abs() < 1e-3);
        assert!(is_there && pixel[3] == 1.0, "{pixel:?}, not {expected:?} at {x}, {y}");
    }
}

#[test]
fn values_that_are_nowhere_and_cells_without_a_number_have_no_surface() {
    let volume =
        of_centers(
            random_hierarchy(3, [CENTER, RADIUS]),
            Method::Basis,
            |[x, y, z]| {
                if x < 0.3 { f64::NAN } else { y + z }
            },
        );
    for value in [-1.0, 3.0, f64::NAN, f64::INFINITY] {
        let surface = Surface::isosurface(value, Paint::Plain([1.0; 3]));
        let film = picture(&bare(&volume, vec![surface], face()), 32, Layout::Padded);
        assert!(film.pixels().iter().all(|pixel| *pixel == [0.0; 4]), "{value}");
    }
    let surface = Surface::isosurface(1.0, Paint::Plain([1.0; 3]));
    let film = picture(&bare(&volume, vec![surface], face()), 32, Layout::Padded);
    for (place, pixel) in film.pixels().iter().enumerate() {
        let x = (place % 32) as f64 / 32.0;
        let expected = if x < 0.25 { Some(0.0) } else { (x > 0.4).then_some(1.0) };
        assert!(pixel.iter().all(|part| part.is_finite()));
        // On the faces of the domain values do not change: the surface y + z = 1 reaches neither.
        let y = 1.0 - (place / 32) as f64 / 32.0;
        if let (Some(alpha), true) = (expected, (0.1..0.9).contains(&y)) {
            assert_eq!(pixel[3], alpha, "at {x}, {y}");
        }
    }
}

#[test]
fn surfaces_cast_shadows_on_surfaces_and_volumes() {
    let volume = slab(Method::Basis, |z| z);
    let light = Light::Directional { direction: [0.0, 0.0, -1.0], color: [1.0; 3] };
    let lighting =
        Lighting { lights: vec![light], shading: Shading::Isotropic, shadows: true, ambient_occlusion: None };
    let roof =
        |opacity| Surface { opacity, ..Surface::slice([0.5, 0.5, 0.9], [0.0, 0.0, 1.0], Paint::Plain([0.0; 3])) };
    let floor =
        Surface { material: Some(MATTE), ..Surface::slice([0.5, 0.5, 0.1], [0.0, 0.0, 1.0], Paint::Plain([1.0; 3])) };
    // The light goes through the roof, and what comes back from the floor does once more.
    for opacity in [0.0, 0.5] {
        let scene = bare(&volume, vec![floor.clone(), roof(opacity)], face());
        let film = picture(&Scene { lighting: lighting.clone(), ..scene }, 16, Layout::Padded);
        let through = (1.0 - opacity) * (1.0 - opacity);
        assert!(film.pixels().iter().all(|pixel| (pixel[0] - through).abs() < 1e-5), "{:?}", film.pixels()[99]);
    }
    // A thin volume between: half the light arrives everywhere below the roof.
    let lit = |surfaces| {
        let scene = Scene { surfaces, ..Scene::new(&volume, extinction(&[(0.0, 0.05), (1.0, 0.05)]), 0.01, face()) };
        picture(&Scene { lighting: lighting.clone(), ..scene }, 16, Layout::Padded).pixels()[8 * 16 + 8]
    };
    let (open, covered) = (lit(vec![]), lit(vec![roof(0.5)]));
    let share = covered[2] / open[2];
    // Above the roof the volume is lit and seen in full; its blue grows with the height.
    let above = 1.0 - 0.9 * 0.9;
    assert!((share - (above + (1.0 - above) * 0.25)).abs() < 0.01, "{share}");
}

/// A square of triangles around the z axis of the unit cube, at a height.
fn square(half: f64, height: f64, colors: Option<[f32; 4]>) -> Mesh {
    let corner = |x: f64, y: f64| [CENTER + half * x, CENTER + half * y, height];
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    Mesh::new(MeshDescription { vertices, triangles, colors: colors.map(|color| vec![color; 4]), normals: None })
        .unwrap()
}

fn flat(mesh: &Mesh) -> Surface<'_> {
    Surface { material: None, ..Surface::mesh(mesh) }
}

#[test]
fn meshes_lie_before_inside_and_behind_the_volume() {
    let volume = slab(Method::Basis, |_| 0.5);
    let function = extinction(&[(0.0, 1.0), (1.0, 1.0)]);
    // How much of the volume is before a mesh at each height.
    for (height, before) in [(2.0, 0.0), (1.0, 0.0), (0.7, 0.3), (0.0, 1.0), (-5.0, 1.0)] {
        let mesh = square(0.3, height, None);
        let scene = Scene { surfaces: vec![flat(&mesh)], ..Scene::new(&volume, function.clone(), 0.01, face()) };
        let film = picture(&scene, 20, Layout::Padded);
        let through = (-before as f32).exp();
        for (place, pixel) in film.pixels().iter().enumerate() {
            let [x, y] = [place % 20, place / 20].map(|pixel| (pixel as f64 + 0.5) / 20.0 - 0.5);
            // Blue is 0.5 in the volume and 1 on the mesh.
            let [blue, alpha] = match x.abs().max(y.abs()) < 0.3 {
                true => [0.5 * (1.0 - through) + through, 1.0],
                false => [0.5 * (1.0 - (-1.0f32).exp()), 1.0 - (-1.0f32).exp()],
            };
            let same = (pixel[2] - blue).abs() < 1e-5 && (pixel[3] - alpha).abs() < 1e-5;
            assert!(same, "{height}: {pixel:?}, not {blue} and {alpha} at {x}, {y}");
        }
    }
}

#[test]
fn meshes_are_seen_where_rays_miss_the_volume_and_through_each_other() {
    let volume = slab(Method::Basis, |_| 0.5);
    let (near, far) = (square(20.0, 1.5, Some([1.0, 0.0, 0.0, 0.25])), square(30.0, -3.0, Some([0.0, 0.0, 1.0, 1.0])));
    let (eye, target) = ([0.5, 0.5, 30.0], [0.5; 3]);
    for projection in [Projection::Perspective { fovy: 40.0 }, Projection::Orthographic { height: 15.0 }] {
        let camera = Camera::new(Viewpoint { eye, target, up: [0.0, 1.0, 0.0], projection }).unwrap();
        let film = picture(&bare(&volume, vec![flat(&far), flat(&near)], camera), 33, Layout::Padded);
        for pixel in film.pixels() {
            for (found, expected) in pixel.iter().zip([0.25, 0.0, 0.75, 1.0]) {
                assert!((found - expected).abs() < 1e-6, "{pixel:?}");
            }
        }
    }
}

#[test]
fn meshes_outside_of_the_volume_are_lit_and_cast_shadows_into_it() {
    let volume = slab(Method::Basis, |_| 0.5);
    let light = |direction| Light::Directional { direction, color: [1.0; 3] };
    let lighting =
        |light| Lighting { lights: vec![light], shading: Shading::Isotropic, shadows: true, ambient_occlusion: None };
    let middle = |film: Film| film.pixels()[10 * 20 + 10];
    let matte = |mesh| Surface { material: Some(MATTE), ..Surface::mesh(mesh) };
    // A roof over a floor, both far outside; the light comes from above, the eye looks from below the roof.
    let (roof, floor) = (square(3.0, 9.0, None), square(3.0, -4.0, None));
    let camera = || {
        let viewpoint = Viewpoint {
            eye: [0.5, 0.5, 5.0],
            target: [0.5, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            projection: Projection::Perspective { fovy: 10.0 },
        };
        Camera::new(viewpoint).unwrap()
    };
    let seen = |surfaces| {
        let scene = Scene { lighting: lighting(light([0.0, 0.0, -1.0])), ..bare(&volume, surfaces, camera()) };
        middle(picture(&scene, 20, Layout::Padded))
    };
    assert!((seen(vec![matte(&floor)])[0] - 1.0).abs() < 1e-5);
    assert_eq!(seen(vec![matte(&floor), matte(&roof)])[0], 0.0);
    // Half of what the roof keeps from the volume below it.
    let lit = |surfaces| {
        let function = extinction(&[(0.0, 1.0), (1.0, 1.0)]);
        let scene = Scene { surfaces, ..Scene::new(&volume, function, 0.01, camera()) };
        let scene = Scene { lighting: lighting(light([0.0, 0.0, -1.0])), ..scene };
        middle(picture(&scene, 20, Layout::Padded))
    };
    let half = Surface { opacity: 0.5, ..matte(&roof) };
    let (open, covered) = (lit(vec![]), lit(vec![half]));
    assert!((covered[0] / open[0] - 0.5).abs() < 1e-3, "{covered:?}, {open:?}");
}

#[test]
fn empty_meshes_change_nothing() {
    let volume = slab(Method::Basis, |z| z);
    let function = extinction(&[(0.0, 0.0), (1.0, 5.0)]);
    let empty = Mesh::new(MeshDescription::default()).unwrap();
    let scene = |surfaces| Scene { surfaces, ..Scene::new(&volume, function.clone(), 0.01, face()) };
    let [with, without] =
        [vec![Surface::mesh(&empty)], vec![]].map(|surfaces| picture(&scene(surfaces), 32, Layout::Padded));
    assert_eq!(with.pixels(), without.pixels());
}
