//! Sixteen values at once: packets of points that go down the kd-tree together (section 5.3 of the paper).
//!
//! A packet first finds the region of each of its points. Points in the interior of their region are one trilinear
//! interpolation in its finest brick, on the spot; the others ask for the eight corners of their dual cells, level by
//! level, all of one level in one descent. Values become single precision as they are read, normalised to their range;
//! weights are single precision from double-precision positions. [`Sampler`] is the reference, and takes over the few
//! points that do not fit.

mod any;
mod basis;
mod blend;
mod dual_cell;
mod level;
mod number;
mod octant;
mod prolong;

use fearless_simd::prelude::*;

use super::{Method, Sampler};
use crate::hierarchy::{BrickValues, LaneNormalisation, LaneValues, Normalisation, Voxel};
use crate::index::{Index, PacketCells, PointDescent, Region};
use crate::simd::{Doubles, Floats, Gather, InstructionSet, Integers, Kernel, LANES, LaneSet, Mask, lanes_of, mask_of};

pub(crate) use any::AnySampler;
use level::PacketLevel;
pub(crate) use number::{LaneNumber, ValuesAndGradients, linear_weights, made_whole};

/// Sixteen points, axis by axis, in cells of the finest level.
pub type PacketPoints = [[f64; LANES]; 3];

/// Sixteen gradients, axis by axis: normalised values per cell of the finest level.
pub type PacketGradients = [[f32; LANES]; 3];

/// Evaluates one method over one field, sixteen points at a time.
///
/// Values are normalised: a finite result `u` stands for the value [`Normalisation::undo`] gives. They are as exact as
/// single precision is for a number between those that take part, the normalisation's `low` among them.
#[derive(Clone, Debug)]
pub struct PacketSampler<'a, T> {
    index: &'a Index,
    /// None where the reference has to do all.
    levels: Vec<PacketLevel>,
    bricks: Vec<LaneValues<'a, T>>,
    normalisation: LaneNormalisation,
    reference: Sampler<'a, T>,
    /// Where the domain begins and ends per axis, in cells of the finest level.
    domain: [[f64; 2]; 3],
}

/// What [`PacketSampler::sample_packets`] finds at sixteen points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PacketSamples {
    /// The normalised values; NaN in holes and where a non-finite cell takes part.
    pub values: [f32; LANES],
    /// The level of each point's leaf cell; -1 in holes.
    pub levels: [i32; LANES],
}

/// Packets that are sampled one after the other.
struct Packets<'s, 'a, T, R> {
    sampler: &'s PacketSampler<'a, T>,
    packets: &'s [PacketPoints],
    samples: &'s mut [R],
}

impl<T: Voxel, R: Record> Kernel for Packets<'_, '_, T, R> {
    type Output = ();

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) {
        for (points, samples) in self.packets.iter().zip(self.samples) {
            *samples = R::of(self.sampler.sample(simd, points, Mask::splat(simd, true)));
        }
    }
}

/// What is handed out about a packet.
trait Record {
    /// What packets compute with to find it.
    type Number<S: Gather>: LaneNumber<S>;

    fn of<S: Gather>(samples: Samples<S, Self::Number<S>>) -> Self;
}

impl Record for PacketSamples {
    type Number<S: Gather> = Floats<S>;

    #[inline(always)]
    fn of<S: Gather>(Samples { values, levels }: Samples<S, Floats<S>>) -> Self {
        Self { values: *values, levels: *levels }
    }
}

impl Record for (PacketSamples, PacketGradients) {
    type Number<S: Gather> = ValuesAndGradients<S>;

    #[inline(always)]
    fn of<S: Gather>(Samples { values, levels }: Samples<S, ValuesAndGradients<S>>) -> Self {
        let ValuesAndGradients { values, gradients: [x, y, z] } = values;
        (PacketSamples { values: *values, levels: *levels }, [*x, *y, *z])
    }
}

/// What a packet of points has found.
#[derive(Clone, Copy)]
pub(crate) struct Samples<S: Gather, N> {
    /// The normalised values; NaN in holes, in lanes that were not asked for, and where a non-finite cell takes part.
    pub(crate) values: N,
    /// The level of each point's leaf cell; -1 in holes and in lanes that were not asked for.
    pub(crate) levels: Integers<S>,
}

