//! How to evaluate a method inside each region from padded bricks: where its finest brick alone is enough, and which
//! other bricks take part in the rest of it.

use rayon::prelude::*;

use super::super::{NO_BOX, RegionFrame, region_places};
use crate::hierarchy::IndexBox;
use crate::index::{Index, Neighbour, Region, out_of_reach};
use crate::reconstruction::Method;

/// How samples outside a region's pure box are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Combination {
    /// From the region's finest brick alone.
    Single,
    /// The hats of all flagged cells, normalised.
    Basis,
    /// Level by level from fine to coarse, each as far as its cells are flagged.
    Layered,
    /// By queries.
    Queried,
}

impl Combination {
    fn of(method: Method) -> Self {
        match method {
            Method::Nearest | Method::Current | Method::Nodal => Self::Single,
            Method::Basis => Self::Basis,
            Method::Blend | Method::Prolong => Self::Layered,
            Method::Finest | Method::Octant => Self::Queried,
        }
    }
}

/// All regions' plans for one method.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) method: Method,
    pub(crate) combination: Combination,
    pub(crate) regions: Vec<RegionPlan>,
    /// The regions' other bricks, one list after the other.
    others: Vec<OtherBrick>,
    /// Per level, cells of the finest level per cell.
    pub(crate) finest_cells: Vec<[f64; 3]>,
    /// The regions' first and last places, where queries are asked.
    pub(crate) places: Vec<[[f64; 3]; 2]>,
}

/// A padded brick. Padded coordinates count its values per axis from 0, padding included.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PaddedBrick {
    /// Where its values start.
    pub(crate) start: usize,
    /// Distances between neighbours in y and z.
    pub(crate) strides: [i32; 2],
    /// The highest values from which a dual cell starts: the number of values without padding.
    pub(crate) values: [i32; 3],
}

/// How to evaluate a method inside one region.
#[derive(Clone, Debug, Default)]
pub(crate) struct RegionPlan {
    pub(crate) brick: PaddedBrick,
    pub(crate) frame: RegionFrame,
    /// The place of the first other brick, the number of those finer than the region, and of all.
    pub(crate) first_other: u32,
    pub(crate) finer: u16,
    pub(crate) count: u16,
}

/// A brick of another level that takes part in a region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OtherBrick {
    pub(crate) brick: PaddedBrick,
    pub(crate) level: u8,
    pub(crate) axes: [OtherAxis; 3],
    /// Where its cells are in reach, and a little more, in the region's padded coordinates.
    pub(crate) reach: [[f32; 3]; 2],
}

/// From a region's padded coordinates to those of an [`OtherBrick`], along one axis: the brick's are
/// `origin + (multiple * local + shift) / parts`, where all four are whole numbers or halves that `f32` holds exactly.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OtherAxis {
    /// Cells of the brick per cell of the region; 1 where those are larger.
    pub(crate) multiple: f32,
    /// Cells of the region per cell of the brick; 1 where those are larger.
    pub(crate) parts: f32,
    /// A cell of the brick near the region.
    pub(crate) origin: f32,
    pub(crate) shift: f32,
}

impl OtherAxis {
    /// The region's padded coordinate of a place of the brick's.
    fn undo(&self, place: f64) -> f64 {
        let [multiple, parts, origin, shift] = [self.multiple, self.parts, self.origin, self.shift].map(f64::from);
        ((place - origin) * parts - shift) / multiple
    }

    /// The brick's padded coordinate of a place.
    pub(crate) fn apply(&self, local: f64) -> f64 {
        let [multiple, parts, origin, shift] = [self.multiple, self.parts, self.origin, self.shift].map(f64::from);
        origin + (multiple * local + shift) / parts
    }
}

impl Plan {
    /// Plans every region; `starts` are those of the padded bricks.
    pub(crate) fn new(index: &Index, method: Method, starts: &[usize]) -> Self {
        let planner = Planner { index, method, combination: Combination::of(method), starts };
        let boxes = index.region_boxes();
        let planned: Vec<(RegionPlan, Vec<OtherBrick>)> =
            boxes.par_iter().enumerate().map(|(number, cells)| planner.region(number, cells)).collect();
        let mut regions = Vec::with_capacity(planned.len());
        let mut others = Vec::new();
        for (mut region, bricks) in planned {
            region.first_other = others.len() as u32;
            regions.push(region);
            others.extend(bricks);
        }
        let finest_cells =
            index.hierarchy().levels().iter().map(|level| level.finest_cells().map(|cells| cells as f64));
        let combination = planner.combination;
        let places = if combination == Combination::Queried { region_places(index) } else { Vec::new() };
        Self { method, combination, regions, others, finest_cells: finest_cells.collect(), places }
    }

