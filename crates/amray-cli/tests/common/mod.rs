//! What tests of the program share: running it, small data, and reading what it wrote.
#![allow(dead_code)] // Each file of tests takes what it needs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Runs `amray` in `directory`.
pub(crate) fn amray(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_amray")).args(arguments).current_dir(directory).output().unwrap()
}

/// What it prints when all goes well.
pub(crate) fn prints(directory: &Path, arguments: &[&str]) -> String {
    let output = amray(directory, arguments);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// The one line it fails with.
pub(crate) fn fails(directory: &Path, arguments: &[&str]) -> String {
    let output = amray(directory, arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {errors}");
    let line = errors.lines().last().unwrap().to_owned();
    assert!(line.starts_with("amray: ") && errors.ends_with('\n'), "{errors}");
    assert_eq!(errors.lines().filter(|line| !line.starts_with("amray: warning: ")).count(), 1, "{errors}");
    line
}

/// What it says of wrong usage.
pub(crate) fn misused(directory: &Path, arguments: &[&str]) -> String {
    let output = amray(directory, arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    errors
}

/// What makes a small demo data set with two levels, of which the finer one does not cover everything.
pub(crate) const SMALL: &[&str] = &["--levels", "2", "--base", "16", "--brick", "8", "--threshold", "0.8"];

/// A small demo data set that the tests share.
pub(crate) fn demo() -> &'static Path {
    static DEMO: OnceLock<PathBuf> = OnceLock::new();
    DEMO.get_or_init(|| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR"));
        prints(directory, &[&["demo", "-o", "small.hdf5"], SMALL].concat());
        directory.join("small.hdf5")
    })
}

pub(crate) fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

pub(crate) fn npy<T: npyz::Deserialize>(path: &Path) -> (Vec<u64>, Vec<T>) {
    let file = npyz::NpyFile::new(std::fs::File::open(path).unwrap()).unwrap();
    (file.shape().to_vec(), file.into_vec().unwrap())
}

/// The width, height and RGB of an opaque picture.
pub(crate) fn png(path: &Path) -> ([u32; 2], Vec<u8>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut bytes).unwrap();
    ([frame.width, frame.height], bytes)
}
