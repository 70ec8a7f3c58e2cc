//! amray's own format: rows of value, colour and opacity or extinction.

use std::fmt::Write;

use serde_json::Value;

use super::super::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use super::{Object, PresetError, describe, json, text};

pub(super) const POINTS: &str = "points";
pub(super) const EXTINCTION_POINTS: &str = "extinction_points";
const KEYS: [&str; 4] = [POINTS, EXTINCTION_POINTS, "scale", "name"];
const SCALES: &str = "\"linear\" or \"log10\"";

pub(super) fn read(preset: &Object) -> Result<TransferFunction, PresetError> {
    if let Some(key) = preset.keys().find(|key| !KEYS.contains(&key.as_str())) {
        let expected = "points or extinction_points, scale and name";
        return Err(PresetError::UnknownKey { key: key.clone(), expected });
    }
    text(preset, "name", "a text")?;
    let scale = match text(preset, "scale", SCALES)? {
        None | Some("linear") => Scale::Linear,
        Some("log10") => Scale::Log10,
        Some(_) => return Err(json::wrong("scale", &preset["scale"], SCALES)),
    };
    let (key, expected, quantity): (_, _, fn(_) -> _) = match (preset.get(POINTS), preset.get(EXTINCTION_POINTS)) {
        (_, None) => (POINTS, "five numbers: value, red, green, blue, opacity", Opacity::PerUnitDistance),
        (None, _) => (EXTINCTION_POINTS, "five numbers: value, red, green, blue, extinction", Opacity::Extinction),
        (Some(_), Some(value)) => return Err(json::wrong(EXTINCTION_POINTS, value, "no such key beside \"points\"")),
    };
    let rows = json::array(preset, key, "an array of points")?;
    let (mut colors, mut opacities) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
    for (index, row) in rows.iter().enumerate() {
        let [value, red, green, blue, opacity] = numbers(row).ok_or_else(|| PresetError::Element {
            key,
            element: "point",
            index,
            found: describe(row),
            expected,
        })?;
        colors.push(ColorPoint { value, color: [red, green, blue].map(|channel| channel as f32) });
        opacities.push(OpacityPoint { value, opacity });
    }
    TransferFunction::new(scale, colors, quantity(opacities)).map_err(|source| PresetError::Points { key, source })
}

fn numbers(row: &Value) -> Option<[f64; 5]> {
    let numbers: Option<Vec<f64>> = row.as_array()?.iter().map(Value::as_f64).collect();
    numbers?.try_into().ok()
}

pub(super) fn write(function: &TransferFunction) -> String {
    let key = match function.opacity() {
        Opacity::PerUnitDistance(_) => POINTS,
        Opacity::Extinction(_) => EXTINCTION_POINTS,
    };
    let mut json = String::from("{\n");
    if function.scale() == Scale::Log10 {
        json.push_str("  \"scale\": \"log10\",\n");
    }
    let rows = rows(function);
    let rows: Vec<String> =
        rows.iter().map(|row| format!("    {}", serde_json::to_string(row).expect("a row is numbers"))).collect();
    write!(json, "  \"{key}\": [\n{}\n  ]\n}}\n", rows.join(",\n")).expect("writing to a string");
    json
}

/// Value, red, green, blue (single precision, so they are written with no more digits than they have), opacity.
type Row = (f64, f32, f32, f32, f64);

