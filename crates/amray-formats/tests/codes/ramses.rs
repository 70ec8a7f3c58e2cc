//! RAMSES outputs, written here as the code's own routines (`output_info`, `backup_amr`, `backup_hydro`) write them: no
//! file of the code itself was at hand. yt 4 reads the same cells and values from what is written.

mod writer;

use std::fs;
use std::path::Path;

use amray::hierarchy::VoxelType;
use amray_formats::{OpenOptions, open};
use amray_testing::Random;

use super::damage::{mutated, survive};
use super::{cells, names, opened, refused, values};
use writer::{Descriptor, Output};

/// Three levels of cells in a box, the middle one and a corner of it refined: several processes.
fn output() -> Output {
    Output::new(3, |level, center| {
        let from_middle = (0..3).map(|axis| (center[axis] - 0.45).abs()).fold(0.0, f64::max);
        (level < 4 && from_middle < 0.2) || (level < 5 && from_middle < 0.2 && center[0] < 0.4)
    })
}

#[test]
fn values_of_all_processes_are_read() {
    for (single, big_endian, descriptor) in [
        (false, false, Descriptor::Table),
        (true, false, Descriptor::Lines),
        (false, true, Descriptor::Lines),
        (true, true, Descriptor::Table),
    ] {
        let directory = tempfile::tempdir().unwrap();
        let output = output().in_form(single, big_endian, descriptor);
        output.write(directory.path());
        let data = opened(directory.path());
        assert_eq!((data.format(), data.time()), ("RAMSES", Some(0.75)));
        assert_eq!(names(&*data), ["density", "velocity_x", "velocity_y", "velocity_z", "pressure"]);
        let voxel_type = if single { VoxelType::F32 } else { VoxelType::F64 };
        assert!(data.fields().iter().all(|field| field.voxel_type == voxel_type));
        assert_eq!(data.fields()[0].unit.as_deref(), Some("5e-1 g/cm^3"));
        assert_eq!(data.hierarchy().bounds(), [[0.0; 3], [2.5; 3]]);
        assert_eq!(cells(&*data), output.cells_by_level());
        assert!(data.hierarchy().warnings().is_empty() && data.warnings().is_empty());
        check_leaves(&output, directory.path());
    }
}

/// Holds every leaf cell to the function that was written.
fn check_leaves(output: &Output, path: &Path) {
    let data = opened(path);
    let leaves = output.leaves();
    for (variable, name) in names(&*data).into_iter().enumerate() {
        let tolerance = if output.single { 1e-4 } else { 1e-9 };
        for (found, leaf) in values(&*data, name, &leaves).into_iter().zip(&leaves) {
            let expected = Output::value(*leaf, variable);
            assert!((found - expected).abs() < tolerance * expected.abs(), "{name} at {leaf:?}: {found}, {expected}");
        }
    }
}

#[test]
fn any_file_of_an_output_opens_it() {
    let directory = tempfile::tempdir().unwrap();
    output().write(directory.path());
    let beside = ["namelist.txt", "part_00080.out00001", "picture.png", "info_00081.txt", "amr_00081.out00001"];
    for name in beside {
        fs::write(directory.path().join(name), "&RUN_PARAMS").unwrap();
    }
    let known = ["info_00080.txt", "amr_00080.out00003", "hydro_00080.out00001", "hydro_file_descriptor.txt"];
    for name in [&known[..], &beside[..2]].concat() {
        assert_eq!(opened(&directory.path().join(name)).format(), "RAMSES", "{name}");
    }
    for name in &beside[2..] {
        assert!(refused(&directory.path().join(name)).contains("expected Chombo"), "{name}");
    }
}

#[test]
fn coarse_cells_and_boundaries() {
    let refined = |level, center: [f64; 3]| level < 4 && center[0] < 0.3;
    for (coarse, inner, boundaries) in [([3, 1, 1], [[1, 0, 0], [2, 1, 1]], 2), ([2, 1, 3], [[0; 3], [2, 1, 3]], 0)] {
        let directory = tempfile::tempdir().unwrap();
        let output = Output::inside(coarse, inner, boundaries, 2, refined);
        output.write(directory.path());
        let data = opened(directory.path());
        let high = std::array::from_fn(|axis| 2.5 * f64::from(inner[1][axis] - inner[0][axis]));
        assert_eq!(data.hierarchy().bounds(), [[0.0; 3], high]);
        assert_eq!(cells(&*data), output.cells_by_level());
        check_leaves(&output, directory.path());
    }
}

#[test]
fn levels_may_be_left_out() {
    let directory = tempfile::tempdir().unwrap();
    let output = output();
    output.write(directory.path());
    let with = |level| open(directory.path(), &OpenOptions { max_level: Some(level), ..OpenOptions::default() });
    let coarse = with(1).unwrap();
    assert_eq!(cells(&*coarse), output.cells_by_level()[..2]);
    // Covered cells have values of their own.
    let center = [0.859375, 1.015625, 1.015625];
    assert!((values(&*coarse, "density", &[center])[0] - Output::value(center, 0)).abs() < 1e-9);
    assert!(with(3).err().unwrap().to_string().contains("no level 3"));
}

