//! Output files that appear whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::FormatError;

/// A file that takes its name only when it is complete; a failed or killed run leaves the old file as it was.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    temporary: NamedTempFile,
}

impl OutputFile {
    /// A temporary file beside `path`.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the directory does not exist or cannot be written to.
    pub fn create(path: &Path) -> Result<Self, FormatError> {
        let directory = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        if path.is_dir() {
            let source = std::io::ErrorKind::IsADirectory.into();
            return Err(FormatError::Io { path: path.into(), action: "write", source });
        }
        let mut builder = Builder::new();
        builder.prefix(".amray-").suffix(".part");
        // What umask leaves of 0666, as for any new file, and not the 0600 of secret temporary files.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let temporary = builder.tempfile_in(directory).map_err(FormatError::io(path, "write"))?;
        Ok(Self { path: path.into(), temporary })
    }

    /// The file to write to.
    pub fn file(&mut self) -> &mut File {
        self.temporary.as_file_mut()
    }

    /// Where the file lies until it is complete, for libraries that open it themselves.
    pub fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`FormatError::Io`] where renaming fails.
    pub fn finish(self) -> Result<(), FormatError> {
        let Self { path, temporary } = self;
        temporary.persist(&path).map_err(|error| FormatError::Io { path, action: "write", source: error.error })?;
        Ok(())
    }

    /// Writes a whole file through `write`.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be made or `write` fails; the file is then as it was before.
    pub fn write(
        path: &Path,
        write: impl FnOnce(&mut BufWriter<&File>) -> std::io::Result<()>,
    ) -> Result<(), FormatError> {
        let output = Self::create(path)?;
        let mut writer = BufWriter::new(output.temporary.as_file());
        write(&mut writer).and_then(|()| writer.flush()).map_err(FormatError::io(path, "write"))?;
        drop(writer);
        output.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture.png");
        OutputFile::write(&path, |writer| writer.write_all(b"first")).unwrap();
        let failed = OutputFile::write(&path, |writer| {
            writer.write_all(b"half of the sec")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().ends_with("picture.png: cannot write: disk full"));
        assert_eq!(std::fs::read(&path).unwrap(), b"first");
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_unwritable_place_is_named() {
        let error = OutputFile::create(Path::new("/nonexistent/a.png")).unwrap_err();
        assert!(error.to_string().starts_with("/nonexistent/a.png: cannot write: "), "{error}");
        assert!(OutputFile::create(Path::new("/")).is_err());
    }
}
