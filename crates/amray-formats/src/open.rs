//! From a path to a data set: which format is it?

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use crate::completed::Completed;
use crate::hdf5::Hdf5;
use crate::{AmrexPlotfile, ChomboFile, DataSet, FormatError, OpenOptions};

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
    let expected = "a Chombo HDF5 file or an AMReX plotfile";
    if metadata.is_file()
        && let Some(hdf5) = Hdf5::open(path)?
    {
        return match ChomboFile::recognises(&hdf5)? {
            true => Ok(Box::new(ChomboFile::read(hdf5, options)?)),
            false => Err(hdf5.unrecognised(expected)),
        };
    }
    let found = if metadata.is_dir() {
        "a directory without a plotfile's Header".into()
    } else if metadata.is_file() {
        described(path)?
    } else {
        "no regular file".into()
    };
    Err(FormatError::Unrecognised { path: path.into(), found, expected: expected.into() })
}

/// What a file that no reader knows looks like.
fn described(path: &Path) -> Result<String, FormatError> {
    let mut start = Vec::new();
    let file = File::open(path).map_err(FormatError::io(path, "open"))?;
    file.take(16).read_to_end(&mut start).map_err(FormatError::io(path, "read"))?;
    Ok(match start.as_slice() {
        [] => "an empty file".into(),
        text if text.iter().all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace()) => {
            format!("a text file that starts with {:?}", String::from_utf8_lossy(text))
        }
        _ => "a file of an unknown kind".into(),
    })
}