#[test]
fn a_level_that_does_not_fill_the_domain_is_no_first_one() {
    let directory = tempfile::tempdir().unwrap();
    let mut output = output();
    output.level_min = 4;
    output.write(directory.path());
    assert_eq!(cells(&*opened(directory.path())), output.cells_by_level());
    fs::remove_file(directory.path().join("hydro_file_descriptor.txt")).unwrap();
    let data = opened(directory.path());
    assert_eq!(names(&*data), ["variable_1", "variable_2", "variable_3", "variable_4", "variable_5"]);
    assert!(data.warnings()[0].contains("no hydro_file_descriptor.txt"));
}

#[test]
fn twenty_levels_of_small_grids_are_few_bricks() {
    let directory = tempfile::tempdir().unwrap();
    let near = |level: usize, center: [f64; 3]| {
        let cells = 2f64.powi(level as i32);
        level < 22 && center.iter().all(|along| along * cells < 8.0)
    };
    let output = Output::new(3, near);
    output.write(directory.path());
    let options = OpenOptions { memory: Some(1 << 16), ..OpenOptions::default() };
    for options in [OpenOptions::default(), options] {
        let data = open(directory.path(), &options).unwrap();
        assert_eq!(data.hierarchy().levels().len(), 20);
        assert_eq!(cells(&*data), [vec![512], vec![4096; 19]].concat());
        assert_eq!(data.hierarchy().brick_count(), 20);
        assert!(data.read_field(2, &|_| {}).is_ok());
    }
    check_leaves(&output, directory.path());
}

/// An output, one of whose files is changed again and again.
fn changed(name: &str, change: impl Fn(&mut Random, &[u8]) -> Vec<u8>, check: impl Fn(Result<(), String>)) {
    for (single, big_endian) in [(false, false), (true, true)] {
        let directory = tempfile::tempdir().unwrap();
        output().in_form(single, big_endian, Descriptor::Table).write(directory.path());
        let file = directory.path().join(name);
        let content = fs::read(&file).unwrap();
        let mut random = Random(5);
        for _ in 0..150 {
            fs::write(&file, change(&mut random, &content)).unwrap();
            check(survive(directory.path()));
        }
    }
}

#[test]
fn damaged_files_are_refused_or_read() {
    for (name, head) in [
        ("info_00080.txt", 600),
        ("hydro_file_descriptor.txt", 100),
        ("amr_00080.out00001", 1500),
        ("amr_00080.out00002", usize::MAX),
        ("hydro_00080.out00001", 200),
        ("hydro_00080.out00002", usize::MAX),
    ] {
        changed(name, |random, content| mutated(content, random, head), |_| {});
    }
}

#[test]
fn files_that_were_cut_short_are_refused() {
    let cut =
        |random: &mut Random, content: &[u8]| content[..random.integer(0, content.len() as i64 - 1) as usize].to_vec();
    for name in ["amr_00080.out00002", "hydro_00080.out00003"] {
        changed(name, cut, |result| assert!(result.is_err()));
    }
}

#[test]
fn errors_name_the_file_and_the_place() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    output().write(path);
    let replaced = |name: &str, from: &str, to: &str| {
        let text = fs::read_to_string(path.join(name)).unwrap();
        fs::write(path.join(name), text.replace(from, to)).unwrap();
        let error = refused(path);
        fs::write(path.join(name), text).unwrap();
        error
    };
    let dimensions = replaced("info_00080.txt", "ndim        =          3", "ndim        =          2");
    assert!(dimensions.ends_with("info_00080.txt: line 2, ndim: 2, expected 3 dimensions"), "{dimensions}");
    let cpus = replaced("info_00080.txt", "ncpu        =          3", "ncpu        =          2");
    assert!(cpus.ends_with("ncpu: 3, expected 2 by the info file"), "{cpus}");
    let hydro = path.join("hydro_00080.out00002");
    let content = fs::read(&hydro).unwrap();
    fs::write(&hydro, fs::read(path.join("hydro_00080.out00001")).unwrap()).unwrap();
    assert!(refused(path).contains("grids, expected"), "{}", refused(path));
    fs::write(&hydro, &content[..4]).unwrap();
    assert!(refused(path).ends_with("ncpu at byte 0: a record of 4 bytes, 4 bytes are left"), "{}", refused(path));
    fs::remove_file(&hydro).unwrap();
    assert!(refused(path).contains("hydro_00080.out00002: cannot open"), "{}", refused(path));
    fs::write(&hydro, &content).unwrap();
    let mesh = path.join("amr_00080.out00002");
    fs::write(&mesh, fs::read(path.join("amr_00080.out00001")).unwrap()).unwrap();
    assert!(survive(path).is_err());
}
