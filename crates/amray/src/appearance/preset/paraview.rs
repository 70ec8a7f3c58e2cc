//! ParaView's presets: colours (`RGBPoints`) mixed in one of VTK's colour spaces, opacities (`Points`) with midpoint
//! and sharpness as in VTK's `vtkPiecewiseFunction`.

use serde_json::Value;

use super::super::color_space::ColorSpace;
use super::super::transfer_function::{check_colors, check_opacity};
use super::super::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use super::{Object, PresetError, flag, json, text};

const COLORS: &str = "RGBPoints";
const OPACITIES: &str = "Points";
/// Linear pieces that stand for a segment that is not linear.
const PIECES: usize = 32;
/// Sharpnesses up to the first are linear, from the second on a step: VTK's own limits.
const LINEAR: f64 = 0.01;
const STEP: f64 = 0.99;

pub(super) fn read(preset: &Object) -> Result<TransferFunction, PresetError> {
    if flag(preset, "IndexedLookup")? || preset.contains_key("IndexedColors") && !preset.contains_key(COLORS) {
        return Err(PresetError::Indexed);
    }
    if !preset.contains_key(COLORS) {
        return Err(PresetError::NoPoints);
    }
    let scale = if flag(preset, "UseLogScale")? { Scale::Log10 } else { Scale::Linear };
    let colors = colors(preset, scale)?;
    let opacities = match preset.get(OPACITIES) {
        // A ramp over all colours is what ParaView makes of a preset without opacities.
        None | Some(Value::Null) => {
            let ends = [(colors[0], 0.0), (colors[colors.len() - 1], 1.0)];
            ends.map(|(point, opacity)| OpacityPoint { value: point.value, opacity }).to_vec()
        }
        Some(_) => opacities(preset, scale)?,
    };
    TransferFunction::new(scale, colors, Opacity::PerUnitDistance(opacities))
        .map_err(|source| PresetError::Points { key: COLORS, source })
}

fn colors(preset: &Object, scale: Scale) -> Result<Vec<ColorPoint>, PresetError> {
    let space = color_space(preset)?;
    let rows = quadruples(preset, COLORS, "value, red, green, blue")?;
    let points: Vec<ColorPoint> = rows
        .iter()
        .map(|&[value, red, green, blue]| ColorPoint { value, color: [red, green, blue].map(|channel| channel as f32) })
        .collect();
    check_colors(scale, &points).map_err(|source| PresetError::Points { key: COLORS, source })?;
    if space == ColorSpace::Rgb {
        return Ok(points);
    }
    let mut mixed = vec![points[0]];
    for pair in points.windows(2) {
        let [first, second] = [pair[0], pair[1]].map(|point| point.color.map(f64::from));
        let range = [pair[0].value, pair[1].value];
        let starts = if space == ColorSpace::Step { 0..=1 } else { 1..=PIECES };
        for piece in starts.clone() {
            let share = piece as f64 / *starts.end() as f64;
            let color = space.mix(first, second, share).map(|channel| channel as f32);
            mixed.push(ColorPoint { value: scale.at_fraction(range, share), color });
        }
    }
    Ok(mixed)
}

fn color_space(preset: &Object) -> Result<ColorSpace, PresetError> {
    const KEY: &str = "ColorSpace";
    const SPACES: &str = "RGB, HSV, Lab, Diverging, Lab/CIEDE2000 or Step";
    Ok(match text(preset, KEY, SPACES)? {
        None | Some("RGB") => ColorSpace::Rgb,
        Some("HSV") => ColorSpace::Hsv,
        // CIEDE2000 spaces the colours of nearly the same path more evenly.
        Some("Lab" | "CIELAB" | "Lab/CIEDE2000") => ColorSpace::Lab,
        Some("Diverging") => ColorSpace::Diverging,
        Some("Step") => ColorSpace::Step,
        Some(_) => return Err(json::wrong(KEY, &preset[KEY], SPACES)),
    })
}

