//! What surrounds each region: the levels in reach of its points, and the interior where one brick is enough.
//!
//! Only neighbours of different levels matter to each other, and the coarser of two reaches farther. So each region
//! looks for what is finer, or a hole, within half a cell of its own, and those that it finds hear of it afterwards.

use rayon::prelude::*;

use super::build::Leaf;
use super::interior::{Neighbour, out_of_reach};
use super::{Index, Node, Region};
use crate::hierarchy::{IndexBox, Level};

/// Parts of the tree with fewer leaves are surveyed by one thread.
const PARALLEL_LEAVES: usize = 256;

/// The regions of the tree's leaves: with the levels in reach and the interior, which depend on neighbours.
pub(super) fn described(index: &Index, leaves: &[Leaf]) -> Vec<Region> {
    let survey = Survey::new(index, leaves);
    let mut views = vec![View::NONE; leaves.len()];
    let root = Part { node: 0, space: index.domain };
    let mut descent = Descent { survey: &survey, views: &mut views, first: 0, meetings: Vec::new() };
    descent.descend(&root, root);
    let mut meetings = descent.meetings;
    meetings.par_sort_unstable();
    let describe = |neighbours: &mut Vec<Neighbour>, (number, view): (usize, &View)| {
        let first = meetings.partition_point(|meeting| meeting.finer < number as u32);
        let with = meetings[first..].iter().take_while(|meeting| meeting.finer == number as u32);
        survey.region(&leaves[number], view, with, neighbours)
    };
    views.par_iter().enumerate().map_init(Vec::new, describe).collect()
}

/// What is known while the regions are described.
struct Survey<'a> {
    index: &'a Index,
    leaves: &'a [Leaf],
    /// Per node, which levels show below it.
    shown: Vec<Shown>,
    /// Per level, cells of the finest level per cell.
    sizes: Vec<[i64; 3]>,
    /// Per level, how far its cells can reach from a region's box, in cells of the finest level.
    margins: Vec<[i64; 3]>,
}

/// The finest levels of the regions below a node. A hole counts as finer than every level: neighbours reach into it.
#[derive(Clone, Copy)]
struct Shown {
    coarsest: u8,
    finest: u8,
}

impl Shown {
    const HOLE: u8 = u8::MAX;
}

/// A node with the space it fills, in cells of the finest level.
#[derive(Clone, Copy)]
struct Part {
    node: u32,
    space: IndexBox,
}

/// What a region sees of what is finer.
#[derive(Clone)]
struct View {
    finest_in_reach: u8,
    /// The interior in half cells of the finest level.
    interior: IndexBox,
}

impl View {
    /// What a hole sees.
    const NONE: Self = Self { finest_in_reach: 0, interior: IndexBox::new([0; 3], [-1; 3]) };
}

/// Two leaves, one of which has the other in reach.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Meeting {
    finer: u32,
    coarser: u32,
}

impl<'a> Survey<'a> {
    fn new(index: &'a Index, leaves: &'a [Leaf]) -> Self {
        let mut shown = vec![Shown { coarsest: 0, finest: 0 }; index.nodes.len()];
        // Children follow their parents.
        for (place, node) in index.nodes.iter().enumerate().rev() {
            shown[place] = match *node {
                Node::Leaf(leaf) => {
                    let level = leaves[leaf as usize].levels.checked_ilog2().map_or(Shown::HOLE, |level| level as u8);
                    Shown { coarsest: level, finest: level }
                }
                Node::Inner { high, .. } => {
                    let (low, high) = (shown[place + 1], shown[high as usize]);
                    Shown { coarsest: low.coarsest.min(high.coarsest), finest: low.finest.max(high.finest) }
                }
            };
        }
        // Half a cell, and where a cell may be covered in part up to one more by which a box falls short of its cells.
        let halves = if index.may_cover_partly { 3 } else { 1 };
        let margin = |level: &Level| level.finest_cells().map(|cells| (halves * cells + 1) / 2);
        let levels = index.hierarchy.levels();
        Self {
            index,
            leaves,
            shown,
            sizes: levels.iter().map(Level::finest_cells).collect(),
            margins: levels.iter().map(margin).collect(),
        }
    }

