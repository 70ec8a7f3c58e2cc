//! Mesh files: STL, OBJ, PLY and VTK PolyData become a [`MeshDescription`].
//!
//! A file is read as a whole. No count in it is believed before the file is known to be long enough for it, so a
//! damaged file is an error, whatever it says.

mod error;
mod merge;
mod number;
mod obj;
mod ply;
mod polygon;
mod stl;
#[cfg(test)]
mod testing;
mod text;
mod vtp;

use std::fs;
use std::io;
use std::path::Path;

use crate::MeshDescription;

pub use error::MeshFileError;
use error::Problem;

const EXPECTED: &str = "a mesh: STL, OBJ, PLY or VTK PolyData (.vtp)";

/// Which reader a file is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Stl,
    Obj,
    Ply,
    Vtp,
}

/// Reads a mesh. The content decides the format; OBJ, which has no mark, is known by the name's ending.
///
/// # Errors
/// [`MeshFileError`] where there is no such file, no reader knows the content, or it is damaged.
pub fn open(path: &Path) -> Result<MeshDescription, MeshFileError> {
    let error = |action| move |source| MeshFileError::Io { path: path.into(), action, source };
    if !fs::metadata(path).map_err(error("open"))?.is_file() {
        return Err(error("open")(io::Error::other("not a regular file")));
    }
    let bytes = fs::read(path).map_err(error("read"))?;
    let format = Format::of(&bytes, path).ok_or_else(|| MeshFileError::Unrecognised {
        path: path.into(),
        found: described(&bytes),
        expected: EXPECTED,
    })?;
    let description = format.read(&bytes).map_err(|problem| problem.of(path))?;
    description.check().map_err(|source| MeshFileError::Mesh { path: path.into(), source })?;
    Ok(description)
}

impl Format {
    fn of(bytes: &[u8], path: &Path) -> Option<Self> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        if ply::recognises(bytes) {
            Some(Self::Ply)
        } else if vtp::recognises(bytes) {
            Some(Self::Vtp)
        } else if ending == "obj" {
            Some(Self::Obj)
        } else if stl::recognises(bytes) || ending == "stl" {
            Some(Self::Stl)
        } else {
            None
        }
    }

    fn read(self, bytes: &[u8]) -> Result<MeshDescription, Problem> {
        match self {
            Self::Stl => stl::read(bytes),
            Self::Obj => obj::read(bytes),
            Self::Ply => ply::read(bytes),
            Self::Vtp => vtp::read(bytes),
        }
    }
}

/// What a file that no reader knows looks like.
fn described(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(16)];
    match start {
        [] => "an empty file".into(),
        text if text.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace()) => {
            format!("a text file that starts with {:?}", String::from_utf8_lossy(text))
        }
        _ => "a file of an unknown kind".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(name: &str, content: &[u8]) -> Result<MeshDescription, String> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(name);
        fs::write(&path, content).unwrap();
        open(&path).map_err(|error| error.to_string().replace(&format!("{}/", directory.path().display()), ""))
    }

    const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    #[test]
    fn the_format_is_found() {
        assert_eq!(opened("a.OBJ", OBJ).unwrap().triangles, [[0, 1, 2]]);
        let expected = "a.txt: a text file that starts with \"v 0 0 0\\nv 1 0 0\\n\", expected ".to_owned() + EXPECTED;
        assert_eq!(opened("a.txt", OBJ).unwrap_err(), expected);
        assert_eq!(opened("a.vtp", b"").unwrap_err(), format!("a.vtp: an empty file, expected {EXPECTED}"));
        assert_eq!(opened("a", b"ply\nformat text\n").unwrap_err().split(": ").nth(1), Some("line 2"));
        assert_eq!(opened("a.ply", b"solid a\nendsolid a\n").unwrap(), MeshDescription::default());
    }

    #[test]
    fn errors_name_the_file_and_the_place() {
        assert_eq!(opened("a.obj", b"v 0 0\n").unwrap_err(), "a.obj: line 1: \"v 0 0\", expected a vertex v x y z");
        let error = opened("a.obj", b"v 0 0 inf\nf 1 1 1").unwrap_err();
        assert_eq!(error, "a.obj: vertex 0 is at (0, 0, inf), expected finite numbers");
        let error = open(Path::new("/nowhere/a.obj")).unwrap_err().to_string();
        assert!(error.starts_with("/nowhere/a.obj: cannot open: "), "{error}");
        let directory = tempfile::tempdir().unwrap();
        assert!(open(directory.path()).unwrap_err().to_string().ends_with("cannot open: not a regular file"));
    }
}
