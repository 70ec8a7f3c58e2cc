//! Pieces of regions, a few cells wide: what values they hold and how far these bend, in one tree with the regions.
//!
//! A transfer function decides per piece whether anything is seen and how long steps can be; pieces that are alike are
//! marched through as one.

use rayon::prelude::*;

use super::RegionFrame;
use super::padded::{FLAG, PaddedBrick, PaddedField, Padding, Plan, RegionPlan, is_hole};
use crate::hierarchy::{IndexBox, Normalisation};
use crate::index::{Index, Node, ValueRanges};
use crate::simd::{Gather, InstructionSet, Kernel};

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

/// The tree of all pieces of a padded copy, the root first.
pub(super) fn of_padded(index: &Index, ranges: &ValueRanges, plan: &Plan, field: &PaddedField) -> Vec<PieceNode> {
    let boxes = index.region_boxes();
    let instructions = InstructionSet::best();
    let regions: Vec<Vec<PieceNode>> = boxes
        .par_iter()
        .enumerate()
        .map(|(number, cells)| instructions.run(Divide { number, cells, index, ranges, plan, field }))
        .collect();
    let mut nodes = Vec::with_capacity(index.nodes().len() + regions.iter().map(Vec::len).sum::<usize>());
    append(index, 0, &regions, &mut nodes);
    nodes
}

/// The tree of regions that are not cut into pieces, of which no more is known than their values' ranges.
pub(super) fn of_regions(index: &Index, ranges: &ValueRanges, normalisation: Normalisation) -> Vec<PieceNode> {
    let pieces = index.region_boxes().into_iter().enumerate().map(|(number, cells)| {
        let level = index.regions()[number].finest_level().unwrap_or(0);
        let size = index.hierarchy().levels()[level].finest_cells();
        let range = ranges.region(number).map(|value| normalisation.apply(value.into()));
        vec![PieceNode {
            region: Some(number as u32),
            cut: None,
            range,
            width: width(&cells, size),
            // Each of three second differences is at most twice the range.
            roughness: 6.0 * (range[1] - range[0]).max(0.0),
        }]
    });
    let mut nodes = Vec::with_capacity(index.nodes().len());
    append(index, 0, &pieces.collect::<Vec<_>>(), &mut nodes);
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
struct Divide<'a> {
    number: usize,
    /// The region, in cells of the finest level.
    cells: &'a IndexBox,
    index: &'a Index,
    ranges: &'a ValueRanges,
    plan: &'a Plan,
    field: &'a PaddedField,
}

impl Kernel for Divide<'_> {
    type Output = Vec<PieceNode>;

    #[inline(always)]
    fn run<S: Gather>(self, _: S) -> Vec<PieceNode> {
        let mut nodes = Vec::new();
        self.divide(*self.cells, &mut nodes);
        nodes
    }
}

