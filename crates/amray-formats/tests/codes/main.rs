//! Real files of simulation codes: what they hold, by other programs' reading of them, and what happens to damaged copies.

mod athena;
mod athena_written;
mod damage;
mod enzo;
mod enzo_written;
mod flash;
mod ramses;

use std::path::Path;
use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::Level;
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{DataSet, OpenOptions, find_field, open};

/// A data set that must open.
fn opened(path: &Path) -> Box<dyn DataSet> {
    open(path, &OpenOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Why a data set does not open.
fn refused(path: &Path) -> String {
    open(path, &OpenOptions::default()).err().expect("the data must be refused").to_string()
}

/// The names of all fields.
fn names(data: &dyn DataSet) -> Vec<&str> {
    data.fields().iter().map(|field| field.name.as_str()).collect()
}

/// Cells per level, covered ones included.
fn cells(data: &dyn DataSet) -> Vec<u64> {
    data.hierarchy().levels().iter().map(Level::cells).collect()
}

/// A field of a data set, in its cells.
fn volume(data: &dyn DataSet, field: &str) -> Volume {
    let number = find_field(Path::new("data"), data.fields(), field).unwrap();
    let field = data.read_field(number, &|_| {}).unwrap();
    Volume::new(Arc::new(Index::build(data.hierarchy().clone())), field, Method::Nearest)
}

/// The values of the leaf cells at some points.
fn values(data: &dyn DataSet, field: &str, points: &[[f64; 3]]) -> Vec<f64> {
    volume(data, field).sample_with_gradients(points).into_iter().map(|sample| sample.value).collect()
}

/// The integral of a field over the domain.
fn integral(data: &dyn DataSet, field: &str) -> f64 {
    volume(data, field).fold_leaf_cells(|| 0.0, |sum, cell| *sum += cell.value * cell.volume, |a, b| a + b)
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1e-9), "{found}, expected {expected}");
}
