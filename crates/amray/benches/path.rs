//! Path tracing, in paths per second: `cargo bench -p amray --bench path`.

use std::sync::Arc;

use amray::Volume;
use amray::appearance::{ColorMap, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::hierarchy::Field;
use amray::index::Index;
use amray::reconstruction::Method;
use amray::render::{PathOptions, PathTracer, RenderOptions};
use amray::scene::{Camera, Lighting, Scene, Shading, Viewpoint};
use amray_testing::explosion;
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

/// Pixels per side.
const SIDE: usize = 128;

/// Haze: light is scattered once or twice.
#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 5)]
fn haze(bencher: Bencher, method: Method) {
    bench(bencher, method, [0.0, 0.1, 6.0], Shading::Isotropic);
}

/// Smoke: an opaque front, scattering within it.
#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 5)]
fn smoke(bencher: Bencher, method: Method) {
    bench(bencher, method, [0.0, 20.0, 400.0], Shading::Isotropic);
}

/// The first meeting alone.
#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 5)]
fn glow(bencher: Bencher, method: Method) {
    bench(bencher, method, [0.0, 0.1, 6.0], Shading::Emissive);
}

/// One pass over a view of an explosion, with an extinction that runs over its values.
fn bench(bencher: Bencher, method: Method, extinctions: [f64; 3], shading: Shading) {
    let (hierarchy, field): (_, Field) = explosion();
    let volume = Volume::new(Arc::new(Index::build(hierarchy)), field, method);
    let range = volume.leaf_range().expect("the field has values");
    let points = extinctions.into_iter().enumerate().map(|(place, opacity)| {
        let value = Scale::Linear.at_fraction(range, place as f64 / 2.0);
        OpacityPoint { value, opacity }
    });
    let opacity = Opacity::Extinction(points.collect());
    let function =
        TransferFunction::from_color_map(ColorMap::Viridis, range, Scale::Linear, opacity).expect("the points ascend");
    let camera = Camera::new(Viewpoint::framing(volume.hierarchy().bounds(), 30.0, 1.0)).expect("it is not flat");
    let lighting = Lighting { lights: Lighting::from_upper_left(&camera), shading, ..Lighting::default() };
    let scene = Scene { lighting, ..Scene::new(&volume, function, 0.01, camera) };
    let options = RenderOptions { size: [SIDE; 2], ..RenderOptions::default() };
    let mut tracer = PathTracer::new(&scene, &options, &PathOptions::default()).expect("all of it can be");
    bencher.counter(ItemsCount::new(SIDE * SIDE)).bench_local(|| tracer.accumulate(1, &|_| {}));
    let statistics = tracer.statistics();
    let per_path = |count: u64| count as f64 / statistics.paths as f64;
    eprintln!(
        "{:.2} scatterings, {:.1} samples a path",
        per_path(statistics.scatterings),
        per_path(statistics.samples)
    );
}
