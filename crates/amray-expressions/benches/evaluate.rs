//! How many cells a second expressions take, by one thread.

use std::hint::black_box;
use std::sync::Arc;

use amray::hierarchy::{Field, Hierarchy};
use amray_expressions::{Expression, Names, Program};
use amray_testing::nested;
use divan::Bencher;
use divan::counter::ItemsCount;

const NAMES: [&str; 4] = ["density", "vx", "vy", "vz"];

const EXPRESSIONS: [&str; 9] = [
    "density + 1",
    "density * vx + vy",
    "sqrt(vx^2 + vy^2 + vz^2)",
    "if(density > 0.5, vx, vy)",
    "log10(density)",
    "density * x",
    "gradient_x(density)",
    "gradient_magnitude(density)",
    "vorticity_magnitude(vx, vy, vz)",
];

fn main() {
    divan::main();
}

/// Bricks of 16^3 cells, as most codes have them.
fn data(single: bool) -> (Arc<Hierarchy>, Vec<Field>) {
    let hierarchy = Arc::new(nested(64, 3, 16));
    let value = |level: usize, [i, j, k]: [i64; 3]| 1.0 + ((i * 7 + j * 3 + k * 5 + level as i64) % 100) as f64 / 50.0;
    let fields = NAMES.map(|name| match single {
        true => Field::from_fn(name, &hierarchy, |level, cell| value(level, cell) as f32),
        false => Field::from_fn(name, &hierarchy, value),
    });
    (hierarchy, fields.to_vec())
}

#[divan::bench(args = EXPRESSIONS)]
fn double_precision(bencher: Bencher, expression: &str) {
    evaluate(bencher, expression, false);
}

#[divan::bench(args = EXPRESSIONS)]
fn single_precision(bencher: Bencher, expression: &str) {
    evaluate(bencher, expression, true);
}

fn evaluate(bencher: Bencher, expression: &str, single: bool) {
    let (hierarchy, fields) = data(single);
    let names = Names { fields: &NAMES, definitions: &[] };
    let program = Program::bind(&Expression::parse(expression).unwrap(), &names).unwrap();
    let fields: Vec<Field> = program.inputs().iter().map(|&number| fields[number].clone()).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    bencher
        .counter(ItemsCount::new(hierarchy.cells()))
        .bench(|| pool.install(|| black_box(program.evaluate("result", &hierarchy, &fields, &|_| {}))));
}