    /// Whether the regions' bricks hold all values that samples can touch.
    pub(crate) fn is_complete(&self) -> bool {
        self.combination != Combination::Queried
    }

    /// The bricks of other levels in a region, from fine to coarse: those finer than the region, and the coarser ones.
    #[inline(always)]
    pub(crate) fn others(&self, region: &RegionPlan) -> [&[OtherBrick]; 2] {
        let (first, finer) = (region.first_other as usize, usize::from(region.finer));
        let others = &self.others[first..first + usize::from(region.count)];
        [&others[..finer], &others[finer..]]
    }

    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(&*self.regions) + size_of_val(&*self.others) + size_of_val(&*self.places)) as u64
    }
}

struct Planner<'a> {
    index: &'a Index,
    method: Method,
    combination: Combination,
    starts: &'a [usize],
}

impl Planner<'_> {
    fn region(&self, number: usize, cells: &IndexBox) -> (RegionPlan, Vec<OtherBrick>) {
        let region = &self.index.regions()[number];
        let Some((level, place)) = region.finest_level().and_then(|level| self.index.finest_brick(region, level))
        else {
            return (RegionPlan::default(), Vec::new());
        };
        let brick = self.brick(level, place);
        let low = self.low(level, place);
        // In half cells of the finest level.
        let whole = cells.refined([2; 3]);
        let (mut neighbours, mut beside_hole) = (Vec::new(), false);
        let mut others = self.covering(region, level);
        self.for_each_neighbour(region, level, cells, &mut |other, other_cells| {
            let closest = self.index.finest_brick(other, level).map(|(closest, _)| closest);
            if let Some(reach) = self.impure_reach(level, other, closest) {
                let reach = self.index.reach(reach, other_cells);
                if reach.intersects(&whole) {
                    neighbours.push(Neighbour::new(reach, other_cells, cells));
                }
                beside_hole |= closest.is_none() && reach.grown([1; 3]).intersects(&whole);
            }
            for other_level in self.combined_levels(region, level) {
                if (other_level > level || !region.has_level(other_level))
                    && other.has_level(other_level)
                    && self.index.reach(other_level, other_cells).intersects(&whole)
                    && let Some((_, place)) = self.index.finest_brick(other, other_level)
                {
                    others.push((other_level, place));
                }
            }
        });
        let pure = out_of_reach(whole, &mut neighbours);
        others.sort_unstable_by_key(|&(level, place)| (std::cmp::Reverse(level), place));
        others.dedup();
        let size = self.finest_cells(level);
        // On a face, or where rounding has led over it, a dual cell beyond would begin, perhaps in a hole.
        const INSIDE: f64 = 1e-3;
        let padded = |corner: [i64; 3], inward: f64| -> [f32; 3] {
            std::array::from_fn(|axis| (corner[axis] as f64 / (2 * size[axis]) as f64 - low[axis] + inward) as f32)
        };
        let inside = [padded(pure.low, INSIDE), padded(pure.high, -INSIDE)];
        let is_empty = pure.is_empty() || (0..3).any(|axis| inside[1][axis] <= inside[0][axis]);
        let plan = RegionPlan {
            brick,
            frame: RegionFrame {
                level: Some(level as u8),
                low,
                pure: if is_empty { NO_BOX } else { inside },
                is_pure: pure == whole && !beside_hole,
            },
            first_other: 0,
            finer: others.iter().filter(|other| other.0 > level).count() as u16,
            count: others.len() as u16,
        };
        (plan, others.into_iter().map(|(other, place)| self.other(level, low, other, place)).collect())
    }

    /// The coarser bricks that cover a region and take part in it.
    fn covering(&self, region: &Region, level: usize) -> Vec<(usize, usize)> {
        let coarser = self.combined_levels(region, level).filter(|&other| other < level && region.has_level(other));
        coarser.filter_map(|other| self.index.finest_brick(region, other)).collect()
    }

    /// The levels, besides its own, whose cells samples in a region may have to look at.
    fn combined_levels(&self, region: &Region, level: usize) -> impl Iterator<Item = usize> + use<> {
        let levels = match self.combination {
            Combination::Single | Combination::Queried => level..level,
            Combination::Basis => region.coarsest_in_reach()..region.finest_in_reach() + 1,
            Combination::Layered => 0..region.finest_in_reach() + 1,
        };
        levels.filter(move |&other| other != level)
    }

    /// The level whose half cell is how far a neighbour, which has `closest` instead of cells of `level`, keeps a region
    /// of that level from being pure. `None` where it does not matter.
    fn impure_reach(&self, level: usize, other: &Region, closest: Option<usize>) -> Option<usize> {
        let finest = other.finest_level().unwrap_or(level);
        match self.method {
            Method::Nearest | Method::Nodal => None,
            _ if closest.is_none() => Some(level),
            Method::Current => None,
            Method::Finest => (finest > level).then_some(self.index.hierarchy().finest_level()),
            // Whichever cells are larger: a fine neighbour covers cells of this level.
            Method::Basis | Method::Octant => (finest != level).then_some(level.min(finest)),
            // Also where finer bricks lie beside this level instead of on it.
            Method::Blend | Method::Prolong if closest != Some(level) => Some(level),
            Method::Blend | Method::Prolong => (level + 1..=finest).find(|&finer| other.has_level(finer)),
        }
    }

    /// Calls `visit` with every region whose cells may be in reach of a region of `level` and with its box.
    fn for_each_neighbour(
        &self,
        region: &Region,
        level: usize,
        cells: &IndexBox,
        visit: &mut impl FnMut(&Region, &IndexBox),
    ) {
        let coarsest = match self.combination {
            Combination::Single => level,
            // Also levels that finer ones cover take part, but bricks over the region have all that they need.
            Combination::Layered => (0..level).find(|&coarser| !region.has_level(coarser)).unwrap_or(level),
            Combination::Basis | Combination::Queried => level.min(region.coarsest_in_reach()),
        };
        let halves = if self.index.may_cover_partly() { 3 } else { 1 };
        // Holes matter that only touch what is in reach.
        let margin = self.finest_cells(coarsest).map(|cells| halves * cells / 2 + 1);
        self.index.for_each_region_in(&cells.grown(margin), &mut |number, shared| {
            // What is shared is enough: the rest of the neighbour is out of reach.
            visit(&self.index.regions()[number], &shared);
        });
    }

    fn other(&self, level: usize, low: [f64; 3], other: usize, place: usize) -> OtherBrick {
        let (size, other_size) = (self.finest_cells(level), self.finest_cells(other));
        let other_low = self.low(other, place);
        let axis = |axis: usize| {
            let (multiple, parts) = ((size[axis] / other_size[axis]).max(1), (other_size[axis] / size[axis]).max(1));
            let (multiple, parts) = (multiple as f64, parts as f64);
            // In whole cells and the rest: both are exact, however many levels lie between.
            let shift = low[axis] * multiple - other_low[axis] * parts;
            let origin = (shift / parts).floor();
            OtherAxis {
                multiple: multiple as f32,
                parts: parts as f32,
                origin: origin as f32,
                shift: (shift - origin * parts) as f32,
            }
        };
        let (brick, axes) = (self.brick(other, place), [axis(0), axis(1), axis(2)]);
        // More than what rounding makes of places.
        const MARGIN: f64 = 1e-2;
        let reach = [
            std::array::from_fn(|axis| (axes[axis].undo(0.0) - MARGIN) as f32),
            std::array::from_fn(|axis| (axes[axis].undo(f64::from(brick.values[axis]) + 1.0) + MARGIN) as f32),
        ];
        OtherBrick { brick, level: other as u8, axes, reach }
    }

    fn brick(&self, level: usize, place: usize) -> PaddedBrick {
        let cells = self.index.hierarchy().levels()[level].brick_at(place);
        let values = self.method.centering().values_of(&cells).size().map(|values| values as i32);
        let row = values[0] + 2;
        PaddedBrick { start: self.starts[place], strides: [row, row * (values[1] + 2)], values }
    }

    /// Where a brick's padded coordinates are 0, in cells of its level: at the first padding value.
    fn low(&self, level: usize, place: usize) -> [f64; 3] {
        let first = self.method.centering().place() - 1.0;
        self.index.hierarchy().levels()[level].brick_at(place).low.map(|cell| cell as f64 + first)
    }

    fn finest_cells(&self, level: usize) -> [i64; 3] {
        self.index.hierarchy().levels()[level].finest_cells()
    }
}
