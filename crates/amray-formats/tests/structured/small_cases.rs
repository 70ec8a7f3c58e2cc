//! Refinement: cases that can be counted by hand, and what is refused.

use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription, VoxelType};
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::structured::amr::{Refined, Refinement};
use amray_formats::{OpenOptions, open};
use amray_testing::Random;

use super::{raw_volume, refinement, write};

/// Bricks per level of what a volume becomes.
fn bricks(size: [usize; 3], values: &[f64], refinement: Refinement) -> (Vec<usize>, Refined) {
    let (directory, volume) = raw_volume(size, values, VoxelType::F32);
    let path = directory.path().join("a.hdf5");
    let refined = write(refinement, &volume, &path).unwrap();
    let read = open(&path, &OpenOptions::default()).unwrap();
    assert_eq!(read.hierarchy().brick_count(), refined.hierarchy.brick_count());
    (refined.hierarchy.levels().iter().map(|level| level.bricks().len()).collect(), refined)
}

#[test]
fn a_constant_volume_keeps_one_coarse_brick() {
    for value in [0.1, f64::NAN] {
        let (found, refined) = bricks([64, 32, 64], &[value; 64 * 32 * 64], refinement(16, 0.0, None));
        assert_eq!(found, [1]);
        assert_eq!((refined.hierarchy.cells(), refined.max_error, refined.mean_error), (16 * 8 * 16, 0.0, 0.0));
    }
}

#[test]
fn holes_in_one_value_are_kept() {
    // Squares of 2x2 samples: the next coarser level has them all, the ones beyond do not.
    let hole = |place: usize| place % 64 / 2 % 8 == 3 && place / 64 / 2 % 8 == 5;
    let values: Vec<f64> = (0..64 * 64).map(|place| if hole(place) { f64::NAN } else { 0.25 }).collect();
    let (found, refined) = bricks([64, 1, 64], &values, refinement(4, 0.0, None));
    // A brick for each of 16 holes, and the first one.
    assert_eq!((&found[3..], found.len()), (&[17, 1][..], 5));
    assert_eq!(refined.max_error, 0.0);
}

#[test]
fn one_sample_keeps_a_brick_of_every_level() {
    let mut values = vec![1.0; 64 * 64 * 64];
    values[40 + 64 * (3 + 64 * 63)] = 2.0;
    let (found, _) = bricks([64; 3], &values, refinement(8, 0.0, None));
    assert_eq!(found, [1, 1, 1, 1]);
    // On level 1, the cell around it is 1 + 1/512; 1 - 1/8 from it on level 3.
    let (found, refined) = bricks([64; 3], &values, refinement(8, 0.9, None));
    // The finest level's first brick tells its grid.
    assert_eq!(found, [1, 2, 2, 1]);
    assert_eq!(refined.hierarchy.levels()[3].bricks()[0], IndexBox::new([0; 3], [8; 3]));
    assert_eq!((refined.max_error, refined.mean_error), (0.875, (0.875 + 7.0 * 0.125) / 64f64.powi(3)));
    let (found, refined) = bricks([64; 3], &values, refinement(8, 1.0, None));
    assert_eq!((found, refined.max_error), (vec![1, 1, 1, 1], 1.0 - 1.0 / 512.0));
}

#[test]
fn volumes_are_padded_at_their_high_ends_alone() {
    // One axis of 21 = 16 + 5 samples: the rim of 5 is kept, and a cell beside it.
    let (found, refined) = bricks([21, 16, 16], &[3.0; 21 * 16 * 16], refinement(8, 0.0, None));
    let levels = refined.hierarchy.levels();
    // 21, 11, 6 cells of which bricks hold 22, 12, 6.
    assert_eq!(found, [1, 1, 4]);
    assert_eq!(levels[2].bricks()[0], IndexBox::new([16, 0, 0], [22, 8, 8]));
    assert_eq!(levels[1].bricks()[0], IndexBox::new([8, 0, 0], [12, 8, 8]));
    assert_eq!(levels[0].bricks()[0], IndexBox::new([0; 3], [6, 4, 4]));
    assert_eq!(levels[2].domain(), IndexBox::new([0; 3], [24, 16, 16]));
    // Samples one apart from the origin on are the cells' centres.
    assert_eq!(refined.hierarchy.bounds(), [[-0.5; 3], [23.5, 15.5, 15.5]]);
}

#[test]
fn flat_volumes_stay_flat() {
    let (_, refined) = bricks([32, 1, 3], &[0.0; 96], refinement(4, 0.0, None));
    let ratios: Vec<_> = refined.hierarchy.levels().iter().map(amray::hierarchy::Level::ratio).collect();
    assert_eq!(ratios, [[1, 1, 1], [2, 1, 1], [2, 1, 2], [2, 1, 2]]);
}

