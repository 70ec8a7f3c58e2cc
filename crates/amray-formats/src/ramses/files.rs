//! Which files an output has.

use std::fs;
use std::path::{Path, PathBuf};

use super::info::Info;

/// The files of an output: they lie in one directory and have one number.
pub(crate) struct OutputFiles {
    directory: PathBuf,
    /// As the files have it: `00080`.
    number: String,
}

impl OutputFiles {
    /// The output that a path belongs to: its directory, or any of its files. `None` where it is none.
    pub(crate) fn find(path: &Path) -> Option<Self> {
        let directory = if path.is_dir() { path } else { path.parent()? };
        let name = path.file_name().and_then(|name| name.to_str()).filter(|_| path.is_file());
        let mut numbers: Vec<String> = match name {
            // A look at all that is beside every file of another format would take long in large directories.
            Some(name) if !name.ends_with(".txt") => numbers_in(name).map(str::to_owned).collect(),
            name => numbers_of_infos(directory)
                .filter(|number| name.is_none_or(|name| is_of_output(name, number)))
                .collect(),
        };
        numbers.sort();
        let files = |number: String| Self { directory: directory.into(), number };
        numbers.into_iter().map(files).find(|files| files.amr(0).is_file() && Info::recognises(&files.info()))
    }

    pub(super) fn info(&self) -> PathBuf {
        self.directory.join(format!("info_{}.txt", self.number))
    }

    /// The mesh that a process (from 0 on) wrote.
    pub(super) fn amr(&self, cpu: usize) -> PathBuf {
        self.directory.join(format!("amr_{}.out{:05}", self.number, cpu + 1))
    }

    /// The values that a process (from 0 on) wrote.
    pub(super) fn hydro(&self, cpu: usize) -> PathBuf {
        self.directory.join(format!("hydro_{}.out{:05}", self.number, cpu + 1))
    }

    /// The names of the values.
    pub(super) fn hydro_descriptor(&self) -> PathBuf {
        self.directory.join("hydro_file_descriptor.txt")
    }
}

/// The number in `info_00080.txt`.
fn number_of_info(name: &str) -> Option<&str> {
    let number = name.strip_prefix("info_")?.strip_suffix(".txt")?;
    (!number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit())).then_some(number)
}

/// The numbers of all info files in a directory.
fn numbers_of_infos(directory: &Path) -> impl Iterator<Item = String> {
    // A file in the working directory.
    let listed = if directory.as_os_str().is_empty() { Path::new(".") } else { directory };
    let entries = fs::read_dir(listed).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some(number_of_info(entry.file_name().to_str()?)?.to_owned()))
}

/// The numbers between an underscore and a dot: `00080` in `part_00080.out00001`.
fn numbers_in(name: &str) -> impl Iterator<Item = &str> {
    let before_dots = name.split('.').rev().skip(1);
    let numbers = before_dots.filter_map(|part| Some(part.rsplit_once('_')?.1));
    numbers.filter(|number| !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit()))
}

/// Whether a file beside an info file belongs to it: `part_00080.out00001`, `namelist.txt`.
fn is_of_output(name: &str, number: &str) -> bool {
    name.contains(&format!("_{number}.")) || (name.ends_with(".txt") && number_of_info(name).is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_an_output() {
        for (name, belongs) in [
            ("info_00080.txt", true),
            ("amr_00080.out00001", true),
            ("part_00080.out00001", true),
            ("namelist.txt", true),
            ("info_00081.txt", false),
            ("hydro_00081.out00001", false),
            ("picture.png", false),
        ] {
            assert_eq!(is_of_output(name, "00080"), belongs, "{name}");
        }
        assert_eq!([number_of_info("info_00080.txt"), number_of_info("info_.txt")], [Some("00080"), None]);
        assert_eq!(number_of_info("info_new.txt"), None);
        let numbers = |name| numbers_in(name).collect::<Vec<_>>();
        assert_eq!(numbers("part_00080.out00001"), ["00080"]);
        assert_eq!(numbers("a_1.b_2.c"), ["2", "1"]);
        assert!(["plt00080.hdf5", "flash_hdf5_chk_0001", "a_b.c", "a_.b"].iter().all(|name| numbers(name).is_empty()));
    }
}