    /// The parts below an inner node.
    fn halves(&self, part: &Part) -> Option<[Part; 2]> {
        let Node::Inner { axis, plane, high } = self.index.nodes[part.node as usize] else { return None };
        let mut halves = [Part { node: part.node + 1, ..*part }, Part { node: high, ..*part }];
        halves[0].space.high[usize::from(axis)] = plane;
        halves[1].space.low[usize::from(axis)] = plane;
        Some(halves)
    }

    /// The number of the first leaf below a node.
    fn first_leaf(&self, mut node: u32) -> usize {
        loop {
            match self.index.nodes[node as usize] {
                Node::Leaf(leaf) => return leaf as usize,
                Node::Inner { .. } => node += 1,
            }
        }
    }

    /// The smallest part inside `part` that holds all that the regions of `level`, or finer, in `space` reach.
    fn narrowed(&self, mut part: Part, level: u8, space: &IndexBox) -> Part {
        let Some(margin) = self.margins.get(usize::from(level)) else { return part };
        let reach = space.grown(*margin).intersection(&part.space);
        while let Some(half) =
            self.halves(&part).and_then(|halves| halves.into_iter().find(|half| half.space.contains_box(&reach)))
        {
            part = half;
        }
        part
    }

    /// A region's `cells` (of the finest level) grown by half a cell of `level`, in half cells of the finest level.
    fn reach(&self, level: usize, cells: &IndexBox) -> IndexBox {
        let size = self.sizes[level];
        // A region's leaf cells fill its box or go on in a region of the same brick, unless one is covered in part.
        let whole = if self.index.may_cover_partly { cells.coarsened(size).refined(size) } else { *cells };
        whole.refined([2; 3]).grown(size)
    }

    /// What the region of `leaf` would see if it reached nothing finer.
    fn view(&self, leaf: &Leaf, level: usize) -> View {
        let region = Region { levels: leaf.levels, first_brick: leaf.first_brick, ..Region::EMPTY };
        let Some((_, brick)) = self.index.finest_brick(&region, level) else { return View::NONE };
        let size = self.sizes[level];
        let brick = self.index.hierarchy.levels()[level].brick_at(brick).refined(size).refined([2; 3]);
        // Cells of the same level are met half a cell inside the brick's own faces.
        let interior = brick.grown(size.map(|cells| -cells)).intersection(&leaf.cells.refined([2; 3]));
        View { finest_in_reach: level as u8, interior }
    }

    /// The region of `leaf`, which has the coarser ones of the `meetings` in reach. `neighbours` is memory to use.
    fn region<'m>(
        &self,
        leaf: &Leaf,
        view: &View,
        meetings: impl Iterator<Item = &'m Meeting>,
        neighbours: &mut Vec<Neighbour>,
    ) -> Region {
        let region = Region { levels: leaf.levels, first_brick: leaf.first_brick, ..Region::EMPTY };
        let Some(level) = region.finest_level() else { return region };
        let mut coarsest_in_reach = level;
        neighbours.clear();
        for meeting in meetings {
            let coarser = &self.leaves[meeting.coarser as usize];
            let coarser_level = coarser.levels.ilog2() as usize;
            coarsest_in_reach = coarsest_in_reach.min(coarser_level);
            let reach = self.reach(coarser_level, &coarser.cells);
            if reach.intersects(&view.interior) {
                neighbours.push(Neighbour::new(reach, &coarser.cells, &leaf.cells));
            }
        }
        let interior = out_of_reach(view.interior, neighbours);
        Region {
            coarsest_in_reach: coarsest_in_reach as u8,
            finest_in_reach: view.finest_in_reach,
            // A flat interior would promise a dual cell to a brick that is one cell thin.
            interior: if interior.is_empty() {
                Region::EMPTY.interior
            } else {
                [interior.low, interior.high].map(|corner| corner.map(|half_cells| half_cells as f64 / 2.0))
            },
            ..region
        }
    }
}

/// A way down the tree, region by region.
struct Descent<'a> {
    survey: &'a Survey<'a>,
    /// Of the leaves from the number `first` on.
    views: &'a mut [View],
    first: usize,
    meetings: Vec<Meeting>,
}

