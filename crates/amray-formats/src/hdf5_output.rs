//! HDF5 files that are written: whole or not at all, values in any order.

use std::path::{Path, PathBuf};

use amray::hierarchy::{Voxel, VoxelType};
use rust_hdf5::format::messages::datatype::DatatypeMessage;
use rust_hdf5::{FileLocking, H5Dataset, H5File, H5Group, Hdf5Error, LibverBound};

use crate::FormatError;
use crate::output::OutputFile;

/// A file that takes its name when it is finished.
pub(crate) struct Hdf5Output {
    path: PathBuf,
    // Dropping the file completes it on disk: it must go before the temporary name does.
    file: H5File,
    output: OutputFile,
}

/// A list of values, of which only the place is reserved at first. It can be written from several threads.
pub(crate) struct ValueList {
    set: H5Dataset,
    voxel_type: VoxelType,
}

impl Hdf5Output {
    /// An empty file.
    ///
    /// # Errors
    /// [`FormatError::Io`] where it cannot be written.
    pub(crate) fn create(path: &Path) -> Result<Self, FormatError> {
        let output = OutputFile::create(path)?;
        // The oldest layout is the one that every HDF5 library reads. Nobody else knows the temporary name.
        let options = H5File::options().libver(LibverBound::Earliest).locking(FileLocking::Disabled);
        let file = options.create(output.temporary_path()).map_err(failure(path))?;
        Ok(Self { path: path.into(), file, output })
    }

    pub(crate) fn root(&self) -> H5Group {
        self.file.root_group()
    }

    /// The file's path, when it is finished.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Completes the file and gives it its name. Everything that belongs to it must be gone.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written or renamed.
    pub(crate) fn finish(self) -> Result<(), FormatError> {
        self.file.close_no_sync().map_err(failure(&self.path))?;
        self.output.finish()
    }
}

impl ValueList {
    pub(crate) fn create(group: &H5Group, name: &str, length: usize, voxel_type: VoxelType) -> Result<Self, Hdf5Error> {
        let set = match voxel_type {
            VoxelType::F32 => group.new_dataset::<f32>().shape([length]).create(name)?,
            VoxelType::F64 => group.new_dataset::<f64>().shape([length]).create(name)?,
        };
        Ok(Self { set, voxel_type })
    }

    /// Writes values from the one counted `start` on, rounded to the file's number type.
    pub(crate) fn write<T: Voxel>(&self, start: usize, values: &[T]) -> Result<(), Hdf5Error> {
        let numbers = values.iter().map(|value| value.to_f64());
        let count = values.len();
        match self.voxel_type {
            VoxelType::F32 => self.set.write_slice(&[start], &[count], &numbers.map(f32::from_f64).collect::<Vec<_>>()),
            VoxelType::F64 => self.set.write_slice(&[start], &[count], &numbers.collect::<Vec<_>>()),
        }
    }
}

/// Sets an attribute to text exactly as long as it is, without room for a NUL.
pub(crate) fn set_text(group: &H5Group, name: &str, text: &str) -> Result<(), Hdf5Error> {
    let mut bytes = text.as_bytes().to_vec();
    // HDF5 has no strings of length 0.
    bytes.resize(text.len().max(1), 0);
    let charset = u8::from(!text.is_ascii());
    group.set_attr_typed(name, DatatypeMessage::FixedString { size: bytes.len() as u32, padding: 0, charset }, bytes)
}

/// The error of a library's call for the file at `path`, for `map_err`.
pub(crate) fn failure(path: &Path) -> impl Fn(Hdf5Error) -> FormatError + use<> {
    let failed = FormatError::io(path, "write");
    move |error| {
        failed(match error {
            Hdf5Error::Io(source) => source,
            other => std::io::Error::other(other.to_string()),
        })
    }
}
