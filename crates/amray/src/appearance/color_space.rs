//! Mixing colours in the colour spaces of VTK's colour transfer functions, ParaView's presets among them.
//!
//! CIELAB is that of sRGB and the white point D65. Msh is its polar form by Moreland, *Diverging Color Maps for
//! Scientific Visualization* (ISVC 2009).

use std::f64::consts::PI;

/// The space in which two colours are mixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorSpace {
    Rgb,
    Hsv,
    Lab,
    /// Moreland's Msh: two distinct saturated colours meet in a white.
    Diverging,
    /// No mixing: the second colour.
    Step,
}

/// XYZ of the white point D65.
const WHITE: [f64; 3] = [0.9505, 1.0, 1.089];
/// Msh saturations below this are grays, whose hue means nothing.
const UNSATURATED: f64 = 0.05;
/// Hues further apart than this have a white between them.
const DISTINCT_HUES: f64 = PI / 3.0;
/// The least lightness of that white.
const MIDDLE_LIGHTNESS: f64 = 88.0;

impl ColorSpace {
    /// The colour that lies `share` (0 to 1) of the way between two; all are red, green, blue within 0 and 1.
    pub(super) fn mix(self, first: [f64; 3], second: [f64; 3], share: f64) -> [f64; 3] {
        match self {
            Self::Rgb => lerp(first, second, share),
            // ParaView does not let hues go through the wrap from 1 to 0.
            Self::Hsv => hsv_to_rgb(lerp(rgb_to_hsv(first), rgb_to_hsv(second), share)),
            Self::Lab => lab_to_rgb(lerp(rgb_to_lab(first), rgb_to_lab(second), share)),
            Self::Diverging => mix_diverging(first, second, share),
            Self::Step => second,
        }
    }
}

fn lerp(first: [f64; 3], second: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|component| first[component] * (1.0 - share) + second[component] * share)
}

fn rgb_to_hsv([red, green, blue]: [f64; 3]) -> [f64; 3] {
    let value = red.max(green).max(blue);
    let chroma = value - red.min(green).min(blue);
    if chroma <= 0.0 {
        return [0.0, 0.0, value];
    }
    let sixths = if value == red {
        ((green - blue) / chroma).rem_euclid(6.0)
    } else if value == green {
        (blue - red) / chroma + 2.0
    } else {
        (red - green) / chroma + 4.0
    };
    [sixths / 6.0, chroma / value, value]
}