/// A row for every value at which colour or opacity have a point, two where either has a step.
fn rows(function: &TransferFunction) -> Vec<Row> {
    let (colors, opacity) = (function.color_curve(), function.opacity_curve());
    let mut values: Vec<f64> = function.colors().iter().map(|point| point.value).collect();
    values.extend(function.opacity().points().iter().map(|point| point.value));
    values.sort_by(f64::total_cmp);
    values.dedup();
    let row = |value: f64, [red, green, blue]: [f64; 3], [opacity]: [f64; 1]| {
        (value, red as f32, green as f32, blue as f32, opacity)
    };
    let mut rows = Vec::new();
    for value in values {
        let position = function.scale().position(value);
        if colors.has_step(position) || opacity.has_step(position) {
            rows.push(row(value, colors.left_of(position), opacity.left_of(position)));
        }
        rows.push(row(value, colors.at(position), opacity.at(position)));
    }
    rows
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(json: &str) -> TransferFunction {
        TransferFunction::from_json(json, None).unwrap()
    }

    fn message(json: &str) -> String {
        TransferFunction::from_json(json, None).unwrap_err().to_string()
    }

    #[test]
    fn points_are_rows_of_value_colour_and_opacity() {
        let function = read(r#"{"name": "haze", "points": [[-1, 0, 0.5, 1, 0.25], [2e3, 1, 1, 1, 1]]}"#);
        let colors = [(-1.0, [0.0, 0.5, 1.0]), (2e3, [1.0; 3])].map(|(value, color)| ColorPoint { value, color });
        let opacities = [(-1.0, 0.25), (2e3, 1.0)].map(|(value, opacity)| OpacityPoint { value, opacity });
        assert_eq!(function.scale(), Scale::Linear);
        assert_eq!(function.colors(), colors);
        assert_eq!(function.opacity(), &Opacity::PerUnitDistance(opacities.to_vec()));

        let function = read(r#"{"scale": "log10", "extinction_points": [[1, 0, 0, 0, 250]]}"#);
        assert_eq!(function.scale(), Scale::Log10);
        assert_eq!(function.opacity(), &Opacity::Extinction(vec![OpacityPoint { value: 1.0, opacity: 250.0 }]));
    }

    #[test]
    fn what_is_written_has_a_point_a_line() {
        let json = "{\n  \"scale\": \"log10\",\n  \"points\": [\n    [0.1,0.1,0.2,1.0,0.3],\n    \
                    [1e+30,0.0,0.0,0.0,1.0]\n  ]\n}\n";
        assert_eq!(read(json).to_json(), json);
    }

    #[test]
    fn separate_points_are_joined() {
        let colors =
            [(0.0, [0.0; 3]), (1.0, [1.0; 3]), (1.0, [0.0; 3])].map(|(value, color)| ColorPoint { value, color });
        let opacities = [(0.5, 0.0), (2.0, 0.75)].map(|(value, opacity)| OpacityPoint { value, opacity });
        let opacity = Opacity::Extinction(opacities.to_vec());
        let function = read(&TransferFunction::new(Scale::Linear, colors.to_vec(), opacity).unwrap().to_json());
        let expected = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [1.0, 1.0, 0.25], [1.0, 0.0, 0.25], [2.0, 0.0, 0.75]];
        let points = function.colors().iter().zip(function.opacity().points());
        let found: Vec<_> = points.map(|(c, o)| [c.value, c.color[1].into(), o.opacity]).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn every_bad_key_and_row_is_named() {
        assert_eq!(
            message(r#"{"points": [], "scal": "log10"}"#),
            "\"scal\": unknown key, expected points or extinction_points, scale and name"
        );
        assert_eq!(message(r#"{"points": [], "scale": "ln"}"#), "\"scale\": \"ln\", expected \"linear\" or \"log10\"");
        assert_eq!(message(r#"{"points": [], "scale": 10}"#), "\"scale\": 10, expected \"linear\" or \"log10\"");
        assert_eq!(message(r#"{"points": [], "name": {}}"#), "\"name\": {}, expected a text");
        assert_eq!(
            message(r#"{"points": [], "extinction_points": []}"#),
            "\"extinction_points\": [], expected no such key beside \"points\""
        );
        assert_eq!(message(r#"{"points": "red"}"#), "\"points\": \"red\", expected an array of points");
        assert_eq!(message(r#"{"points": []}"#), "\"points\": no colour points, expected at least one");
        assert_eq!(
            message(r#"{"points": [[0, 0, 0, 0, 0], [1, 0, 0, 0]]}"#),
            "\"points\", point 1: [1,0,0,0], expected five numbers: value, red, green, blue, opacity"
        );
        assert_eq!(
            message(r#"{"extinction_points": [[0, 0, null, 0, 0]]}"#),
            "\"extinction_points\", point 0: [0,0,null,0,0], expected five numbers: value, red, green, blue, extinction"
        );
        assert_eq!(
            message(r#"{"points": [[0, 0, 0, 0, 0], [1, 0, 0, 0, 1.5]]}"#),
            "\"points\": opacity point 1: opacity 1.5, expected a number within 0 and 1"
        );
        assert_eq!(
            message(r#"{"points": [[0, 0, 0, 256, 0]]}"#),
            "\"points\": colour point 0: [0.0, 0.0, 256.0], expected red, green and blue within 0 and 1"
        );
        assert_eq!(
            message(r#"{"points": [[1, 0, 0, 0, 0], [0, 0, 0, 0, 1]]}"#),
            "\"points\": colour point 1: value 0.0 after 1.0, expected ascending values"
        );
        assert_eq!(
            message(r#"{"extinction_points": [[0, 0, 0, 0, -0.5]]}"#),
            "\"extinction_points\": opacity point 0: extinction -0.5, expected a finite number of at least 0"
        );
        assert_eq!(
            message(r#"{"points": [[0, 0, 0, 0, 1]], "scale": "log10"}"#),
            "\"points\": colour point 0: value 0.0, expected a number above 0 on a log scale"
        );
    }

    proptest! {
        #[test]
        fn round_trips_are_exact(
            mut values in prop::collection::vec(1e-30f64..1e30, 1..12),
            colors in prop::collection::vec([0f32..=1.0, 0f32..=1.0, 0f32..=1.0], 12),
            opacities in prop::collection::vec(0f64..=1.0, 12),
            log in any::<bool>(),
            step in any::<bool>(),
        ) {
            values.sort_by(f64::total_cmp);
            if step {
                values.insert(0, values[0]);
            }
            let scale = if log { Scale::Log10 } else { Scale::Linear };
            let color_points = values.iter().zip(&colors).map(|(&value, &color)| ColorPoint { value, color }).collect();
            let points = values.iter().zip(&opacities).map(|(&value, &opacity)| OpacityPoint { value, opacity }).collect();
            let function = TransferFunction::new(scale, color_points, Opacity::PerUnitDistance(points)).unwrap();
            prop_assert_eq!(read(&function.to_json()), function);
        }
    }
}
