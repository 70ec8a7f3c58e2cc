//! Bounds on the extinction, part by part: between two of them, light goes as if it were through a homogeneous medium.

use rayon::prelude::*;

use crate::Volume;
use crate::appearance::PreparedTransferFunction;
use crate::hierarchy::{IndexBox, Normalisation};
use crate::index::{Cuts, NodeSpan, Ray, Walk};
use crate::layout::PieceNode;

/// A cell that is deeper is as good as a surface: extinctions end there. Otherwise light would meet no end of nothing
/// in parts of which a corner is opaque.
const DEEPEST_CELL: f64 = 64.0;
/// Parts are joined where a bound for both makes light meet so much less than nothing more often, per way across.
const JOINED: f64 = 0.25;

/// The tree of parts.
pub(super) struct Majorants {
    domain: IndexBox,
    nodes: Vec<Node>,
    parts: Vec<Part>,
}

/// A box inside one region, and how dense it can be.
pub(super) struct Part {
    /// The first and the last places, in cells of the finest level.
    ends: [[f64; 3]; 2],
    /// The region's place in the index.
    pub(super) region: usize,
    /// No sample has more extinction.
    pub(super) majorant: f64,
    /// Extinctions beyond this are as good as infinite.
    pub(super) opaque: f64,
}

/// A node of the tree; its low child follows it directly.
#[derive(Clone, Copy)]
enum Node {
    Cut { axis: u8, plane: f64, high: u32 },
    Empty,
    Part(u32),
}

impl Majorants {
    /// The bounds for a volume in these pieces, whose values look as `function` says.
    pub(super) fn new(volume: &Volume, pieces: &[PieceNode], function: &PreparedTransferFunction) -> Self {
        let index = volume.index();
        let normalisation = volume.normalisation();
        let levels = index.hierarchy().levels().iter();
        let opaque: Vec<f64> =
            levels.map(|level| DEEPEST_CELL / level.cell_size().into_iter().fold(f64::INFINITY, f64::min)).collect();
        let opaque: Vec<f64> =
            index.regions().iter().map(|region| region.finest_level().map_or(0.0, |level| opaque[level])).collect();
        let majorant = |piece: &PieceNode| match (piece.cut, piece.region) {
            (None, Some(region)) => largest(piece.range, normalisation, function).min(opaque[region as usize]),
            _ => 0.0,
        };
        let majorants: Vec<f64> = pieces.par_iter().map(majorant).collect();
        let made = Self { domain: index.domain(), nodes: Vec::new(), parts: Vec::new() };
        let finest = &index.hierarchy().levels()[index.hierarchy().finest_level()];
        let mut build = Build { pieces, majorants: &majorants, opaque: &opaque, cell_size: finest.cell_size(), made };
        build.below(0, index.domain());
        build.made
    }

    /// The parts that are not empty, in order, between `near` and `far` on a ray. `waiting` is memory that walks use one
    /// after the other.
    #[inline]
    pub(super) fn walk(
        &self,
        ray: Ray,
        ends: [f64; 2],
        waiting: &mut Vec<NodeSpan>,
    ) -> impl Iterator<Item = (&Part, [f64; 2])> {
        Walk::new(self, &self.domain, ray, ends, waiting).filter_map(|span| match self.nodes[span.node] {
            Node::Part(part) => Some((&self.parts[part as usize], [span.enter, span.leave])),
            Node::Empty | Node::Cut { .. } => None,
        })
    }
}

impl Cuts for Majorants {
    #[inline]
    fn cut(&self, node: usize) -> Option<(usize, f64, usize)> {
        match self.nodes[node] {
            Node::Cut { axis, plane, high } => Some((usize::from(axis), plane, high as usize)),
            Node::Empty | Node::Part(_) => None,
        }
    }
}

impl Part {
    /// A place that rounding may have moved over a face, back in the part: beyond, values can be others.
    #[inline]
    pub(super) fn inside(&self, place: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| place[axis].max(self.ends[0][axis]).min(self.ends[1][axis]))
    }
}

/// The largest extinction of a piece's values, which are in units of the field's range.
fn largest(range: [f32; 2], normalisation: Normalisation, function: &PreparedTransferFunction) -> f64 {
    // Ranges and samples are rounded, to less than this of their distance from the field's lowest value and of their own.
    // Where the function has a step, the last digit decides.
    const ROUNDING: f64 = 16.0 * f32::EPSILON as f64;
    const DIGITS: f64 = 16.0 * f64::EPSILON;
    let [low, high] = range.map(|unit| normalisation.undo(unit));
    let lowest = normalisation.undo(0.0);
    let rounding = [low, high].map(|end| ROUNDING * (end - lowest).abs() + DIGITS * end.abs());
    let rounding = rounding[0].max(rounding[1]);
    function.max_extinction(low - rounding, high + rounding)
}

/// Puts parts together, from the smallest on.
struct Build<'a> {
    pieces: &'a [PieceNode],
    /// By piece; 0 for nodes that are cut.
    majorants: &'a [f64],
    /// By region.
    opaque: &'a [f64],
    /// Of the finest level, in world units.
    cell_size: [f64; 3],
    made: Majorants,
}

/// What a node holds.
struct Summary {
    majorant: f64,
    /// The mean of the majorants of its pieces.
    mean: f64,
}

impl Build<'_> {
    /// Appends the tree below a node of the tree of pieces, which fills `cells`.
    fn below(&mut self, node: usize, cells: IndexBox) -> Summary {
        let PieceNode { region, cut, .. } = self.pieces[node];
        let (place, parts) = (self.made.nodes.len(), self.made.parts.len());
        let Some(cut) = cut else {
            let majorant = self.majorants[node];
            self.append(region, cells, majorant);
            return Summary { majorant, mean: majorant };
        };
        let axis = usize::from(cut.axis);
        let (mut below, mut above) = (cells, cells);
        (below.high[axis], above.low[axis]) = (cut.plane, cut.plane);
        self.made.nodes.push(Node::Empty);
        let low = self.below(node + 1, below);
        let high_place = self.made.nodes.len() as u32;
        let high = self.below(cut.high as usize, above);
        let share = below.size()[axis] as f64 / cells.size()[axis] as f64;
        let majorant = low.majorant.max(high.majorant);
        let mean = low.mean * share + high.mean * (1.0 - share);
        let join = majorant == 0.0 || region.is_some() && (majorant - mean) * self.longest_side(&cells) <= JOINED;
        if join {
            self.made.nodes.truncate(place);
            self.made.parts.truncate(parts);
            self.append(region, cells, majorant);
        } else {
            self.made.nodes[place] = Node::Cut { axis: cut.axis, plane: cut.plane as f64, high: high_place };
        }
        Summary { majorant, mean }
    }

    fn append(&mut self, region: Option<u32>, cells: IndexBox, majorant: f64) {
        let node = match region {
            Some(region) if majorant > 0.0 => {
                let ends = [cells.low.map(|cell| cell as f64), cells.high.map(|cell| (cell as f64).next_down())];
                let region = region as usize;
                self.made.parts.push(Part { ends, region, majorant, opaque: self.opaque[region] });
                Node::Part(self.made.parts.len() as u32 - 1)
            }
            _ => Node::Empty,
        };
        self.made.nodes.push(node);
    }

    /// In world units.
    fn longest_side(&self, cells: &IndexBox) -> f64 {
        (0..3).map(|axis| cells.size()[axis] as f64 * self.cell_size[axis]).fold(0.0, f64::max)
    }
}