fn hsv_to_rgb([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    [5.0, 3.0, 1.0].map(|shift| {
        let sixths = (shift + hue * 6.0).rem_euclid(6.0);
        value - value * saturation * sixths.min(4.0 - sixths).clamp(0.0, 1.0)
    })
}

/// CIELAB of a display colour: lightness 0 to 100, then green to red, then blue to yellow.
pub(super) fn rgb_to_lab(rgb: [f64; 3]) -> [f64; 3] {
    let [red, green, blue] =
        rgb.map(|value| if value > 0.04045 { ((value + 0.055) / 1.055).powf(2.4) } else { value / 12.92 });
    let xyz = [
        red * 0.4124 + green * 0.3576 + blue * 0.1805,
        red * 0.2126 + green * 0.7152 + blue * 0.0722,
        red * 0.0193 + green * 0.1192 + blue * 0.9505,
    ];
    let [x, y, z] = std::array::from_fn(|axis| {
        let share = xyz[axis] / WHITE[axis];
        if share > 0.008856 { share.cbrt() } else { 7.787 * share + 16.0 / 116.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn lab_to_rgb([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (lightness + 16.0) / 116.0;
    let roots = [y + a / 500.0, y, y - b / 200.0];
    let [x, y, z] = std::array::from_fn(|axis| {
        let cube = roots[axis].powi(3);
        WHITE[axis] * if cube > 0.008856 { cube } else { (roots[axis] - 16.0 / 116.0) / 7.787 }
    });
    let linear = [
        x * 3.2406 + y * -1.5372 + z * -0.4986,
        x * -0.9689 + y * 1.8758 + z * 0.0415,
        x * 0.0557 + y * -0.2040 + z * 1.0570,
    ];
    let rgb = linear.map(|value| if value > 0.0031308 { 1.055 * value.powf(1.0 / 2.4) - 0.055 } else { 12.92 * value });
    // Outside the display's gamut VTK dims the colour until it fits; so its hue stays.
    let brightest = rgb.into_iter().fold(1.0, f64::max);
    rgb.map(|value| (value / brightest).max(0.0))
}

/// Moreland's magnitude, saturation and hue (the last two in radians).
fn lab_to_msh([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let magnitude = (lightness * lightness + a * a + b * b).sqrt();
    let saturation = if magnitude > 0.001 { (lightness / magnitude).clamp(-1.0, 1.0).acos() } else { 0.0 };
    [magnitude, saturation, if saturation > 0.001 { b.atan2(a) } else { 0.0 }]
}

fn msh_to_lab([magnitude, saturation, hue]: [f64; 3]) -> [f64; 3] {
    let chroma = magnitude * saturation.sin();
    [magnitude * saturation.cos(), chroma * hue.cos(), chroma * hue.sin()]
}

fn mix_diverging(first: [f64; 3], second: [f64; 3], mut share: f64) -> [f64; 3] {
    let [mut first, mut second] = [first, second].map(|rgb| lab_to_msh(rgb_to_lab(rgb)));
    let apart = (first[2] - second[2]).abs();
    let distinct = apart.min(2.0 * PI - apart) > DISTINCT_HUES;
    if first[1] > UNSATURATED && second[1] > UNSATURATED && distinct {
        let white = [first[0].max(second[0]).max(MIDDLE_LIGHTNESS), 0.0, 0.0];
        if share < 0.5 {
            second = white;
            share *= 2.0;
        } else {
            first = white;
            share = 2.0 * share - 1.0;
        }
    }
    if first[1] < UNSATURATED && second[1] > UNSATURATED {
        first[2] = hue_of_gray(second, first[0]);
    } else if second[1] < UNSATURATED && first[1] > UNSATURATED {
        second[2] = hue_of_gray(first, second[0]);
    }
    lab_to_rgb(msh_to_lab(lerp(first, second, share)))
}

/// The hue to mix towards where a saturated colour ends in a gray: spun so that the change looks even.
fn hue_of_gray([magnitude, saturation, hue]: [f64; 3], gray_magnitude: f64) -> f64 {
    if magnitude >= gray_magnitude - 0.1 {
        return hue;
    }
    let spin =
        saturation * (gray_magnitude * gray_magnitude - magnitude * magnitude).sqrt() / (magnitude * saturation.sin());
    // Away from purple.
    if hue > -0.3 * PI { hue + spin } else { hue - spin }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
        let close = (0..3).all(|component| (found[component] - expected[component]).abs() <= tolerance);
        assert!(close, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn conversions_go_there_and_back() {
        for rgb in [[0.0; 3], [1.0; 3], [0.2, 0.4, 0.9], [0.9, 0.1, 0.3], [0.5, 0.5, 0.5], [1.0, 0.0, 0.2]] {
            near(hsv_to_rgb(rgb_to_hsv(rgb)), rgb, 1e-12);
            near(lab_to_rgb(rgb_to_lab(rgb)), rgb, 2e-3);
            let lab = rgb_to_lab(rgb);
            near(msh_to_lab(lab_to_msh(lab)), lab, 0.1);
        }
    }

    #[test]
    fn lab_of_the_primaries() {
        near(rgb_to_lab([1.0; 3]), [100.0, 0.0, 0.0], 0.02);
        near(rgb_to_lab([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20], 0.05);
        near(rgb_to_lab([0.0, 0.0, 1.0]), [32.30, 79.19, -107.86], 0.05);
    }

    #[test]
    fn hues_of_the_rainbow() {
        let [blue, red] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        near(ColorSpace::Hsv.mix(blue, red, 0.5), [0.0, 1.0, 0.0], 1e-12);
        near(ColorSpace::Hsv.mix(blue, red, 0.25), [0.0, 1.0, 1.0], 1e-12);
    }

    #[test]
    fn diverging_meets_in_white_and_keeps_its_ends() {
        // Moreland's cool to warm, from the table that he publishes with the paper.
        let [cool, warm] = [[59.0, 76.0, 192.0], [180.0, 4.0, 38.0]].map(|rgb| rgb.map(|value| value / 255.0));
        let at = |share| ColorSpace::Diverging.mix(cool, warm, share).map(|value| value * 255.0);
        near(at(0.0), [59.0, 76.0, 192.0], 0.6);
        near(at(0.25), [141.0, 176.0, 254.0], 1.1);
        near(at(0.5), [221.0, 221.0, 221.0], 0.6);
        near(at(0.75), [244.0, 154.0, 123.0], 1.1);
        near(at(1.0), [180.0, 4.0, 38.0], 0.6);
    }

    #[test]
    fn steps_take_the_second_colour() {
        assert_eq!(ColorSpace::Step.mix([0.0; 3], [0.1, 0.2, 0.3], 0.0), [0.1, 0.2, 0.3]);
    }
}
