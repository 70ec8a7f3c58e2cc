//! Whole frames of the same scene, told apart by one thing: `cargo bench -p amray --bench frame`. 1024x1024 pixels.

use std::sync::Arc;

use amray::Volume;
use amray::appearance::{ColorMap, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
use amray::index::Index;
use amray::reconstruction::Method;
use amray::render::{Engine, Layout, RenderOptions, render};
use amray::scene::{Camera, Scene, Viewpoint};
use amray_testing::Shell;
use divan::Bencher;

fn main() {
    divan::main();
}

/// The same cells in bricks of this many per axis.
#[divan::bench(args = [8, 16, 32], sample_count = 15)]
fn brick_side(bencher: Bencher, brick: i64) {
    let volume = volume(Shell { levels: 4, brick }.hierarchy(), Method::Current);
    bench(bencher, &volume, Layout::Padded, ALL);
}

/// Three levels that each cover half of the side of the one below, and a fourth that covers 1 % of the domain.
#[divan::bench(args = [3, 4], sample_count = 15)]
fn levels(bencher: Bencher, levels: usize) {
    bench(bencher, &volume(nested(levels), Method::Current), Layout::Padded, ALL);
}

#[divan::bench(args = [1, 2], sample_count = 15)]
fn threads(bencher: Bencher, threads: usize) {
    bench(bencher, &volume(nested(3), Method::Current), Layout::Padded, threads);
}

#[divan::bench(args = [Method::Current, Method::Basis, Method::Prolong], sample_count = 15)]
fn method(bencher: Bencher, method: Method) {
    bench(bencher, &volume(Shell { levels: 4, brick: 16 }.hierarchy(), method), Layout::Padded, ALL);
}

#[divan::bench(args = [Layout::Padded, Layout::InPlace], sample_count = 15)]
fn layout(bencher: Bencher, layout: Layout) {
    bench(bencher, &volume(Shell { levels: 4, brick: 16 }.hierarchy(), Method::Current), layout, ALL);
}

/// As many threads as there are cores.
const ALL: usize = 0;

/// A translucent picture of all of the volume.
fn bench(bencher: Bencher, volume: &Volume, layout: Layout, threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
    let viewpoint = Viewpoint::framing(volume.hierarchy().bounds(), 30.0, 1.0);
    let opacity = [(0.0, 0.1), (1.0, 6.0)].map(|(value, opacity)| OpacityPoint { value, opacity });
    let opacity = Opacity::Extinction(opacity.into());
    let function = TransferFunction::from_color_map(ColorMap::Viridis, [0.0, 1.0], Scale::Linear, opacity)
        .expect("the points ascend");
    let scene = Scene::new(volume, function, 0.01, Camera::new(viewpoint).expect("the volume is not flat"));
    let options = RenderOptions { engine: Engine::March(layout), ..RenderOptions::default() };
    let frame = || pool.install(|| render(&scene, &options, &|_| {}));
    // What is made once only, such as the padded copy, is made by the first frame.
    frame();
    bencher.bench_local(frame);
}

/// Waves that the coarsest cells resolve.
fn volume(hierarchy: Hierarchy, method: Method) -> Volume {
    let hierarchy = Arc::new(hierarchy);
    let field = Field::from_fn("waves", &hierarchy, |level, cell| {
        let center = hierarchy.to_world(level, cell.map(|index| index as f64 + 0.5));
        let [x, y, z] = center.map(|place| (25.0 * place).sin() as f32);
        0.5 + (x * y + y * z + z * x) / 6.0
    });
    Volume::new(Arc::new(Index::build(hierarchy)), field, method)
}

/// Up to four levels around the middle of a cube; all bricks have 16^3 cells.
fn nested(levels: usize) -> Hierarchy {
    let level = |level: i64| {
        // Half of the level below; the last one 112 of 512 cells, 1.05 % of the domain.
        let (side, width) = (64 << level, if level == 3 { 112 } else { 64 });
        let low = (side - width) / 2;
        let bricks = IndexBox::new([0; 3], [width / 16; 3]).iter();
        LevelDescription {
            ratio: [if level == 0 { 1 } else { 2 }; 3],
            cell_size: [1.0 / side as f64; 3],
            domain: IndexBox::new([0; 3], [side; 3]),
            bricks: bricks
                .map(|place| {
                    let corner = place.map(|index| low + 16 * index);
                    IndexBox::new(corner, corner.map(|index| index + 16))
                })
                .collect(),
        }
    };
    Hierarchy::new([0.0; 3], (0..levels as i64).map(level).collect()).expect("levels are nested")
}
