//! Meshes against a search through all triangles, and closed surfaces against what closed means.

use amray_mesh::{Hit, Mesh, MeshDescription, Ray};
use proptest::prelude::*;

type Vector = [f64; 3];

const EVERYWHERE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn combine(a: Vector, b: Vector, f: impl Fn(f64, f64) -> f64) -> Vector {
    std::array::from_fn(|axis| f(a[axis], b[axis]))
}

fn minus(a: Vector, b: Vector) -> Vector {
    combine(a, b, |a, b| a - b)
}

fn dot(a: Vector, b: Vector) -> f64 {
    combine(a, b, |a, b| a * b).iter().sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn ray(origin: Vector, direction: Vector, (from, to): (f64, f64)) -> Ray {
    Ray { origin, direction, from, to }
}

fn through(origin: Vector, target: Vector) -> Ray {
    ray(origin, minus(target, origin), EVERYWHERE)
}

fn hits(mesh: &Mesh, ray: &Ray) -> Vec<Hit> {
    let mut hits = Vec::new();
    mesh.hits(ray, &mut hits);
    assert_eq!(mesh.nearest(ray), hits.first().copied());
    assert_eq!(mesh.is_hit(ray), !hits.is_empty());
    hits
}

/// Where the ray meets the triangle (Möller, Trumbore 1997), and by how much of the triangle it is inside.
fn meeting(ray: &Ray, [a, b, c]: [Vector; 3]) -> Option<(f64, f64)> {
    let [u, v, to] = [minus(b, a), minus(c, a), minus(ray.origin, a)];
    let across = cross(ray.direction, v);
    let determinant = dot(u, across);
    let weight_b = dot(to, across) / determinant;
    let weight_c = dot(ray.direction, cross(to, u)) / determinant;
    let inside = weight_b.min(weight_c).min(1.0 - weight_b - weight_c);
    (determinant != 0.0).then(|| (dot(v, cross(to, u)) / determinant, inside))
}

fn corners(description: &MeshDescription, triangle: usize) -> [Vector; 3] {
    description.triangles[triangle].map(|vertex| description.vertices[vertex as usize])
}

/// Every triangle that is met well inside is found, where it is, and none that is missed well outside.
fn check(description: &MeshDescription, mesh: &Mesh, ray: &Ray) {
    const CLEARLY: f64 = 1e-3;
    const NEAR: f64 = 1e-3;
    let hits = hits(mesh, ray);
    assert!(hits.is_sorted_by(|a, b| a.t <= b.t));
    for triangle in 0..description.triangles.len() {
        let found: Vec<&Hit> = hits.iter().filter(|hit| hit.triangle as usize == triangle).collect();
        let Some((t, inside)) = meeting(ray, corners(description, triangle)) else { continue };
        let in_range = (t - ray.from).min(ray.to - t);
        if inside > CLEARLY && in_range > NEAR {
            assert_eq!(found.len(), 1, "{triangle} at {t}: {hits:?}");
            assert!((found[0].t - t).abs() < NEAR, "{triangle} at {t}: {hits:?}");
        } else if inside < -CLEARLY || in_range < -NEAR {
            assert_eq!(found.len(), 0, "{triangle} at {t}: {hits:?}");
        }
    }
}

fn point(size: f64) -> impl Strategy<Value = Vector> {
    prop::array::uniform3(-size..size)
}

/// Triangles of random corners that are not slivers, where single precision would not say much.
fn triangles() -> impl Strategy<Value = MeshDescription> {
    let fat = |triangle: &[Vector; 3]| {
        let [a, b, c] = *triangle;
        let area = cross(minus(b, a), minus(c, a));
        let longest = [minus(b, a), minus(c, b), minus(a, c)].iter().map(|side| dot(*side, *side)).fold(0.0, f64::max);
        dot(area, area).sqrt() > 0.05 * longest
    };
    let triangle = prop::array::uniform3(point(1.0)).prop_filter("a sliver", fat);
    prop::collection::vec(triangle, 1..40).prop_map(|corners| MeshDescription {
        triangles: (0..corners.len() as u32).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner)).collect(),
        vertices: corners.into_iter().flatten().collect(),
        ..MeshDescription::default()
    })
}

/// A direction with components that may be exactly zero.
fn direction() -> impl Strategy<Value = Vector> {
    let component = || prop_oneof![3 => -1.0..1.0, 1 => Just(0.0), 1 => Just(-0.0)];
    (component(), component(), component())
        .prop_map(|(x, y, z)| [x, y, z])
        .prop_filter("short", |direction| dot(*direction, *direction) > 0.1)
}

