//! How much light arrives, on lattices of points over those parts of a volume that are seen.
//!
//! Light changes slowly where a volume is thin, and rays from every sample of every pixel to every light would find the
//! same again and again. So rays are sent from the points of a lattice, when the first ray meets a part; in between,
//! light is interpolated. Lattices are the finer, the denser the volume is.

use std::sync::OnceLock;

use fearless_simd::prelude::*;

use super::super::RenderStatistics;
use super::super::packet::PACKETS;
use super::super::traverse::Stack;
use super::occlusion::{Arriving, Asked, Kind, Numbers, Occluders, Occlusion};
use crate::appearance::PreparedTransferFunction;
use crate::hierarchy::{IndexBox, Normalisation};
use crate::index::Index;
use crate::layout::PieceNode;
use crate::scene::Lighting;
use crate::simd::{Doubles, Floats, Gather, Integers, LANES, LaneSet, Mask, mask_of};

/// The longest distance between points of a lattice, in cells.
const LONGEST: f64 = 4.0;
/// The most optical depth between two points of a lattice, where they are more than a cell apart.
const DEEPEST: f64 = 0.32;
/// Where a cell is as deep as this, its neighbours cannot tell on what side of a surface it lies: nothing there is in
/// the shadow of what is nearer than a few cells.
const OPAQUE: f64 = 1.0;
const OWN_SHADOW: f64 = 3.0;

/// In cells of the finest level.
const BESIDE: f64 = 1e-3;

/// The lattices of all parts of a volume, by the node of the tree of pieces.
pub(in super::super) struct Lattices<'a> {
    index: &'a Index,
    media: Vec<Density<'a>>,
    /// The most cells between two points.
    longest: f64,
    /// How far rays of ambient occlusion go.
    occlusion: f64,
    lattices: Vec<OnceLock<LightHere>>,
}

/// How dense parts of a volume can be.
pub(in super::super) struct Density<'a> {
    pub(in super::super) pieces: &'a [PieceNode],
    pub(in super::super) normalisation: Normalisation,
    pub(in super::super) function: PreparedTransferFunction,
}

impl Density<'_> {
    fn largest(&self, node: usize) -> f64 {
        let [low, high] = self.pieces[node].range.map(|unit| self.normalisation.undo(unit));
        self.function.max_extinction(low, high)
    }
}

impl<'a> Lattices<'a> {
    /// No lattice yet.
    pub(in super::super) fn new(
        index: &'a Index,
        media: Vec<Density<'a>>,
        lighting: &Lighting,
        samples_per_cell: f64,
    ) -> Self {
        let occlusion = lighting.ambient_occlusion.map_or(0.0, |occlusion| occlusion.distance);
        let lattices = media[0].pieces.iter().map(|_| OnceLock::new()).collect();
        Self { index, media, longest: (LONGEST / samples_per_cell).clamp(1.0, LONGEST), occlusion, lattices }
    }

    /// The light in a node that lies in one region.
    #[inline(always)]
    pub(super) fn get<S: Gather>(
        &self,
        simd: S,
        node: usize,
        occlusion: &Occlusion<impl Occluders>,
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) -> &LightHere {
        match self.lattices[node].get() {
            Some(light) => light,
            None => self.lattices[node].get_or_init(|| self.make(simd, node, occlusion, stack, statistics)),
        }
    }

    /// What arrives at `places`, in parts that rays have passed before; in others, `arriving`.
    #[inline(never)]
    pub(super) fn elsewhere<S: Gather>(
        &self,
        simd: S,
        place: &[Doubles<S>; 3],
        places: Mask<S>,
        mut arriving: Arriving<S>,
    ) -> Arriving<S> {
        simd.vectorize(
            #[inline(always)]
            || {
                let lanes = [place[0].store(), place[1].store(), place[2].store()];
                let mut left = places.to_bitmask();
                while left != 0 {
                    let lane = left.trailing_zeros() as usize;
                    left &= left - 1;
                    if let Some(light) = self.around([lanes[0][lane], lanes[1][lane], lanes[2][lane]]) {
                        let inside = light.holds(simd, place) & places;
                        arriving = Arriving::select(inside, light.arriving(simd, place), arriving);
                        left &= !inside.to_bitmask();
                    }
                }
                arriving
            },
        )
    }

    /// The light in the part that holds a place, in cells of the finest level, where a ray has met it.
    fn around(&self, place: [f64; 3]) -> Option<&LightHere> {
        let mut node = 0;
        loop {
            if let Some(light) = self.lattices[node].get() {
                return Some(light);
            }
            let cut = self.media[0].pieces[node].cut?;
            node = if place[usize::from(cut.axis)] < cut.plane as f64 { node + 1 } else { cut.high as usize };
        }
    }

