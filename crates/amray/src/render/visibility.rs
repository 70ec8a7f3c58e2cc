//! What a transfer function makes of each region: invisible, or worth how many samples.

use rayon::prelude::*;

use crate::Volume;
use crate::appearance::{PreparedTransferFunction, Segments, Window};
use crate::index::{Index, Node};

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

impl Visibility {
    pub(super) fn new(
        volume: &Volume,
        function: &PreparedTransferFunction,
        segments: &Segments,
        unit: impl Fn(f64) -> f64 + Sync,
    ) -> Self {
        let index = volume.index();
        let steps = steps(index);
        let ranges = volume.ranges();
        let regions: Vec<RegionLook> = index
            .regions()
            .par_iter()
            .enumerate()
            .with_min_len(512)
            .map(|(number, region)| {
                let [low, high] = ranges.region(number).map(f64::from);
                let Some(level) = region.finest_level() else { return RegionLook::default() };
                RegionLook {
                    visible: low <= high && function.max_extinction(low, high) > 0.0,
                    window: segments.window([low, high].map(|value| unit(value) as f32)),
                    step: steps[level],
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
