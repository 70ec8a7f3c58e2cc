//! Pieces of regions, a few cells wide: what values they hold and how far these bend, in one tree with the regions.
//!
//! A transfer function decides per piece whether anything is seen and how long steps can be; pieces that are alike are
//! marched through as one.

mod block;
mod sources;

use rayon::prelude::*;

use super::RegionFrame;
use crate::hierarchy::IndexBox;
use crate::index::{Index, Node};
use crate::simd::{Gather, InstructionSet, Kernel};

pub(super) use sources::{BrickPieces, PaddedPieces};

/// The longest side of a piece, in cells of its level.
const LONGEST: i64 = 8;

/// A node of the tree of pieces; its low child follows it directly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PieceNode {
    /// The region that the node lies in; `None` where it holds several.
    pub(crate) region: Option<u32>,
    /// Where the node is cut: the axis, the low face of the finest level's cells there, and the high child. `None` for
    /// a piece.
    pub(crate) cut: Option<Cut>,
    /// The lowest and highest value of any sample, in units of the field's range; `[inf, -inf]` where there is none.
    pub(crate) range: [f32; 2],
    /// Cells along the longest side, where the node lies in one region.
    pub(crate) width: f32,
    /// The largest sum of a cell's second differences across the three axes, in the same units; infinite where cells are
    /// not a number.
    pub(crate) roughness: f32,
}

/// Where a node is cut in two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    pub(crate) axis: u8,
    pub(crate) high: u32,
    pub(crate) plane: i64,
}

/// Where pieces learn what their values are like.
pub(super) trait Source: Sync {
    /// Where a region lies.
    fn frame(&self, region: usize) -> &RegionFrame;

    /// The range and the roughness of a part of a region, which has cells of `size`; both in cells of the finest level.
    fn piece(&self, region: usize, cells: &IndexBox, size: [i64; 3]) -> PieceNode;
}

/// The tree of all pieces, the root first.
pub(super) fn tree(index: &Index, source: &impl Source) -> Vec<PieceNode> {
    let boxes = index.region_boxes();
    let instructions = InstructionSet::best();
    let regions: Vec<Vec<PieceNode>> = boxes
        .par_iter()
        .enumerate()
        .map(|(number, cells)| instructions.run(Divide { number, cells, index, source }))
        .collect();
    let mut nodes = Vec::with_capacity(index.nodes().len() + regions.iter().map(Vec::len).sum::<usize>());
    append(index, 0, &regions, &mut nodes);
    nodes
}

/// Cells of a size, in cells of the finest level, along the longest side of a box.
fn width(cells: &IndexBox, size: [i64; 3]) -> f32 {
    (0..3).map(|axis| cells.size()[axis] as f32 / size[axis] as f32).fold(0.0, f32::max)
}

/// Appends the tree below a node of the index.
fn append(index: &Index, node: usize, regions: &[Vec<PieceNode>], nodes: &mut Vec<PieceNode>) {
    match index.nodes()[node] {
        Node::Leaf(region) => {
            let offset = nodes.len() as u32;
            nodes.extend(
                regions[region as usize]
                    .iter()
                    .map(|node| PieceNode { cut: node.cut.map(|cut| Cut { high: cut.high + offset, ..cut }), ..*node }),
            );
        }
        Node::Inner { axis, plane, high } => {
            let place = nodes.len();
            nodes.push(PieceNode::NOTHING);
            append(index, node + 1, regions, nodes);
            let cut = Cut { axis, plane, high: nodes.len() as u32 };
            append(index, high as usize, regions, nodes);
            nodes[place] = PieceNode::over(None, cut, 0.0, &nodes[place + 1], &nodes[cut.high as usize]);
        }
    }
}

impl PieceNode {
    const NOTHING: Self =
        Self { region: None, cut: None, range: [f32::INFINITY, f32::NEG_INFINITY], width: 0.0, roughness: 0.0 };

    fn over(region: Option<u32>, cut: Cut, width: f32, low: &Self, high: &Self) -> Self {
        let range = [low.range[0].min(high.range[0]), low.range[1].max(high.range[1])];
        Self { region, cut: Some(cut), range, width, roughness: low.roughness.max(high.roughness) }
    }
}

/// Divides one region.
struct Divide<'a, V> {
    number: usize,
    /// The region, in cells of the finest level.
    cells: &'a IndexBox,
    index: &'a Index,
    source: &'a V,
}

impl<V: Source> Kernel for Divide<'_, V> {
    type Output = Vec<PieceNode>;

    #[inline(always)]
    fn run<S: Gather>(self, _: S) -> Vec<PieceNode> {
        let mut nodes = Vec::new();
        self.divide(*self.cells, &mut nodes);
        nodes
    }
}

impl<V: Source> Divide<'_, V> {
    fn divide(&self, cells: IndexBox, nodes: &mut Vec<PieceNode>) {
        let region = Some(self.number as u32);
        let Some(level) = self.source.frame(self.number).level else {
            return nodes.push(PieceNode { region, ..PieceNode::NOTHING });
        };
        let size = self.index.hierarchy().levels()[usize::from(level)].finest_cells();
        let parts: [i64; 3] = std::array::from_fn(|axis| {
            let longest = LONGEST * size[axis];
            (cells.size()[axis] + longest - 1) / longest
        });
        let axis = (0..3).fold(0, |widest, axis| if parts[axis] > parts[widest] { axis } else { widest });
        let width = width(&cells, size);
        if parts[axis] <= 1 {
            return nodes.push(PieceNode { region, width, ..self.source.piece(self.number, &cells, size) });
        }
        let plane = cells.low[axis] + (parts[axis] / 2) * LONGEST * size[axis];
        let (mut below, mut above) = (cells, cells);
        below.high[axis] = plane;
        above.low[axis] = plane;
        let place = nodes.len();
        nodes.push(PieceNode::NOTHING);
        self.divide(below, nodes);
        let cut = Cut { axis: axis as u8, plane, high: nodes.len() as u32 };
        self.divide(above, nodes);
        nodes[place] = PieceNode::over(region, cut, width, &nodes[place + 1], &nodes[cut.high as usize]);
    }
}