fn opacities(preset: &Object, scale: Scale) -> Result<Vec<OpacityPoint>, PresetError> {
    let rows = quadruples(preset, OPACITIES, "value, opacity, midpoint, sharpness")?;
    for (index, &[.., midpoint, sharpness]) in rows.iter().enumerate() {
        if let Some(found) = [midpoint, sharpness].into_iter().find(|share| !(0.0..=1.0).contains(share)) {
            let (element, expected) = ("point", "midpoint and sharpness within 0 and 1");
            return Err(PresetError::Element { key: OPACITIES, element, index, found: found.to_string(), expected });
        }
    }
    let points: Vec<OpacityPoint> = rows.iter().map(|&[value, opacity, ..]| OpacityPoint { value, opacity }).collect();
    let points = Opacity::PerUnitDistance(points);
    check_opacity(scale, &points).map_err(|source| PresetError::Points { key: OPACITIES, source })?;
    let points = points.points();
    let mut resampled = vec![points[0]];
    for (pair, &[.., midpoint, sharpness]) in points.windows(2).zip(&rows) {
        let range = [pair[0].value, pair[1].value];
        let place = |share| scale.at_fraction(range, share);
        let mut push = |share, opacity| resampled.push(OpacityPoint { value: place(share), opacity });
        if sharpness > STEP {
            push(midpoint, pair[0].opacity);
            push(midpoint, pair[1].opacity);
        } else if sharpness >= LINEAR {
            for piece in 1..PIECES {
                let share = piece as f64 / PIECES as f64;
                push(share, sharp_segment([pair[0].opacity, pair[1].opacity], share, midpoint, sharpness));
            }
        } else if midpoint != 0.5 {
            push(midpoint, 0.5 * (pair[0].opacity + pair[1].opacity));
        }
        resampled.push(pair[1]);
    }
    Ok(resampled)
}

/// A segment of `vtkPiecewiseFunction`: a Hermite curve that passes half its height at the midpoint.
fn sharp_segment([first, second]: [f64; 2], share: f64, midpoint: f64, sharpness: f64) -> f64 {
    let midpoint = midpoint.clamp(1e-5, 1.0 - 1e-5);
    let even =
        if share < midpoint { 0.5 * share / midpoint } else { 0.5 + 0.5 * (share - midpoint) / (1.0 - midpoint) };
    let exponent = 1.0 + 10.0 * sharpness;
    let bent =
        if even < 0.5 { 0.5 * (2.0 * even).powf(exponent) } else { 1.0 - 0.5 * (2.0 - 2.0 * even).powf(exponent) };
    let slope = (1.0 - sharpness) * (second - first);
    let [square, cube] = [bent.powi(2), bent.powi(3)];
    let blend = 3.0 * square - 2.0 * cube;
    let value = first + blend * (second - first) + (2.0 * cube - 3.0 * square + bent) * slope;
    value.clamp(first.min(second), first.max(second))
}

/// The flat array of a key, in rows of four.
fn quadruples(preset: &Object, key: &'static str, meaning: &'static str) -> Result<Vec<[f64; 4]>, PresetError> {
    let values = json::array(preset, key, "an array of numbers")?;
    let mut numbers = Vec::with_capacity(values.len());
    for (index, value) in values.iter().enumerate() {
        numbers.push(value.as_f64().ok_or_else(|| PresetError::Element {
            key,
            element: "number",
            index,
            found: json::describe(value),
            expected: "a number",
        })?);
    }
    let (rows, []) = numbers.as_chunks() else {
        return Err(PresetError::Count { key, count: numbers.len(), meaning });
    };
    Ok(rows.to_vec())
}

#[cfg(test)]
mod tests {
    use super::super::super::Sample;
    use super::*;

    fn read(json: &str) -> TransferFunction {
        TransferFunction::from_json(json, None).unwrap()
    }

    fn message(json: &str) -> String {
        TransferFunction::from_json(json, None).unwrap_err().to_string()
    }

