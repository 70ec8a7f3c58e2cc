//! Readers and writers of AMR simulation data: from a path to a [`Hierarchy`] and its [`Field`]s.
//!
//! [`open`] recognises a data set by its content and reads its geometry; values are read (or mapped) field by field.

mod amr_format;
mod amrex;
mod athena;
mod chombo;
mod completed;
pub mod demo;
mod derived;
mod enzo;
mod error;
mod flash;
mod hdf5;
mod hdf5_output;
mod key_values;
mod mapped_file;
mod number;
mod open;
pub mod output;
pub mod picture;
pub mod points;
mod ramses;
mod refined;
mod relative_path;
mod store;
mod stored_bricks;
pub mod structured;
mod summary;
mod vtk;

use std::path::Path;
use std::sync::Arc;

use amray::hierarchy::{Field, Hierarchy, VoxelType};

pub use amr_format::{AmrContent, AmrFormat, AmrWriter};
pub use amray_expressions::Definition;
pub use amrex::AmrexPlotfile;
pub use chombo::{ChomboFile, ChomboWriter};
pub use derived::{derived_fields, read_named};
pub use error::FormatError;
pub use open::open;
pub use summary::Summary;
pub use vtk::{VthbFile, VthbWriter, VtkhdfFile, VtkhdfWriter};

/// One data set on disk: its geometry, and fields that are read when asked for.
pub trait DataSet: Send + Sync {
    /// All that is known of it without its values.
    fn summary(&self) -> &Summary;

    /// Reads one field (by its place in [`DataSet::fields`]) and no other; maps its values in place where the file
    /// stores them contiguous and in this machine's byte order. `progress` is told the share that is done, 0 to 1,
    /// possibly from several threads.
    ///
    /// # Errors
    /// [`FormatError`] where the file is damaged or cannot be read.
    ///
    /// # Panics
    /// Where there is no such field.
    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError>;

    /// Whether the file stores no coarse cells under finer ones, as octree codes do. Then [`OpenOptions::max_level`] is
    /// left alone by the reader: coarse levels follow from the finer ones, and [`open`] adds them.
    fn leaf_only(&self) -> bool {
        false
    }

    /// Expressions that the data set keeps under names of their own; they may mean nothing over its fields:
    /// [`derived_fields`] are those that do.
    fn expressions(&self) -> &[Definition] {
        &[]
    }

    /// The format's name, as in `amray info`.
    fn format(&self) -> &'static str {
        self.summary().format
    }

    /// The simulation time, where the file states it.
    fn time(&self) -> Option<f64> {
        self.summary().time
    }

    /// The mesh, shared by all fields.
    fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.summary().hierarchy
    }

    /// The fields, in the order of the file.
    fn fields(&self) -> &[FieldInfo] {
        &self.summary().fields
    }

    /// What is unusual, as [`Summary::warnings`].
    fn warnings(&self) -> &[String] {
        &self.summary().warnings
    }
}

/// What is known of a field before its values are read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldInfo {
    /// The name, as the file spells it.
    pub name: String,
    /// The number type in memory.
    pub voxel_type: VoxelType,
    /// The unit, where the file states one.
    pub unit: Option<String>,
}

/// How to open a data set.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenOptions {
    /// Leave out levels finer than this one: as if they did not exist.
    pub max_level: Option<usize>,
    /// The most bytes of memory that the values of a field may take. Where they must be read (compressed, in another byte
    /// order) and take more, they go into a file without a name, in the system's directory for such (`TMPDIR`), and are
    /// mapped from there.
    pub memory: Option<u64>,
}

impl OpenOptions {
    /// How many of a data set's `levels` are to be read.
    ///
    /// # Errors
    /// [`FormatError::MaxLevel`] where the finest level asked for does not exist.
    pub fn level_count(&self, path: &Path, levels: usize) -> Result<usize, FormatError> {
        match self.max_level {
            Some(asked) if asked >= levels => {
                Err(FormatError::MaxLevel { path: path.into(), asked, finest: levels.saturating_sub(1) })
            }
            Some(asked) => Ok(asked + 1),
            None => Ok(levels),
        }
    }
}

/// The place of the field called `name` in [`DataSet::fields`].
///
/// # Errors
/// [`FormatError::UnknownField`] lists the fields there are and suggests the nearest.
pub fn find_field(path: &Path, fields: &[FieldInfo], name: &str) -> Result<usize, FormatError> {
    fields.iter().position(|field| field.name == name).ok_or_else(|| {
        let known: Vec<String> = fields.iter().map(|field| field.name.clone()).collect();
        FormatError::unknown_field(path, name, known)
    })
}
