//! Damaged copies of real files: whatever happens to them, they are refused with a reason or read.

use std::fs;
use std::path::Path;

use amray_formats::{OpenOptions, open};
use amray_testing::{Random, real_data};

/// Opens what may be damaged and reads a field of it.
pub(crate) fn survive(path: &Path) -> Result<(), String> {
    let data = open(path, &OpenOptions::default()).map_err(|error| error.to_string())?;
    if !data.fields().is_empty() {
        data.read_field(0, &|_| {}).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// Replaces a few bytes, mostly of the file's first `head` ones, where the structure is.
pub(crate) fn mutated(content: &[u8], random: &mut Random, head: usize) -> Vec<u8> {
    let mut content = content.to_vec();
    for _ in 0..random.integer(1, 8) {
        let end = if random.chance(0.9) { head.min(content.len()) } else { content.len() };
        let place = random.integer(0, end as i64 - 1) as usize;
        content[place] = random.bits() as u8;
    }
    content
}

#[test]
fn athena_files() {
    let Some(path) = real_data("athena/blast_offc.u8.00001.athdf") else { return };
    let content = fs::read(path).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let copy = directory.path().join("a.athdf");
    let mut random = Random(7);
    for _ in 0..400 {
        fs::write(&copy, mutated(&content, &mut random, 13_000)).unwrap();
        let _ = survive(&copy);
    }
    for _ in 0..60 {
        fs::write(&copy, &content[..random.integer(0, content.len() as i64 - 1) as usize]).unwrap();
        assert!(survive(&copy).is_err());
    }
}

/// A copy of a dump, one of whose files is changed again and again.
fn enzo_copies(name: &str, mut change: impl FnMut(&mut Random, &[u8]) -> Vec<u8>, check: impl Fn(Result<(), String>)) {
    let Some(dump) = real_data("enzo/noh_refine4/DD0001") else { return };
    let directory = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(dump).unwrap().flatten() {
        fs::copy(entry.path(), directory.path().join(entry.file_name())).unwrap();
    }
    let file = directory.path().join(name);
    let content = fs::read(&file).unwrap();
    let mut random = Random(3);
    for _ in 0..200 {
        // Copies of files that must not be written to cannot be either.
        let _ = fs::remove_file(&file);
        fs::write(&file, change(&mut random, &content)).unwrap();
        check(survive(directory.path()));
    }
}

#[test]
fn enzo_grids() {
    enzo_copies("noh3Damr_0001.hierarchy", |random, content| mutated(content, random, usize::MAX), |_| {});
    let cut =
        |random: &mut Random, content: &[u8]| content[..random.integer(0, content.len() as i64 - 60) as usize].to_vec();
    enzo_copies("noh3Damr_0001.hierarchy", cut, |result| assert!(result.is_err()));
}

#[test]
fn enzo_parameters_and_values() {
    enzo_copies("noh3Damr_0001", |random, content| mutated(content, random, 6000), |_| {});
    enzo_copies("noh3Damr_0001.cpu0000", |random, content| mutated(content, random, 6000), |_| {});
}

#[test]
fn pointers_in_a_circle_end() {
    let circle = |_: &mut Random, content: &[u8]| {
        let text = String::from_utf8_lossy(content);
        text.replace("Grid[3]->NextGridNextLevel = 0", "Grid[3]->NextGridNextLevel = 2").into_bytes()
    };
    enzo_copies("noh3Damr_0001.hierarchy", circle, |result| {
        let error = result.unwrap_err();
        assert!(error.contains("several Pointers lead to it"), "{error}");
    });
    let elsewhere = |_: &mut Random, content: &[u8]| {
        let text = String::from_utf8_lossy(content);
        text.replace("./DD0001/noh3Damr_0001.cpu0000", "/etc/passwd").into_bytes()
    };
    enzo_copies("noh3Damr_0001.hierarchy", elsewhere, |result| {
        let error = result.unwrap_err();
        assert!(error.contains("passwd: cannot open"), "{error}");
    });
}