    /// The opacity of a unit distance at `value`.
    fn opacity(function: &TransferFunction, value: f64) -> f32 {
        function.prepared(1.0).sample(value).alpha(1.0)
    }

    /// The colour at `value`, in units of 1 / 255.
    fn color(function: &TransferFunction, value: f64) -> [i32; 3] {
        let Sample { color, .. } = function.prepared(1.0).sample(value);
        color.map(|channel| (channel * 255.0).round() as i32)
    }

    /// What "Cool to Warm" looks like when ParaView exports it.
    const COOL_TO_WARM: &str = r#"[{
        "ColorSpace" : "Diverging", "Creator" : "Moreland", "DefaultMap" : true, "Name" : "Cool to Warm",
        "NanColor" : [1, 1, 0],
        "Points" : [0, 0, 0.5, 0, 10, 1, 0.5, 0],
        "RGBPoints" : [0, 0.23137254902, 0.298039215686, 0.752941176471,
                       5, 0.865, 0.865, 0.865,
                       10, 0.705882352941, 0.0156862745098, 0.149019607843]
    }]"#;

    #[test]
    fn cool_to_warm_as_paraview_exports_it() {
        let function = read(COOL_TO_WARM);
        assert_eq!(function.range(), [0.0, 10.0]);
        let colors = [0.0, 2.5, 5.0, 7.5, 10.0].map(|value| color(&function, value));
        assert_eq!(colors, [[59, 76, 192], [141, 176, 254], [221, 221, 221], [244, 154, 123], [180, 4, 38]]);
        assert!((opacity(&function, 2.5) - 0.25).abs() < 1e-6);
        assert_eq!(opacity(&function, 10.0), 1.0);
    }

    #[test]
    fn hues_do_not_wrap() {
        let function =
            read(r#"{"ColorSpace": "HSV", "Name": "Blue to Red Rainbow", "RGBPoints": [-1, 0, 0, 1, 1, 1, 0, 0]}"#);
        let colors = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|value| color(&function, value));
        assert_eq!(colors, [[0, 0, 255], [0, 255, 255], [0, 255, 0], [255, 255, 0], [255, 0, 0]]);
    }

    #[test]
    fn without_opacities_they_rise_over_the_range() {
        let function = read(r#"{"RGBPoints": [2, 0, 0, 0, 4, 1, 1, 1]}"#);
        let ramp = [(2.0, 0.0), (4.0, 1.0)].map(|(value, opacity)| OpacityPoint { value, opacity });
        assert_eq!(function.opacity(), &Opacity::PerUnitDistance(ramp.to_vec()));
    }

    #[test]
    fn a_log_scale_holds_for_colours_and_opacities() {
        let function = read(
            r#"{"ColorSpace": "Lab", "UseLogScale": 1, "RGBPoints": [0.01, 0, 0, 0, 100, 1, 1, 1],
                "Points": [0.01, 0, 0.5, 0, 100, 1, 0.5, 0]}"#,
        );
        assert_eq!(function.scale(), Scale::Log10);
        assert!((opacity(&function, 1.0) - 0.5).abs() < 1e-6);
        // The gray of lightness 50.
        assert_eq!(color(&function, 1.0), [119, 119, 119]);
        assert_eq!(
            message(r#"{"UseLogScale": true, "RGBPoints": [0, 0, 0, 0, 100, 1, 1, 1]}"#),
            "\"RGBPoints\": colour point 0: value 0.0, expected a number above 0 on a log scale"
        );
    }

    #[test]
    fn steps_take_the_colour_of_their_end() {
        let function =
            read(r#"{"ColorSpace": "Step", "RGBPoints": [0, 1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1], "Points": null}"#);
        let colors = [-0.5, 0.5, 0.99, 1.01, 3.0].map(|value| color(&function, value));
        assert_eq!(colors, [[255, 0, 0], [0, 255, 0], [0, 255, 0], [0, 0, 255], [0, 0, 255]]);
    }

    #[test]
    fn midpoint_and_sharpness_shape_the_segment() {
        let with = |midpoint, sharpness| {
            read(&format!(
                r#"{{"RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "Points": [0, 0.2, {midpoint}, {sharpness}, 1, 0.8, 0.5, 0]}}"#
            ))
        };
        let near = |function: &TransferFunction, value, expected: f32| {
            let found = opacity(function, value);
            assert!((found - expected).abs() < 2e-4, "{found} at {value}, expected {expected}");
        };
        // Moved midpoint: two linear pieces.
        let bent = with(0.25, 0.0);
        assert_eq!(bent.opacity().points().len(), 3);
        near(&bent, 0.25, 0.5);
        near(&bent, 0.625, 0.65);
        // Full sharpness: a step at the midpoint.
        let step = with(0.25, 1.0);
        near(&step, 0.2499, 0.2);
        near(&step, 0.25, 0.8);
        // In between: values of vtkPiecewiseFunction, worked out by hand. At a quarter, 0.5 * 0.5^6 = 1/128.
        let curve = with(0.5, 0.5);
        let s = 1.0f32 / 128.0;
        let height = 3.0 * s * s - 2.0 * s * s * s + (2.0 * s * s * s - 3.0 * s * s + s) * 0.5;
        near(&curve, 0.25, 0.2 + 0.6 * height);
        near(&curve, 0.5, 0.5);
        near(&curve, 0.75, 0.8 - 0.6 * height);
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        assert_eq!(
            message(r#"{"Name": "KAAMS", "IndexedColors": [1, 1, 1, 1, 0, 0]}"#),
            "an indexed (categorical) preset, expected one that is continuous in the value (\"RGBPoints\")"
        );
        assert!(message(r#"{"IndexedLookup": true, "RGBPoints": [0, 0, 0, 0]}"#).starts_with("an indexed"));
        assert_eq!(
            message(r#"{"ColorSpace": "CMYK", "RGBPoints": [0, 0, 0, 0]}"#),
            "\"ColorSpace\": \"CMYK\", expected RGB, HSV, Lab, Diverging, Lab/CIEDE2000 or Step"
        );
        assert_eq!(message(r#"{"RGBPoints": 7}"#), "\"RGBPoints\": 7, expected an array of numbers");
        assert_eq!(
            message(r#"{"RGBPoints": [0, 0, 0, 0, 1]}"#),
            "\"RGBPoints\": 5 numbers, expected a multiple of 4 (value, red, green, blue)"
        );
        assert_eq!(message(r#"{"RGBPoints": [0, 0, "x", 0]}"#), "\"RGBPoints\", number 2: \"x\", expected a number");
        assert_eq!(message(r#"{"RGBPoints": []}"#), "\"RGBPoints\": no colour points, expected at least one");
        assert_eq!(
            message(r#"{"ColorSpace": "Lab", "RGBPoints": [0, 0, 0, 0, 1, 2, 0, 0]}"#),
            "\"RGBPoints\": colour point 1: [2.0, 0.0, 0.0], expected red, green and blue within 0 and 1"
        );
        assert_eq!(
            message(r#"{"RGBPoints": [0, 0, 0, 0], "Points": [0, 0, 0.5, 0, 1, 1, 1.5, 0]}"#),
            "\"Points\", point 1: 1.5, expected midpoint and sharpness within 0 and 1"
        );
        assert_eq!(
            message(r#"{"RGBPoints": [0, 0, 0, 0], "Points": [0, 0, 0.5, 0, -1, 1, 0.5, 0]}"#),
            "\"Points\": opacity point 1: value -1.0 after 0.0, expected ascending values"
        );
        assert_eq!(message(r#"{"RGBPoints": [0, 0, 0, 0], "UseLogScale": 2}"#), "\"UseLogScale\": 2, expected 0 or 1");
    }
}
