//! The formats that AMR data are written in.

use std::fs;
use std::path::Path;

use amray::hierarchy::{Centering, Hierarchy, Voxel, VoxelType};

use crate::vtk::{VthbWriter, VtkhdfWriter};
use crate::{ChomboWriter, FormatError};

/// A format that AMR data are written in, by the ending of the file's name. A further one is a variant here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AmrFormat {
    /// Chombo HDF5.
    Chombo,
    /// VTK's OverlappingAMR: an XML index and a directory of images.
    Vthb,
    /// VTK's OverlappingAMR in one HDF5 file.
    Vtkhdf,
}

/// What is known of AMR data before the first value is written.
#[derive(Clone, Copy, Debug)]
pub struct AmrContent<'a> {
    /// The mesh.
    pub hierarchy: &'a Hierarchy,
    /// The names of the fields.
    pub components: &'a [&'a str],
    /// What the values belong to.
    pub centering: Centering,
    /// The number type of all values.
    pub voxel_type: VoxelType,
    /// The simulation time.
    pub time: f64,
}

/// AMR data that are being written; they take their name when they are finished.
///
/// Values can come from several threads at once and in any order. What is never written is 0.
pub enum AmrWriter {
    /// In Chombo's format.
    Chombo(ChomboWriter),
    /// As VTK's XML.
    Vthb(VthbWriter),
    /// As VTK's HDF5.
    Vtkhdf(VtkhdfWriter),
}

impl AmrFormat {
    /// The endings that are known, for messages.
    pub const ENDINGS: &str = ".hdf5 or .h5 (Chombo), .vthb or .vtkhdf (VTK)";

    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] lists the endings that are known.
    pub fn of(path: &Path) -> Result<Self, FormatError> {
        match path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).as_deref() {
            Some("hdf5" | "h5") => Ok(Self::Chombo),
            Some("vthb") => Ok(Self::Vthb),
            Some("vtkhdf") => Ok(Self::Vtkhdf),
            other => Err(FormatError::Unrecognised {
                path: path.into(),
                found: other.map_or("no ending".into(), |ending| format!("ending .{ending}")),
                expected: Self::ENDINGS.into(),
            }),
        }
    }

    /// The number of bytes of finished data at `path`, in all of their files.
    ///
    /// # Errors
    /// [`FormatError::Io`] where they cannot be looked at.
    pub fn bytes_at(self, path: &Path) -> Result<u64, FormatError> {
        let length = |path: &Path| Ok(fs::metadata(path).map_err(FormatError::io(path, "read"))?.len());
        let images = match self {
            Self::Chombo | Self::Vtkhdf => None,
            Self::Vthb => Some(path.with_extension("")),
        };
        let images = images.iter().flat_map(fs::read_dir).flatten().flatten();
        images.map(|image| length(&image.path())).sum::<Result<u64, _>>().and_then(|images| Ok(images + length(path)?))
    }

    /// Lays down everything but the values.
    ///
    /// # Errors
    /// [`FormatError`] where the format has no room for the hierarchy or the names, or the file cannot be written.
    pub fn create(self, path: &Path, content: &AmrContent) -> Result<AmrWriter, FormatError> {
        Ok(match self {
            Self::Chombo => AmrWriter::Chombo(ChomboWriter::create(path, content)?),
            Self::Vthb => AmrWriter::Vthb(VthbWriter::create(path, content)?),
            Self::Vtkhdf => AmrWriter::Vtkhdf(VtkhdfWriter::create(path, content)?),
        })
    }
}

impl AmrWriter {
    /// Writes some values of a brick's component, from the one counted `first` on, x fastest, rounded to the file's number
    /// type.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written.
    ///
    /// # Panics
    /// Where there is no such level, brick or component, or not as many values.
    pub fn write<T: Voxel>(
        &self,
        level: usize,
        brick: usize,
        component: usize,
        first: usize,
        values: &[T],
    ) -> Result<(), FormatError> {
        match self {
            Self::Chombo(writer) => writer.write(level, brick, component, first, values),
            Self::Vthb(writer) => writer.write(level, brick, component, first, values),
            Self::Vtkhdf(writer) => writer.write(level, brick, component, first, values),
        }
    }

    /// Completes the data and gives them their name.
    ///
    /// # Errors
    /// [`FormatError::Io`] where they cannot be written or renamed.
    pub fn finish(self) -> Result<(), FormatError> {
        match self {
            Self::Chombo(writer) => writer.finish(),
            Self::Vthb(writer) => writer.finish(),
            Self::Vtkhdf(writer) => writer.finish(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_decides() {
        assert_eq!(AmrFormat::of(Path::new("a.3d.HDF5")).unwrap(), AmrFormat::Chombo);
        assert_eq!(AmrFormat::of(Path::new("a.vthb")).unwrap(), AmrFormat::Vthb);
        assert_eq!(AmrFormat::of(Path::new("a.vtkhdf")).unwrap(), AmrFormat::Vtkhdf);
        let error = AmrFormat::of(Path::new("a.vtu")).unwrap_err().to_string();
        assert_eq!(error, "a.vtu: ending .vtu, expected .hdf5 or .h5 (Chombo), .vthb or .vtkhdf (VTK)");
        assert!(AmrFormat::of(Path::new("hdf5")).is_err());
    }
}
