//! Segments against the transfer functions that they stand for, their means against fine sums, light against exponentials.

use proptest::prelude::*;

use super::*;
use crate::appearance::{
    ColorMap, ColorPoint, Opacity, OpacityPoint, PreparedTransferFunction, Scale, TransferFunction,
};
use crate::simd::{InstructionSet, Kernel, LANES};

/// Extinction, and extinction times red, green and blue, of sixteen lanes.
type Looks = [[f32; LANES]; 4];

/// The means over intervals.
struct Means<'a> {
    segments: &'a Segments,
    window: Window,
    from: [f32; LANES],
    to: [f32; LANES],
}

impl Kernel for Means<'_> {
    type Output = Looks;

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> Looks {
        let Self { segments, window, from, to } = self;
        let from = segments.place(simd, Floats::from_slice(simd, &from), window);
        let to = segments.place(simd, Floats::from_slice(simd, &to), window);
        let slopes = segments.slopes(simd, to.segment);
        let Glow { extinction, emission: [red, green, blue] } =
            segments.mean(simd, [&from, &to], &slopes, Mask::splat(simd, true));
        [extinction.into(), red.into(), green.into(), blue.into()]
    }
}

/// The looks of values, in units of the field's range.
fn looks(set: InstructionSet, segments: &Segments, values: [f32; LANES]) -> Looks {
    set.run(Means { segments, window: Window::all(segments), from: values, to: values })
}

/// Where values lie.
struct Places<'a>(&'a Segments, Window, [f32; LANES]);

impl Kernel for Places<'_> {
    type Output = ([f32; LANES], [i32; LANES]);

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> Self::Output {
        let Self(segments, window, values) = self;
        let Place { position, segment } = segments.place(simd, Floats::from_slice(simd, &values), window);
        (position.into(), segment.into())
    }
}

/// A random function, the field's range, and the values at which the function may step.
#[derive(Debug)]
struct Case {
    function: PreparedTransferFunction,
    low: f64,
    width: f64,
    steps: Vec<f64>,
}

impl Case {
    fn segments(&self) -> Segments {
        Segments::new(&self.function, self.low, self.width)
    }

    fn value(&self, unit: f32) -> f64 {
        self.low + f64::from(unit) * self.width
    }

    /// Whether a value is told apart from those at which the function may step.
    fn is_apart(&self, value: f64) -> bool {
        self.steps.iter().all(|step| (value - step).abs() > 2e-6 * self.width.max(value.abs()))
    }
}

