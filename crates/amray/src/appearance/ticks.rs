//! Round numbers for the ticks of a scale, and their labels.

use super::Scale;

/// One labelled tick.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub(crate) value: f64,
    pub(crate) label: String,
}

impl Tick {
    /// A tick at the only value there is.
    pub(super) fn single(value: f64) -> Vec<Self> {
        vec![Self { value, label: compact(value, SINGLE_DIGITS) }]
    }
}

/// Digits of a label that no other one needs to be told from.
const SINGLE_DIGITS: usize = 6;

/// At most about `most` round values between the ends of a range that the scale can spread: multiples of 1, 2 or 5
/// times a power of ten, on a log scale decades.
pub(crate) fn ticks(scale: Scale, range: [f64; 2], most: usize) -> Vec<Tick> {
    let most = most.max(2);
    let mut values = match scale {
        Scale::Linear => linear(range, most),
        Scale::Log10 => logarithmic(range, most),
    };
    if values.len() < 2 {
        values = range.to_vec();
    }
    // As many digits as tell neighbours apart.
    let digits = (1..=17).find(|&digits| {
        let rounded: Vec<String> = values.iter().map(|&value| compact(value, digits)).collect();
        let exact = rounded.iter().zip(&values).all(|(label, &value)| {
            let error = label.parse::<f64>().map_or(f64::INFINITY, |label| (label - value).abs());
            error <= 1e-6 * (range[1] - range[0]).min(value.abs())
        });
        exact && rounded.windows(2).all(|pair| pair[0] != pair[1])
    });
    let label = |value| compact(value, digits.unwrap_or(17));
    values.into_iter().map(|value| Tick { value, label: label(value) }).collect()
}

/// Multiples of the smallest step of 1, 2 or 5 times a power of ten that makes at most `most`.
fn linear([low, high]: [f64; 2], most: usize) -> Vec<f64> {
    let rough = (high - low) / most as f64;
    let exponent = rough.log10().floor() as i32;
    let steps = (exponent..=exponent + 1).flat_map(|exponent| [1, 2, 5].map(|factor| (factor, exponent)));
    for (factor, exponent) in steps {
        let step = decimal(factor, exponent);
        // Ends that are multiples up to rounding count.
        let first = (low / step - 1e-9).ceil();
        let last = (high / step + 1e-9).floor();
        if first.abs().max(last.abs()) >= 2f64.powi(53) / 10.0 {
            // Neighbouring numbers are further apart than the steps.
            return Vec::new();
        }
        if last - first < most as f64 {
            let multiples = first as i64..=last as i64;
            return multiples.map(|multiple| decimal(multiple * factor, exponent).clamp(low, high)).collect();
        }
    }
    Vec::new()
}

/// Decades, or every second, third, ... one; in a range of few decades 2 and 5 between them as well.
fn logarithmic([low, high]: [f64; 2], most: usize) -> Vec<f64> {
    let inside = |value: &f64| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(value);
    let [first, last] = [low.log10().floor() as i32, high.log10().ceil() as i32];
    let decades: Vec<i32> = (first..=last).filter(|&decade| inside(&decimal(1, decade))).collect();
    let spread = |factors: &[i64]| -> Vec<f64> {
        let values = (first..=last).flat_map(|decade| factors.iter().map(move |&factor| decimal(factor, decade)));
        values.filter(inside).map(|value| value.clamp(low, high)).collect()
    };
    if decades.len() > 2 {
        let stride = decades.len().div_ceil(most) as i32;
        let kept = decades.into_iter().filter(|decade| decade.rem_euclid(stride) == 0);
        return kept.map(|decade| decimal(1, decade).clamp(low, high)).collect();
    }
    let values = spread(&[1, 2, 5]);
    if values.len() > 2 { values } else { linear([low, high], most) }
}

/// `factor` times a power of ten, to the last digit.
fn decimal(factor: i64, exponent: i32) -> f64 {
    format!("{factor}e{exponent}").parse().expect("digits and an exponent")
}

/// A number in at most `digits` significant digits like C's `%g`, with exponents as short as they can be.
fn compact(value: f64, digits: usize) -> String {
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').expect("scientific notation has an exponent");
    let exponent: i32 = exponent.parse().expect("the exponent is an integer");
    if (-4..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        let fixed = format!("{value:.decimals$}");
        without_zeros(&fixed).into()
    } else {
        format!("{}e{exponent}", without_zeros(mantissa))
    }
}

/// A number's text without zeros behind its point.
fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn labels(scale: Scale, range: [f64; 2], most: usize) -> Vec<String> {
        ticks(scale, range, most).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_ticks_are_multiples_of_one_two_or_five() {
        let linear = |low, high, most| labels(Scale::Linear, [low, high], most);
        assert_eq!(linear(0.0, 1.0, 6), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(linear(0.0, 1.0, 5), ["0", "0.5", "1"]);
        assert_eq!(linear(-1.3, 1.3, 8), ["-1", "-0.5", "0", "0.5", "1"]);
        assert_eq!(linear(0.1, 0.3, 5), ["0.1", "0.15", "0.2", "0.25", "0.3"]);
        assert_eq!(linear(3.0, 97.0, 10), ["10", "20", "30", "40", "50", "60", "70", "80", "90"]);
        assert_eq!(linear(0.0, 3e6, 4), ["0", "1e6", "2e6", "3e6"]);
        assert_eq!(linear(0.0, 2.5e-7, 6), ["0", "5e-8", "1e-7", "1.5e-7", "2e-7", "2.5e-7"]);
        assert_eq!(linear(101325.0, 101325.5, 3), ["101325", "101325.2", "101325.4"]);
        assert_eq!(linear(1e300, 3e300, 3), ["1e300", "2e300", "3e300"]);
    }

    #[test]
    fn log_ticks_are_decades() {
        let log = |low, high, most| labels(Scale::Log10, [low, high], most);
        assert_eq!(log(1e-3, 1e2, 8), ["0.001", "0.01", "0.1", "1", "10", "100"]);
        assert_eq!(log(1e-31, 1e-18, 5), ["1e-30", "1e-27", "1e-24", "1e-21", "1e-18"]);
        assert_eq!(log(3.0, 70.0, 8), ["5", "10", "20", "50"]);
        assert_eq!(log(0.9, 150.0, 8), ["1", "10", "100"]);
        assert_eq!(log(2.1, 4.3, 5), ["2.5", "3", "3.5", "4"]);
    }

    #[test]
    fn ranges_narrower_than_any_step_show_their_ends() {
        let next = 1.0f64.next_up();
        assert_eq!(labels(Scale::Linear, [1.0, next], 5), ["1", "1.0000000000000002"]);
    }

    proptest! {
        #[test]
        fn any_range_has_ticks_inside(low in -1e12f64..1e12, exponent in -12i32..300, log in any::<bool>(), most in 2usize..12) {
            let (scale, low) = if log { (Scale::Log10, low.abs().max(1e-300)) } else { (Scale::Linear, low) };
            let range = [low, low + 10f64.powi(exponent)];
            prop_assume!(scale.check(range).is_ok());
            let ticks = ticks(scale, range, most);
            prop_assert!(ticks.len() >= 2 && ticks.len() <= most.max(7), "{ticks:?}");
            prop_assert!(ticks.windows(2).all(|pair| pair[0].value < pair[1].value));
            prop_assert!(ticks.iter().all(|tick| range[0] <= tick.value && tick.value <= range[1]));
        }
    }
}
