//! Transfer functions as JSON: amray's own format and ParaView's presets.

mod json;
mod own;
mod paraview;

use serde_json::{Map, Value};
use thiserror::Error;

use super::{TransferFunction, TransferFunctionError};
use json::{describe, flag, text};

type Object = Map<String, Value>;

/// JSON that describes no transfer function. Numbers, rows and points are counted from 0.
#[derive(Debug, Error)]
pub enum PresetError {
    /// Text that is not JSON; the message names line and column.
    #[error("not JSON: {0}")]
    Syntax(#[from] serde_json::Error),
    /// JSON of another shape.
    #[error("{found}, expected one preset or an array of presets")]
    Shape {
        /// What is there instead.
        found: String,
    },
    /// An array without presets.
    #[error("an empty array, expected at least one preset")]
    Empty,
    /// A name that none of the presets has.
    #[error("no preset is named {name:?}; the presets are {}", known.join(", "))]
    UnknownName {
        /// The name asked for.
        name: String,
        /// The names of all presets.
        known: Vec<String>,
    },
    /// An object that is no preset.
    #[error(
        "no transfer function, expected the key \"points\", \"extinction_points\" or, as ParaView has it, \"RGBPoints\""
    )]
    NoPoints,
    /// A ParaView preset for categories.
    #[error("an indexed (categorical) preset, expected one that is continuous in the value (\"RGBPoints\")")]
    Indexed,
    /// A key with a value of the wrong kind.
    #[error("{key:?}: {found}, expected {expected}")]
    Key {
        /// The key.
        key: String,
        /// Its value.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A key that means nothing.
    #[error("{key:?}: unknown key, expected {expected}")]
    UnknownKey {
        /// The key.
        key: String,
        /// The keys there are.
        expected: &'static str,
    },
    /// An element of an array of the wrong kind.
    #[error("{key:?}, {element} {index}: {found}, expected {expected}")]
    Element {
        /// The array's key.
        key: &'static str,
        /// What the array is made of.
        element: &'static str,
        /// The element.
        index: usize,
        /// Its value.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
    /// A flat array of a wrong length.
    #[error("{key:?}: {count} numbers, expected a multiple of 4 ({meaning})")]
    Count {
        /// The array's key.
        key: &'static str,
        /// Its length.
        count: usize,
        /// What the four numbers are.
        meaning: &'static str,
    },
    /// Points that make no transfer function.
    #[error("{key:?}: {source}")]
    Points {
        /// The key of the points.
        key: &'static str,
        /// What is wrong with them.
        source: TransferFunctionError,
    },
}

impl TransferFunction {
    /// A transfer function from the JSON of one preset or of an array of them: of the first, or of the one called
    /// `name`.
    ///
    /// A preset is either amray's own, `{"points": [[value, r, g, b, a], ...]}` with the opacity a of one unit
    /// distance or `{"extinction_points": [[value, r, g, b, sigma], ...]}` with the extinction sigma per world
    /// length, each optionally with `"scale": "log10"` and `"name"`; or ParaView's, with `RGBPoints`, `Points`,
    /// `ColorSpace` and `UseLogScale`.
    ///
    /// # Errors
    /// [`PresetError`] names the key and the number that cannot be used.
    pub fn from_json(json: &str, name: Option<&str>) -> Result<Self, PresetError> {
        let value: Value = serde_json::from_str(json)?;
        let presets = match &value {
            Value::Object(preset) => vec![preset],
            Value::Array(presets) => presets
                .iter()
                .map(|preset| preset.as_object().ok_or_else(|| PresetError::Shape { found: describe(preset) }))
                .collect::<Result<_, _>>()?,
            _ => return Err(PresetError::Shape { found: describe(&value) }),
        };
        let preset = match name {
            None => presets.first().ok_or(PresetError::Empty)?,
            Some(name) => presets.iter().find(|preset| name_of(preset) == Some(name)).ok_or_else(|| {
                let known = presets.iter().map(|preset| name_of(preset).unwrap_or("(unnamed)").to_owned()).collect();
                PresetError::UnknownName { name: name.into(), known }
            })?,
        };
        if preset.contains_key(own::POINTS) || preset.contains_key(own::EXTINCTION_POINTS) {
            own::read(preset)
        } else {
            paraview::read(preset)
        }
    }

    /// The function in amray's own format, as [`TransferFunction::from_json`] reads it: a point a line.
    ///
    /// Where colours and opacities have points of their own, both get points at all values.
    pub fn to_json(&self) -> String {
        own::write(self)
    }
}

fn name_of(preset: &Object) -> Option<&str> {
    preset.get("name").or_else(|| preset.get("Name"))?.as_str()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(json: &str, name: Option<&str>) -> String {
        TransferFunction::from_json(json, name).unwrap_err().to_string()
    }

    const TWO: &str = r#"[{"name": "first", "points": [[1, 0, 0, 0, 0.5]]},
                          {"Name": "second", "RGBPoints": [2, 0, 0, 0, 3, 1, 1, 1]}]"#;

    #[test]
    fn presets_are_chosen_by_name() {
        let range = |name| TransferFunction::from_json(TWO, name).unwrap().range();
        assert_eq!(range(None), [1.0, 1.0]);
        assert_eq!(range(Some("first")), [1.0, 1.0]);
        assert_eq!(range(Some("second")), [2.0, 3.0]);
        assert_eq!(message(TWO, Some("third")), "no preset is named \"third\"; the presets are first, second");
    }

    #[test]
    fn other_json_is_refused() {
        assert_eq!(message("{", None), "not JSON: EOF while parsing an object at line 1 column 1");
        assert_eq!(message("{\"points\": [[1e999]]}", None), "not JSON: number out of range at line 1 column 18");
        assert_eq!(message("3", None), "3, expected one preset or an array of presets");
        assert_eq!(message("[[]]", None), "[], expected one preset or an array of presets");
        assert_eq!(message("[]", None), "an empty array, expected at least one preset");
        assert_eq!(
            message("{}", None),
            "no transfer function, expected the key \"points\", \"extinction_points\" or, as ParaView has it, \
             \"RGBPoints\""
        );
        let long = format!("{{\"points\": \"{}\"}}", "x".repeat(1000));
        let shown = "x".repeat(59);
        assert_eq!(message(&long, None), format!("\"points\": \"{shown}..., expected an array of points"));
        assert!(message(&"[".repeat(100_000), None).starts_with("not JSON: recursion limit exceeded"));
    }
}