/// Functions of up to `most` points, on a lattice so that steps and single points occur.
fn any_case(most: usize) -> impl Strategy<Value = Case> {
    let opacities = prop::collection::vec((1u32..400, 0u8..=20), 1..most);
    let colors = prop::collection::vec((1u32..400, prop::array::uniform3(0u8..=10)), 1..most);
    (opacities, colors, any::<bool>(), any::<bool>(), any::<bool>()).prop_map(
        |(mut opacities, mut colors, log, extinction, mapped)| {
            opacities.sort_by_key(|point| point.0);
            colors.sort_by_key(|point| point.0);
            // From 1 to 5, or over four decades.
            let value = |place: u32| {
                let place = f64::from(place) / 100.0;
                if log { 10f64.powf(place) } else { 1.0 + place }
            };
            let steps = opacities.iter().map(|point| point.0).chain(colors.iter().map(|point| point.0));
            let steps = steps.map(value).collect();
            let points = opacities
                .iter()
                .map(|&(place, opacity)| OpacityPoint { value: value(place), opacity: f64::from(opacity) / 20.0 });
            let opacity = if extinction {
                Opacity::Extinction(points.collect())
            } else {
                Opacity::PerUnitDistance(points.collect())
            };
            let scale = if log { Scale::Log10 } else { Scale::Linear };
            let range = [value(20), value(380)];
            let function = if mapped {
                TransferFunction::from_color_map(ColorMap::Viridis, range, scale, opacity)
            } else {
                let point = |&(place, color): &(u32, [u8; 3])| ColorPoint {
                    value: value(place),
                    color: color.map(|channel| f32::from(channel) / 10.0),
                };
                TransferFunction::new(scale, colors.iter().map(point).collect(), opacity)
            };
            let [low, high] = [value(0), value(400)];
            Case { function: function.unwrap().prepared(0.1), low, width: high - low, steps }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn segments_look_like_their_function(case in any_case(12), units in prop::array::uniform16(0f32..=1.0)) {
        let segments = case.segments();
        let largest = case.function.max_extinction(case.low, case.low + case.width).min(1e7);
        for set in InstructionSet::available() {
            let [extinction, red, green, blue] = looks(set, &segments, units);
            for lane in 0..LANES {
                let value = case.value(units[lane]);
                let expected = case.function.sample(value);
                if !case.is_apart(value) {
                    continue;
                }
                let found = f64::from(extinction[lane]);
                let exact = expected.extinction.min(1e7);
                // What is nearly opaque within a unit distance may be less exact; single precision knows no small
                // differences of large numbers.
                let tolerance = 2e-3 * exact * (1.0 + exact * 0.1) + 1e-6 * largest;
                prop_assert!((found - exact).abs() <= tolerance, "extinction {found}, not {exact} at {value}");
                for (emission, color) in [red, green, blue].into_iter().zip(expected.color) {
                    if exact > 1e-2 * largest {
                        let found = f64::from(emission[lane]) / found;
                        let error = (found - f64::from(color)).abs();
                        prop_assert!(error <= 1.0 / 1024.0 + 1e-4, "colour {found}, not {color} at {value}");
                    }
                }
            }
        }
    }

    #[test]
    fn means_are_sums_of_what_lies_between(
        case in any_case(10),
        from in prop::array::uniform16(0f32..=1.0),
        widths in prop::array::uniform16(0f32..=1.0),
    ) {
        let segments = case.segments();
        let set = InstructionSet::best();
        // Some of the intervals are narrow.
        let to: [f32; LANES] = std::array::from_fn(|lane| {
            let scale = [1.0, 0.1, 0.01, 0.001][lane % 4];
            let to = from[lane] + (2.0 * widths[lane] - 1.0) * scale;
            to.clamp(0.0, 1.0)
        });
        let found = set.run(Means { segments: &segments, window: Window::all(&segments), from, to });
        let (from_at, _) = set.run(Places(&segments, Window::all(&segments), from));
        let (to_at, _) = set.run(Places(&segments, Window::all(&segments), to));
        // How well segments stand for the function is another question.
        let starts = segments.starts();
        let number = |kind: usize, segment: usize| f64::from(segments.tables.table(kind)[segment]);
        let at = |component: usize, segment: usize, position: f64| -> f64 {
            let kinds = if component == 0 { &SLOPES[1..3] } else { &SLOPES[3 * component..3 * component + 3] };
            let distance = position - number(START, segment);
            kinds.iter().rev().fold(0.0, |sum, &kind| sum * distance + number(kind, segment))
        };
        // Over all segments' parts, by Simpson's rule, which is exact for them.
        let integral = |component: usize, from: f64, to: f64| -> f64 {
            let parts = (0..segments.count).map(|segment| {
                let end = starts.get(segment + 1).map_or(1.0, |&start| f64::from(start));
                let (from, to) = (from.max(starts[segment].into()), to.min(end));
                let at = |share: f64| at(component, segment, from + share * (to - from));
                if from < to { (to - from) / 6.0 * (at(0.0) + 4.0 * at(0.5) + at(1.0)) } else { 0.0 }
            });
            parts.sum()
        };
        for lane in 0..LANES {
            let (from, to) = (f64::from(from_at[lane]), f64::from(to_at[lane]));
            let (low, high) = (from.min(to), from.max(to));
            for component in 0..4 {
                let segment = |position: f64| starts[1..].partition_point(|&start| f64::from(start) <= position);
                let ends = [at(component, segment(from), from), at(component, segment(to), to)];
                let mean = integral(component, low, high) / (high - low);
                // Of narrow intervals that cross from one segment to another, both ends are enough.
                let expected = if high - low <= 1e-5 { (ends[0] + ends[1]) / 2.0 } else { mean };
                // Integrals up to both ends are subtracted in single precision.
                let rounding = 4.0 * f64::from(f32::EPSILON) * integral(component, 0.0, high) / (high - low).max(1e-5);
                let steps = segment(low)..=segment(high);
                let largest = steps.map(|segment| at(component, segment, starts[segment].into())).fold(0.0, f64::max);
                let tolerance = 1e-5 * largest.max(ends[0]).max(ends[1]) + rounding;
                let found = f64::from(found[component][lane]);
                prop_assert!(
                    (found - expected).abs() <= tolerance,
                    "{component} over {from} to {to}: {found}, not {expected} to within {tolerance}"
                );
            }
        }
    }

    #[test]
    fn positions_are_found_in_tables_of_any_length(
        case in any_case(150),
        units in prop::array::uniform16(-0.5f32..=1.5),
        ends in prop::array::uniform2(0f32..=1.0),
    ) {
        let segments = case.segments();
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        for set in InstructionSet::available() {
            for (window, range) in [(Window::all(&segments), [-0.5, 1.5]), (segments.window(ends), ends)] {
                let values = units.map(|unit| unit.clamp(range[0], range[1]));
                let (positions, found) = set.run(Places(&segments, window, values));
                for lane in 0..LANES {
                    let expected = segments.starts()[1..].partition_point(|&start| start <= positions[lane]);
                    // On a log scale, values at the window's ends are rounded in more than one way.
                    let near = segments.starts().iter().any(|start| (start - positions[lane]).abs() < 1e-5);
                    let same = found[lane] == expected as i32;
                    prop_assert!(same || near, "{} of {}: {} not {expected}", positions[lane], segments.count, found[lane]);
                }
            }
        }
    }
}

#[test]
fn tables_of_all_lengths_occur() {
    let zigzag = |count: usize| {
        let point = |place: usize| OpacityPoint { value: place as f64, opacity: (place % 2) as f64 };
        let opacity = Opacity::Extinction((0..=count).map(point).collect());
        let colors = vec![ColorPoint { value: 0.0, color: [1.0; 3] }];
        let function = TransferFunction::new(Scale::Linear, colors, opacity).unwrap().prepared(1.0);
        Segments::new(&function, 0.0, count as f64)
    };
    for count in [1, 2, 7, 15, 16, 17, 31, 32, 33, 64, 100, 300] {
        let segments = zigzag(count);
        assert_eq!(segments.count, count);
        for set in InstructionSet::available() {
            for first in (0..count).step_by(5) {
                let values = std::array::from_fn(|lane| ((first + lane).min(count - 1) as f32 + 0.25) / count as f32);
                let [extinction, ..] = looks(set, &segments, values);
                for lane in 0..LANES {
                    let odd = (first + lane).min(count - 1) % 2 == 1;
                    let expected = if odd { 0.75 } else { 0.25 };
                    let error = (extinction[lane] - expected).abs();
                    assert!(error < 1e-4 * count as f32, "{count} segments, {first} + {lane}: {}", extinction[lane]);
                }
            }
        }
    }
}

/// Radiance that is added over one interval: what of it is seen, and what gets through.
struct Added {
    extinction: [f32; LANES],
    length: [f32; LANES],
    before: f32,
}

impl Kernel for Added {
    type Output = [[f32; LANES]; 2];

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> Self::Output {
        let extinction = Floats::from_slice(simd, &self.extinction);
        let mut light = Radiance::none(simd);
        light.transmittance = Floats::splat(simd, self.before);
        let glow = Glow { extinction, emission: [extinction * Floats::splat(simd, 0.5); 3] };
        light.add(simd, &glow, Floats::from_slice(simd, &self.length), Mask::splat(simd, true));
        [light.color[1].into(), light.transmittance.into()]
    }
}

#[test]
fn light_falls_off_exponentially() {
    let depths: Vec<f64> = (-120..=40).map(|power| 10f64.powf(f64::from(power) / 8.0)).chain([0.0, 0.5, 1e5]).collect();
    for set in InstructionSet::available() {
        for scale in [1.0, 1e-10, 1e10, 1e20] {
            for depths in depths.chunks(LANES) {
                // One lane may be thin where another is thick.
                let extinction = std::array::from_fn(|lane| (depths[lane % depths.len()] * scale) as f32);
                let length = [scale.recip() as f32; LANES];
                for before in [1.0f32, 0.125] {
                    let [color, transmittance] = set.run(Added { extinction, length, before });
                    for lane in 0..LANES {
                        let depth = f64::from(extinction[lane]) * f64::from(length[lane]);
                        let alpha = -(-depth).exp_m1() * f64::from(before);
                        let left = f64::from(before) - alpha;
                        let name = set.name();
                        let [color, through] = [color[lane], transmittance[lane]].map(f64::from);
                        assert!((through - left).abs() <= 1e-6, "{name}, depth {depth}: {through}, not {left}");
                        assert!(
                            (color - 0.5 * alpha).abs() <= 1e-6,
                            "{name}, depth {depth}: {color}, not half {alpha}"
                        );
                    }
                }
            }
        }
    }
}
