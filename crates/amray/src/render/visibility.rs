//! What a transfer function makes of each piece: invisible, or worth how many samples.

use crate::Volume;
use crate::appearance::{PreparedTransferFunction, Segments, Window};
use crate::hierarchy::Normalisation;
use crate::index::{Index, Region};
use crate::layout::PieceNode;
use crate::reconstruction::Method;

/// How a node of the tree of pieces looks.
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
    /// The segments of the transfer function that the (first field's) values can lie in.
    pub(super) window: Window,
    /// The length of a step over that on level 0: a power of two.
    pub(super) step: f32,
}

/// Decides how nodes look. Made anew when a transfer function changes: the index and the pieces stay.
pub(super) struct Visibility<'a> {
    /// What is seen, at least one; their trees of pieces differ in values alone.
    media: Vec<SeenField<'a>>,
    /// Per region, the level of its leaf cells.
    levels: Vec<Option<usize>>,
    /// Per level, the step over that on level 0, and the longest side of a cell.
    steps: Vec<f64>,
    cell_sizes: Vec<f64>,
    adaptive: bool,
    /// Whether dense parts are marched through piece by piece: see [`DENSE`].
    is_lit: bool,
    /// Whether each cell counts: where values jump from cell to cell, how they bend tells nothing.
    cell_by_cell: bool,
}

/// A field under its transfer function.
#[derive(Clone, Copy)]
pub(super) struct SeenField<'a> {
    pub(super) function: &'a PreparedTransferFunction,
    pub(super) segments: &'a Segments,
    pub(super) pieces: &'a [PieceNode],
    pub(super) normalisation: Normalisation,
}

impl SeenField<'_> {
    /// The largest extinction of any sample in a node; below 0 where there is none.
    fn largest_extinction(&self, node: usize) -> f64 {
        let [low, high] = self.pieces[node].range.map(|unit| self.normalisation.undo(unit));
        if low <= high { self.function.max_extinction(low, high) } else { -1.0 }
    }
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
    /// Of fields of one mesh and method, `volume`'s first; `is_colored` says that yet another field gives it colours.
    pub(super) fn new(
        volume: &'a Volume,
        media: Vec<SeenField<'a>>,
        is_colored: bool,
        adaptive: bool,
        is_lit: bool,
    ) -> Self {
        let levels = volume.hierarchy().levels();
        let cell_sizes = levels.iter().map(|level| level.cell_size().into_iter().fold(0.0, f64::max)).collect();
        let regions = volume.index().regions().iter();
        Self {
            media,
            levels: regions.map(Region::finest_level).collect(),
            steps: steps(volume.index()),
            cell_sizes,
            adaptive,
            is_lit,
            cell_by_cell: is_colored || matches!(volume.method(), Method::Nearest | Method::Finest),
        }
    }

    /// The looks of all nodes.
    pub(super) fn looks(&self) -> Vec<NodeLook> {
        let pieces = self.media[0].pieces;
        let mut looks = vec![NodeLook::Hidden; pieces.len()];
        // Children follow their parents.
        for (place, node) in pieces.iter().enumerate().rev() {
            looks[place] = match node.cut {
                None => self.look_of_piece(place),
                Some(cut) => match (looks[place + 1], looks[cut.high as usize]) {
                    (NodeLook::Hidden, NodeLook::Hidden) => NodeLook::Hidden,
                    (NodeLook::Seen(low), NodeLook::Seen(high)) if node.region.is_some() => {
                        let children = [(low, &pieces[place + 1]), (high, &pieces[cut.high as usize])];
                        self.joined(place, children).map_or(NodeLook::Mixed, NodeLook::Seen)
                    }
                    _ => NodeLook::Mixed,
                },
            };
        }
        looks
    }

    /// How to march through two children of a node as one: with the shorter step of both, if that costs less than to stop
    /// between them.
    fn joined(&self, node: usize, children: [(SeenLook, &PieceNode); 2]) -> Option<SeenLook> {
        let step = children[0].0.step.min(children[1].0.step);
        let level = self.level(node)?;
        if self.is_lit && self.depth_of_cell(node, level) > DENSE {
            return None;
        }
        let whole = self.steps[level] as f32;
        let more: f32 =
            children.iter().map(|(look, child)| child.width * whole * (step.recip() - look.step.recip())).sum();
        (more <= STOP).then(|| SeenLook { window: self.window(node), step })
    }

    /// The level of a node's leaf cells.
    fn level(&self, node: usize) -> Option<usize> {
        self.levels[self.media[0].pieces[node].region? as usize]
    }

    /// The largest optical depth of a cell.
    fn depth_of_cell(&self, node: usize, level: usize) -> f64 {
        let extinction: f64 = self.media.iter().map(|field| field.largest_extinction(node).max(0.0)).sum();
        extinction * self.cell_sizes[level]
    }

    fn window(&self, node: usize) -> Window {
        let SeenField { segments, pieces, .. } = self.media[0];
        if self.adaptive { segments.window(pieces[node].range) } else { Window::all(segments) }
    }

    fn look_of_piece(&self, piece: usize) -> NodeLook {
        let seen = !self.adaptive || self.media.iter().any(|field| field.largest_extinction(piece) > 0.0);
        let (true, Some(level)) = (seen, self.level(piece)) else {
            return NodeLook::Hidden;
        };
        let cells = self.longest_step(piece, level).clamp(1.0, LONGEST_STEP).log2().floor().exp2();
        NodeLook::Seen(SeenLook { window: self.window(piece), step: (self.steps[level] * cells) as f32 })
    }

    /// How many cells a step in a piece can be long.
    fn longest_step(&self, piece: usize, level: usize) -> f64 {
        let is_rough = |field: &SeenField| field.pieces[piece].roughness.is_infinite();
        if !self.adaptive || self.cell_by_cell || self.media.iter().any(is_rough) {
            return 1.0;
        }
        // Over a step of n cells, values differ from a line by up to n^2 / 8 of how far they bend in one.
        let error = |field: &SeenField| {
            let PieceNode { range, roughness, width, .. } = field.pieces[piece];
            let bend = f64::from(roughness) / 8.0;
            bend * field.segments.steepness(field.segments.window(range)) * f64::from(width) * self.cell_sizes[level]
        };
        let cells = (TOLERANCE / self.media.iter().map(error).sum::<f64>()).sqrt();
        // Light falls off along a step, too.
        if self.is_lit { cells.min(DENSE / self.depth_of_cell(piece, level)) } else { cells }
    }
}

/// Per level, the step over that on level 0: halved until it fits the cell on its narrowest axis.
pub(super) fn steps(index: &Index) -> Vec<f64> {
    let levels = index.hierarchy().levels();
    let coarsest = levels[0].finest_cells();
    let refinement = |cells: [i64; 3]| (0..3).map(|axis| coarsest[axis] / cells[axis]).max().unwrap_or(1);
    levels.iter().map(|level| (refinement(level.finest_cells()) as f64).log2().ceil().exp2().recip()).collect()
}
