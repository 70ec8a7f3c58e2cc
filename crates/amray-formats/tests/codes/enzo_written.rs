//! Enzo dumps written here after Enzo's documentation: what real dumps at hand do not show.

use std::fs;
use std::path::Path;

use rust_hdf5::{FileLocking, H5File, H5Type};

use super::{names, opened, refused, values};

/// Two grids of 4x4x4 cells, side by side.
const GRID: [usize; 3] = [4; 3];

/// A dump `name` whose values have `values` written for each of the grids.
fn write(directory: &Path, name: &str, file: &str, values: impl Fn(usize, &rust_hdf5::H5Group)) {
    let parameters = "InitialTime = 0.5\nTopGridRank = 3\nTopGridDimensions = 8 4 4\nDomainLeftEdge = 0 0 0\n\
                      DomainRightEdge = 2 1 1\nRefineBy = 2\n";
    fs::write(directory.join(name), parameters).unwrap();
    let grid = |id: usize, next: usize| {
        format!(
            "Grid = {id}\nGridStartIndex = 3 3 3\nGridEndIndex = 6 6 6\nGridLeftEdge = {} 0 0\nGridRightEdge = {id} 1 1\n\
             BaryonFileName = ./{file}\nPointer: Grid[{id}]->NextGridThisLevel = {next}\n\
             Pointer: Grid[{id}]->NextGridNextLevel = 0\n",
            id - 1
        )
    };
    fs::write(directory.join(format!("{name}.hierarchy")), grid(1, 2) + &grid(2, 0)).unwrap();
    let hdf5 = H5File::options().locking(FileLocking::BestEffort).create(directory.join(format!("{name}.cpu0000")));
    let hdf5 = hdf5.unwrap();
    for id in 1..=2 {
        values(id, &hdf5.create_group(&format!("Grid{id:08}")).unwrap());
    }
    hdf5.close().unwrap();
}

fn set<T: H5Type>(group: &rust_hdf5::H5Group, name: &str, shape: [usize; 3], value: T) {
    let values = vec![value; shape.iter().product()];
    group.new_dataset::<T>().shape(shape).create(name).unwrap().write_raw(&values).unwrap();
}

fn density(id: usize, group: &rust_hdf5::H5Group) {
    set(group, "Density", GRID, id as f64);
}

#[test]
fn of_several_dumps_none_is_picked() {
    let directory = tempfile::tempdir().unwrap();
    for dump in 0..9 {
        let name = format!("DD000{dump}");
        write(directory.path(), &name, &format!("{name}.cpu0000"), density);
        if dump == 0 {
            // Grids without parameters are no dump.
            fs::write(directory.path().join("other.hierarchy"), "Grid = 1\n").unwrap();
            let data = opened(directory.path());
            assert_eq!(values(&*data, "Density", &[[0.5; 3], [1.5, 0.5, 0.5]]), [1.0, 2.0]);
        }
    }
    let error = refused(directory.path());
    let expected = ": 9 Enzo dumps (DD0000, DD0001, DD0002, DD0003, DD0004, DD0005, DD0006, DD0007, ...), expected one: \
                    pass the parameter file of one of them";
    assert!(error.ends_with(expected), "{error}");
    assert_eq!(names(&*opened(&directory.path().join("DD0003"))), ["Density"]);
}

#[test]
fn fields_that_are_left_out_are_told_with_the_reason() {
    let directory = tempfile::tempdir().unwrap();
    write(directory.path(), "a", "a.cpu0000", |id, group| {
        density(id, group);
        set(group, "Flat", [4, 4, 1], 0.0f64);
        set(group, "Bell\u{7}", GRID, 0.0f64);
        match id {
            1 => set(group, "Mixed", GRID, 0.0f32),
            _ => set(group, "Mixed", GRID, 0.0f64),
        }
        if id == 2 {
            set(group, "Late", GRID, 0.0f64);
        }
        group.new_dataset::<f64>().shape([7]).create("stars").unwrap().write_raw(&[0.0; 7]).unwrap();
    });
    let data = opened(&directory.path().join("a"));
    assert_eq!(names(&*data), ["Density"]);
    let mut warnings = data.warnings().to_vec();
    warnings.sort();
    let [bell, flat, late, mixed] = &warnings[..] else { panic!("{warnings:?}") };
    assert_eq!(bell, "Bell  is left out: its name has control characters");
    assert!(flat.starts_with("Flat is left out: "), "{flat}");
    assert!(flat.ends_with("Grid00000001/Flat: shape [4, 4, 1], expected [4, 4, 4]"), "{flat}");
    assert_eq!(late, "Late is left out: 1 of 2 grids lack it");
    assert_eq!(mixed, "Mixed is left out: single precision in some grids, double precision in others");
}

#[test]
fn damaged_headers_are_not_passed_over() {
    let directory = tempfile::tempdir().unwrap();
    write(directory.path(), "a", "a.cpu0000", |id, group| {
        density(id, group);
        set(group, "Energy", GRID, 0.0f32);
    });
    let path = directory.path().join("a.cpu0000");
    let content = fs::read(&path).unwrap();
    // A float of 4 bytes, of which each part is damaged in turn.
    let float = [0x11, 0x20, 0x1f, 0, 4, 0, 0, 0];
    let place = content.windows(float.len()).position(|bytes| bytes == float).unwrap();
    for offset in [0, 4, 5] {
        let mut damaged = content.clone();
        damaged[place + offset] ^= 0x0f;
        fs::write(&path, damaged).unwrap();
        let told = match amray_formats::open(&directory.path().join("a"), &amray_formats::OpenOptions::default()) {
            Ok(data) => data.warnings().join("\n"),
            Err(error) => error.to_string(),
        };
        assert!(told.contains("Grid00000001"), "{told:?}");
    }
}

#[test]
fn control_characters_stay_out_of_messages() {
    let directory = tempfile::tempdir().unwrap();
    write(directory.path(), "a", "b\u{1b}[31m.cpu0000", density);
    let error = refused(&directory.path().join("a"));
    assert!(error.contains(r#"grid 1: BaryonFileName "b\u{1b}[31m.cpu0000", expected a name without"#), "{error}");
    write(directory.path(), "a", "a.cpu0000", density);
    let parameters = fs::read_to_string(directory.path().join("a")).unwrap();
    fs::write(directory.path().join("a"), parameters.replace("Rank = 3", "Rank = 2 \u{1b}[31m")).unwrap();
    assert!(refused(&directory.path().join("a")).ends_with("2  [31m, expected 3 dimensions"));
}
