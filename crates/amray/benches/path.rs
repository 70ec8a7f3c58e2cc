//! Path tracing, in paths per second: `cargo bench -p amray --bench path`.

use std::sync::Arc;

use amray::Volume;
use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
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

/// Haze: most paths go through.
#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 5)]
fn haze(bencher: Bencher, method: Method) {
    bench(bencher, method, [0.0, 2.0, 20.0], Shading::Isotropic);
}

/// Smoke: what is met is opaque, and scatters several times.
#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 5)]
fn smoke(bencher: Bencher, method: Method) {
    bench(bencher, method, [0.0, 100.0, 400.0], Shading::Isotropic);
}

/// The first meeting alone.
#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 5)]
fn glow(bencher: Bencher, method: Method) {
    bench(bencher, method, [0.0, 2.0, 20.0], Shading::Emissive);
}

/// One pass over a view of an explosion, with an extinction that runs over its values.
fn bench(bencher: Bencher, method: Method, extinctions: [f64; 3], shading: Shading) {
    let (hierarchy, field): (_, Field) = explosion();
    let volume = Volume::new(Arc::new(Index::build(hierarchy)), field, method);
    let range = volume.leaf_range().expect("the field has values");
    let point = |share, opacity| OpacityPoint { value: Scale::Linear.at_fraction(range, share), opacity };
    let points = [point(0.0, extinctions[0]), point(0.5, extinctions[1]), point(1.0, extinctions[2])];
    let colors = vec![ColorPoint { value: range[0], color: [0.95, 0.85, 0.7] }];
    let function =
        TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points.into())).expect("the points ascend");
    let camera = Camera::new(Viewpoint::framing(volume.hierarchy().bounds(), 30.0, 1.0)).expect("it is not flat");
    let lighting = Lighting { lights: Lighting::from_upper_left(&camera), shading, ..Lighting::default() };
    let scene = Scene { lighting, ..Scene::new(&volume, function, 0.01, camera) };
    let options = RenderOptions { size: [SIDE; 2], ..RenderOptions::default() };
    let mut tracer = PathTracer::new(&scene, &options, &PathOptions::default()).expect("all of it can be");
    bencher.counter(ItemsCount::new(SIDE * SIDE)).bench_local(|| tracer.accumulate(1, &|_| {}));
}
