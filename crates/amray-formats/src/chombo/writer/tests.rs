//! What is written is read back by another library.

use std::path::{Path, PathBuf};

use amray::hierarchy::{Centering, Hierarchy, HierarchyError, IndexBox, LevelDescription, VoxelType};
use hdf5_reader::{Datatype, Hdf5File};
use tempfile::TempDir;

use super::ChomboWriter;
use crate::{AmrContent, ChomboFile, DataSet, FormatError, OpenOptions};

/// Two bricks over a 4 x 4 x 8 domain, and a finer one inside the first.
fn hierarchy(origin: [f64; 3], cell_size: [f64; 3], ratio: [i64; 3]) -> Result<Hierarchy, HierarchyError> {
    let domain = IndexBox::new([0, 0, 0], [4, 4, 8]);
    let bricks = vec![IndexBox::new([0; 3], [4; 3]), IndexBox::new([0, 0, 4], [4, 4, 8])];
    let coarse = LevelDescription { ratio: [1; 3], cell_size, domain, bricks };
    let fine = LevelDescription {
        ratio,
        cell_size: std::array::from_fn(|axis| cell_size[axis] / ratio[axis] as f64),
        domain: domain.refined(ratio),
        bricks: vec![IndexBox::new([1, 1, 1], [3, 2, 3]).refined(ratio)],
    };
    Hierarchy::new(origin, vec![coarse, fine])
}

fn new_file() -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("written.hdf5");
    (directory, path)
}

fn refusal(result: Result<ChomboWriter, FormatError>) -> String {
    result.err().expect("it must be refused").to_string()
}

fn create(
    path: &Path,
    hierarchy: &Hierarchy,
    components: &[&str],
    voxel_type: VoxelType,
    time: f64,
) -> Result<ChomboWriter, FormatError> {
    let centering = Centering::Cells;
    ChomboWriter::create(path, &AmrContent { hierarchy, components, centering, voxel_type, time })
}

fn attribute(file: &Hdf5File, group: &str, name: &str) -> hdf5_reader::Attribute {
    file.group(group).unwrap().attribute(name).unwrap()
}

fn integers(bytes: &[u8]) -> Vec<i32> {
    bytes.chunks_exact(4).map(|four| i32::from_le_bytes(four.try_into().unwrap())).collect()
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap())).collect()
}

#[test]
fn everything_is_read_back() {
    let (_directory, path) = new_file();
    let hierarchy = hierarchy([0.0; 3], [0.5; 3], [2; 3]).unwrap();
    let writer = create(&path, &hierarchy, &["density", "x-momentum"], VoxelType::F64, 1.5).unwrap();
    let numbers = |first: i32, count: i32| (first..first + count).map(f64::from).collect::<Vec<f64>>();
    // The last first, and one brick never.
    writer.write(1, 0, 1, 0, &numbers(3000, 32)).unwrap();
    writer.write(0, 1, 1, 0, &numbers(2000, 64)).unwrap();
    writer.write(0, 1, 0, 0, &[1.0f32; 64]).unwrap();
    writer.write(1, 0, 0, 0, &numbers(4000, 32)).unwrap();
    writer.finish().unwrap();

    let file = Hdf5File::open(&path).unwrap();
    for (name, expected) in [("num_levels", 2), ("max_level", 1), ("num_components", 2), ("iteration", 0)] {
        assert_eq!(attribute(&file, "/", name).read_scalar::<i32>().unwrap(), expected, "{name}");
    }
    assert_eq!(attribute(&file, "/", "filetype").read_string().unwrap(), "VanillaAMRFileType");
    assert_eq!(attribute(&file, "/", "component_1").read_string().unwrap(), "x-momentum");
    assert!(matches!(attribute(&file, "/", "component_1").datatype, Datatype::String { .. }));
    assert_eq!(attribute(&file, "/", "component_1").raw_data.len(), 10);
    assert_eq!(attribute(&file, "/", "time").read_scalar::<f64>().unwrap(), 1.5);
    assert_eq!(attribute(&file, "/Chombo_global", "SpaceDim").read_scalar::<i32>().unwrap(), 3);
    for (level, dx, domain) in [("/level_0", 0.5, [3, 3, 7]), ("/level_1", 0.25, [7, 7, 15])] {
        assert_eq!(attribute(&file, level, "dx").read_scalar::<f64>().unwrap(), dx);
        assert_eq!(attribute(&file, level, "ref_ratio").read_scalar::<i32>().unwrap(), 2);
        assert_eq!(attribute(&file, level, "time").read_scalar::<f64>().unwrap(), 1.5);
        let corners = attribute(&file, level, "prob_domain").raw_data;
        assert_eq!(corners.len(), 28);
        assert_eq!(integers(&corners)[..6], [[0; 3], domain].concat());
        let attributes = format!("{level}/data_attributes");
        assert_eq!(attribute(&file, &attributes, "comps").read_scalar::<i32>().unwrap(), 2);
        assert_eq!(integers(&attribute(&file, &attributes, "outputGhost").raw_data), [0; 3]);
        assert_eq!(attribute(&file, &attributes, "objectType").read_string().unwrap(), "FArrayBox");
    }
    let bytes = |name: &str| file.dataset(name).unwrap().read_raw_bytes().unwrap();
    assert_eq!(integers(&bytes("/level_0/boxes")), [0, 0, 0, 3, 3, 3, 0, 0, 0, 4, 3, 3, 7, 0]);
    assert_eq!(integers(&bytes("/level_1/boxes")), [2, 2, 2, 5, 3, 5, 0]);
    assert_eq!(integers(&bytes("/level_0/Processors")), [0, 0]);
    let offsets = file.dataset("/level_0/data:offsets=0").unwrap().read_array::<i64>().unwrap();
    assert_eq!(offsets.iter().copied().collect::<Vec<_>>(), [0, 128, 256]);
    let expected = [vec![0.0; 128], vec![1.0; 64], numbers(2000, 64)].concat();
    assert_eq!(doubles(&bytes("/level_0/data:datatype=0")), expected);
    assert_eq!(doubles(&bytes("/level_1/data:datatype=0")), [numbers(4000, 32), numbers(3000, 32)].concat());
}