/// Where the lowest and the highest value are in the first and the last cell, a volume normalises as one level does.
#[test]
fn a_volume_of_threshold_0_samples_to_the_same_bits() {
    let side = 32;
    let mut random = Random(7);
    let mut values: Vec<f64> = (0..side * side * side)
        .map(|number| if number % side < side / 2 { 0.25 } else { f64::from(random.unit() as f32) })
        .collect();
    values[0] = -1.0;
    *values.last_mut().unwrap() = 2.0;
    let (directory, volume) = raw_volume([side; 3], &values, VoxelType::F32);
    let path = directory.path().join("a.hdf5");
    write(refinement(8, 0.0, None), &volume, &path).unwrap();
    let data = open(&path, &OpenOptions::default()).unwrap();
    let cells: Vec<u64> = data.hierarchy().levels().iter().map(amray::hierarchy::Level::cells).collect();
    assert!(cells[2] < (side * side * side) as u64 && cells[2] >= (side * side * side / 2) as u64, "{cells:?}");
    let sample = |hierarchy: &Arc<Hierarchy>, field: Field, points: &[[f64; 3]]| {
        Volume::new(Arc::new(Index::build(hierarchy.clone())), field, Method::Finest).sample(points)
    };
    let domain = IndexBox::new([0; 3], [side as i64; 3]);
    let level = LevelDescription { ratio: [1; 3], cell_size: [1.0; 3], domain, bricks: vec![domain] };
    let original = Arc::new(Hierarchy::new([-0.5; 3], vec![level]).unwrap());
    let field = Field::from_fn("value", &original, |_, [x, y, z]| {
        values[x as usize + side * (y as usize + side * z as usize)] as f32
    });
    let points: Vec<_> = (0..5000).map(|_| random.point(original.bounds())).collect();
    let expected = sample(&original, field, &points);
    let found = sample(data.hierarchy(), data.read_field(0, &|_| {}).unwrap(), &points);
    let different = expected.iter().zip(&found).filter(|(expected, found)| expected.to_bits() != found.to_bits());
    assert_eq!(different.count(), 0);
}

#[test]
fn any_memory_that_is_enough_gives_the_same_file() {
    let size = [40, 33, 37];
    let mut random = Random(5);
    let values: Vec<f64> = (0..size.iter().product::<usize>()).map(|_| random.unit()).collect();
    let (directory, volume) = raw_volume(size, &values, VoxelType::F64);
    let path = directory.path().join("a.hdf5");
    let convert = |memory: u64| {
        let refined = write(Refinement { memory, ..refinement(8, 0.3, None) }, &volume, &path);
        refined.map(|_| std::fs::read(&path).unwrap()).map_err(|error| error.to_string())
    };
    let plenty = convert(1 << 30).unwrap();
    let refused = convert(1000).unwrap_err();
    let needed = refused.strip_prefix("1000 bytes of memory, expected at least ").expect("it says what is needed");
    let needed: u64 = needed.parse().unwrap();
    assert_eq!(convert(needed).unwrap(), plenty);
    assert_eq!(convert(needed + 50_000).unwrap(), plenty);
    assert!(convert(needed - 1).is_err());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 2, "temporary files are gone");
}

#[test]
fn parameters_out_of_range_are_refused() {
    let (directory, volume) = raw_volume([5, 4, 3], &[0.0; 60], VoxelType::F32);
    let path = directory.path().join("a.hdf5");
    let error = |refinement: Refinement| write(refinement, &volume, &path).unwrap_err().to_string();
    assert_eq!(error(refinement(7, 0.0, None)), "the brick size is 7, expected an even number from 4 to 256");
    assert_eq!(error(refinement(8, -1.0, None)), "the threshold is -1, expected a finite number, not below 0");
    assert!(error(refinement(8, f64::NAN, None)).starts_with("the threshold is NaN"));
    assert_eq!(error(refinement(8, 0.0, Some(5))), "the number of levels is 5, expected 1 to 4");
    assert!(write(refinement(8, 0.0, Some(4)), &volume, &path).is_ok());
    let error = write(refinement(8, 0.0, None), &volume, &directory.path().join("a.vtk")).unwrap_err().to_string();
    assert!(error.ends_with("a.vtk: ending .vtk, expected .hdf5 or .h5 (Chombo), .vthb or .vtkhdf (VTK)"), "{error}");
    let nowhere = write(refinement(8, 0.0, None), &volume, std::path::Path::new("/nonexistent/a.hdf5"));
    let error = nowhere.unwrap_err().to_string();
    assert!(error.starts_with("/nonexistent/a.hdf5: cannot write: "), "{error}");
}