impl Descent<'_> {
    /// Surveys the regions of `part`. All that they reach lies in `around`.
    fn descend(&mut self, part: &Part, around: Part) {
        let survey = self.survey;
        let around = survey.narrowed(around, survey.shown[part.node as usize].coarsest, &part.space);
        let Some([low, high]) = survey.halves(part) else { return self.look(part, &around) };
        if self.views.len() > PARALLEL_LEAVES {
            let middle = survey.first_leaf(high.node);
            let (low_views, high_views) = self.views.split_at_mut(middle - self.first);
            let mut this = Descent { survey, views: low_views, first: self.first, meetings: Vec::new() };
            let mut other = Descent { survey, views: high_views, first: middle, meetings: Vec::new() };
            rayon::join(|| this.descend(&low, around), || other.descend(&high, around));
            self.meetings.append(&mut this.meetings);
            self.meetings.append(&mut other.meetings);
        } else {
            self.descend(&low, around);
            self.descend(&high, around);
        }
    }

    /// Looks at what is finer around the region of a leaf.
    fn look(&mut self, part: &Part, around: &Part) {
        let survey = self.survey;
        let number = survey.first_leaf(part.node);
        let leaf = &survey.leaves[number];
        let Some(level) = leaf.levels.checked_ilog2() else { return };
        let level = level as usize;
        let mut view = survey.view(leaf, level);
        let margin = survey.margins[level];
        let mut look = Look {
            survey,
            number: number as u32,
            level,
            cells: &leaf.cells,
            margin,
            reach: survey.reach(level, &leaf.cells),
            view: &mut view,
            neighbours: Vec::new(),
            meetings: &mut self.meetings,
        };
        look.below(around.node, &mut around.space.clone(), false);
        let mut neighbours = look.neighbours;
        view.interior = out_of_reach(view.interior, &mut neighbours);
        self.views[number - self.first] = view;
    }
}

/// A region that looks around.
struct Look<'a> {
    survey: &'a Survey<'a>,
    number: u32,
    level: usize,
    cells: &'a IndexBox,
    margin: [i64; 3],
    /// In half cells.
    reach: IndexBox,
    view: &'a mut View,
    neighbours: Vec<Neighbour>,
    meetings: &'a mut Vec<Meeting>,
}

impl Look<'_> {
    /// Looks at everything finer below `node`, which fills `space`. `known` where the neighbour is noted as a whole.
    fn below(&mut self, node: u32, space: &mut IndexBox, mut known: bool) {
        let survey = self.survey;
        let shown = survey.shown[node as usize];
        if usize::from(shown.finest) <= self.level {
            return;
        }
        if usize::from(shown.coarsest) > self.level && !known {
            // Whichever is finer: it covers cells of this level that a dual cell would touch.
            let reach = survey.reach(self.level, space);
            if reach.intersects(&self.view.interior) {
                self.neighbours.push(Neighbour::new(reach, space, self.cells));
            }
            known = true;
        }
        match survey.index.nodes[node as usize] {
            Node::Leaf(leaf) if shown.finest != Shown::HOLE => self.meet(leaf, shown.finest, space),
            Node::Leaf(_) => (),
            Node::Inner { axis, plane, high } => {
                let axis = usize::from(axis);
                let ends = (space.low[axis], space.high[axis]);
                if self.cells.low[axis] - self.margin[axis] < plane {
                    space.high[axis] = plane;
                    self.below(node + 1, space, known);
                    space.high[axis] = ends.1;
                }
                if self.cells.high[axis] + self.margin[axis] > plane {
                    space.low[axis] = plane;
                    self.below(high, space, known);
                    space.low[axis] = ends.0;
                }
            }
        }
    }

    /// Takes note of a leaf whose finest level is `finest`.
    fn meet(&mut self, leaf: u32, finest: u8, space: &IndexBox) {
        let survey = self.survey;
        // In reach: nearer than half a cell.
        let half_cells = space.refined([2; 3]);
        if !self.reach.intersects(&half_cells) {
            return;
        }
        self.meetings.push(Meeting { finer: leaf, coarser: self.number });
        if finest > self.view.finest_in_reach {
            let levels = survey.leaves[leaf as usize].levels;
            let own = self.cells.refined([2; 3]);
            let finer = (self.view.finest_in_reach + 1..=finest).rev().filter(|level| levels >> level & 1 == 1);
            let found = { finer }.find(|&level| survey.reach(usize::from(level), space).intersects(&own));
            self.view.finest_in_reach = found.unwrap_or(self.view.finest_in_reach);
        }
    }
}