/// A packet on its way.
struct Packet<S: Gather, N> {
    /// In cells of the finest level, inside the domain.
    points: [Doubles<S>; 3],
    /// Slopes are per cell of the finest level.
    values: N,
    /// Of the leaf cells; -1 in holes.
    levels: Integers<S>,
    /// The levels in reach of each point, coarsest and finest.
    reach: [Integers<S>; 2],
}

impl<'a, T: Voxel> PacketSampler<'a, T> {
    /// A sampler of the values in `bricks`, one for each brick of the index's hierarchy.
    ///
    /// # Panics
    /// Where the number of bricks differs.
    pub fn new(index: &'a Index, bricks: &'a [BrickValues<T>], method: Method, normalisation: Normalisation) -> Self {
        let hierarchy = index.hierarchy();
        assert_eq!(bricks.len(), hierarchy.brick_count(), "values of as many bricks as there are");
        let normalisation = LaneNormalisation::new(normalisation);
        let (mut levels, mut lane_values) = (Vec::new(), Vec::new());
        // What 32 bits cannot hold is left to the reference.
        if index.fits_packets() && normalisation.serves::<T>() {
            levels = hierarchy.levels().iter().map(PacketLevel::new).collect();
            let domain_low = |level: usize| hierarchy.levels()[level].domain().low;
            let bricks = hierarchy.bricks().zip(bricks);
            lane_values =
                bricks.map(|(brick, values)| LaneValues::new(values, &brick.cells, domain_low(brick.level))).collect();
        }
        let [low, high] = [index.domain().low, index.domain().high].map(|corner| corner.map(|cell| cell as f64));
        Self {
            index,
            levels,
            bricks: lane_values,
            normalisation,
            reference: Sampler::new(index, bricks, method),
            domain: std::array::from_fn(|axis| [low[axis], high[axis]]),
        }
    }

    /// Samples at packets of points; points outside the domain are moved to its boundary.
    ///
    /// # Panics
    /// Where there are more packets than places for their samples.
    pub fn sample_packets(&self, set: InstructionSet, packets: &[PacketPoints], samples: &mut [PacketSamples]) {
        assert!(packets.len() <= samples.len(), "{} packets, room for {}", packets.len(), samples.len());
        set.run(Packets { sampler: self, packets, samples });
    }

    /// [`sample_packets`](Self::sample_packets) with the gradients of the same function, as
    /// [`Sampler::sample_world_with_gradient`] describes them. Where a value is not finite, its gradient means nothing.
    ///
    /// # Panics
    /// Where there are more packets than places for their samples.
    pub fn sample_packets_with_gradients(
        &self,
        set: InstructionSet,
        packets: &[PacketPoints],
        samples: &mut [(PacketSamples, PacketGradients)],
    ) {
        assert!(packets.len() <= samples.len(), "{} packets, room for {}", packets.len(), samples.len());
        set.run(Packets { sampler: self, packets, samples });
    }

    /// The normalised values at any number of points, which `to_cells` turns into cells of the finest level.
    pub(crate) fn sample_points(&self, points: &[[f64; 3]], to_cells: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f32> {
        let packets: Vec<PacketPoints> = points
            .chunks(LANES)
            .map(|points| {
                let mut packet = [[0.0; LANES]; 3];
                for (lane, &point) in points.iter().enumerate() {
                    for (axis, position) in to_cells(point).into_iter().enumerate() {
                        packet[axis][lane] = position;
                    }
                }
                packet
            })
            .collect();
        let mut samples = vec![PacketSamples { values: [0.0; LANES], levels: [0; LANES] }; packets.len()];
        self.sample_packets(InstructionSet::best(), &packets, &mut samples);
        samples.iter().flat_map(|samples| samples.values).take(points.len()).collect()
    }

    /// The normalised values at the `active` points, which are moved into the domain.
    #[inline(always)]
    pub(crate) fn sample<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        points: &PacketPoints,
        active: Mask<S>,
    ) -> Samples<S, N> {
        let lanes = lanes_of(active);
        let none = Integers::splat(simd, -1);
        let [x, y, z] = self.domain;
        let mut packet = Packet {
            points: [
                Doubles::load(simd, &points[0]).clamp(simd, x),
                Doubles::load(simd, &points[1]).clamp(simd, y),
                Doubles::load(simd, &points[2]).clamp(simd, z),
            ],
            values: N::constant(Floats::splat(simd, f32::NAN)),
            levels: none,
            reach: [none; 2],
        };
        if self.levels.is_empty() {
            self.by_reference(simd, lanes, &mut packet);
        } else if lanes != 0 {
            let rest = self.sample_inside(simd, lanes, &mut packet);
            if rest != 0 {
                self.sample_across(simd, rest, &mut packet);
            }
        }
        Samples { values: packet.values, levels: packet.levels }
    }

