//! How fast a mesh is built and asked: `cargo bench -p amray-mesh`. Throughput is triangles or rays a second.

use std::hint::black_box;
use std::sync::LazyLock;

use amray_mesh::{Mesh, MeshDescription, Ray};
use divan::Bencher;
use divan::counter::ItemsCount;

/// A million triangles.
const RINGS: u32 = 500;
const SIDE: usize = 256;

static SPHERE: LazyLock<Mesh> = LazyLock::new(|| Mesh::new(MeshDescription::sphere([0.0; 3], 1.0, RINGS)).unwrap());

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 5)]
fn build(bencher: Bencher) {
    let description = MeshDescription::sphere([0.0; 3], 1.0, RINGS);
    bencher
        .counter(ItemsCount::new(description.triangles.len()))
        .with_inputs(|| description.clone())
        .bench_values(Mesh::new);
}

/// Neighbouring rays from an eye, as in a picture.
fn from_an_eye() -> Vec<Ray> {
    let ray = |pixel: usize| {
        let [x, y] = [pixel % SIDE, pixel / SIDE].map(|index| 2.0 * index as f64 / SIDE as f64 - 1.0);
        Ray { origin: [0.3, 0.2, 4.0], direction: [0.3 * x, 0.3 * y, -1.0], from: 0.0, to: f64::INFINITY }
    };
    (0..SIDE * SIDE).map(ray).collect()
}

/// Rays between random points of a box around the sphere.
fn anywhere() -> Vec<Ray> {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1u64 << 23) as f64 - 1.0
    };
    let mut point = || [random(), random(), random()];
    (0..SIDE * SIDE).map(|_| Ray { origin: point(), direction: point(), from: 0.0, to: f64::INFINITY }).collect()
}

#[derive(Clone, Copy, Debug)]
enum Rays {
    FromAnEye,
    Anywhere,
}

const RAYS: [Rays; 2] = [Rays::FromAnEye, Rays::Anywhere];

fn bench<T>(bencher: Bencher, rays: Rays, ask: impl Fn(&Mesh, &Ray) -> T + Sync) {
    let rays = match rays {
        Rays::FromAnEye => from_an_eye(),
        Rays::Anywhere => anywhere(),
    };
    let mesh = &*SPHERE;
    bencher.counter(ItemsCount::new(rays.len())).bench_local(|| {
        for ray in &rays {
            black_box(ask(mesh, ray));
        }
    });
}

#[divan::bench(args = RAYS, sample_count = 20)]
fn nearest(bencher: Bencher, rays: Rays) {
    bench(bencher, rays, Mesh::nearest);
}

#[divan::bench(args = RAYS, sample_count = 20)]
fn is_hit(bencher: Bencher, rays: Rays) {
    bench(bencher, rays, Mesh::is_hit);
}

#[divan::bench(args = RAYS, sample_count = 20)]
fn transmittance(bencher: Bencher, rays: Rays) {
    bench(bencher, rays, |mesh, ray| mesh.transmittance(ray, |_| 0.5));
}