impl Divide<'_> {
    fn divide(&self, cells: IndexBox, nodes: &mut Vec<PieceNode>) {
        let plan = &self.plan.regions[self.number];
        let region = Some(self.number as u32);
        let Some(level) = plan.frame.level else { return nodes.push(PieceNode { region, ..PieceNode::NOTHING }) };
        let size = self.index.hierarchy().levels()[usize::from(level)].finest_cells();
        let parts: [i64; 3] = std::array::from_fn(|axis| {
            let longest = LONGEST * size[axis];
            (cells.size()[axis] + longest - 1) / longest
        });
        let axis = (0..3).fold(0, |widest, axis| if parts[axis] > parts[widest] { axis } else { widest });
        let width = width(&cells, size);
        if parts[axis] <= 1 {
            return nodes.push(PieceNode { region, width, ..self.piece(plan, &cells, size) });
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

    /// What the values of a piece are like.
    #[inline(always)]
    fn piece(&self, plan: &RegionPlan, cells: &IndexBox, size: [i64; 3]) -> PieceNode {
        let corner = |corner: [i64; 3]| -> [f64; 3] {
            std::array::from_fn(|axis| corner[axis] as f64 / size[axis] as f64 - plan.frame.low[axis])
        };
        let (low, high) = (corner(cells.low), corner(cells.high));
        let mut piece = PieceNode::NOTHING;
        self.scan(&plan.brick, [low, high], 1.0, &mut piece);
        let RegionFrame { pure, is_pure, .. } = &plan.frame;
        let inside = (0..3).all(|axis| f64::from(pure[0][axis]) <= low[axis] && high[axis] <= f64::from(pure[1][axis]));
        if *is_pure || inside {
            return piece;
        }
        if !self.plan.is_complete() {
            piece.range = self.ranges.region(self.number).map(|value| self.field.normalisation.apply(value.into()));
            return piece;
        }
        for other in self.plan.others(plan).into_iter().flatten() {
            let moved =
                |point: [f64; 3]| -> [f64; 3] { std::array::from_fn(|axis| other.axes[axis].apply(point[axis])) };
            // Second differences grow with the square of a cell's size.
            let finer = other.axes.iter().map(|axis| axis.multiple / axis.parts).fold(0.0, f32::max);
            self.scan(&other.brick, [moved(low), moved(high)], finer * finer, &mut piece);
        }
        piece
    }

    /// Widens what is known of a piece by the values of a brick that samples between two places can touch; a cell of the
    /// piece's bends `scale` times as much as one of the brick's.
    #[inline(always)]
    fn scan(&self, brick: &PaddedBrick, [low, high]: [[f64; 3]; 2], scale: f32, piece: &mut PieceNode) {
        let values = self.field.brick(brick);
        let first = |axis: usize| (low[axis].floor().max(0.0)) as usize;
        let end = |axis: usize| (high[axis].floor().min(f64::from(brick.cells[axis])) + 2.0).max(0.0) as usize;
        let [row, slice] = brick.strides.map(|stride| stride as usize);
        if (0..3).any(|axis| end(axis) <= first(axis)) {
            return;
        }
        // What only stands for a leaf cell of another level has no weight.
        let leaves_only = Padding::of(self.plan.method) == Padding::Leaves;
        let counts = |value: f32| !leaves_only || value.to_bits() & FLAG == FLAG;
        let length = end(0) - first(0);
        let [mut lowest, mut highest] = piece.range;
        let mut roughness = 0.0f32;
        for z in first(2)..end(2) {
            for y in first(1)..end(1) {
                let start = first(0) + row * y + slice * z;
                let line = &values[start..start + length];
                for &value in line {
                    // Not a number is neither.
                    lowest = if value < lowest { value } else { lowest };
                    highest = if value > highest { value } else { highest };
                }
                if !self.field.is_finite && line.iter().any(|&value| !value.is_finite() && !is_hole(value)) {
                    roughness = f32::INFINITY;
                }
                // Padding has no neighbours on all sides, and is some other piece's cell.
                let is_cell = |place: usize, axis: usize| 0 < place && place <= brick.cells[axis] as usize;
                if !is_cell(y, 1) || !is_cell(z, 2) {
                    continue;
                }
                let (from, to) = (first(0).max(1), end(0).min(brick.cells[0] as usize + 1));
                let start = from + row * y + slice * z;
                let length = to.saturating_sub(from);
                let line = |start: usize| &values[start..start + length];
                let (own, left, right) = (line(start), line(start - 1), line(start + 1));
                let (front, back) = (line(start - row), line(start + row));
                let (below, above) = (line(start - slice), line(start + slice));
                for x in 0..length {
                    // Beside a hole, values go on as they are.
                    let difference = |other: f32| if other.is_nan() { 0.0 } else { other - own[x] };
                    let along = |low: f32, high: f32| {
                        if counts(low) && counts(high) { (difference(low) + difference(high)).abs() } else { 0.0 }
                    };
                    let bend = along(left[x], right[x]) + along(front[x], back[x]) + along(below[x], above[x]);
                    roughness = if bend > roughness && counts(own[x]) { bend } else { roughness };
                }
            }
        }
        piece.range = [lowest, highest];
        piece.roughness = piece.roughness.max(scale * roughness);
    }
}
