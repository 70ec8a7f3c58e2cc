//! The first picture, with no settings given: a scale, a range, a colour map and opacities that show the structure.
//!
//! Most of a simulation's volume is background; what is looked for (fronts, filaments, cores) fills little of it. So
//! every band of values adds about the same optical depth to a ray through it: the more volume a band fills, the
//! more transparent it is, and what fills a good part of the domain vanishes.

use super::{ColorMap, Histogram, Opacity, OpacityPoint, Scale, TransferFunction};

/// Bins of a histogram that are fine enough for all that is derived from it here.
pub const HISTOGRAM_BINS: usize = 4096;

/// Positive values that span a factor of more than this get a log scale.
const LOG_RATIO: f64 = 1e3;
/// The share of the volume that the range leaves out at either end.
const CLIPPED: f64 = 1e-5;
/// Ranges that reach at least this much of one side's distance from 0 on the other side are signed.
const SIGNED_BALANCE: f64 = 0.25;
/// Signed values nearer to 0 than this share of the largest fade out.
const ZERO_BAND: f64 = 0.15;
/// Opacity points, evenly spaced in position.
const POINTS: usize = 33;
/// Unit distances (see [`TransferFunction::prepared`]) along the domain's longest side: what the opacities found here
/// refer to.
pub const UNIT_DISTANCES: f64 = 100.0;
/// A ray that meets values of a share s of the volume does so on about s^WAY of its way: 1 is right for sheets across
/// the domain, 1/3 for balls.
const WAY: f64 = 0.5;
/// The optical depth that the values around one point add to a ray that meets them.
const DEPTH: f64 = 0.2;
/// The largest optical depth of a unit distance, for values of nearly no volume.
const LARGEST_DEPTH: f64 = 0.4;
/// Points that stand for more than this share of the volume are background: invisible.
const BACKGROUND: f64 = 0.2;

/// The scale that suits finite values from `low` to `high`.
pub fn scale(low: f64, high: f64) -> Scale {
    if low > 0.0 && high / low > LOG_RATIO { Scale::Log10 } else { Scale::Linear }
}

/// The range of values that have structure: outliers are left out; of signed values as much on both sides of 0.
/// Where all values share a bin, that is the whole range of the histogram.
pub fn range(histogram: &Histogram) -> [f64; 2] {
    let whole = histogram.range();
    let [low, high] = [CLIPPED, 1.0 - CLIPPED].map(|share| histogram.quantile(share));
    let (Some(low), Some(high)) = (low, high) else { return whole };
    let [first, last] = [low, high].map(|value| histogram.scale().fraction(whole, value));
    if (last - first) * histogram.weights().len() as f64 <= 1.0 {
        whole
    } else if is_signed([low, high]) {
        let largest = high.max(-low);
        [-largest, largest]
    } else {
        [low, high]
    }
}

/// A diverging map for values on both sides of 0, else a sequential one.
pub fn color_map(range: [f64; 2]) -> ColorMap {
    if is_signed(range) { ColorMap::CoolToWarm } else { ColorMap::Viridis }
}

/// Opacities (of a unit distance, a hundredth of the domain's longest side) over `range`: low for the values of large
/// volumes, high for those of small ones; of signed values those near 0 fade out.
pub fn opacity(histogram: &Histogram, range: [f64; 2]) -> Opacity {
    let scale = histogram.scale();
    let signed = is_signed(range);
    let point = |(index, share)| {
        let place = index as f64 / (POINTS - 1) as f64;
        let value = scale.at_fraction(range, place);
        let visible = if signed { fade((value / range[1].max(-range[0])).abs() / ZERO_BAND) } else { 1.0 };
        OpacityPoint { value, opacity: visible * -(-optical_depth(share)).exp_m1() }
    };
    Opacity::PerUnitDistance(volume_shares(histogram, range).into_iter().enumerate().map(point).collect())
}

/// The transfer function of the first picture, with the colour map and over the range that are given.
///
/// # Panics
/// Where the range does not ascend or does not suit the histogram's scale.
pub fn transfer_function(
    histogram: &Histogram,
    map: Option<ColorMap>,
    given_range: Option<[f64; 2]>,
) -> TransferFunction {
    let range = given_range.unwrap_or_else(|| range(histogram));
    let map = map.unwrap_or_else(|| color_map(range));
    TransferFunction::from_color_map(map, range, histogram.scale(), opacity(histogram, range))
        .expect("the range ascends and suits the scale")
}

fn is_signed([low, high]: [f64; 2]) -> bool {
    low < 0.0 && high > 0.0 && high.min(-low) >= SIGNED_BALANCE * high.max(-low)
}

/// The share of the volume around each of the opacity points, smoothed.
fn volume_shares(histogram: &Histogram, range: [f64; 2]) -> [f64; POINTS] {
    let mut shares = [0.0; POINTS];
    let total = histogram.total_weight();
    for (bin, weight) in histogram.weights().iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
        let place = histogram.scale().fraction(range, histogram.center(bin)).clamp(0.0, 1.0) * (POINTS - 1) as f64;
        let index = (place as usize).min(POINTS - 2);
        let upper = place - index as f64;
        shares[index] += weight / total * (1.0 - upper);
        shares[index + 1] += weight / total * upper;
    }
    std::array::from_fn(|index| {
        let [below, above] = [index.saturating_sub(1), (index + 1).min(POINTS - 1)];
        0.25 * (shares[below] + 2.0 * shares[index] + shares[above])
    })
}

