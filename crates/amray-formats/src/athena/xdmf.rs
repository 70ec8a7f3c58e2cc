//! The XDMF file that Athena++ writes beside its data, for other programs: it names the data.

use std::path::{Path, PathBuf};

use crate::FormatError;
use crate::mapped_file::start_of;

/// The names of data come early.
const LOOKED_AT: u64 = 1 << 16;

/// The .athdf file that an XDMF file is about, beside it; `None` where the file is none.
///
/// # Errors
/// [`FormatError::Io`] where the file cannot be read.
pub(crate) fn named_in_xdmf(path: &Path) -> Result<Option<PathBuf>, FormatError> {
    let start = start_of(path, LOOKED_AT)?;
    let text = String::from_utf8_lossy(&start);
    if !text.contains("<Xdmf") {
        return Ok(None);
    }
    let name = text.split(".athdf:").next().filter(|before| before.len() < text.len());
    let name = name
        .and_then(|before| before.rsplit(|letter: char| letter.is_whitespace() || "/\\<>\"".contains(letter)).next());
    Ok(name.filter(|name| !name.is_empty()).map(|name| path.with_file_name(format!("{name}.athdf"))))
}
