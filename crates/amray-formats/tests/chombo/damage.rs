//! Damaged files give one line of error or the right shape of data; never a panic, a hang or a large allocation.

use std::path::Path;

use amray_formats::OpenOptions;
use amray_testing::{Random, real_data};
use proptest::prelude::*;

use crate::failure;
use crate::sample::{Sample, Set};

/// What opening and reading a damaged file complains of. `failure` checks that it is one line.
fn complaint(path: &Path, bytes: &[u8]) -> Option<String> {
    // A new file each time: overwriting one makes some file systems wait for the disk.
    if path.exists() {
        std::fs::remove_file(path).unwrap();
    }
    std::fs::write(path, bytes).unwrap();
    failure(path, &OpenOptions::default())
}

fn chunked() -> Sample {
    let mut sample = Sample::new(2, [1, 0, 0]);
    let values = sample.values(1);
    sample.set("level_1/data:datatype=0", Set::Chunked(values, 20));
    sample
}

#[test]
fn a_file_cut_short_anywhere_is_refused() {
    let (directory, path) = chunked().write();
    let whole = std::fs::read(&path).unwrap();
    let cut = directory.path().join("cut.hdf5");
    for length in 0..whole.len() {
        let error = complaint(&cut, &whole[..length]).expect("a part is not the whole");
        let expected = if length < 8 { "not an HDF5 file" } else { "superblock: " };
        assert!(error.starts_with(expected), "{length}: {error}");
    }
    assert_eq!(complaint(&cut, &whole), None);
    let error = complaint(&cut, &whole[..whole.len() - 1]).unwrap();
    assert_eq!(
        error,
        format!("superblock: the file is cut short: {} bytes, expected {}", whole.len() - 1, whole.len())
    );
}

#[test]
fn a_real_file_cut_short_is_refused() {
    let Some(path) = real_data("chombo/edge_vec_dx.3d.hdf5") else { return };
    let whole = std::fs::read(path).unwrap();
    let directory = tempfile::tempdir().unwrap();
    for length in (0..whole.len()).step_by(997) {
        assert!(complaint(&directory.path().join("cut.hdf5"), &whole[..length]).is_some(), "{length}");
    }
}

#[test]
fn what_the_missing_end_held_is_noticed() {
    // As above, but the length in the superblock is that of the part.
    let (directory, path) = chunked().write();
    let whole = std::fs::read(&path).unwrap();
    let stated = (whole.len() as u64).to_le_bytes();
    let place = whole.windows(8).position(|bytes| bytes == stated).expect("the superblock holds the length");
    let cut = directory.path().join("cut.hdf5");
    for length in place + 8..whole.len() {
        let mut bytes = whole[..length].to_vec();
        bytes[place..place + 8].copy_from_slice(&(length as u64).to_le_bytes());
        assert!(complaint(&cut, &bytes).is_some(), "{length}");
    }
}

#[test]
fn mutated_real_files_are_survived() {
    for name in ["edge_vec_dx.3d.hdf5", "bbh_ghosts3.3d.hdf5"] {
        let Some(path) = real_data(&format!("chombo/{name}")) else { return };
        let whole = std::fs::read(path).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let mut random = Random(1);
        for _ in 0..40 {
            let mut bytes = whole.clone();
            // Headers lie near the start and between the values.
            for _ in 0..random.integer(1, 20) {
                let reach = if random.chance(0.5) { 20_000 } else { bytes.len() };
                let place = random.integer(0, reach as i64 - 1) as usize;
                bytes[place] = random.bits() as u8;
            }
            complaint(&directory.path().join("mutated.hdf5"), &bytes);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_are_survived(
        compressed in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 1usize..9), 1..6),
    ) {
        let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/chombo_gzip_shuffle_f64.hdf5");
        let mut bytes = match compressed {
            true => std::fs::read(fixture).unwrap(),
            false => std::fs::read(chunked().write().1).unwrap(),
        };
        for (place, value, count) in changes {
            let place = place.index(bytes.len());
            let end = (place + count).min(bytes.len());
            bytes[place..end].fill(value);
        }
        let directory = tempfile::tempdir().unwrap();
        complaint(&directory.path().join("mutated.hdf5"), &bytes);
    }
}
