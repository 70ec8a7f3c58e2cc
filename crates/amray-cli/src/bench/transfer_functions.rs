//! Three transfer functions that are alike for all data: an opaque, a translucent and a sparse one.

use amray::appearance::{Histogram, Opacity, OpacityPoint, TransferFunction, automatic};

/// Values of more than this share of the volume in one bin are background, which does not count.
const BACKGROUND: f64 = 0.05;
/// Of what is not background, the share below the opaque surface, and below where it is fully opaque.
const SURFACE: [f64; 2] = [0.70, 0.72];
/// The share where what is translucent begins.
const TRANSLUCENT: f64 = 0.50;
/// The shares where the sparse shell begins, is densest and ends.
const SHELL: [f64; 3] = [0.95, 0.96, 0.97];
/// The optical depth of the domain's diagonal through opaque values, and through the middle of the shell.
const OPAQUE_DEPTH: f64 = 1000.0;
const SHELL_DEPTH: f64 = 100.0;
/// The same of the translucent function, on average over the volume, and of its highest values at most.
const TRANSLUCENT_DEPTH: f64 = 3.0;
const DENSEST_DEPTH: f64 = 100.0;

/// The functions with their names, from the volume-weighted histogram of the leaf cells and the domain's diagonal.
pub(super) fn of_data(histogram: &Histogram, diagonal: f64) -> [(&'static str, TransferFunction); 3] {
    let shown = without_background(histogram);
    let value = |share: f64| shown.quantile(share).expect("finite values were counted");
    let range = automatic::range(histogram);
    let function = |points: &[(f64, f64)]| {
        let mut points: Vec<OpacityPoint> =
            points.iter().map(|&(value, depth)| OpacityPoint { value, opacity: depth / diagonal }).collect();
        points.sort_by(|a, b| a.value.total_cmp(&b.value));
        let map = automatic::color_map(range);
        TransferFunction::from_color_map(map, range, histogram.scale(), Opacity::Extinction(points))
            .expect("points ascend on the histogram's scale")
    };
    let [below, above] = SURFACE.map(value);
    let opaque = function(&[(below, 0.0), (above, OPAQUE_DEPTH)]);
    let [start, middle, end] = SHELL.map(value);
    let sparse = function(&[(start, 0.0), (middle, SHELL_DEPTH), (end, 0.0)]);
    let ramp = function(&[(value(TRANSLUCENT), 0.0), (value(1.0), 1.0)]);
    let mean = mean_extinction(histogram, &ramp) * diagonal;
    let translucent = ramp.scaled_opacity((TRANSLUCENT_DEPTH / mean).min(DENSEST_DEPTH));
    [("opaque", opaque), ("translucent", translucent), ("sparse", sparse)]
}

/// The histogram without the bins of background, unless that is all there is.
fn without_background(histogram: &Histogram) -> Histogram {
    let total = histogram.total_weight();
    let [low, high] = histogram.range();
    let mut shown = Histogram::new(low, high, histogram.scale(), histogram.weights().len())
        .expect("the range is that of a histogram");
    for (bin, &weight) in histogram.weights().iter().enumerate() {
        if weight <= BACKGROUND * total {
            shown.add(histogram.center(bin), weight);
        }
    }
    if shown.total_weight() > 0.0 { shown } else { histogram.clone() }
}

/// Over the volume.
fn mean_extinction(histogram: &Histogram, function: &TransferFunction) -> f64 {
    let prepared = function.prepared(1.0);
    let weighed = |(bin, weight): (usize, &f64)| weight * prepared.sample(histogram.center(bin)).extinction;
    histogram.weights().iter().enumerate().map(weighed).sum::<f64>() / histogram.total_weight()
}

#[cfg(test)]
mod tests {
    use super::*;
    use amray::appearance::Scale;

    /// Half of the volume at 0, the rest even from 0 to 1.
    fn histogram(scale: Scale, low: f64) -> Histogram {
        let mut histogram = Histogram::new(low, 1.0, scale, automatic::HISTOGRAM_BINS).unwrap();
        histogram.add(low, 1e5);
        (0..100_000).for_each(|i| histogram.add(low + (1.0 - low) * (f64::from(i) + 0.5) / 1e5, 1.0));
        histogram
    }

    #[test]
    fn shares_of_the_volume_are_seen() {
        let histogram = histogram(Scale::Linear, 0.0);
        for ((name, function), seen) in of_data(&histogram, 2.0).into_iter().zip([0.15, 0.25, 0.01]) {
            let prepared = function.prepared(1.0);
            let visible = |bin: &usize| prepared.sample(histogram.center(*bin)).extinction > 0.0;
            let weight: f64 = (0..automatic::HISTOGRAM_BINS).filter(visible).map(|bin| histogram.weights()[bin]).sum();
            let share = weight / histogram.total_weight();
            assert!((share - seen).abs() < 0.002, "{name}: {share}");
        }
    }

    #[test]
    fn the_translucent_function_has_its_depth() {
        for histogram in [histogram(Scale::Linear, 0.0), histogram(Scale::Log10, 1e-5)] {
            let [_, (name, translucent), _] = of_data(&histogram, 2.0);
            let depth = mean_extinction(&histogram, &translucent) * 2.0;
            assert!((depth - TRANSLUCENT_DEPTH).abs() < 0.01, "{name}: {depth}");
        }
    }

    #[test]
    fn a_constant_field_has_functions_too() {
        let mut constant = Histogram::new(3.0, 3.0, Scale::Linear, automatic::HISTOGRAM_BINS).unwrap();
        constant.add(3.0, 1.0);
        of_data(&constant, 1.0);
    }
}
