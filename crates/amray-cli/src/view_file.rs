//! Views in a file: cameras with transfer functions under names, for pictures that are to be comparable.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use amray::appearance::TransferFunction;
use serde_json::{Map, Value, json};

use crate::appearance::AppearanceArguments;
use crate::data::DataSection;
use crate::json_file;
use crate::number::SIZE_LIMIT;
use crate::scene_file::{PictureSection, SceneDocument};

/// What `--view` names: `FILE:NAME:TF`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ViewName {
    file: PathBuf,
    view: String,
    transfer_function: String,
}

/// A camera and a transfer function.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    pub(crate) field: Option<String>,
    pub(crate) eye: [f64; 3],
    pub(crate) target: [f64; 3],
    pub(crate) up: [f64; 3],
    /// In degrees.
    pub(crate) fovy: f64,
    pub(crate) size: Option<[usize; 2]>,
    pub(crate) transfer_function: TransferFunction,
}

impl From<View> for SceneDocument {
    fn from(view: View) -> Self {
        Self {
            camera: (&view).into(),
            data: DataSection { field: view.field, ..DataSection::default() },
            appearance: AppearanceArguments::of(view.transfer_function),
            picture: PictureSection { size: view.size, ..PictureSection::default() },
            ..Self::default()
        }
    }
}

impl FromStr for ViewName {
    type Err = &'static str;

    /// The file's name may hold colons.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.rsplitn(3, ':').collect::<Vec<_>>()[..] {
            [function, view, file] if ![function, view, file].contains(&"") => {
                Ok(Self { file: file.into(), view: view.into(), transfer_function: function.into() })
            }
            _ => Err("expected FILE:NAME:TF, such as views.json:front:sparse"),
        }
    }
}

/// The view without its file.
impl fmt::Display for ViewName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.view, self.transfer_function)
    }
}

impl ViewName {
    /// Reads the view.
    pub(crate) fn read(&self) -> anyhow::Result<View> {
        json_file::read(&self.file, "the views", |json| self.of_json(json))
    }

    /// The view of a file's text.
    fn of_json(&self, json: &str) -> Result<View, String> {
        let views: Map<String, Value> = serde_json::from_str(json).map_err(|error| format!("no views: {error}"))?;
        let place = format!("view {:?}", self.view);
        let view = named(&views, &self.view, "view")?;
        let view = view.as_object().ok_or_else(|| format!("{place}: expected an object"))?;
        let functions = view.get("tf").and_then(Value::as_object);
        let functions =
            functions.ok_or_else(|| format!("{place}: \"tf\": expected an object of transfer functions"))?;
        let points = named(functions, &self.transfer_function, "transfer function")
            .map_err(|problem| format!("{place}: {problem}"))?;
        let function = TransferFunction::from_json(&json!({ "extinction_points": points }).to_string(), None);
        let triple = |key: &str| numbers::<3>(view, key).map_err(|problem| format!("{place}: {problem}"));
        let fovy = view.get("fovy").and_then(Value::as_f64).filter(|fovy| *fovy > 0.0 && *fovy < 180.0);
        Ok(View {
            field: match view.get("field") {
                None => None,
                Some(Value::String(name)) => Some(name.clone()),
                Some(_) => return Err(format!("{place}: \"field\": expected a name")),
            },
            eye: triple("eye")?,
            target: triple("target")?,
            up: triple("up")?,
            fovy: fovy.ok_or_else(|| format!("{place}: \"fovy\": expected an angle above 0 and below 180 degrees"))?,
            size: view.get("size").map(|size| pixels(size).ok_or(size)).transpose().map_err(|size| {
                format!("{place}: \"size\": {size}, expected pixels, or [width, height], from 1 to {SIZE_LIMIT}")
            })?,
            transfer_function: function
                .map_err(|error| format!("{place}: transfer function {:?}: {error}", self.transfer_function))?,
        })
    }
}

/// The entry called `name`, or which ones there are.
fn named<'a>(entries: &'a Map<String, Value>, name: &str, what: &str) -> Result<&'a Value, String> {
    entries.get(name).ok_or_else(|| {
        let known: Vec<&str> = entries.keys().map(String::as_str).collect();
        format!("no {what} is named {name:?}; there are {}", known.join(", "))
    })
}

fn numbers<const COUNT: usize>(object: &Map<String, Value>, key: &str) -> Result<[f64; COUNT], String> {
    let found = object.get(key).and_then(Value::as_array);
    let found: Option<Vec<f64>> = found.and_then(|array| array.iter().map(Value::as_f64).collect());
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| format!("{key:?}: expected {COUNT} numbers"))
}

/// One number for both sides, or width and height.
fn pixels(size: &Value) -> Option<[usize; 2]> {
    let side = |side: &Value| side.as_u64().map(|side| side as usize).filter(|side| (1..=SIZE_LIMIT).contains(side));
    match size.as_array().map(Vec::as_slice) {
        Some([width, height]) => Some([side(width)?, side(height)?]),
        Some(_) => None,
        None => side(size).map(|side| [side; 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWS: &str = r#"{"front": {
        "field": "density", "eye": [2, 0.5, 1e1], "target": [0, 0, 0], "up": [0, 1, 0], "fovy": 30, "size": [640, 480],
        "tf": {"thin": [[0, 1, 0, 0, 0], [2, 1, 0.5, 0, 3.5]], "bad": [[0, 2, 0, 0, 0]]}
    }, "bare": {"eye": [1, 0], "tf": {"thin": []}}}"#;

    fn view(name: &str, json: &str) -> Result<View, String> {
        name.parse::<ViewName>().unwrap().of_json(json)
    }

    #[test]
    fn names_may_lie_in_files_with_colons() {
        let name: ViewName = "C:/a:b.json:front:thin".parse().unwrap();
        assert_eq!((name.file.to_str().unwrap(), name.to_string().as_str()), ("C:/a:b.json", "front:thin"));
        for wrong in ["a.json", "a.json:front", ":front:thin", "a.json::thin", "a.json:front:"] {
            assert!(wrong.parse::<ViewName>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_view_is_read() {
        let view = view("f:front:thin", VIEWS).unwrap();
        assert_eq!((view.field.as_deref(), view.eye, view.up), (Some("density"), [2.0, 0.5, 10.0], [0.0, 1.0, 0.0]));
        assert_eq!((view.fovy, view.size), (30.0, Some([640, 480])));
        assert_eq!(view.transfer_function.prepared(9.0).sample(2.0).extinction, 3.5);
    }

    #[test]
    fn sizes_are_a_number_or_two() {
        assert_eq!(pixels(&json!(64)), Some([64; 2]));
        for wrong in [json!(0), json!(1.5), json!([1]), json!("64"), json!([64, 1_000_000])] {
            assert_eq!(pixels(&wrong), None, "{wrong}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (name, json, expected) in [
            ("f:back:thin", VIEWS, "no view is named \"back\"; there are bare, front"),
            ("f:front:thick", VIEWS, "view \"front\": no transfer function is named \"thick\"; there are bad, thin"),
            ("f:front:bad", VIEWS, "view \"front\": transfer function \"bad\": "),
            ("f:bare:thin", VIEWS, "view \"bare\": \"eye\": expected 3 numbers"),
            ("f:front:thin", "[]", "no views: "),
            ("f:front:thin", "{\"front\": 1}", "view \"front\": expected an object"),
            ("f:front:thin", "{\"front\": {}}", "view \"front\": \"tf\": expected an object of transfer functions"),
        ] {
            let problem = view(name, json).unwrap_err();
            assert!(problem.starts_with(expected), "{name}: {problem}");
        }
    }
}
