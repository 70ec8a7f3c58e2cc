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
    let mut descent = Descent::new(&survey, &mut views, 0);
    descent.descend(0, &index.domain, 0);
    let meetings = ByFiner::new(&descent.meetings, leaves.len());
    let describe = |neighbours: &mut Vec<Neighbour>, (number, view): (usize, &View)| {
        survey.region(&leaves[number], view, meetings.of(number), neighbours)
    };
    views.par_iter().enumerate().with_min_len(PARALLEL_LEAVES).map_init(Vec::new, describe).collect()
}

/// What is known while the regions are described.
struct Survey<'a> {
    index: &'a Index,
    leaves: &'a [Leaf],
    /// Per node, the coarsest level that is the finest one of some region below it.
    coarsest: Vec<u8>,
    /// Per node, the finest level below it. A hole counts as finer than every level: neighbours reach into it.
    finest: Vec<u8>,
    /// Per level, how far its cells can reach from a region's box, in cells of the finest level.
    margins: Vec<[i64; 3]>,
}

/// The level of a region without any.
const HOLE: u8 = u8::MAX;

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

/// Two leaves, the finer of which lies in reach of the coarser.
#[derive(Clone, Copy)]
struct Meeting {
    finer: u32,
    coarser: u32,
}

/// Meetings, grouped by the finer leaf.
struct ByFiner {
    /// Per leaf, where its meetings end.
    ends: Vec<usize>,
    coarser: Vec<u32>,
}

impl ByFiner {
    fn new(meetings: &[Meeting], leaves: usize) -> Self {
        let mut ends = vec![0usize; leaves + 1];
        for meeting in meetings {
            ends[meeting.finer as usize + 1] += 1;
        }
        for leaf in 0..leaves {
            ends[leaf + 1] += ends[leaf];
        }
        // Now they are starts; each moves to its end as the list fills.
        let mut coarser = vec![0; meetings.len()];
        for meeting in meetings {
            let end = &mut ends[meeting.finer as usize];
            coarser[*end] = meeting.coarser;
            *end += 1;
        }
        Self { ends, coarser }
    }

    /// The leaves that have `finer` in reach.
    fn of(&self, finer: usize) -> &[u32] {
        let start = finer.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.coarser[start..self.ends[finer]]
    }
}

impl<'a> Survey<'a> {
    fn new(index: &'a Index, leaves: &'a [Leaf]) -> Self {
        let nodes = index.nodes.len();
        let (mut coarsest, mut finest) = (vec![0; nodes], vec![0; nodes]);
        // Children follow their parents.
        for (place, node) in index.nodes.iter().enumerate().rev() {
            (coarsest[place], finest[place]) = match *node {
                Node::Leaf(leaf) => {
                    let level = leaves[leaf as usize].levels.checked_ilog2().map_or(HOLE, |level| level as u8);
                    (level, level)
                }
                Node::Inner { high, .. } => {
                    let (low, high) = (place + 1, high as usize);
                    (coarsest[low].min(coarsest[high]), finest[low].max(finest[high]))
                }
            };
        }
        // Half a cell, and where a cell may be covered in part up to one more by which a box falls short of its cells.
        let halves = if index.may_cover_partly { 3 } else { 1 };
        let margin = |level: &Level| level.finest_cells().map(|cells| (halves * cells + 1) / 2);
        let levels = index.hierarchy.levels();
        Self { index, leaves, coarsest, finest, margins: levels.iter().map(margin).collect() }
    }

    /// The number of the first leaf below a node.
    fn first_leaf(&self, mut node: usize) -> usize {
        loop {
            match self.index.nodes[node] {
                Node::Leaf(leaf) => return leaf as usize,
                Node::Inner { .. } => node += 1,
            }
        }
    }

    /// The deepest node at or below `around` that holds all of the regions below `node`, in `space`, and around them
    /// that they reach.
    fn narrowed(&self, mut around: usize, node: usize, space: &IndexBox) -> usize {
        let Some(margin) = self.margins.get(usize::from(self.coarsest[node])) else { return around };
        while let Node::Inner { axis, plane, high } = self.index.nodes[around] {
            let axis = usize::from(axis);
            if space.high[axis] + margin[axis] <= plane {
                around += 1;
            } else if space.low[axis] - margin[axis] >= plane {
                around = high as usize;
            } else {
                break;
            }
        }
        around
    }

    /// What the region of `leaf` would see if it reached nothing finer.
    fn view(&self, leaf: &Leaf, level: usize) -> View {
        let region = Region { levels: leaf.levels, first_brick: leaf.first_brick, ..Region::EMPTY };
        let Some((_, brick)) = self.index.finest_brick(&region, level) else { return View::NONE };
        let description = &self.index.hierarchy.levels()[level];
        let size = description.finest_cells();
        let brick = description.brick_at(brick).refined(size).refined([2; 3]);
        // Cells of the same level are met half a cell inside the brick's own faces.
        let interior = brick.grown(size.map(|cells| -cells)).intersection(&leaf.cells.refined([2; 3]));
        View { finest_in_reach: level as u8, interior }
    }

