//! Structured volumes: samples on one regular grid, read slice by slice, and AMR data made of them.
//!
//! Samples are values at points. They are taken as the centres of cells: so the first cell begins half a spacing before
//! the first sample, and every sample keeps its world position.

pub mod amr;
mod nifti;
mod npy;
mod nrrd;
mod raw;
mod samples;
mod transposed;
mod vti;

use std::fs::File;
use std::path::Path;

use amray::hierarchy::VoxelType;

use crate::FormatError;
use crate::mapped_file::start_of;
pub use crate::number::{ByteOrder, NumberType};
use crate::vtk::Image;
pub use raw::RawLayout;
pub use samples::SliceReader;
use samples::{Fastest, Samples};

/// More samples along an axis than any file format here can number; AMR files have 32-bit indices.
const MAX_SIDE: u64 = i32::MAX as u64;

/// The first bytes of a file, enough for each format to be told.
const BEGINNING: u64 = 4096;

/// A structured volume on disk: what its header says, and where its samples are.
#[derive(Clone, Debug)]
pub struct StructuredVolume {
    format: &'static str,
    samples: Samples,
    spacing: [f64; 3],
    origin: [f64; 3],
    warnings: Vec<String>,
}

/// The formats that are recognised by their content. A further one is a variant here and a file beside; raw files, which
/// say nothing of themselves, are opened by [`StructuredVolume::open_raw`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Nrrd,
    NumPy,
    Nifti,
    Vti,
}

impl Format {
    /// The format that a file's first bytes tell.
    fn of(path: &Path) -> Result<Option<Self>, FormatError> {
        let start = start_of(path, BEGINNING)?;
        Ok(if start.starts_with(b"NRRD000") {
            Some(Self::Nrrd)
        } else if start.starts_with(b"\x93NUMPY") {
            Some(Self::NumPy)
        } else if nifti::recognises(path, &start)? {
            Some(Self::Nifti)
        } else if Image::recognises(&start) {
            Some(Self::Vti)
        } else {
            None
        })
    }
}

impl StructuredVolume {
    /// What [`StructuredVolume::open`] knows, for messages.
    pub const FORMATS: &str = "NRRD, NumPy, NIfTI, VTK ImageData";

    /// Whether `path` is a file that [`StructuredVolume::open`] knows. Directories, pipes and devices are not.
    ///
    /// # Errors
    /// [`FormatError::Io`] where nothing is there or it cannot be read.
    pub fn recognises(path: &Path) -> Result<bool, FormatError> {
        let metadata = std::fs::metadata(path).map_err(FormatError::io(path, "open"))?;
        Ok(metadata.is_file() && Format::of(path)?.is_some())
    }

    /// Opens a volume whose file says what it is: NRRD (`.nrrd`, `.nhdr`), NumPy (`.npy`), NIfTI-1 (`.nii`, `.nii.gz`) or
    /// VTK ImageData (`.vti`). The content decides, not the name. Where the format has several arrays in a file, `field`
    /// is the name of the one to read; if not given, the file's active scalars or its first ones.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] where it is none of these, another [`FormatError`] where it is damaged, has not three
    /// axes, holds what is no scalar, or has no array of that name.
    pub fn open(path: &Path, field: Option<&str>) -> Result<Self, FormatError> {
        match (Format::of(path)?, field) {
            (Some(Format::Vti), _) => vti::open(path, field),
            (Some(_), Some(name)) => {
                Err(FormatError::malformed(path, "header", format!("one array without a name, expected {name:?}")))
            }
            (Some(Format::Nrrd), None) => nrrd::open(path),
            (Some(Format::NumPy), None) => npy::open(path),
            (Some(Format::Nifti), None) => nifti::open(path),
            (None, _) => Err(FormatError::Unrecognised {
                path: path.into(),
                found: "a file of an unknown kind".into(),
                expected: format!("a structured volume ({})", Self::FORMATS),
            }),
        }
    }

