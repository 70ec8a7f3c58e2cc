//! Output files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::FormatError;

/// A file that takes its name only when it is complete; a failed or killed run leaves the old file as it was.
///
/// Where the name is a link's, the file that it leads to is replaced and the link stays. A pipe or a device keeps its
/// name too: it is sent the complete content.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    target: Target,
    temporary: NamedTempFile,
}

/// What becomes of a complete file.
#[derive(Debug)]
enum Target {
    /// It is renamed to this.
    Name(PathBuf),
    /// Its content is written into what is there: a pipe or a device.
    Stream,
}

/// Finds out whether a file can be written at `path`, before work is put into its content.
///
/// # Errors
/// As [`OutputFile::create`].
pub fn check_writable(path: &Path) -> Result<(), FormatError> {
    OutputFile::create(path).map(drop)
}

impl OutputFile {
    /// A temporary file beside `path`.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the directory does not exist or cannot be written to.
    pub fn create(path: &Path) -> Result<Self, FormatError> {
        let (target, directory) = match fs::metadata(path) {
            Ok(there) if there.is_dir() => {
                let source = io::ErrorKind::IsADirectory.into();
                return Err(FormatError::Io { path: path.into(), action: "write", source });
            }
            Ok(there) if !there.is_file() => (Target::Stream, std::env::temp_dir()),
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(FormatError::io(path, "write")(error)),
            _ => {
                let name = followed(path);
                let directory = match name.parent() {
                    Some(parent) if !parent.as_os_str().is_empty() => parent.into(),
                    _ => PathBuf::from("."),
                };
                (Target::Name(name), directory)
            }
        };
        // Opened here, the file gets what umask leaves of 0666, as any new file, and not the 0600 of secret temporary
        // files; and the error, should there be one, does not speak of the temporary name.
        let open = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
        let temporary = Builder::new().prefix(".amray-").suffix(".part").make_in(directory, open);
        Ok(Self { path: path.into(), target, temporary: temporary.map_err(FormatError::io(path, "write"))? })
    }

    /// Where the file lies until it is complete, for libraries that open it themselves.
    pub fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// Gives the file its name, or sends its content where it belongs.
    ///
    /// # Errors
    /// [`FormatError::Io`] where renaming or sending fails.
    pub fn finish(self) -> Result<(), FormatError> {
        let Self { path, target, temporary } = self;
        let finished = match target {
            Target::Name(name) => temporary.persist(name).map(drop).map_err(|error| error.error),
            Target::Stream => send(temporary.path(), &path),
        };
        finished.map_err(FormatError::io(&path, "write"))
    }

    /// Writes a whole file through `write`.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be made or `write` fails; the file is then as it was before.
    pub fn write(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> Result<(), FormatError> {
        let output = Self::create(path)?;
        let mut writer = BufWriter::new(output.temporary.as_file());
        write(&mut writer).and_then(|()| writer.flush()).map_err(FormatError::io(path, "write"))?;
        drop(writer);
        output.finish()
    }
}

/// Where the symbolic links that `path` may name lead, be anything there or not.
fn followed(path: &Path) -> PathBuf {
    /// As many as Linux follows; more are a circle.
    const MOST_LINKS: usize = 40;
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&path) else { break };
        path = path.parent().map_or_else(|| next.clone(), |parent| parent.join(&next));
    }
    path
}

fn send(from: &Path, to: &Path) -> io::Result<()> {
    // Not through `fs::copy`, which would give the target the temporary file's permissions.
    io::copy(&mut File::open(from)?, &mut File::options().write(true).open(to)?).map(drop)
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
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().ends_with("picture.png: cannot write: disk full"));
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
    }

    #[test]
    #[cfg(unix)]
    fn an_unwritable_place_is_named() {
        let error = check_writable(Path::new("/nonexistent/a.png")).unwrap_err().to_string();
        assert_eq!(error, "/nonexistent/a.png: cannot write: No such file or directory (os error 2)");
        assert!(check_writable(Path::new("/")).is_err());
    }

    #[test]
    fn a_check_leaves_nothing() {
        let directory = tempfile::tempdir().unwrap();
        check_writable(&directory.path().join("a.png")).unwrap();
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    }

    #[test]
    #[cfg(unix)]
    fn links_are_followed() {
        let directory = tempfile::tempdir().unwrap();
        let [target, link, second] = ["target", "link", "second"].map(|name| directory.path().join(name));
        std::os::unix::fs::symlink("target", &link).unwrap();
        std::os::unix::fs::symlink(&link, &second).unwrap();
        for content in [b"new", b"old"] {
            OutputFile::write(&second, |writer| writer.write_all(content)).unwrap();
            assert_eq!(fs::read(&target).unwrap(), content);
        }
        assert!(link.is_symlink() && second.is_symlink() && !target.is_symlink());
        let circle = directory.path().join("circle");
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        assert!(check_writable(&circle).is_err());
    }

    #[test]
    #[cfg(unix)]
    fn pipes_and_devices_are_written_into() {
        use std::os::unix::fs::FileTypeExt;

        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        check_writable(&pipe).unwrap();
        OutputFile::write(&pipe, |writer| writer.write_all(b"picture")).unwrap();
        assert_eq!(reader.join().unwrap(), b"picture");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        OutputFile::write(Path::new("/dev/null"), |writer| writer.write_all(b"picture")).unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }
}
