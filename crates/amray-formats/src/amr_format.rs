//! The formats that AMR data are written in.

use std::path::Path;

use amray::hierarchy::{Hierarchy, VoxelType};

use crate::{ChomboWriter, FormatError};

/// A format that AMR data are written in, by the ending of the file's name. A further one is a variant here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AmrFormat {
    /// Chombo HDF5.
    Chombo,
}

impl AmrFormat {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] lists the endings that are known.
    pub fn of(path: &Path) -> Result<Self, FormatError> {
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("hdf5" | "h5") => Ok(Self::Chombo),
            other => Err(FormatError::Unrecognised {
                path: path.into(),
                found: other.map_or("no ending".into(), |ending| format!("ending .{ending}")),
                expected: ".hdf5 or .h5".into(),
            }),
        }
    }

    /// A file of this format that takes its name when it is finished.
    ///
    /// # Errors
    /// As [`ChomboWriter::create`].
    pub fn create(
        self,
        path: &Path,
        hierarchy: &Hierarchy,
        components: &[&str],
        voxel_type: VoxelType,
        time: f64,
    ) -> Result<ChomboWriter, FormatError> {
        match self {
            Self::Chombo => ChomboWriter::create(path, hierarchy, components, voxel_type, time),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_decides() {
        assert_eq!(AmrFormat::of(Path::new("a.3d.HDF5")).unwrap(), AmrFormat::Chombo);
        let error = AmrFormat::of(Path::new("a.vtu")).unwrap_err().to_string();
        assert_eq!(error, "a.vtu: ending .vtu, expected .hdf5 or .h5");
        assert!(AmrFormat::of(Path::new("hdf5")).is_err());
    }
}
