//! What a transfer function makes of each piece: invisible, or worth how many samples.

use crate::Volume;
use crate::appearance::{PreparedTransferFunction, Segments, Window};
use crate::hierarchy::Normalisation;
use crate::index::{Index, Region};
use crate::layout::PieceNode;
use crate::reconstruction::Method;

/// How a node of the tree of pieces looks under one transfer function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NodeLook {
    /// Nothing in it is seen.
    Hidden,
    /// It is marched through as one.
    Seen(SeenLook),
    /// Its children look different.
    Mixed,
}

/// How to march through what is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SeenLook {
    /// The segments of the transfer function that the values can lie in.
    pub(super) window: Window,
    /// The length of a step over that on level 0: a power of two.
    pub(super) step: f32,
}

/// Decides how nodes look. Made anew when the transfer function changes: the index and the pieces stay.
pub(super) struct Visibility<'a> {
    function: &'a PreparedTransferFunction,
    segments: &'a Segments,
    pieces: &'a [PieceNode],
    normalisation: Normalisation,
    /// Per region, the level of its leaf cells.
    levels: Vec<Option<usize>>,
    /// Per level, the step over that on level 0, and the longest side of a cell.
    steps: Vec<f64>,
    cell_sizes: Vec<f64>,
    adaptive: bool,
    /// Whether dense parts are marched through piece by piece: see [`DENSE`].
    is_lit: bool,
    /// Whether values jump from cell to cell: how they bend tells nothing then.
    has_steps: bool,
}

/// How far the optical depth of a piece may be off because its samples are far apart. The bound that is held to it is a
/// loose one: pictures were off by a fiftieth of it (root mean square), and nowhere by half of it.
const TOLERANCE: f64 = 4e-2;
/// What it costs to stop and go on between two pieces, in samples.
const STOP: f32 = 8.0;
/// Where a cell has more optical depth, only the front of what is seen is worth finding out how it is lit; elsewhere a
/// step has no more.
const DENSE: f64 = 0.25;
/// The longest step, in cells.
const LONGEST_STEP: f64 = 8.0;

impl<'a> Visibility<'a> {
    pub(super) fn new(
        volume: &'a Volume,
        (pieces, normalisation): (&'a [PieceNode], Normalisation),
        function: &'a PreparedTransferFunction,
        segments: &'a Segments,
        adaptive: bool,
        is_lit: bool,
    ) -> Self {
        let levels = volume.hierarchy().levels();
        let cell_sizes = levels.iter().map(|level| level.cell_size().into_iter().fold(0.0, f64::max)).collect();
        let regions = volume.index().regions().iter();
        Self {
            function,
            segments,
            pieces,
            normalisation,
            levels: regions.map(Region::finest_level).collect(),
            steps: steps(volume.index()),
            cell_sizes,
            adaptive,
            is_lit,
            has_steps: matches!(volume.method(), Method::Nearest | Method::Finest),
        }
    }

    /// The looks of all nodes.
    pub(super) fn looks(&self) -> Vec<NodeLook> {
        let pieces = self.pieces;
        let mut looks = vec![NodeLook::Hidden; pieces.len()];
        // Children follow their parents.
        for (place, node) in pieces.iter().enumerate().rev() {
            looks[place] = match node.cut {
                None => self.look_of_piece(node),
                Some(cut) => match (looks[place + 1], looks[cut.high as usize]) {
                    (NodeLook::Hidden, NodeLook::Hidden) => NodeLook::Hidden,
                    (NodeLook::Seen(low), NodeLook::Seen(high)) if node.region.is_some() => {
                        let children = [(low, &pieces[place + 1]), (high, &pieces[cut.high as usize])];
                        self.joined(node, children).map_or(NodeLook::Mixed, NodeLook::Seen)
                    }
                    _ => NodeLook::Mixed,
                },
            };
        }
        looks
    }

    /// How to march through two children as one: with the shorter step of both, if that costs less than to stop between
    /// them.
    fn joined(&self, node: &PieceNode, children: [(SeenLook, &PieceNode); 2]) -> Option<SeenLook> {
        let step = children[0].0.step.min(children[1].0.step);
        let level = self.levels[node.region? as usize]?;
        if self.is_lit && self.depth_of_cell(node, level) > DENSE {
            return None;
        }
        let whole = self.steps[level] as f32;
        let more: f32 =
            children.iter().map(|(look, child)| child.width * whole * (step.recip() - look.step.recip())).sum();
        (more <= STOP).then(|| SeenLook { window: self.window(node), step })
    }

    /// The largest optical depth of a cell.
    fn depth_of_cell(&self, node: &PieceNode, level: usize) -> f64 {
        let [low, high] = node.range.map(|unit| self.normalisation.undo(unit));
        self.function.max_extinction(low, high) * self.cell_sizes[level]
    }

    fn window(&self, node: &PieceNode) -> Window {
        if self.adaptive { self.segments.window(node.range) } else { Window::all(self.segments) }
    }

    fn look_of_piece(&self, piece: &PieceNode) -> NodeLook {
        let [low, high] = piece.range.map(|unit| self.normalisation.undo(unit));
        let level = piece.region.and_then(|region| self.levels[region as usize]);
        let seen = !self.adaptive || low <= high && self.function.max_extinction(low, high) > 0.0;
        let (true, Some(level)) = (seen, level) else {
            return NodeLook::Hidden;
        };
        if !self.adaptive {
            let window = Window::all(self.segments);
            return NodeLook::Seen(SeenLook { window, step: self.steps[level] as f32 });
        }
        let window = self.segments.window(piece.range);
        if self.has_steps || piece.roughness.is_infinite() {
            return NodeLook::Seen(SeenLook { window, step: self.steps[level] as f32 });
        }
        // Over a step of n cells, values differ from a line by up to n^2 / 8 of how far they bend in one.
        let bend = f64::from(piece.roughness) / 8.0;
        let error = bend * self.segments.steepness(window) * f64::from(piece.width) * self.cell_sizes[level];
        let mut cells = (TOLERANCE / error).sqrt();
        if self.is_lit {
            // Light falls off along a step, too.
            cells = cells.min(DENSE / self.depth_of_cell(piece, level));
        }
        let cells = cells.clamp(1.0, LONGEST_STEP).log2().floor().exp2();
        NodeLook::Seen(SeenLook { window, step: (self.steps[level] * cells) as f32 })
    }
}

/// Per level, the step over that on level 0: halved until it fits the cell on its narrowest axis.
pub(super) fn steps(index: &Index) -> Vec<f64> {
    let levels = index.hierarchy().levels();
    let coarsest = levels[0].finest_cells();
    let refinement = |cells: [i64; 3]| (0..3).map(|axis| coarsest[axis] / cells[axis]).max().unwrap_or(1);
    levels.iter().map(|level| (refinement(level.finest_cells()) as f64).log2().ceil().exp2().recip()).collect()
}