    /// The region of `leaf`, which the leaves `coarser` have in reach. `neighbours` is memory to use.
    fn region(&self, leaf: &Leaf, view: &View, coarser: &[u32], neighbours: &mut Vec<Neighbour>) -> Region {
        let region = Region { levels: leaf.levels, first_brick: leaf.first_brick, ..Region::EMPTY };
        let Some(level) = region.finest_level() else { return region };
        let mut coarsest_in_reach = level;
        neighbours.clear();
        for &coarser in coarser {
            let coarser = &self.leaves[coarser as usize];
            let coarser_level = coarser.levels.ilog2() as usize;
            coarsest_in_reach = coarsest_in_reach.min(coarser_level);
            let reach = self.index.reach(coarser_level, &coarser.cells);
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
    /// Memory to use.
    stack: Vec<usize>,
    found: Vec<u32>,
    neighbours: Vec<Neighbour>,
}

impl<'a> Descent<'a> {
    fn new(survey: &'a Survey<'a>, views: &'a mut [View], first: usize) -> Self {
        Self {
            survey,
            views,
            first,
            meetings: Vec::new(),
            stack: Vec::new(),
            found: Vec::new(),
            neighbours: Vec::new(),
        }
    }

    /// Surveys the regions below `node`, which fills `space`. All that they reach lies below `around`.
    fn descend(&mut self, node: usize, space: &IndexBox, around: usize) {
        let survey = self.survey;
        let around = survey.narrowed(around, node, space);
        let (axis, plane, high) = match survey.index.nodes[node] {
            Node::Leaf(leaf) => return self.look(leaf as usize, around),
            Node::Inner { axis, plane, high } => (usize::from(axis), plane, high as usize),
        };
        let (mut below, mut above) = (*space, *space);
        below.high[axis] = plane;
        above.low[axis] = plane;
        if self.views.len() > PARALLEL_LEAVES {
            let middle = survey.first_leaf(high);
            let (low_views, high_views) = self.views.split_at_mut(middle - self.first);
            let mut this = Descent::new(survey, low_views, self.first);
            let mut other = Descent::new(survey, high_views, middle);
            this.meetings = std::mem::take(&mut self.meetings);
            rayon::join(|| this.descend(node + 1, &below, around), || other.descend(high, &above, around));
            self.meetings = this.meetings;
            self.meetings.append(&mut other.meetings);
        } else {
            self.descend(node + 1, &below, around);
            self.descend(high, &above, around);
        }
    }

    /// Looks at what is finer around the region of the leaf with this number.
    fn look(&mut self, number: usize, around: usize) {
        let survey = self.survey;
        let leaf = &survey.leaves[number];
        let Some(level) = leaf.levels.checked_ilog2().map(|level| level as usize) else { return };
        let mut view = survey.view(leaf, level);
        let own = leaf.cells.refined([2; 3]);
        let reach = survey.index.reach(level, &leaf.cells);
        self.find_finer(level, &leaf.cells.grown(survey.margins[level]), around);
        self.neighbours.clear();
        for &number_of_other in &self.found {
            let other = &survey.leaves[number_of_other as usize];
            // Whichever is finer: it covers cells of this level that a dual cell would touch.
            let taken = survey.index.reach(level, &other.cells);
            if taken.intersects(&view.interior) {
                self.neighbours.push(Neighbour::new(taken, &other.cells, &leaf.cells));
            }
            // In reach: nearer than half a cell, which is the coarser region's for one and the finer's for the other.
            if other.levels != 0 && reach.intersects(&other.cells.refined([2; 3])) {
                self.meetings.push(Meeting { finer: number_of_other, coarser: number as u32 });
            }
            let more = levels_of(other.levels & (!1u64 << view.finest_in_reach));
            let touching = { more }.find(|&level| survey.index.reach(level, &other.cells).intersects(&own));
            view.finest_in_reach = touching.map_or(view.finest_in_reach, |level| level as u8);
        }
        view.interior = out_of_reach(view.interior, &mut self.neighbours);
        self.views[number - self.first] = view;
    }

    /// Finds the leaves below `around` that share cells with `cells` (of the finest level) and are finer than `level`.
    fn find_finer(&mut self, level: usize, cells: &IndexBox, around: usize) {
        let survey = self.survey;
        let finer = |node: usize| usize::from(survey.finest[node]) > level;
        self.found.clear();
        self.stack.extend(Some(around).filter(|&node| finer(node)));
        while let Some(mut node) = self.stack.pop() {
            loop {
                match survey.index.nodes[node] {
                    Node::Leaf(leaf) => {
                        self.found.push(leaf);
                        break;
                    }
                    Node::Inner { axis, plane, high } => {
                        let (low, high) = (node + 1, high as usize);
                        // Which way it goes cannot be foreseen: no branch for it.
                        let into_low = (cells.low[usize::from(axis)] < plane) & finer(low);
                        let into_high = (cells.high[usize::from(axis)] > plane) & finer(high);
                        if !(into_low | into_high) {
                            break;
                        }
                        if into_low & into_high {
                            self.stack.push(high);
                        }
                        node = if into_low { low } else { high };
                    }
                }
            }
        }
    }
}

/// The levels of a mask, from fine to coarse.
fn levels_of(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let level = mask.checked_ilog2()?;
        mask ^= 1 << level;
        Some(level as usize)
    })
}