/// The optical depth of a unit distance of values that fill `share` of the volume.
fn optical_depth(share: f64) -> f64 {
    let way = UNIT_DISTANCES * share.powf(WAY);
    DEPTH / (way + DEPTH / LARGEST_DEPTH) * fade((BACKGROUND - share) / BACKGROUND)
}

/// 0 up to 0, smoothly rising to 1 at 1.
fn fade(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A histogram of values with their volumes.
    fn histogram(range: [f64; 2], scale: Scale, values: impl IntoIterator<Item = (f64, f64)>) -> Histogram {
        let mut histogram = Histogram::new(range[0], range[1], scale, HISTOGRAM_BINS).unwrap();
        values.into_iter().for_each(|(value, volume)| histogram.add(value, volume));
        histogram
    }

    /// Nine tenths of the volume at 1, a front (values 2 to 3) and a core (3 to 4, a ten-thousandth of the volume).
    fn blast() -> Histogram {
        let band = |low: f64, volume: f64| (0..1000).map(move |i| (low + f64::from(i) / 1000.0, volume / 1000.0));
        histogram([0.0, 4.0], Scale::Linear, [(1.0, 0.9)].into_iter().chain(band(2.0, 0.0999)).chain(band(3.0, 1e-4)))
    }

    fn alpha(function: &TransferFunction, value: f64) -> f32 {
        function.prepared(1.0).sample(value).alpha(1.0)
    }

    #[test]
    fn the_background_vanishes_and_the_rare_shows() {
        let function = transfer_function(&blast(), None, None);
        assert_eq!(alpha(&function, 1.0), 0.0);
        let [front, core] = [2.5, 3.5].map(|value| alpha(&function, value));
        assert!((0.015..0.06).contains(&front), "front {front}");
        assert!((0.2..0.33).contains(&core), "core {core}");
        assert!(function.opacity().points().len() <= 33);
    }

    #[test]
    fn an_average_ray_keeps_a_moderate_depth() {
        // Even the values of a plain ramp, which have no background, do not make a wall.
        let even = (0..10_000).map(|i| (f64::from(i), 1.0));
        for histogram in [blast(), histogram([0.0, 1e4], Scale::Linear, even)] {
            let function = transfer_function(&histogram, None, None).prepared(1.0);
            let mean = |sum: f64, bin: usize| {
                let extinction = function.sample(histogram.center(bin)).extinction;
                sum + histogram.weights()[bin] / histogram.total_weight() * extinction
            };
            let depth = UNIT_DISTANCES * (0..HISTOGRAM_BINS).fold(0.0, mean);
            assert!((0.2..2.0).contains(&depth), "{depth}");
        }
    }

    #[test]
    fn outliers_do_not_stretch_the_range() {
        let values = (0..10_000).map(|i| (f64::from(i) / 1e4, 1.0)).chain([(1000.0, 1e-9)]);
        let histogram = histogram([0.0, 1000.0], Scale::Linear, values);
        assert!(range(&histogram)[1] < 2.0, "{:?}", range(&histogram));
        let [low, high] = range(&blast());
        assert!((1.0..1.001).contains(&low) && (3.85..4.0).contains(&high), "{low} {high}");
    }

    #[test]
    fn signed_values_diverge_around_zero() {
        let waves = (0..10_000).map(|i| (1e-3 * f64::from(i).sin(), 1.0)).chain([(0.0, 9e4)]);
        let function = transfer_function(&histogram([-1e-3, 8e-4], Scale::Linear, waves), None, None);
        let [low, high] = function.range();
        assert!(low == -high && high > 7e-4, "{low} {high}");
        assert_eq!(function.colors()[0].color, ColorMap::CoolToWarm.color(0.0));
        assert_eq!(alpha(&function, 0.0), 0.0);
        assert!(alpha(&function, 5e-4) > 0.02 && alpha(&function, -5e-4) > 0.02);
        assert_eq!(
            [[-1.0, 9.0], [0.0, 2.0], [-3.0, 1.0]].map(color_map),
            [ColorMap::Viridis, ColorMap::Viridis, ColorMap::CoolToWarm]
        );
    }

    #[test]
    fn positive_values_over_many_decades_are_logarithmic() {
        let scales = [[1e-5, 1.0], [0.5, 5.0], [0.0, 1e9], [-1.0, 1e9]].map(|[low, high]| scale(low, high));
        assert_eq!(scales, [Scale::Log10, Scale::Linear, Scale::Linear, Scale::Linear]);
        let decades = (0..700).map(|i| (10f64.powf(f64::from(i) / 100.0 - 5.0), 1.0));
        let function = transfer_function(&histogram([1e-5, 1e2], Scale::Log10, decades), None, None);
        assert_eq!(function.scale(), Scale::Log10);
        let [low, high] = function.range();
        assert!((1e-5..2e-5).contains(&low) && (5e1..=1e2).contains(&high), "{low} {high}");
    }

    #[test]
    fn nothing_and_constants_are_no_trouble() {
        let empty = histogram([0.0, 1.0], Scale::Linear, []);
        assert_eq!(transfer_function(&empty, None, None).range(), [0.0, 1.0]);
        let constant = histogram([5.0, 5.0], Scale::Linear, [(5.0, 1.0)]);
        let function = transfer_function(&constant, None, None);
        assert!(function.range()[0] <= 5.0 && function.range()[1] >= 5.0);
        assert_eq!(alpha(&function, 5.0), 0.0);
    }
}