    #[inline(never)]
    fn make<S: Gather>(
        &self,
        simd: S,
        node: usize,
        occlusion: &Occlusion<impl Occluders>,
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) -> LightHere {
        simd.vectorize(
            #[inline(always)]
            || {
                let cells = box_of(self.media[0].pieces, self.index.domain(), node);
                let mut lattices = [None, None];
                for (lattice, kind) in lattices.iter_mut().zip([Kind::Direct, Kind::Ambient]) {
                    let count = occlusion.tables(kind);
                    if count > 0 {
                        let lattice = lattice.insert(self.plan(node, &cells, kind, count));
                        lattice.fill(simd, kind, self.own_shadow(node), occlusion, stack, statistics);
                    }
                }
                let [direct, ambient] = lattices;
                LightHere {
                    cells: [cells.low, cells.high].map(|corner| corner.map(|cell| cell as f64)),
                    direct,
                    ambient,
                }
            },
        )
    }

    /// The level of a node's region.
    fn level(&self, node: usize) -> usize {
        let region = self.media[0].pieces[node].region.unwrap_or(0) as usize;
        self.index.regions()[region].finest_level().unwrap_or(0)
    }

    /// How many cells apart the points of a node are at most.
    fn distance(&self, node: usize, kind: Kind) -> f64 {
        let direct = (DEEPEST / self.depth_of_cell(node)).clamp(1.0, self.longest);
        match kind {
            Kind::Direct => direct,
            // It comes from everywhere and has no sharp shadows.
            Kind::Ambient => (2.0 * direct).min((self.occlusion / self.cell_size(node)).max(1.0)),
        }
    }

    /// The largest optical depth of a cell.
    fn depth_of_cell(&self, node: usize) -> f64 {
        self.media.iter().map(|medium| medium.largest(node)).sum::<f64>() * self.cell_size(node)
    }

    /// The longest side of a cell.
    fn cell_size(&self, node: usize) -> f64 {
        self.index.hierarchy().levels()[self.level(node)].cell_size().into_iter().fold(0.0, f64::max)
    }

    /// How far away what throws shadows on a node is at least, in world units.
    fn own_shadow(&self, node: usize) -> f32 {
        if self.depth_of_cell(node) >= OPAQUE { (OWN_SHADOW * self.cell_size(node)) as f32 } else { 0.0 }
    }

    fn plan(&self, node: usize, cells: &IndexBox, kind: Kind, kinds: usize) -> Lattice {
        let domain = self.index.domain();
        let cell = self.index.hierarchy().levels()[self.level(node)].finest_cells();
        let distance = self.distance(node, kind);
        let sides = cells.size().map(|side| side as f64);
        let points: [i32; 3] =
            std::array::from_fn(|axis| (sides[axis] / (cell[axis] as f64 * distance)).ceil() as i32 + 1);
        let step = std::array::from_fn(|axis| sides[axis] / f64::from(points[axis] - 1));
        let count = points.iter().map(|&count| count as usize).product::<usize>();
        Lattice {
            low: cells.low.map(|cell| cell as f64),
            step,
            points,
            inside: [domain.low.map(|cell| cell as f64 + BESIDE), domain.high.map(|cell| cell as f64 - BESIDE)],
            tables: vec![0.0; count * kinds + 1],
            kinds,
            least: if kind == Kind::Direct { 0.0 } else { -1.0 },
        }
    }
}

/// The box of a node of a tree that fills `cells`, in cells of the finest level.
fn box_of(pieces: &[PieceNode], mut cells: IndexBox, node: usize) -> IndexBox {
    let mut place = 0;
    while place != node {
        // A node with nodes below it is cut.
        let Some(cut) = pieces[place].cut else { break };
        let axis = usize::from(cut.axis);
        if node < cut.high as usize {
            place += 1;
            cells.high[axis] = cells.high[axis].min(cut.plane);
        } else {
            place = cut.high as usize;
            cells.low[axis] = cells.low[axis].max(cut.plane);
        }
    }
    cells
}

/// The light in one part of a volume.
pub(super) struct LightHere {
    /// The part, in cells of the finest level.
    cells: [[f64; 3]; 2],
    direct: Option<Lattice>,
    ambient: Option<Lattice>,
}

/// What arrives of one kind of light at points over one part of a volume.
struct Lattice {
    /// The first point, and how far it is to the next ones, in cells of the finest level.
    low: [f64; 3],
    step: [f64; 3],
    points: [i32; 3],
    /// Where rays can start: beside the domain's faces, along which rays would be neither inside nor outside.
    inside: [[f64; 3]; 2],
    /// A table of points, x fastest, per number that tells what arrives. One number more than that.
    tables: Vec<f32>,
    kinds: usize,
    /// The lowest of all such numbers; the highest is 1.
    least: f32,
}

