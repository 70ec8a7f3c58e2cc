//! Keys of a camera's way, from a JSON file.

use std::path::Path;

use amray::scene::{CameraKey, CameraPath, Projection, Viewpoint};
use serde::Deserialize;

use crate::json_file;
use crate::view::FOVY;

/// A camera at a time, as the file has it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    time: f64,
    eye: [f64; 3],
    target: [f64; 3],
    #[serde(default = "up")]
    up: [f64; 3],
    /// In degrees.
    #[serde(default = "fovy")]
    fovy: f64,
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn fovy() -> f64 {
    FOVY
}

/// Reads the way.
///
/// # Errors
/// Which key of the file is wrong, and how.
pub(super) fn read(path: &Path) -> anyhow::Result<CameraPath> {
    json_file::read(path, "the keys", of_json)
}

fn of_json(text: &str) -> Result<CameraPath, String> {
    let value = json_file::value(text)?;
    if !value.is_array() {
        return Err("expected a list of keys".into());
    }
    let keys: Vec<Key> = json_file::typed(value)?;
    let keys = keys.into_iter().map(|Key { time, eye, target, up, fovy }| CameraKey {
        time,
        viewpoint: Viewpoint { eye, target, up, projection: Projection::Perspective { fovy } },
    });
    CameraPath::new(keys.collect()).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_read() {
        let path = of_json(
            r#"[{"time": 1, "eye": [4, 0, 0], "target": [0, 0, 0]},
            {"time": 2, "eye": [0, 4, 0], "target": [0, 0, 1], "up": [0, 1, 1], "fovy": 20}]"#,
        );
        let path = path.unwrap();
        assert_eq!(path.times(), [1.0, 2.0]);
        assert_eq!(path.at(2.0).projection, Projection::Perspective { fovy: 20.0 });
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (json, expected) in [
            ("[{", "no JSON: "),
            (r#"{"keys": []}"#, "expected a list of keys"),
            ("[]", "there is no key"),
            (r#"[{"time": 1, "eye": [4, 0], "target": [0, 0, 0]}]"#, "[0].eye: invalid length 2"),
            (r#"[{"time": 1, "eye": [4, 0, 0]}]"#, "[0]: missing field `target`"),
            (r#"[{"time": 1, "eye": [0, 0, 0], "target": [0, 0, 0]}]"#, "key 0: camera: eye and target"),
        ] {
            let problem = of_json(json).unwrap_err();
            assert!(problem.starts_with(expected), "{json}: {problem}");
        }
    }
}
