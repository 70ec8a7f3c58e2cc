//! From a path to a data set: which format is it?

use std::fs;
use std::path::Path;

use crate::athena::{AthenaFile, named_in_xdmf};
use crate::completed::Completed;
use crate::enzo::EnzoDump;
use crate::flash::FlashFile;
use crate::hdf5::Hdf5;
use crate::mapped_file::start_of;
use crate::ramses::{OutputFiles, RamsesOutput};
use crate::structured::StructuredVolume;
use crate::{AmrexPlotfile, ChomboFile, DataSet, FormatError, OpenOptions, VthbFile, VtkhdfFile};

/// The formats that are read.
const EXPECTED: &str =
    "Chombo, Athena++, FLASH or VTK HDF5, a VTK AMR index, an AMReX plotfile, an Enzo dump or a RAMSES output";

/// Opens a data set of any format that amray reads. The content decides, not the name. Where the file stores leaf cells
/// alone, the coarse levels are added, as means of the finer ones.
///
/// # Errors
/// [`FormatError`] where nothing is there, no reader knows the content, or the content is damaged.
pub fn open(path: &Path, options: &OpenOptions) -> Result<Box<dyn DataSet>, FormatError> {
    let data = open_as_stored(path, options)?;
    Ok(match data.leaf_only() {
        true => Box::new(Completed::new(data, path, options)?),
        false => data,
    })
}

fn open_as_stored(path: &Path, options: &OpenOptions) -> Result<Box<dyn DataSet>, FormatError> {
    let metadata = fs::metadata(path).map_err(FormatError::io(path, "open"))?;
    if AmrexPlotfile::recognises(path) {
        return Ok(Box::new(AmrexPlotfile::open(path, options)?));
    }
    if let Some(parameters) = EnzoDump::find(path)? {
        return Ok(Box::new(EnzoDump::open(&parameters, options)?));
    }
    if let Some(files) = OutputFiles::find(path) {
        return Ok(Box::new(RamsesOutput::open(&files, options)?));
    }
    if metadata.is_file() {
        if let Some(hdf5) = Hdf5::open(path)? {
            return open_hdf5(hdf5, options);
        }
        if VthbFile::recognises(path)? {
            return Ok(Box::new(VthbFile::open(path, options)?));
        }
        if let Some(data) = named_in_xdmf(path)? {
            let none = || FormatError::malformed(&data, "the file", "not HDF5, expected Athena++ data");
            return open_hdf5(Hdf5::open(&data)?.ok_or_else(none)?, options);
        }
    }
    let found = if metadata.is_dir() {
        "a directory without the files of a plotfile, a dump or an output".into()
    } else if metadata.is_file() {
        described(path)?
    } else {
        "no regular file".into()
    };
    Err(FormatError::Unrecognised { path: path.into(), found, expected: EXPECTED.into() })
}

fn open_hdf5(hdf5: Hdf5, options: &OpenOptions) -> Result<Box<dyn DataSet>, FormatError> {
    Ok(if ChomboFile::recognises(&hdf5)? {
        Box::new(ChomboFile::read(hdf5, options)?)
    } else if AthenaFile::recognises(&hdf5)? {
        Box::new(AthenaFile::read(hdf5, options)?)
    } else if FlashFile::recognises(&hdf5)? {
        Box::new(FlashFile::read(hdf5, options)?)
    } else if VtkhdfFile::recognises(&hdf5)? {
        Box::new(VtkhdfFile::read(hdf5, options)?)
    } else {
        return Err(hdf5.unrecognised(EXPECTED));
    })
}

/// What a file that no reader knows looks like.
fn described(path: &Path) -> Result<String, FormatError> {
    if StructuredVolume::recognises(path)? {
        return Ok("a structured volume (amray convert makes AMR data of it)".into());
    }
    Ok(match start_of(path, 16)?.as_slice() {
        [] => "an empty file".into(),
        text if text.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace()) => {
            format!("a text file that starts with {:?}", String::from_utf8_lossy(text))
        }
        _ => "a file of an unknown kind".into(),
    })
}
