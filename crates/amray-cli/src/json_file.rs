//! JSON files that users write: errors say which file, which key, and what is wrong.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

/// The text of a file that holds `what`, and what `parse` makes of it.
pub(crate) fn read<T>(path: &Path, what: &str, parse: impl FnOnce(&str) -> Result<T, String>) -> anyhow::Result<T> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("cannot read {what}: {error}"));
    text.and_then(|text| parse(&text)).map_err(|problem| anyhow::anyhow!("{}: {problem}", path.display()))
}

/// The value of a JSON text.
pub(crate) fn value(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("no JSON: {error}"))
}

/// A value as what it should be; the error names the key.
pub(crate) fn typed<T: DeserializeOwned>(value: Value) -> Result<T, String> {
    serde_path_to_error::deserialize(value).map_err(|error| format!("{}: {}", error.path(), error.inner()))
}
