//! Marching taken apart, on one thread: `cargo bench -p amray --bench march`. Throughput is samples a second.

use std::sync::Arc;

use amray::Volume;
use amray::appearance::{ColorMap, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::bench::{Integrator, RegionSampler};
use amray::index::Index;
use amray::reconstruction::Method;
use amray_testing::explosion;
use divan::Bencher;
use divan::counter::ItemsCount;

const PACKETS: usize = 1 << 14;
const LANES: usize = 16;

fn main() {
    divan::main();
}

fn volume(method: Method) -> Volume {
    let (hierarchy, field) = explosion();
    Volume::new(Arc::new(Index::build(hierarchy)), field, method)
}

/// The most that marching could reach: sixteen neighbouring rays through one brick that is in the nearest cache.
#[divan::bench]
fn interior_of_one_brick(bencher: Bencher) {
    let volume = volume(Method::Current);
    run(bencher, &RegionSampler::of_one_brick(&volume, PACKETS));
}

/// Nearest and current have no borders: one brick is always enough for them.
const BORDERED: [Method; 5] = [Method::Finest, Method::Blend, Method::Basis, Method::Octant, Method::Prolong];

/// Samples that more than one brick may take part in.
#[divan::bench(args = BORDERED)]
fn border(bencher: Bencher, method: Method) {
    let volume = volume(method);
    run(bencher, &RegionSampler::of_borders(&volume, PACKETS));
}

fn run(bencher: Bencher, sampler: &RegionSampler) {
    // The padded copy is made by the first run.
    sampler.run();
    bencher.counter(ItemsCount::new(sampler.samples())).bench_local(|| sampler.run());
}

/// Few points, as drawn by hand, and many.
const POINTS: [usize; 3] = [2, 8, 64];

/// From values to light, with no samples to wait for.
#[divan::bench(args = POINTS)]
fn transfer_function(bencher: Bencher, points: usize) {
    let point =
        |number: usize| OpacityPoint { value: number as f64 / (points - 1) as f64, opacity: [0.0, 1e-6][number % 2] };
    let opacity = Opacity::Extinction((0..points).map(point).collect());
    let function = TransferFunction::from_color_map(ColorMap::Gray, [0.0, 1.0], Scale::Linear, opacity)
        .expect("the points ascend");
    let integrator = Integrator::new(&function, [0.0, 1.0], PACKETS);
    bencher.counter(ItemsCount::new(PACKETS * LANES)).bench_local(|| integrator.run());
}
