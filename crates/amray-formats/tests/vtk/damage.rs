//! Damaged copies: whatever happens to them, they are refused with a reason or read.

use std::fs;
use std::path::Path;

use amray::hierarchy::{Centering, VoxelType};
use amray_formats::{OpenOptions, open};
use amray_testing::Random;

use super::{uneven, write};

/// Opens what may be damaged and reads its fields.
fn look(path: &Path) {
    let Ok(data) = open(path, &OpenOptions::default()) else { return };
    for field in 0..data.fields().len() {
        let _ = data.read_field(field, &|_| {});
    }
}

/// Damages a file of a data set again and again.
fn damage(path: &Path, file: &Path, rounds: usize) {
    let content = fs::read(file).unwrap();
    let mut random = Random(11);
    for _ in 0..rounds {
        let mut damaged = content.clone();
        for _ in 0..random.integer(1, 6) {
            damaged[random.integer(0, content.len() as i64 - 1) as usize] = random.bits() as u8;
        }
        fs::write(file, &damaged).unwrap();
        look(path);
        damaged.truncate(random.integer(0, content.len() as i64 - 1) as usize);
        fs::write(file, &damaged).unwrap();
        look(path);
    }
}

#[test]
fn damaged_files_do_no_harm() {
    let directory = tempfile::tempdir().unwrap();
    for centering in [Centering::Cells, Centering::Nodes] {
        let path = directory.path().join("a.vthb");
        for file in ["a.vthb", "a/a_0.vti", "a/a_2.vti"] {
            write(&path, &uneven(), &["phi", "psi"], centering, VoxelType::F64);
            damage(&path, &directory.path().join(file), 500);
        }
        let path = directory.path().join("a.vtkhdf");
        write(&path, &uneven(), &["phi", "psi"], centering, VoxelType::F64);
        damage(&path, &path, 1000);
    }
}
