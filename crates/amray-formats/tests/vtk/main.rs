//! VTK's formats: files that VTK wrote, files written by hand, what is written here and read back, here and by VTK itself,
//! and damaged files.

mod by_hand;
mod damage;
mod real;
mod round_trip;
mod with_vtk;

use std::path::Path;
use std::sync::Arc;

use amray::hierarchy::{Centering, Field, Hierarchy, VoxelType};
use amray_formats::{AmrContent, AmrFormat, DataSet, OpenOptions, open};

/// A data set that must open.
fn opened(path: &Path) -> Box<dyn DataSet> {
    open(path, &OpenOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Why a data set does not open, or its first field cannot be read; without the directory.
fn refused(path: &Path) -> String {
    let read = open(path, &OpenOptions::default()).and_then(|data| data.read_field(0, &|_| {}));
    let error = read.expect_err("the data must be refused").to_string();
    error.replace(&format!("{}/", path.parent().unwrap().display()), "")
}

/// All values of a field, brick by brick, x fastest.
fn values(hierarchy: &Hierarchy, field: &Field) -> Vec<Vec<f64>> {
    let of_brick = |(number, cells)| {
        let places = field.centering().values_of(&cells);
        let index = |place: [i64; 3]| [0, 1, 2].map(|axis| (place[axis] - cells.low[axis]) as usize);
        places.iter().map(|place| field.value(number, index(place))).collect()
    };
    hierarchy.bricks().map(|brick| brick.cells).enumerate().map(of_brick).collect()
}

/// A value that tells its place, its component and its level.
fn value(level: usize, component: usize, [i, j, k]: [i64; 3]) -> f64 {
    i as f64 + 0.01 * j as f64 + 100.0 * k as f64 + 0.25 * component as f64 + 1e4 * level as f64
}

/// Writes components of [`value`]s.
fn write(path: &Path, hierarchy: &Hierarchy, components: &[&str], centering: Centering, voxel_type: VoxelType) {
    let content = AmrContent { hierarchy, components, centering, voxel_type, time: 0.0 };
    let writer = AmrFormat::of(path).unwrap().create(path, &content).unwrap_or_else(|error| panic!("{error}"));
    for brick in hierarchy.bricks() {
        let places = centering.values_of(&brick.cells);
        for component in 0..components.len() {
            let values: Vec<f64> = places.iter().map(|place| value(brick.level, component, place)).collect();
            // In two parts, the last one first.
            let half = values.len() / 2;
            writer.write(brick.level, brick.number, component, half, &values[half..]).unwrap();
            writer.write(brick.level, brick.number, component, 0, &values[..half]).unwrap();
        }
    }
    writer.finish().unwrap();
}

/// Two levels whose ratios and cell sizes differ between axes, off the origin.
fn uneven() -> Arc<Hierarchy> {
    use amray::hierarchy::{IndexBox, LevelDescription};
    let domain = IndexBox::new([-2, 0, 4], [6, 6, 8]);
    let bricks = vec![IndexBox::new([-2, 0, 4], [3, 6, 8]), IndexBox::new([3, 0, 4], [6, 6, 8])];
    let coarse = LevelDescription { ratio: [1; 3], cell_size: [0.5, 0.25, 1.0], domain, bricks };
    let ratio = [2, 1, 4];
    let fine = LevelDescription {
        ratio,
        cell_size: [0.25, 0.25, 0.25],
        domain: domain.refined(ratio),
        bricks: vec![IndexBox::new([0, 1, 5], [4, 4, 7]).refined(ratio)],
    };
    Arc::new(Hierarchy::new([0.1, -3.0, 7.5], vec![coarse, fine]).unwrap())
}
