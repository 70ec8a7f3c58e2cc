//! Files that are read where they lie: mapped into memory, if they are regular files.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use memmap2::Mmap;

use crate::FormatError;

/// Opens a file to read it. Directories are refused, and pipes and devices, which could make readers wait for ever.
///
/// # Errors
/// [`FormatError::Io`] where there is no such regular file or it cannot be opened.
pub(crate) fn open_regular(path: &Path) -> Result<File, FormatError> {
    let error = FormatError::io(path, "open");
    if !fs::metadata(path).map_err(&error)?.is_file() {
        return Err(error(io::Error::other("not a regular file")));
    }
    File::open(path).map_err(error)
}

/// The first bytes of a file, at most so many.
///
/// # Errors
/// [`FormatError::Io`] where there is no such regular file or it cannot be read.
pub(crate) fn start_of(path: &Path, bytes: u64) -> Result<Vec<u8>, FormatError> {
    let mut start = Vec::new();
    open_regular(path)?.take(bytes).read_to_end(&mut start).map_err(FormatError::io(path, "read"))?;
    Ok(start)
}

/// Maps a whole file.
///
/// # Errors
/// [`FormatError::Io`] where there is no such regular file, or it cannot be opened or mapped.
pub(crate) fn map(path: &Path) -> Result<Arc<Mmap>, FormatError> {
    map_open(&open_regular(path)?, path)
}

/// Maps a whole file that is open; `path` is for errors.
///
/// # Errors
/// [`FormatError::Io`] where it cannot be mapped.
pub(crate) fn map_open(file: &File, path: &Path) -> Result<Arc<Mmap>, FormatError> {
    // SAFETY: the map is only read, as plain numbers, for which any bytes will do: another program that writes to the
    // file cannot break an invariant. Truncating the file meanwhile makes reads past its new end a bus error, which is
    // the known price of using values in place.
    #[allow(unsafe_code)]
    let map = unsafe { Mmap::map(file) };
    Ok(Arc::new(map.map_err(FormatError::io(path, "map"))?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_mapped() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a");
        fs::write(&path, "values").unwrap();
        assert_eq!(map(&path).unwrap()[..], *b"values");
        let error = map(directory.path()).unwrap_err().to_string();
        assert_eq!(error, format!("{}: cannot open: not a regular file", directory.path().display()));
    }
}
