//! JSON values with errors that say which key or number is wrong.

use serde_json::Value;

use super::{Object, PresetError};

/// The start of a value, for messages.
pub(super) fn describe(value: &Value) -> String {
    const LONGEST: usize = 60;
    let text = value.to_string();
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

/// The text of an optional key.
pub(super) fn text<'a>(preset: &'a Object, key: &str, expected: &'static str) -> Result<Option<&'a str>, PresetError> {
    let Some(value) = preset.get(key) else { return Ok(None) };
    let text = value.as_str().ok_or_else(|| wrong(key, value, expected))?;
    Ok(Some(text))
}

/// An optional switch, as true and false or as 1 and 0.
pub(super) fn flag(preset: &Object, key: &str) -> Result<bool, PresetError> {
    let Some(value) = preset.get(key) else { return Ok(false) };
    let number = value.as_f64().or(value.as_bool().map(f64::from));
    match number {
        Some(0.0) => Ok(false),
        Some(1.0) => Ok(true),
        _ => Err(wrong(key, value, "0 or 1")),
    }
}

/// The array of a key.
pub(super) fn array<'a>(preset: &'a Object, key: &str, expected: &'static str) -> Result<&'a [Value], PresetError> {
    let value = &preset[key];
    value.as_array().map(Vec::as_slice).ok_or_else(|| wrong(key, value, expected))
}

/// The error of a key whose value is not as expected.
pub(super) fn wrong(key: &str, value: &Value, expected: &'static str) -> PresetError {
    PresetError::Key { key: key.into(), found: describe(value), expected }
}
