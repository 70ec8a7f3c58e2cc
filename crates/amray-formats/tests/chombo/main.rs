//! The Chombo reader against files of real codes, files of other writers, and damaged files.

mod damage;
mod real_files;
mod sample;
mod storage;
mod variants;

use std::path::Path;

use amray::hierarchy::Field;
use amray_formats::{ChomboFile, DataSet, FormatError, OpenOptions};

fn open(path: &Path) -> ChomboFile {
    ChomboFile::open(path, &OpenOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn read(data: &ChomboFile, field: usize) -> Field {
    data.read_field(field, &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// The message of the error that opening the file, or reading its fields, gives, without the path.
fn failure(path: &Path, options: &OpenOptions) -> Option<String> {
    let result = ChomboFile::open(path, options).and_then(|data| {
        let fields = 0..data.fields().len();
        fields.map(|field| data.read_field(field, &|_| {})).find_map(Result::err).map_or(Ok(()), Err)
    });
    result.err().map(|error| message(path, &error))
}

fn message(path: &Path, error: &FormatError) -> String {
    let message = error.to_string();
    assert!(!message.contains('\n'), "{message:?}");
    message.strip_prefix(&format!("{}: ", path.display())).expect("an error starts with the path").to_owned()
}
