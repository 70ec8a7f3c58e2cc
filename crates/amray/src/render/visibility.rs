//! What a transfer function makes of each region: invisible, or worth how many samples.

use rayon::prelude::*;

use crate::Volume;
use crate::appearance::{PreparedTransferFunction, Segments, Window};
use crate::index::{Index, Node};
use crate::padded::Padded;

/// How a region is sampled under one transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RegionLook {
    /// Whether any value in it is seen.
    pub(super) visible: bool,
    /// The segments of the transfer function that its values can lie in.
    pub(super) window: Window,
    /// The length of a step over that on level 0: a power of two.
    pub(super) step: f64,
}

/// What is seen of a volume under one transfer function. Made anew when that changes: the index stays.
#[derive(Clone, Debug)]
pub(super) struct Visibility {
    pub(super) regions: Vec<RegionLook>,
    /// Per node of the tree, whether anything below it is seen.
    pub(super) nodes: Vec<bool>,
}

/// How far a region's light may be off because its samples are far apart.
const TOLERANCE: f64 = 2e-4;
/// The longest and the shortest step, in cells.
const STEPS: [f64; 2] = [8.0, 1.0];

impl Visibility {
    pub(super) fn new(
        volume: &Volume,
        padded: &Padded,
        function: &PreparedTransferFunction,
        segments: &Segments,
    ) -> Self {
        let index = volume.index();
        let steps = steps(index);
        let ranges = volume.ranges();
        let normalization = padded.field.normalization;
        let boxes = index.region_boxes();
        let finest = index.hierarchy().levels()[index.hierarchy().finest_level()].cell_size();
        let regions: Vec<RegionLook> = index
            .regions()
            .par_iter()
            .enumerate()
            .with_min_len(512)
            .map(|(number, region)| {
                let [low, high] = ranges.region(number).map(f64::from);
                let Some(level) = region.finest_level() else { return RegionLook::default() };
                let window = segments.window([low, high].map(|value| normalization.to_unit(value) as f32));
                // Over a step of n cells, values differ from a line by up to n^2 / 8 of how far they bend in one.
                let sides = boxes[number].size();
                let depth = (0..3).map(|axis| sides[axis] as f64 * finest[axis]).fold(0.0, f64::max);
                let error = f64::from(padded.roughness[number]) / 8.0 * segments.steepness(window) * depth;
                let cells = (TOLERANCE / error).sqrt().min(STEPS[0]).max(STEPS[1]).log2().floor().exp2();
                RegionLook {
                    visible: low <= high && function.max_extinction(low, high) > 0.0,
                    window,
                    step: steps[level] * cells,
                }
            })
            .collect();
        let mut nodes = vec![false; index.nodes().len()];
        // Children follow their parents.
        for (place, node) in index.nodes().iter().enumerate().rev() {
            nodes[place] = match *node {
                Node::Leaf(region) => regions[region as usize].visible,
                Node::Inner { high, .. } => nodes[place + 1] || nodes[high as usize],
            };
        }
        Self { regions, nodes }
    }
}

/// Per level, the step over that on level 0: halved until it fits the cell on its narrowest axis.
fn steps(index: &Index) -> Vec<f64> {
    let levels = index.hierarchy().levels();
    let coarsest = levels[0].finest_cells();
    let refinement = |cells: [i64; 3]| (0..3).map(|axis| coarsest[axis] / cells[axis]).max().unwrap_or(1);
    levels.iter().map(|level| (refinement(level.finest_cells()) as f64).log2().ceil().exp2().recip()).collect()
}