impl LightHere {
    /// Which places lie in the part.
    #[inline(always)]
    pub(super) fn holds<S: Gather>(&self, simd: S, place: &[Doubles<S>; 3]) -> Mask<S> {
        let [low, high] = &self.cells;
        let mut lanes = LaneSet::MAX;
        for axis in 0..3 {
            lanes &= place[axis].within(simd, [low[axis], high[axis]]);
        }
        mask_of(simd, lanes)
    }

    /// What arrives at places, in cells of the finest level, in the part or right beside it.
    #[inline(always)]
    pub(super) fn arriving<S: Gather>(&self, simd: S, place: &[Doubles<S>; 3]) -> Arriving<S> {
        let mut arriving = Arriving::all(simd);
        if let Some(lattice) = &self.direct {
            lattice.look_up(simd, place, &mut arriving.direct);
        }
        if let Some(lattice) = &self.ambient {
            lattice.look_up(simd, place, &mut arriving.ambient);
        }
        arriving
    }
}

impl Lattice {
    /// Asks for the light at all points.
    #[inline(always)]
    fn fill<S: Gather>(
        &mut self,
        simd: S,
        kind: Kind,
        own_shadow: f32,
        occlusion: &Occlusion<impl Occluders>,
        stack: &mut Stack<S>,
        statistics: &mut RenderStatistics,
    ) {
        let [columns, rows, slices] = self.points.map(|count| count as usize);
        let count = columns * rows * slices;
        for first in (0..count).step_by(PACKETS * LANES) {
            let mut asked = [Asked::nothing(simd); PACKETS];
            for number in 0..PACKETS {
                let mut lanes = [[0.0; LANES]; 3];
                let mut active = 0u64;
                for lane in 0..LANES {
                    let point = first + number * LANES + lane;
                    active |= u64::from(point < count) << lane;
                    let cell = [point % columns, point / columns % rows, point / (columns * rows)];
                    for axis in 0..3 {
                        let place = self.low[axis] + cell[axis] as f64 * self.step[axis];
                        lanes[axis][lane] = place.clamp(self.inside[0][axis], self.inside[1][axis]);
                    }
                }
                for axis in 0..3 {
                    asked[number].place[axis] = Doubles::load(simd, &lanes[axis]);
                }
                asked[number].rays = Mask::from_bitmask(simd, active);
                asked[number].skipped = Floats::splat(simd, own_shadow);
            }
            let arriving = occlusion.arriving(simd, kind, &asked, stack, statistics);
            for number in 0..PACKETS {
                let start = first + number * LANES;
                let lanes = LANES.min(count.saturating_sub(start));
                if lanes == 0 {
                    break;
                }
                for table in 0..self.kinds {
                    let values: [f32; LANES] = arriving[number][table].into();
                    let place = table * count + start;
                    self.tables[place..place + lanes].copy_from_slice(&values[..lanes]);
                }
            }
        }
    }

    /// Puts what arrives at places into `numbers`.
    #[inline(always)]
    fn look_up<S: Gather>(&self, simd: S, place: &[Doubles<S>; 3], numbers: &mut Numbers<S>) {
        let (zero, one) = (Floats::splat(simd, 0.0), Floats::splat(simd, 1.0));
        let (mut cells, mut share) = ([Integers::splat(simd, 0); 3], [zero; 3]);
        for axis in 0..3 {
            let last = Floats::splat(simd, (self.points[axis] - 1) as f32);
            let from_low = (place[axis] - Doubles::splat(simd, self.low[axis])).to_floats();
            // Beside the part light goes on as it does inside.
            let point = from_low * Floats::splat(simd, self.step[axis].recip() as f32);
            let point = point.max(-one).min(last + one);
            let cell = point.floor().min(last - one).max(zero);
            share[axis] = point - cell;
            cells[axis] = cell.to_int();
        }
        let [row, slice] = [self.points[0], self.points[0] * self.points[1]];
        let base = cells[0] + cells[1] * Integers::splat(simd, row) + cells[2] * Integers::splat(simd, slice);
        let count = (slice * self.points[2]) as usize;
        for table in 0..self.kinds {
            numbers[table] = self.interpolated(simd, table * count, base, share).max(self.least).min(one);
        }
    }

    /// A table's values between eight points each.
    #[inline(always)]
    fn interpolated<S: Gather>(
        &self,
        simd: S,
        table: usize,
        base: Integers<S>,
        [x, y, z]: [Floats<S>; 3],
    ) -> Floats<S> {
        let table = &self.tables[table..];
        let [row, slice] = [self.points[0] as usize, (self.points[0] * self.points[1]) as usize];
        let mut lines = [x; 4];
        for (line, offset) in [0, row, slice, row + slice].into_iter().enumerate() {
            let [low, high] = simd.look_up_pairs(&table[offset..], base);
            lines[line] = x.mul_add(high - low, low);
        }
        let [low, high] = [y.mul_add(lines[1] - lines[0], lines[0]), y.mul_add(lines[3] - lines[2], lines[2])];
        z.mul_add(high - low, low)
    }
}
