//! HDF5 files as the readers see them: groups, attributes and data sets, with errors that name the place.
//!
//! A thin layer over the crate `hdf5-reader`: counts in a file are not believed before they are held against its
//! length, and contiguous values can be used where they lie in the mapped file.

mod block;
mod data_set;
mod group;
mod number;
mod parts;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hdf5_reader::io::Cursor;
use hdf5_reader::storage::BytesStorage;
use hdf5_reader::{DEFAULT_MAX_OBJECT_HEADER_BYTES, Hdf5File, OpenOptions};
use memmap2::Mmap;

use crate::{FormatError, mapped_file};

pub(crate) use block::Blocks;
pub(crate) use data_set::{Hdf5Set, Storage};
pub(crate) use group::Hdf5Group;
pub(crate) use hdf5_reader::H5Type;
pub(crate) use parts::Parts;

/// Deflate shrinks by at most this factor: no file decompresses to more.
const LARGEST_COMPRESSION: usize = 1032;

/// An open HDF5 file, mapped into memory.
pub(crate) struct Hdf5 {
    source: Arc<Source>,
}

/// What groups and data sets keep of the file they belong to.
struct Source {
    path: PathBuf,
    map: Arc<Mmap>,
    file: Hdf5File,
}

/// The map as the HDF5 library wants it.
struct SharedMap(Arc<Mmap>);

impl AsRef<[u8]> for SharedMap {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Hdf5 {
    /// Opens and maps a file; `None` where its content is not HDF5.
    ///
    /// # Errors
    /// [`FormatError`] where the file cannot be read, is shorter than it says, or is of an unknown version.
    pub(crate) fn open(path: &Path) -> Result<Option<Self>, FormatError> {
        let map = mapped_file::map(path)?;
        let options = OpenOptions::default()
            .with_chunk_cache_bytes(0)
            .with_max_read_bytes(map.len().saturating_mul(LARGEST_COMPRESSION))
            .with_max_object_header_bytes(map.len().min(DEFAULT_MAX_OBJECT_HEADER_BYTES));
        let storage = Arc::new(BytesStorage::from_owner(SharedMap(Arc::clone(&map))));
        let file = match Hdf5File::from_storage_with_options(storage, options) {
            Ok(file) => file,
            Err(hdf5_reader::error::Error::InvalidMagic) => return Ok(None),
            Err(error) => return Err(FormatError::malformed(path, "superblock", one_line(&error.to_string()))),
        };
        check_length(path, &file, &map)?;
        Ok(Some(Self { source: Arc::new(Source { path: path.into(), map, file }) }))
    }

    /// The file's path.
    pub(crate) fn path(&self) -> &Path {
        &self.source.path
    }

    /// The whole file's bytes.
    pub(crate) fn map(&self) -> &Arc<Mmap> {
        &self.source.map
    }

    /// The root group.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it cannot be read.
    pub(crate) fn root(&self) -> Result<Hdf5Group, FormatError> {
        let root = self.source.file.root_group().map_err(|error| self.source.failed("/", &error))?;
        Hdf5Group::new(Arc::clone(&self.source), String::new(), root)
    }

    /// The error for a file that is none of the `expected` formats; says what it holds instead.
    pub(crate) fn unrecognised(&self, expected: &str) -> FormatError {
        let found = match self.root().and_then(|root| root.member_names()) {
            Err(damaged) => return damaged,
            Ok(members) if members.is_empty() => "an empty HDF5 file".into(),
            Ok(members) => format!("an HDF5 file that holds {}", listing(members.iter().map(String::as_str))),
        };
        FormatError::Unrecognised { path: self.path().into(), found, expected: expected.into() }
    }
}

impl Source {
    fn malformed(&self, place: &str, problem: &str) -> FormatError {
        FormatError::malformed(&self.path, one_line(place), one_line(problem))
    }

    fn failed(&self, place: &str, error: &hdf5_reader::error::Error) -> FormatError {
        use hdf5_reader::error::Error;
        let mut cause = error;
        while let Error::Context { source, .. } = cause {
            cause = source;
        }
        match cause {
            Error::UnsupportedFilter(filter) => {
                let expected = "expected gzip, szip, lz4 or none (h5repack can change it)";
                self.malformed(place, &format!("compressed in a way that cannot be read ({filter}), {expected}"))
            }
            cause => self.malformed(place, &cause.to_string()),
        }
    }
}

/// The superblock says how long the file is: one that was cut short is not worth looking into.
fn check_length(path: &Path, file: &Hdf5File, map: &Mmap) -> Result<(), FormatError> {
    let superblock = file.superblock();
    let end = superblock.base_address.saturating_add(superblock.eof_address);
    if Cursor::is_undefined_offset(superblock.eof_address, superblock.offset_size) || end <= map.len() as u64 {
        return Ok(());
    }
    let problem = format!("the file is cut short: {} bytes, expected {end}", map.len());
    Err(FormatError::malformed(path, "superblock", problem))
}

/// Text from a file without line breaks and other control characters.
pub(crate) fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

/// The first few of `names`, for a message.
pub(crate) fn listing<'a>(mut names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<&str> = names.by_ref().take(SHOWN).collect();
    let more = if names.next().is_some() { ", ..." } else { "" };
    one_line(&format!("{}{more}", shown.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_a_file_cannot_break_a_message() {
        assert_eq!(listing(["a\nb", "c"].into_iter()), "a b, c");
        assert_eq!(listing(["x"; 9].into_iter()), "x, x, x, x, x, x, x, x, ...");
    }

    #[test]
    fn what_is_not_hdf5_is_none() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a");
        for content in [&b""[..], b"text", &[0; 5000]] {
            std::fs::write(&path, content).unwrap();
            assert!(Hdf5::open(&path).unwrap().is_none());
        }
        assert!(Hdf5::open(directory.path()).is_err_and(|error| error.to_string().contains("not a regular file")));
    }
}