fn moved(description: &MeshDescription, offset: Vector, scale: f64) -> MeshDescription {
    let mut moved = description.clone();
    moved.vertices.iter_mut().for_each(|vertex| *vertex = combine(*vertex, offset, |v, o| scale * v + o));
    moved
}

proptest! {
    #[test]
    fn random_triangles_are_found(
        description in triangles(),
        origin in point(2.0),
        direction in direction(),
        from in -3.0..1.0,
        length in 0.0..4.0,
    ) {
        let mesh = Mesh::new(description.clone()).unwrap();
        check(&description, &mesh, &ray(origin, direction, (from, from + length)));
        check(&description, &mesh, &ray(origin, direction, EVERYWHERE));
    }

    #[test]
    fn the_place_in_the_world_and_the_size_do_not_matter(
        description in triangles(),
        origin in point(2.0),
        direction in direction(),
        exponent in -60..60,
    ) {
        let scale = f64::from(exponent).exp2();
        let offset = [1e9 * scale, -3e8 * scale, 2e9 * scale];
        let moved_mesh = Mesh::new(moved(&description, offset, scale)).unwrap();
        let ray = ray(combine(origin, offset, |x, o| scale * x + o), direction.map(|x| scale * x), EVERYWHERE);
        let local = Ray { origin: minus(ray.origin, offset).map(|x| x / scale), direction, ..ray };
        let description = moved(&moved(&description, offset, scale), offset.map(|o| -o / scale), 1.0 / scale);
        let hits = hits(&moved_mesh, &ray);
        let expected = (0..description.triangles.len())
            .filter_map(|triangle| meeting(&local, corners(&description, triangle)))
            .filter(|(_, inside)| *inside > 1e-3);
        for (t, _) in expected {
            prop_assert!(hits.iter().any(|hit| (hit.t - t).abs() < 1e-3), "{t}: {hits:?}");
        }
    }

    #[test]
    fn a_closed_sphere_is_gone_into_and_out_of(target in point(0.57), origin in point(20.0), rings in 2u32..30) {
        let mesh = Mesh::new(MeshDescription::sphere([0.0; 3], 1.0, rings)).unwrap();
        let hits = hits(&mesh, &through(origin, target));
        prop_assert_eq!(hits.len() % 2, 0);
        // A convex body; its faces are at least this far from the middle where there are two rings.
        if rings > 8 && dot(target, target) < 0.9 {
            prop_assert_eq!(hits.len(), 2);
        }
    }
}

/// Rays from inside and outside, through every vertex, the middle of every edge and of every triangle.
#[test]
fn nothing_slips_through_vertices_and_edges() {
    for offset in [[0.0; 3], [1e9, -1e9, 3e9], [0.1, 0.2, 0.3]] {
        let description = MeshDescription::sphere(offset, 1.0, 16);
        let mesh = Mesh::new(description.clone()).unwrap();
        let origins = [[0.0; 3], [0.1, 0.2, -0.3], [0.0, 0.5, 0.0], [3.0, 0.0, 0.0], [2.0, 2.0, 2.0], [0.0, 0.0, 50.0]];
        for origin in origins.map(|origin| combine(origin, offset, |a, b| a + b)) {
            let is_inside = dot(minus(origin, offset), minus(origin, offset)) < 0.9;
            for triangle in 0..description.triangles.len() {
                let [a, b, c] = corners(&description, triangle);
                let middle = |a, b| combine(a, b, |a, b| 0.5 * a + 0.5 * b);
                for target in [a, middle(a, b), middle(b, c), middle(a, c), middle(a, middle(b, c))] {
                    let ray = through(origin, target);
                    assert_eq!(hits(&mesh, &ray).len() % 2, 0, "{origin:?} {target:?}");
                    if is_inside {
                        assert_eq!(hits(&mesh, &Ray { from: 0.0, ..ray }).len(), 1, "{origin:?} {target:?}");
                    }
                }
            }
        }
    }
}

