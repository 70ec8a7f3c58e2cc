//! The definition written down: all levels as whole arrays, and every brick asked for every sample in it.

use std::collections::BTreeSet;

use amray::hierarchy::{Voxel, VoxelType};

/// One level as a whole array, x fastest.
pub(crate) struct Level {
    pub(crate) size: [usize; 3],
    /// Cells per coarser cell.
    pub(crate) ratio: [usize; 3],
    /// Samples per cell.
    pub(crate) samples: [usize; 3],
    pub(crate) values: Vec<f64>,
}

impl Level {
    pub(crate) fn value(&self, [x, y, z]: [usize; 3]) -> f64 {
        self.values[x + self.size[0] * (y + self.size[1] * z)]
    }
}

/// Cells from `low` to `high`, x fastest.
pub(crate) fn cells(low: [usize; 3], high: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (low[2]..high[2]).flat_map(move |z| (low[1]..high[1]).flat_map(move |y| (low[0]..high[0]).map(move |x| [x, y, z])))
}

/// All levels, coarsest first.
pub(crate) fn levels(size: [usize; 3], values: &[f64], count: usize, voxel_type: VoxelType) -> Vec<Level> {
    let mut levels = vec![Level { size, ratio: [1; 3], samples: [1; 3], values: values.to_vec() }];
    while levels.len() < count {
        let finer = levels.last_mut().unwrap();
        finer.ratio = finer.size.map(|cells| cells.min(2));
        let size = [0, 1, 2].map(|axis| finer.size[axis].div_ceil(finer.ratio[axis]));
        let samples = [0, 1, 2].map(|axis| finer.samples[axis] * finer.ratio[axis]);
        let mean = |cell: [usize; 3]| {
            let low = [0, 1, 2].map(|axis| cell[axis] * finer.ratio[axis]);
            let high = [0, 1, 2].map(|axis| (low[axis] + finer.ratio[axis]).min(finer.size[axis]));
            let numbers: Vec<f64> =
                cells(low, high).map(|cell| finer.value(cell)).filter(|value| value.is_finite()).collect();
            let lowest = numbers.iter().copied().fold(f64::INFINITY, f64::min);
            let highest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            match numbers.len() {
                0 => f64::NAN,
                count => (numbers.iter().sum::<f64>() / count as f64).clamp(lowest, highest),
            }
        };
        let round = |value: f64| match voxel_type {
            VoxelType::F32 => f32::from_f64(value).into(),
            VoxelType::F64 => value,
        };
        let values = cells([0; 3], size).map(mean).map(round).collect();
        levels.push(Level { size, ratio: [1; 3], samples, values });
    }
    levels.reverse();
    levels
}

/// Whether a sample and what stands for it differ by more than the threshold, or only one of them is a number.
pub(crate) fn differ(sample: f64, cell: f64, threshold: f64) -> bool {
    match [sample, cell].map(f64::is_finite) {
        [true, true] => (sample - cell).abs() > threshold,
        [a, b] => a != b,
    }
}

/// The places in the grid of the bricks that must be kept of each level that is; of level 0 not all are listed.
pub(crate) fn kept(levels: &[Level], brick: usize, threshold: f64) -> Vec<BTreeSet<[usize; 3]>> {
    let finest = levels.last().unwrap();
    let mut kept = vec![BTreeSet::new(); levels.len()];
    for number in (1..levels.len()).rev() {
        let (level, coarser) = (&levels[number], &levels[number - 1]);
        for sample in cells([0; 3], finest.size) {
            let cell = [0, 1, 2].map(|axis| sample[axis] / coarser.samples[axis]);
            if differ(finest.value(sample), coarser.value(cell), threshold) {
                kept[number].insert([0, 1, 2].map(|axis| sample[axis] / level.samples[axis] / brick));
            }
        }
        let stored = stored(levels, number);
        for place in cells([0; 3], stored.map(|cells| cells.div_ceil(brick))) {
            if (0..3).any(|axis| is_padded(levels, axis) && place[axis] >= (level.size[axis] - 1) / brick) {
                kept[number].insert(place);
            }
        }
        let parents: Vec<_> =
            kept[number].iter().map(|place| [0, 1, 2].map(|axis| place[axis] / level.ratio[axis])).collect();
        if number > 1 {
            kept[number - 1].extend(parents);
        }
    }
    if levels.len() > 1 && kept[levels.len() - 1].is_empty() {
        let first = levels[0].values[0];
        let one_value = levels[0].values.iter().all(|&value| value == first || value.is_nan() && first.is_nan());
        if one_value && kept[1..].iter().all(BTreeSet::is_empty) {
            kept.truncate(1);
        }
        kept.iter_mut().for_each(|places| _ = places.insert([0; 3]));
    }
    kept
}

pub(crate) fn is_padded(levels: &[Level], axis: usize) -> bool {
    !levels.last().unwrap().size[axis].is_multiple_of(levels[0].samples[axis])
}

/// Cells up to which a level may be stored.
pub(crate) fn stored(levels: &[Level], number: usize) -> [usize; 3] {
    let up_to = |number: usize, axis: usize| {
        let (cells, ratio) = (levels[number].size[axis], levels[number].ratio[axis]);
        // One cell more than there is, up to a coarser cell's end.
        if is_padded(levels, axis) { (cells + 1).next_multiple_of(ratio) } else { cells }
    };
    [0, 1, 2].map(|axis| match number {
        0 if levels.len() > 1 => up_to(1, axis) / levels[1].ratio[axis],
        _ => up_to(number, axis),
    })
}
