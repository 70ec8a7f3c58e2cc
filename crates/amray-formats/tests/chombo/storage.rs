//! However values are stored, they are the same: compressed, in chunks, big-endian, in single precision.

use std::path::{Path, PathBuf};

use amray::hierarchy::{IndexBox, Residence, VoxelType};
use amray_formats::{ChomboFile, DataSet, OpenOptions};

use crate::sample::{Sample, Set, value};
use crate::{failure, open, read};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

/// Every cell of every field holds the value of the samples.
fn assert_values(path: &Path, voxel_type: VoxelType, residence: Residence) {
    assert_values_of(&open(path), voxel_type, residence);
}

fn assert_values_of(data: &ChomboFile, voxel_type: VoxelType, residence: Residence) {
    for component in 0..2 {
        let field = read(data, component);
        assert_eq!(field.voxel_type(), voxel_type);
        assert_eq!(field.bytes(residence), data.hierarchy().cells() * voxel_type.bytes() as u64);
        for (number, brick) in data.hierarchy().bricks().enumerate() {
            let IndexBox { low, .. } = brick.cells;
            for cell in brick.cells.iter() {
                let inside = std::array::from_fn(|axis| (cell[axis] - low[axis]) as usize);
                assert_eq!(field.value(number, inside), value(component, brick.level, cell), "{brick:?}");
            }
        }
    }
}

#[test]
fn compressed_values_are_read() {
    assert_values(&fixture("chombo_gzip_shuffle_f64.hdf5"), VoxelType::F64, Residence::Owned);
    assert_values(&fixture("chombo_gzip_f32.hdf5"), VoxelType::F32, Residence::Owned);
}

#[test]
fn values_beyond_the_memory_go_into_a_scratch_file() {
    let path = fixture("chombo_gzip_shuffle_f64.hdf5");
    for (memory, residence) in [(Some(100), Residence::Mapped), (Some(1 << 30), Residence::Owned)] {
        let data = ChomboFile::open(&path, &OpenOptions { memory, ..OpenOptions::default() }).unwrap();
        assert_values_of(&data, VoxelType::F64, residence);
    }
}

#[test]
fn big_endian_values_are_turned() {
    let residence = if cfg!(target_endian = "little") { Residence::Owned } else { Residence::Mapped };
    assert_values(&fixture("chombo_big_endian_f32.hdf5"), VoxelType::F32, residence);
}

#[test]
fn strings_of_variable_length_are_names_too() {
    let data = open(&fixture("chombo_gzip_f32.hdf5"));
    let names: Vec<_> = data.fields().iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["x-momentum", "density"]);
}

#[test]
fn an_unknown_compression_is_named() {
    assert_eq!(
        failure(&fixture("chombo_lzf.hdf5"), &OpenOptions::default()).unwrap(),
        "level_0/data:datatype=0: compressed in a way that cannot be read (filter id 32000), \
         expected gzip, szip, lz4 or none (h5repack can change it)"
    );
}

#[test]
fn chunks_of_any_length_give_the_same_values() {
    for ghosts in [[0, 0, 0], [1, 0, 2]] {
        let plain = Sample::new(3, ghosts);
        assert_values(&plain.write().1, VoxelType::F64, Residence::Mapped);
        for chunk in [1, 7, 32, 100, 5000] {
            let mut sample = plain.clone();
            for level in 0..3 {
                sample.set(&format!("level_{level}/data:datatype=0"), Set::Chunked(plain.values(level), chunk));
            }
            assert_values(&sample.write().1, VoxelType::F64, Residence::Owned);
        }
    }
}

#[test]
fn many_bricks_are_read_in_runs() {
    // A row of 512 bricks of one cell, in chunks that hold two and a half bricks.
    let mut sample = Sample::new(1, [0; 3]);
    let boxes: Vec<[i32; 6]> = (0..512).map(|i| [i, 0, 0, i, 0, 0]).collect();
    let values = boxes.iter().flat_map(|cell| [0, 1].map(|component| value(component, 0, [cell[0].into(), 0, 0])));
    sample.set("level_0/data:datatype=0", Set::Chunked(values.collect(), 5));
    sample.set("level_0/data:offsets=0", Set::Integers((0..=512).map(|brick| 2 * brick).collect()));
    sample.set("level_0/boxes", Set::Boxes(boxes));
    sample.attribute("level_0/prob_domain", crate::sample::Attribute::Box([0, 0, 0, 511, 0, 0]));
    assert_values(&sample.write().1, VoxelType::F64, Residence::Owned);
}

#[test]
fn single_precision_is_kept() {
    let mut sample = Sample::new(2, [0, 1, 0]);
    for level in 0..2 {
        let values = sample.values(level).into_iter().map(|value| value as f32).collect();
        sample.set(&format!("level_{level}/data:datatype=0"), Set::Singles(values));
    }
    assert_values(&sample.write().1, VoxelType::F32, Residence::Mapped);
}

#[test]
fn progress_ends_at_one() {
    let path = fixture("chombo_gzip_f32.hdf5");
    for path in [path, Sample::new(2, [0; 3]).write().1] {
        let told = std::sync::Mutex::new(Vec::new());
        open(&path).read_field(0, &|share| told.lock().unwrap().push(share)).unwrap();
        let told = told.into_inner().unwrap();
        assert!(told.contains(&1.0) && told.iter().all(|share| (0.0..=1.0).contains(share)), "{told:?}");
    }
}