    /// Opens a file that holds nothing but samples.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where its length is another than `layout` makes it.
    pub fn open_raw(path: &Path, layout: &RawLayout) -> Result<Self, FormatError> {
        raw::open(path, layout)
    }

    /// The volume with another distance between samples, or another position of the first one, where they are given.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where a spacing is no positive number or an origin not finite.
    pub fn placed(mut self, spacing: Option<[f64; 3]>, origin: Option<[f64; 3]>) -> Result<Self, FormatError> {
        self.spacing = spacing.unwrap_or(self.spacing);
        self.origin = origin.unwrap_or(self.origin);
        self.checked()
    }

    /// The format's name, as in `amray info`.
    pub fn format(&self) -> &'static str {
        self.format
    }

    /// The file that holds the samples: another than the one that was opened where that is a detached header.
    pub fn sample_file(&self) -> &Path {
        &self.samples.path
    }

    /// Samples per axis.
    pub fn size(&self) -> [usize; 3] {
        self.samples.size
    }

    /// The number of samples.
    pub fn sample_count(&self) -> u64 {
        self.size().iter().map(|&samples| samples as u64).product()
    }

    /// The type of the stored samples.
    pub fn number_type(&self) -> NumberType {
        self.samples.number
    }

    /// The smaller of amray's number types that holds every value.
    pub fn voxel_type(&self) -> VoxelType {
        self.samples.voxel_type()
    }

    /// The distance between samples per axis, in world units.
    pub fn spacing(&self) -> [f64; 3] {
        self.spacing
    }

    /// The world position of the first sample.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// What is unusual about the file but does not keep it from being read, a line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Reads the volume from its first slice on. `memory` is how many bytes the reader may keep besides what it hands
    /// out; it needs more than a megabyte only where the file stores samples z fastest.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be read.
    pub fn slices(&self, memory: u64) -> Result<SliceReader<'_>, FormatError> {
        SliceReader::new(&self.samples, memory)
    }

    /// Whether a [`SliceReader`] makes use of memory.
    fn is_transposed(&self) -> bool {
        self.samples.fastest == Fastest::Z
    }

    fn checked(self) -> Result<Self, FormatError> {
        let wrong = |what, found: [f64; 3], expected| {
            let problem = format!("{what} is {found:?}, expected {expected}");
            Err(FormatError::malformed(&self.samples.path, "grid", problem))
        };
        if !is_spacing(&self.spacing) {
            return wrong("the spacing", self.spacing, "positive numbers");
        }
        if !self.origin.iter().all(|position| position.is_finite()) {
            return wrong("the origin", self.origin, "finite numbers");
        }
        Ok(self)
    }
}

/// Whether numbers can be the distances between neighbours along each axis.
pub(crate) fn is_spacing(spacing: &[f64; 3]) -> bool {
    spacing.iter().all(|width| width.is_normal() && *width > 0.0)
}

/// Samples per axis that a header states, if there are any and their bytes can be counted.
fn checked_size(path: &Path, place: &str, size: [u64; 3]) -> Result<[usize; 3], FormatError> {
    const MAX_SAMPLES: u64 = i64::MAX as u64 / size_of::<f64>() as u64;
    let count = size.iter().try_fold(1u64, |count, &samples| count.checked_mul(samples));
    if size.iter().all(|samples| (1..=MAX_SIDE).contains(samples)) && count.is_some_and(|count| count <= MAX_SAMPLES) {
        return Ok(size.map(|samples| samples as usize));
    }
    let problem = format!("size {size:?}, expected 1 to {MAX_SIDE} samples per axis and {MAX_SAMPLES} in all");
    Err(FormatError::malformed(path, place, problem))
}

/// The length of a file.
fn length(file: &File, path: &Path) -> Result<u64, FormatError> {
    Ok(file.metadata().map_err(FormatError::io(path, "read"))?.len())
}