#[test]
fn axes_that_differ_are_written_as_vectors_and_values_in_single_precision() {
    let (_directory, path) = new_file();
    let hierarchy = hierarchy([0.0; 3], [0.5, 0.5, 1.0], [2, 1, 4]).unwrap();
    let writer = create(&path, &hierarchy, &["a"], VoxelType::F32, 0.0).unwrap();
    writer.write(1, 0, 0, 0, &[1.0 / 3.0; 32]).unwrap();
    writer.finish().unwrap();
    let file = Hdf5File::open(&path).unwrap();
    assert_eq!(doubles(&attribute(&file, "/level_1", "vec_dx").raw_data), [0.25, 0.5, 0.25]);
    assert_eq!(integers(&attribute(&file, "/level_0", "vec_ref_ratio").raw_data), [2, 1, 4]);
    assert!(file.group("/level_0").unwrap().attribute("dx").is_err());
    let values = file.dataset("/level_1/data:datatype=0").unwrap().read_array::<f32>().unwrap();
    assert!(values.len() == 32 && values.iter().all(|&value| value == 1.0 / 3.0));
}

#[test]
fn an_origin_moves_the_indices_or_is_stated() {
    let (_directory, path) = new_file();
    let moved = hierarchy([-1.0, 0.5, 0.3 / 0.1 * 0.5], [0.5; 3], [2; 3]).unwrap();
    create(&path, &moved, &["a"], VoxelType::F64, 0.0).unwrap().finish().unwrap();
    let file = Hdf5File::open(&path).unwrap();
    assert_eq!(integers(&attribute(&file, "/level_0", "prob_domain").raw_data)[..6], [-2, 1, 3, 1, 4, 10]);
    assert_eq!(integers(&attribute(&file, "/level_1", "prob_domain").raw_data)[..6], [-4, 2, 6, 3, 9, 21]);
    let boxes = file.dataset("/level_1/boxes").unwrap().read_raw_bytes().unwrap();
    assert_eq!(integers(&boxes)[..6], [-2, 4, 8, 1, 5, 11]);

    let between = hierarchy([0.1, 0.0, 0.0], [0.5; 3], [2; 3]).unwrap();
    create(&path, &between, &["a"], VoxelType::F64, 0.0).unwrap().finish().unwrap();
    let file = Hdf5File::open(&path).unwrap();
    assert_eq!(doubles(&attribute(&file, "/", "origin").raw_data), [0.1, 0.0, 0.0]);
    assert_eq!(integers(&attribute(&file, "/level_0", "prob_domain").raw_data)[..6], [0, 0, 0, 3, 3, 7]);
    let read = ChomboFile::open(&path, &OpenOptions::default()).unwrap();
    assert_eq!(read.hierarchy().bounds(), between.bounds());
}

