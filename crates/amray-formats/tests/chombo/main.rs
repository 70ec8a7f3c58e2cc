//! The Chombo reader against files of real codes, files of other writers, and damaged files.

mod damage;
mod real_files;
mod sample;
mod storage;
mod variants;

use std::path::Path;
use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::Field;
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{ChomboFile, DataSet, FormatError, OpenOptions, derived_fields, read_named};

fn open(path: &Path) -> ChomboFile {
    ChomboFile::open(path, &OpenOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn read(data: &ChomboFile, field: usize) -> Field {
    data.read_field(field, &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// The message of the error that opening the file, or reading its fields, gives, without the path.
fn failure(path: &Path, options: &OpenOptions) -> Option<String> {
    ChomboFile::open(path, options).and_then(|data| sample_all(&data)).err().map(|error| message(path, &error))
}

/// Reads every field and samples a point of each.
fn sample_all(data: &ChomboFile) -> Result<(), FormatError> {
    // Damage can make a mesh that is sound, but takes its time.
    let few = data.hierarchy().cells() < 1_000_000;
    let index = few.then(|| Arc::new(Index::build(data.hierarchy().clone())));
    let stored = (0..data.fields().len()).map(|field| data.read_field(field, &|_| {}));
    let derived = derived_fields(data).into_iter();
    let derived = derived.map(|derived| read_named(Path::new(""), data, &derived.name, &|field| field, &|_| {}));
    for values in stored.chain(derived) {
        let values = values?;
        if let Some(index) = &index {
            let [low, high] = data.hierarchy().bounds();
            let middle = std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) / 2.0);
            Volume::new(index.clone(), values, Method::Basis).sample(&[middle]);
        }
    }
    Ok(())
}

fn message(path: &Path, error: &FormatError) -> String {
    let message = error.to_string();
    assert!(!message.contains('\n'), "{message:?}");
    message.strip_prefix(&format!("{}: ", path.display())).expect("an error starts with the path").to_owned()
}