    /// Finds the region of each point, and the values of those that need but its finest brick. Returns the other lanes.
    #[inline(always)]
    fn sample_inside<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        lanes: LaneSet,
        packet: &mut Packet<S, N>,
    ) -> LaneSet {
        let method = self.reference.method;
        let cells = self.cells(simd, packet);
        let mut rest = 0;
        let mut descent = PointDescent::new(lanes);
        while let Some((number, here)) = descent.next(simd, self.index, &cells) {
            let region = &self.index.regions()[number];
            let Some(level) = region.finest_level() else { continue };
            let mask = mask_of(simd, here);
            packet.levels = mask.select(Integers::splat(simd, level as i32), packet.levels);
            let reach = [region.coarsest_in_reach(), region.finest_in_reach()];
            for (level, levels) in reach.into_iter().zip(&mut packet.reach) {
                *levels = mask.select(Integers::splat(simd, level as i32), *levels);
            }
            let one_brick = match method {
                Method::Nearest => 0,
                Method::Finest if level + 1 < self.levels.len() => 0,
                Method::Nodal => here,
                _ => here & interior(simd, region, packet),
            };
            let mut found = 0;
            if method == Method::Nearest {
                let values = self.nearest(simd, region, level, &cells, here);
                packet.values = N::select(mask, N::constant(values), packet.values);
                found = here;
            } else if one_brick != 0 {
                let values: N = self.trilinear(simd, region, level, packet, one_brick);
                // A corner of weight zero does not take part, not even one that is not a number: the long way knows.
                found = one_brick & lanes_of(values.all_finite());
                packet.values = N::select(mask_of(simd, found), values, packet.values);
            }
            rest |= here & !found;
        }
        rest
    }

    /// Trilinear interpolation in one brick, around points in its cells from the first one's centre on. Points outside
    /// are moved inside. Slopes are per cell of the brick.
    #[inline(always)]
    pub(crate) fn in_brick<S: Gather, N: LaneNumber<S>>(&self, simd: S, brick: usize, point: [Floats<S>; 3]) -> N {
        let brick = &self.bricks[brick];
        let mut share = [N::constant(point[0]); 3];
        let mut base = [Integers::splat(simd, 0); 3];
        for axis in 0..3 {
            // The last dual cell is used to its end.
            let last = Integers::splat(simd, (brick.last()[axis] - 1).max(0));
            base[axis] = point[axis].to_int::<Integers<S>>().max(Integers::splat(simd, 0)).min(last);
            let rest = point[axis] - base[axis].to_float::<Floats<S>>();
            share[axis] = N::along(axis, rest, Floats::splat(simd, 1.0));
        }
        N::trilinear(&brick.read_dual(simd, &base, LaneSet::MAX, &self.normalisation), share)
    }

    /// Whether packets can be sampled at all, or the reference has to do everything.
    pub(crate) fn is_packed(&self) -> bool {
        !self.levels.is_empty()
    }

    /// The values of points that need more than one brick.
    #[inline(never)]
    fn sample_across<S: Gather, N: LaneNumber<S>>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S, N>) {
        simd.vectorize(
            #[inline(always)]
            || match self.reference.method {
                Method::Nearest => {}
                // Nodes of no weight that are no numbers.
                Method::Nodal => self.by_reference(simd, lanes, packet),
                Method::Finest => self.lerp_at(simd, self.levels.len() - 1, lanes, packet),
                Method::Current => {
                    let mut levels = Levels { of_lanes: packet.levels, left: lanes };
                    while let Some((level, lanes)) = levels.next(simd) {
                        self.lerp_at(simd, level, lanes, packet);
                    }
                }
                Method::Blend => self.blend(simd, lanes, packet),
                Method::Basis => self.basis(simd, lanes, packet),
                Method::Octant => self.octant(simd, lanes, packet),
                Method::Prolong => self.prolong(simd, lanes, packet),
            },
        );
    }

    /// Takes the values of `lanes` from the reference.
    #[cold]
    #[inline(never)]
    fn by_reference<S: Gather, N: LaneNumber<S>>(&self, simd: S, lanes: LaneSet, packet: &mut Packet<S, N>) {
        let points = packet.points.map(Doubles::store);
        let mut levels = *packet.levels;
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let (region, point) = self.reference.place(points.map(|axis| axis[lane]));
            packet.values.set_lane(lane, self.reference.evaluate_in(region, point), &self.normalisation);
            levels[lane] = self.index.regions()[region].finest_level().map_or(-1, |level| level as i32);
        }
        packet.levels = Integers::from_slice(simd, &levels);
    }

    /// The cells of the finest level that hold the points.
    #[inline(always)]
    fn cells<S: Gather, N>(&self, simd: S, packet: &Packet<S, N>) -> PacketCells<S> {
        let mut cells = [Integers::splat(simd, 0); 3];
        for axis in 0..3 {
            let [low, high] = self.domain[axis];
            let (cell, _) = packet.points[axis].scaled(simd, low, 1.0, 0.0).split(simd);
            // The domain's high boundary belongs to its last cells.
            cells[axis] = cell.min(Integers::splat(simd, (high - low) as i32 - 1));
        }
        cells
    }

    /// The values of the leaf cells that hold the points.
    #[inline(always)]
    fn nearest<S: Gather>(
        &self,
        simd: S,
        region: &Region,
        level: usize,
        cells: &PacketCells<S>,
        lanes: LaneSet,
    ) -> Floats<S> {
        let Some((_, brick)) = self.index.finest_brick(region, level) else { return Floats::splat(simd, f32::NAN) };
        let brick = &self.bricks[brick];
        let mut leaf = *cells;
        for axis in 0..3 {
            leaf[axis] = self.levels[level].holding(simd, axis, cells[axis]);
        }
        brick.read(simd, &leaf, lanes, &self.normalisation)
    }

    /// Trilinear interpolation in the region's finest brick, around points of the region's interior (of all the region
    /// where values lie on nodes).
    #[inline(always)]
    fn trilinear<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        region: &Region,
        level: usize,
        packet: &Packet<S, N>,
        lanes: LaneSet,
    ) -> N {
        let nothing = N::constant(Floats::splat(simd, f32::NAN));
        let Some((_, brick)) = self.index.finest_brick(region, level) else { return nothing };
        let (brick, lattice) = (&self.bricks[brick], &self.levels[level]);
        // Where the brick's first value lies.
        let center = if self.reference.method == Method::Nodal { 0.0 } else { 0.5 };
        let (mut base, mut share) = ([Integers::splat(simd, 0); 3], [nothing; 3]);
        for axis in 0..3 {
            let shift = -center - f64::from(brick.low()[axis]);
            let position = lattice.position::<S, N>(simd, axis, packet.points[axis], self.domain[axis][0], shift);
            // On the interior's high face the last dual cell is used to its end.
            let end = f64::from(brick.last()[axis]).next_down();
            let (cell, rest) = position.clamp(simd, [0.0, end]).split(simd);
            base[axis] = cell;
            share[axis] = N::along(axis, rest, Floats::splat(simd, lattice.scale(axis) as f32));
        }
        N::trilinear(&brick.read_dual(simd, &base, lanes, &self.normalisation), share)
    }
}

/// The lanes whose points lie in the region's interior.
#[inline(always)]
fn interior<S: Gather, N: LaneNumber<S>>(simd: S, region: &Region, packet: &Packet<S, N>) -> LaneSet {
    let [low, high] = region.interior();
    let mut lanes = LaneSet::MAX;
    for axis in 0..3 {
        // On the high face slopes are those of the dual cells beyond.
        let last = if N::HAS_SLOPES { high[axis].next_down() } else { high[axis] };
        lanes &= packet.points[axis].within(simd, [low[axis], last]);
    }
    lanes
}

/// The distinct levels of some lanes.
struct Levels<S: Gather> {
    of_lanes: Integers<S>,
    left: LaneSet,
}

impl<S: Gather> Levels<S> {
    /// The next level and the lanes that have it.
    #[inline(always)]
    fn next(&mut self, simd: S) -> Option<(usize, LaneSet)> {
        let level = *self.of_lanes.as_slice().get(self.left.trailing_zeros() as usize)?;
        let lanes = self.left & lanes_of(self.of_lanes.simd_eq(Integers::splat(simd, level)));
        self.left &= !lanes;
        Some((level as usize, lanes))
    }
}
