//! How a volume's values become numbers that single precision holds well while rays march.

use rayon::prelude::*;

use crate::Volume;
use crate::hierarchy::{BrickValues, Normalisation, Voxel, with_voxels};

/// The normalisation that makes a volume's lowest value 0 and its highest 1.
pub(crate) fn normalisation(volume: &Volume) -> Normalisation {
    // Known ranges are rounded outward to single precision, which does not matter if it is little of their width.
    const PRECISE: f64 = 1e4;
    let [low, high] = volume.ranges().whole().map(f64::from);
    let rounding = low.abs().max(high.abs()) * f64::from(f32::EPSILON);
    if low.is_finite() && high.is_finite() && high - low >= PRECISE * rounding {
        return Normalisation::of_range([low, high]);
    }
    let range =
        with_voxels!(volume.field().values(), bricks => bricks.par_iter().map(range_of).reduce(|| NOTHING, join));
    Normalisation::of_range(range)
}

/// The range of no values.
const NOTHING: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

fn join(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// The lowest and highest finite value of a brick.
fn range_of<T: Voxel>(brick: &BrickValues<T>) -> [f64; 2] {
    let mut range = NOTHING;
    brick.for_each([0; 3], brick.size(), |value| {
        let value = value.to_f64();
        if value.is_finite() {
            range = join(range, [value; 2]);
        }
    });
    range
}