/// The corners and rays lie on one grid: nothing is rounded, and most rays go through edges and vertices exactly.
#[test]
fn a_cube_on_a_grid_is_closed_in_all_directions() {
    let corner = |index: usize| [0, 1, 2].map(|axis| if index >> axis & 1 == 0 { -1.0 } else { 1.0 });
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mesh = Mesh::new(MeshDescription {
        vertices: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..MeshDescription::default()
    })
    .unwrap();
    let steps = || (-4..=4).map(|step| f64::from(step) / 2.0);
    let grid = || steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    for origin in grid() {
        for direction in grid().filter(|direction| *direction != [0.0; 3]) {
            let hits = hits(&mesh, &ray(origin, direction, EVERYWHERE));
            let inside = origin.iter().all(|x: &f64| x.abs() < 1.0);
            assert!(
                if inside { hits.len() == 2 } else { hits.len().is_multiple_of(2) },
                "{origin:?} {direction:?} {hits:?}"
            );
        }
    }
}

#[test]
fn a_hundred_thousand_identical_triangles_are_all_hit() {
    const COUNT: usize = 100_000;
    let mesh = Mesh::new(MeshDescription {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]; COUNT],
        ..MeshDescription::default()
    })
    .unwrap();
    let ray = ray([0.25, 0.25, 1.0], [0.0, 0.0, -1.0], EVERYWHERE);
    assert_eq!(mesh.nearest(&ray).unwrap().triangle, 0);
    let hits = hits(&mesh, &ray);
    assert!(hits.iter().enumerate().all(|(place, hit)| hit.triangle as usize == place && hit.t == 1.0));
    assert_eq!(hits.len(), COUNT);
}

/// Each triangle half as large as the one around it, until single precision ends.
#[test]
fn nested_triangles_are_hit_down_to_the_smallest() {
    let mut description = MeshDescription::default();
    for level in 0..120 {
        let size = 0.5f64.powi(level);
        let first = description.vertices.len() as u32;
        description.vertices.extend([[-size, -size, size], [size, -size, size], [0.0, size, size]]);
        description.triangles.push([first, first + 1, first + 2]);
    }
    let mesh = Mesh::new(description.clone()).unwrap();
    // The mesh's middle is at half of its height, where digits end sooner.
    assert!(mesh.triangle_count() > 20);
    let hits = hits(&mesh, &ray([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], EVERYWHERE));
    assert!(hits.iter().enumerate().take(20).all(|(place, hit)| hit.triangle as usize == place));
    assert!(hits.len() >= 20);
}

#[test]
fn an_empty_mesh_hits_nothing() {
    let mesh = Mesh::new(MeshDescription::default()).unwrap();
    assert!(hits(&mesh, &ray([0.0; 3], [0.0, 0.0, 1.0], EVERYWHERE)).is_empty());
    assert_eq!(mesh.transmittance(&ray([0.0; 3], [0.0, 0.0, 1.0], EVERYWHERE), |_| 1.0), 1.0);
}

#[test]
fn rays_that_leave_a_surface_do_not_hit_it_again() {
    for (center, radius) in [([0.0; 3], 1.0), ([1e6, 2e6, -3e6], 5.0), ([1e-7; 3], 1e-9)] {
        let mesh = Mesh::new(MeshDescription::sphere(center, radius, 40)).unwrap();
        assert!(mesh.precision() < 2e-6 * radius.max(1e-9 * center[2].abs()));
        for step in 0..500 {
            let (y, x) = (0.37 * f64::from(step)).sin_cos();
            let direction = [x, y, (0.91 * f64::from(step)).sin()];
            let hit = mesh.nearest(&ray(center, direction, (0.0, f64::INFINITY))).unwrap();
            let normal = hit.geometric_normal.map(f64::from);
            let place = combine(center, direction, |c, d| c + hit.t * d);
            let off = |distance: f64| combine(place, normal, |p, n| p + distance * n);
            assert!(!mesh.is_hit(&ray(off(mesh.precision()), normal, (0.0, f64::INFINITY))), "{place:?}");
            let inward = ray(off(-mesh.precision()), normal.map(|n| -n), (0.0, f64::INFINITY));
            assert_eq!(hits(&mesh, &inward).len(), 1, "{place:?}");
        }
    }
}

#[test]
fn extreme_sizes_and_far_eyes() {
    for size in [1e-300, 1e-30, 1e30, 1e300] {
        let mesh = Mesh::new(MeshDescription::sphere([0.0; 3], size, 20)).unwrap();
        let hits = hits(&mesh, &ray([0.1 * size, 0.2 * size, 1e5 * size], [0.0, 0.0, -size], EVERYWHERE));
        assert_eq!(hits.len(), 2, "{size}");
        assert!((hits[0].t - (1e5 - 0.95f64.sqrt())).abs() < 0.02 && (hits[1].t - (1e5 + 0.95f64.sqrt())).abs() < 0.02);
    }
}
