//! What was written is read again: geometry, fields, every value.

use std::sync::Mutex;

use amray::hierarchy::Residence;

use super::super::real_format::ByteOrder;
use super::synthetic::{FIELDS, PLAIN, RATIO, Synthetic, bricks, domains, value};
use super::*;

fn assert_holds_what_was_written(plotfile: &AmrexPlotfile, synthetic: Synthetic) {
    let hierarchy = plotfile.hierarchy();
    for (field, name) in FIELDS.into_iter().enumerate() {
        let values = read(plotfile, field);
        assert_eq!((values.name(), values.voxel_type()), (name, synthetic.voxel_type));
        let residence = if synthetic.byte_order.is_native() { Residence::Mapped } else { Residence::Owned };
        assert_eq!(values.bytes(residence), hierarchy.cells() * synthetic.voxel_type.bytes() as u64);
        for (number, brick) in hierarchy.bricks().enumerate() {
            for cell in brick.cells.iter() {
                let place = std::array::from_fn(|axis| (cell[axis] - brick.cells.low[axis]) as usize);
                let expected = value(field, brick.level, cell);
                assert_eq!(values.value(number, place), expected, "{synthetic:?}: {name}, {brick:?}, cell {cell:?}");
            }
        }
    }
}

#[test]
fn every_version_format_and_number_of_ghost_cells() {
    for version in 1..=4 {
        for voxel_type in [VoxelType::F32, VoxelType::F64] {
            for byte_order in [ByteOrder::Little, ByteOrder::Big] {
                for ghosts in [[0; 3], [1; 3], [2, 1, 0]] {
                    let synthetic = Synthetic { version, voxel_type, byte_order, ghosts };
                    let directory = tempfile::tempdir().unwrap();
                    synthetic.write(directory.path());
                    assert_holds_what_was_written(&open(directory.path()).unwrap(), synthetic);
                }
            }
        }
    }
}

#[test]
fn geometry_is_that_of_the_header() {
    let directory = tempfile::tempdir().unwrap();
    PLAIN.write(directory.path());
    let plotfile = open(directory.path()).unwrap();
    let hierarchy = plotfile.hierarchy();
    assert_eq!((plotfile.format(), plotfile.time()), ("AMReX plotfile", Some(2.5)));
    assert_eq!(plotfile.warnings(), [""; 0]);
    assert_eq!(hierarchy.origin(), [12.0, 0.0, -5.0]);
    assert_eq!(hierarchy.bounds(), [[10.0, 0.0, -1.0], [14.0, 4.0, 7.0]]);
    for (level, found) in hierarchy.levels().iter().enumerate() {
        assert_eq!((found.domain(), found.bricks()), (domains()[level], bricks()[level].as_slice()));
        assert_eq!(found.ratio(), [[1; 3], RATIO][level]);
        assert_eq!(found.cell_size(), [[0.5, 1.0, 2.0], [0.25, 1.0, 0.5]][level]);
    }
}

#[test]
fn progress_ends_at_one() {
    let directory = tempfile::tempdir().unwrap();
    PLAIN.write(directory.path());
    let told = Mutex::new(Vec::new());
    open(directory.path()).unwrap().read_field(0, &|share| told.lock().unwrap().push(share)).unwrap();
    let mut told = told.into_inner().unwrap();
    told.sort_by(f64::total_cmp);
    assert_eq!(told, [0.2, 0.4, 0.6, 0.8, 1.0]);
}

#[test]
fn other_coordinates_are_a_warning() {
    let directory = tempfile::tempdir().unwrap();
    PLAIN.write(directory.path());
    let header = directory.path().join("Header");
    let text = std::fs::read_to_string(&header).unwrap().replacen("0.5 \n0\n", "0.5 \n1\n", 1);
    std::fs::write(&header, text).unwrap();
    assert_eq!(
        open(directory.path()).unwrap().warnings(),
        ["the coordinates are cylindrical, but are shown as if they were Cartesian"]
    );
}
