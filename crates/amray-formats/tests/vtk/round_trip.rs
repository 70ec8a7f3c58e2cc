//! What is written is read back, by every format.

use std::fs;
use std::path::Path;

use amray::hierarchy::{Centering, Residence, VoxelType};
use amray_formats::{AmrContent, AmrFormat};

use super::{opened, uneven, value, values, write};

#[test]
fn every_format_gives_back_what_it_was_given() {
    let directory = tempfile::tempdir().unwrap();
    let hierarchy = uneven();
    for name in ["a.vthb", "a.vtkhdf", "a.hdf5"] {
        for centering in [Centering::Cells, Centering::Nodes] {
            for voxel_type in [VoxelType::F32, VoxelType::F64] {
                let path = directory.path().join(name);
                let names = ["phi <&\"x", "velocity"];
                write(&path, &hierarchy, &names, centering, voxel_type);
                let data = opened(&path);
                let place = format!("{name} {centering:?} {voxel_type:?}");
                assert_eq!(data.fields().iter().map(|field| &field.name).collect::<Vec<_>>(), names, "{place}");
                let read = data.hierarchy();
                for (found, expected) in read.levels().iter().zip(hierarchy.levels()) {
                    assert_eq!((found.ratio(), found.cell_size()), (expected.ratio(), expected.cell_size()), "{place}");
                }
                for (brick, (found, expected)) in read.bricks().zip(hierarchy.bricks()).enumerate() {
                    assert_eq!((found.level, found.cells), (expected.level, expected.cells), "{place} {brick}");
                }
                assert_eq!((read.origin(), read.bounds()), (hierarchy.origin(), hierarchy.bounds()), "{place}");
                for component in 0..2 {
                    let field = data.read_field(component, &|_| {}).unwrap();
                    assert_eq!((field.centering(), field.voxel_type()), (centering, voxel_type), "{place}");
                    assert!(field.bytes(Residence::Owned) == 0, "{place}");
                    for (brick, found) in hierarchy.bricks().zip(values(read, &field)) {
                        let places = centering.values_of(&brick.cells);
                        let expected = places.iter().map(|place| match voxel_type {
                            VoxelType::F32 => f64::from(value(brick.level, component, place) as f32),
                            VoxelType::F64 => value(brick.level, component, place),
                        });
                        assert_eq!(found, expected.collect::<Vec<_>>(), "{place} {brick:?}");
                    }
                }
            }
        }
    }
    // Nothing temporary is left, and images of an earlier run were replaced.
    let mut left: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["a", "a.hdf5", "a.vthb", "a.vtkhdf"]);
    assert_eq!(fs::read_dir(directory.path().join("a")).unwrap().count(), 3);
}

fn create(path: &Path, components: &[&str]) -> Result<(), String> {
    let (hierarchy, centering, voxel_type) = (uneven(), Centering::Cells, VoxelType::F32);
    let content = AmrContent { hierarchy: &hierarchy, components, centering, voxel_type, time: 0.0 };
    let writer = AmrFormat::of(path).unwrap().create(path, &content);
    writer.map(drop).map_err(|error| error.to_string())
}

#[test]
fn nothing_else_is_overwritten() {
    let directory = tempfile::tempdir().unwrap();
    fs::create_dir(directory.path().join("a")).unwrap();
    let other = directory.path().join("a/notes.txt");
    fs::write(&other, "mine").unwrap();
    let path = directory.path().join("a.vthb");
    let error = create(&path, &["phi"]).unwrap_err();
    let expected = "cannot write images into: notes.txt is in the way: remove it, or choose another name";
    assert!(error.ends_with(expected), "{error}");
    assert_eq!(fs::read(&other).unwrap(), b"mine");
    fs::remove_file(&other).unwrap();
    // What is given up leaves nothing.
    create(&path, &["phi"]).unwrap();
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}

#[test]
fn names_that_hdf5_cannot_have_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    for name in ["a/b", "", "."] {
        let error = create(&directory.path().join("a.vtkhdf"), &[name]).unwrap_err();
        assert!(
            error.ends_with(&format!("fields: {name:?} is no name in HDF5: expected one without a slash")),
            "{error}"
        );
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