#[test]
fn a_brick_may_come_in_parts() {
    let (_directory, path) = new_file();
    let hierarchy = hierarchy([0.0; 3], [0.5; 3], [2; 3]).unwrap();
    let writer = create(&path, &hierarchy, &["a", "b"], VoxelType::F64, 0.0).unwrap();
    writer.write(0, 1, 1, 16, &[2.0; 48]).unwrap();
    writer.write(0, 1, 1, 0, &[1.0; 16]).unwrap();
    writer.finish().unwrap();
    let file = Hdf5File::open(&path).unwrap();
    let values = doubles(&file.dataset("/level_0/data:datatype=0").unwrap().read_raw_bytes().unwrap());
    assert_eq!(values, [vec![0.0; 192], vec![1.0; 16], vec![2.0; 48]].concat());
}

#[test]
fn indices_beyond_32_bits_are_refused() {
    let (directory, path) = new_file();
    let domain = IndexBox::new([0; 3], [(1 << 31) + 1, 8, 8]);
    let bricks = vec![IndexBox::new([0; 3], [8; 3])];
    let level = LevelDescription { ratio: [1; 3], cell_size: [1.0; 3], domain, bricks };
    let large = Hierarchy::new([0.0; 3], vec![level.clone()]).unwrap();
    let message = refusal(create(&path, &large, &["a"], VoxelType::F64, 0.0));
    let expected = "level 0: domain ((0,0,0) (2147483648,7,7)) does not fit Chombo's 32-bit indices";
    assert!(message.ends_with(expected), "{message}");
    // The origin counts too, whatever it is.
    let fits = LevelDescription { domain: IndexBox::new([0; 3], [8; 3]), ..level };
    for origin in [2147483641.0, -1e15] {
        let far = Hierarchy::new([origin, 0.0, 0.0], vec![fits.clone()]).unwrap();
        let message = refusal(create(&path, &far, &["a"], VoxelType::F64, 0.0));
        assert!(
            message.ends_with("level 0: domain ((0,0,0) (7,7,7)) does not fit Chombo's 32-bit indices"),
            "{message}"
        );
    }
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn a_level_may_be_empty_and_values_too_many() {
    let (_directory, path) = new_file();
    let domain = IndexBox::new([0; 3], [8; 3]);
    let coarse = LevelDescription { ratio: [1; 3], cell_size: [1.0; 3], domain, bricks: Vec::new() };
    let fine = LevelDescription {
        ratio: [2; 3],
        cell_size: [0.5; 3],
        domain: domain.refined([2; 3]),
        bricks: vec![domain.refined([2; 3])],
    };
    let hollow = Hierarchy::new([0.0; 3], vec![coarse, fine]).unwrap();
    create(&path, &hollow, &[], VoxelType::F64, 0.0).unwrap().finish().unwrap();
    create(&path, &hollow, &["a", ""], VoxelType::F64, 0.0).unwrap().finish().unwrap();
    let file = Hdf5File::open(&path).unwrap();
    assert_eq!(file.dataset("/level_0/boxes").unwrap().num_elements().unwrap(), 0);
    assert_eq!(file.dataset("/level_1/data:datatype=0").unwrap().num_elements().unwrap(), 2 * 16 * 16 * 16);

    let side = 1 << 20;
    let bricks = vec![IndexBox::new([0; 3], [side; 3])];
    let level = LevelDescription { ratio: [1; 3], cell_size: [1.0; 3], domain: bricks[0], bricks };
    let huge = Hierarchy::new([0.0; 3], vec![level]).unwrap();
    let message = refusal(create(&path, &huge, &["a", "b"], VoxelType::F64, 0.0));
    assert!(message.ends_with("level 0: 1 bricks of 2 components hold too many values"), "{message}");
}

#[test]
fn an_abandoned_file_leaves_the_old_one() {
    let (directory, path) = new_file();
    std::fs::write(&path, "old").unwrap();
    let hierarchy = hierarchy([0.0; 3], [0.5; 3], [2; 3]).unwrap();
    drop(create(&path, &hierarchy, &["a"], VoxelType::F64, 0.0).unwrap());
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    let nowhere = Path::new("/nonexistent/a.hdf5");
    let message = refusal(create(nowhere, &hierarchy, &["a"], VoxelType::F64, 0.0));
    assert!(message.starts_with("/nonexistent/a.hdf5: cannot write: "), "{message}");
}
