//! How fast the index is built and asked: `cargo bench -p amray --bench index`. Throughput is per brick, byte or query.

use std::hint::black_box;
use std::sync::{Arc, LazyLock};

use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
use amray::index::{Index, Planes, ValueRanges};
use amray_testing::{Random, Shell};
use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};

/// The same cells in small, middling and large bricks.
const BRICKS: [i64; 3] = [8, 16, 32];
const LEVELS: usize = 5;
const QUERIES: usize = 10_000;

fn main() {
    divan::main();
}

#[divan::bench(args = BRICKS)]
fn build(bencher: Bencher, brick: i64) {
    let hierarchy = Arc::new(Shell { levels: LEVELS, brick }.hierarchy());
    bencher.counter(ItemsCount::new(hierarchy.brick_count())).bench(|| Index::build(hierarchy.clone()));
}

#[divan::bench(args = BRICKS)]
fn ranges(bencher: Bencher, brick: i64) {
    bench_ranges(bencher, Shell { levels: LEVELS - 1, brick }.hierarchy());
}

#[divan::bench]
fn ranges_of_a_huge_brick(bencher: Bencher) {
    bench_ranges(bencher, bricks_on_a_huge_one());
}

fn bench_ranges(bencher: Bencher, hierarchy: Hierarchy) {
    let hierarchy = Arc::new(hierarchy);
    let index = Index::build(hierarchy.clone());
    let field = Field::from_fn("wave", &hierarchy, |level, cell| {
        hierarchy
            .to_world(level, cell.map(|index| index as f64))
            .map(|place| (20.0 * place).sin() as f32)
            .iter()
            .sum::<f32>()
    });
    let bytes = BytesCount::new(hierarchy.cells() * size_of::<f32>() as u64);
    bencher.counter(bytes).bench(|| ValueRanges::build(&index, &field));
}

/// A brick of 256^3 cells, thousands of which of 16^3 lie scattered over.
fn bricks_on_a_huge_one() -> Hierarchy {
    let mut random = Random(1);
    let coarse = IndexBox::new([0; 3], [256; 3]);
    let fine = IndexBox::new([0; 3], [32; 3]).iter().filter(|_| random.chance(0.125));
    let fine = fine.map(|place| IndexBox::new(place, place.map(|index| index + 1)).refined([16; 3])).collect();
    let level = |ratio: i64, side: i64, bricks| LevelDescription {
        ratio: [ratio; 3],
        cell_size: [1.0 / side as f64; 3],
        domain: IndexBox::new([0; 3], [side; 3]),
        bricks,
    };
    Hierarchy::new([0.0; 3], vec![level(1, 256, vec![coarse]), level(2, 512, fine)]).expect("bricks lie in the domain")
}

/// The index of the shell in bricks of 16^3.
static INDEX: LazyLock<Index> =
    LazyLock::new(|| Index::build(Arc::new(Shell { levels: LEVELS, brick: 16 }.hierarchy())));

/// Cells of the finest level in rows along x, as a ray or a slice meets them.
fn coherent() -> Vec<[i64; 3]> {
    let [side, ..] = INDEX.domain().size();
    (0..QUERIES as i64).map(|query| [query % side, 7 * (query / side) % side, side / 2]).collect()
}

/// Cells of the finest level anywhere.
fn scattered() -> Vec<[i64; 3]> {
    let [side, ..] = INDEX.domain().size();
    let mut random = Random(1);
    (0..QUERIES).map(|_| std::array::from_fn(|_| random.integer(0, side - 1))).collect()
}

fn bench_queries(bencher: Bencher, cells: &[[i64; 3]], query: impl Fn([i64; 3]) + Sync) {
    bencher.counter(ItemsCount::new(cells.len())).bench(|| cells.iter().for_each(|&cell| query(cell)));
}

#[divan::bench]
fn find_leaf_coherent(bencher: Bencher) {
    bench_queries(bencher, &coherent(), find_leaf);
}

#[divan::bench]
fn find_leaf_scattered(bencher: Bencher) {
    bench_queries(bencher, &scattered(), find_leaf);
}

#[divan::bench]
fn find_dual_coherent(bencher: Bencher) {
    bench_queries(bencher, &coherent(), find_dual);
}

#[divan::bench]
fn find_dual_scattered(bencher: Bencher) {
    bench_queries(bencher, &scattered(), find_dual);
}

fn find_leaf(cell: [i64; 3]) {
    black_box(INDEX.find_leaf(cell));
}

/// Finds the eight cells of the finest level's dual cell that begins at `cell`.
fn find_dual(cell: [i64; 3]) {
    let last = INDEX.domain().high.map(|high| high - 1);
    let cells = std::array::from_fn(|axis| [cell[axis], last[axis].min(cell[axis] + 1)]);
    let planes = Planes { cells, active: Planes::ALL };
    INDEX.find_dual(LEVELS - 1, &planes, &mut |corner, found| {
        black_box((corner, found));
    });
}
