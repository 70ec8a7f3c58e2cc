//! Structured volumes: their readers, and the AMR data made of them.

mod brute_force;
mod readers;
mod refinement;
mod small_cases;

use std::path::{Path, PathBuf};

use amray::hierarchy::{Voxel, VoxelType};
use amray_formats::structured::amr::{Refined, Refinement, RefinementError};
use amray_formats::structured::{ByteOrder, NumberType, RawLayout, StructuredVolume};
use tempfile::TempDir;

/// A directory, and a file in it with this content.
fn file(name: &str, content: &[u8]) -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

/// A raw volume with these values.
fn raw_volume(size: [usize; 3], values: &[f64], voxel_type: VoxelType) -> (TempDir, StructuredVolume) {
    let (number_type, bytes): (_, Vec<u8>) = match voxel_type {
        VoxelType::F32 => (NumberType::F32, values.iter().flat_map(|&value| (value as f32).to_le_bytes()).collect()),
        VoxelType::F64 => (NumberType::F64, values.iter().flat_map(|value| value.to_le_bytes()).collect()),
    };
    let (directory, path) = file("volume.raw", &bytes);
    let layout = RawLayout { size: size.map(|samples| samples as u64), number_type, byte_order: ByteOrder::Little };
    (directory, StructuredVolume::open_raw(&path, &layout).unwrap())
}

/// All values of a volume, `count` slices at a time.
fn read_all<T: Voxel>(volume: &StructuredVolume, count: usize) -> Result<Vec<T>, amray_formats::FormatError> {
    let [_, _, depth] = volume.size();
    let mut reader = volume.slices(1 << 10)?;
    let (mut all, mut slices) = (Vec::new(), Vec::new());
    for first in (0..depth).step_by(count) {
        reader.read::<T>(count.min(depth - first), &mut slices)?;
        all.extend_from_slice(&slices);
    }
    Ok(all)
}

/// A refinement within a hundred megabytes.
fn refinement(brick: usize, threshold: f64, levels: Option<usize>) -> Refinement {
    Refinement { brick, threshold, levels, memory: 100_000_000 }
}

fn write(refinement: Refinement, volume: &StructuredVolume, path: &Path) -> Result<Refined, RefinementError> {
    refinement.write(volume, path, &|share| assert!((0.0..=1.0).contains(&share)))
}
