//! Regions sampled from both layouts, with every instruction set, against the scalar reference; pieces against samples.

use std::sync::Arc;

use amray_testing::{Random, RandomMesh, Shape, nested_cubes, noise};
use fearless_simd::prelude::*;
use proptest::prelude::*;

use super::pieces::PieceNode;
use super::*;
use crate::Volume;
use crate::hierarchy::{BrickValues, Centering, Field, FieldValues, Hierarchy, IndexBox, LevelDescription};
use crate::index::Index;
use crate::reconstruction::{Method, Sampler};
use crate::simd::{InstructionSet, Kernel, LANES};

/// Sixteen points of a region, in its local coordinates.
type LocalPoints = [[f32; LANES]; 3];

/// What is found at the points of a packet: values, values beside their gradients, and these, axis by axis.
#[derive(Clone, Copy)]
struct Found {
    values: [f32; LANES],
    values_beside: [f32; LANES],
    gradients: [[f32; LANES]; 3],
}

/// Samples a region at packets of points, without and with gradients.
struct Sampling<'a, V> {
    values: &'a V,
    region: usize,
    points: &'a [LocalPoints],
    pure: bool,
}

impl<V: RegionValues> Kernel for Sampling<'_, V> {
    type Output = Vec<Found>;

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> Self::Output {
        let Self { values, region, points, pure } = self;
        let mut samples = Vec::with_capacity(points.len());
        for [x, y, z] in points {
            let mut point = [Floats::splat(simd, 0.0); 3];
            for (axis, lanes) in [x, y, z].into_iter().enumerate() {
                point[axis] = Floats::from_slice(simd, lanes);
            }
            let all = Mask::splat(simd, true);
            let (alone, both) = match pure {
                true => (values.pure(simd, region, point), values.pure_with_gradient(simd, region, point)),
                false => {
                    (values.anywhere(simd, region, point, all), values.anywhere_with_gradient(simd, region, point, all))
                }
            };
            let [x, y, z] = both.gradients;
            samples.push(Found { values: *alone, values_beside: *both.values, gradients: [*x, *y, *z] });
        }
        samples
    }
}

/// The hierarchy of a mesh of `amray-testing`, which is built upon another copy of this crate than its own tests are.
macro_rules! own {
    ($hierarchy:expr) => {{
        let other = $hierarchy;
        let levels = other.levels().iter().map(|level| LevelDescription {
            ratio: level.ratio(),
            cell_size: level.cell_size(),
            domain: IndexBox::new(level.domain().low, level.domain().high),
            bricks: level.bricks().iter().map(|brick| IndexBox::new(brick.low, brick.high)).collect(),
        });
        Hierarchy::new(other.origin(), levels.collect()).unwrap()
    }};
}

fn random_mesh(seed: u64, random: &mut Random) -> Hierarchy {
    own!(RandomMesh::new(random, Shape::any(seed)).cut(random))
}

/// A mesh and its values, at cells and at nodes, from which a volume can be made for each method.
struct Case {
    index: Arc<Index>,
    cells: Field,
    nodes: Field,
}

/// Those that can be chosen, and that of node-centred fields.
fn methods() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().chain([Method::Nodal])
}

impl Case {
    fn new(hierarchy: Hierarchy, value: impl Fn(usize, [i64; 3]) -> f64) -> Self {
        let field = |centering| Field::centered_from_fn("value", centering, &hierarchy, &value);
        let (cells, nodes) = (field(Centering::Cells), field(Centering::Nodes));
        Self { index: Arc::new(Index::build(Arc::new(hierarchy))), cells, nodes }
    }

    fn volume(&self, method: Method) -> Volume {
        let field = match method.centering() {
            Centering::Cells => &self.cells,
            Centering::Nodes => &self.nodes,
        };
        Volume::new(self.index.clone(), field.clone(), method)
    }

    /// Holds both layouts, for every method, against the reference at some points of every region, with a share of
    /// `on_faces` of their coordinates on the region's faces.
    fn check(&self, random: &mut Random, on_faces: f64) -> Result<(), TestCaseError> {
        for method in methods() {
            let volume = self.volume(method);
            let sampler = &volume.packet_sampler();
            let padded = PaddedValues::new(volume.padded(), sampler);
            self.check_values("padded", &volume, &padded, (random, on_faces))?;
            let in_place = InPlace { plan: volume.in_place(), sampler };
            self.check_values("in place", &volume, &in_place, (random, on_faces))?;
        }
        Ok(())
    }

    fn check_values(
        &self,
        layout: &str,
        volume: &Volume,
        values: &impl RegionValues,
        (random, on_faces): (&mut Random, f64),
    ) -> Result<(), TestCaseError> {
        let method = volume.method();
        let reference = Sampler::new(&self.index, bricks(volume), method);
        let (normalisation, width) = (volume.normalisation(), width(volume));
        let places = region_places(&self.index);
        for (region, cells) in self.index.region_boxes().into_iter().enumerate() {
            let frame = values.frame(region);
            let Some(level) = frame.level else { continue };
            let size = values.finest_cells(level);
            let cell_size = self.index.hierarchy().levels()[usize::from(level)].cell_size();
            let place = |local: [f64; 3]| -> [f64; 3] {
                std::array::from_fn(|axis| (local[axis] + frame.low[axis]) * size[axis])
            };
            // On a high face, the reference would find what lies beyond: perhaps a hole.
            let [first, last] = &places[region];
            let inside = |point: [f64; 3]| -> [f64; 3] {
                std::array::from_fn(|axis| point[axis].max(first[axis]).min(last[axis]))
            };
            let corner = |corner: [i64; 3]| -> [f64; 3] {
                std::array::from_fn(|axis| corner[axis] as f64 / size[axis] - frame.low[axis])
            };
            let whole = [corner(cells.low), corner(cells.high)];
            let pure = frame.pure.map(|corner| corner.map(f64::from));
            // Others' weights change by one per cell, or by a few per cell of the next finer level.
            let steepest = if method == Method::Finest { *size } else { [1.0; 3] };
            let jumps = method == Method::Nearest;
            let on_faces = if jumps { 0.0 } else { on_faces };
            for (limits, is_pure) in [(whole, false), (if frame.is_pure { whole } else { pure }, true)] {
                if limits[0][0].is_infinite() {
                    continue;
                }
                let points: Vec<LocalPoints> = (0..2).map(|_| random_points(random, limits, on_faces)).collect();
                for set in InstructionSet::available() {
                    let found = set.run(Sampling { values, region, points: &points, pure: is_pure });
                    for (points, found) in points.iter().zip(found) {
                        for lane in 0..LANES {
                            let local: [f64; 3] = std::array::from_fn(|axis| f64::from(points[axis][lane]));
                            let point = place(local);
                            let expected = reference.sample_in(region, inside(point));
                            let place_of = || {
                                format!(
                                    "{method}, {layout}, {}, pure {is_pure}, region {region} of level {level} at \
                                     {point:?} ({local:?} in {limits:?})",
                                    set.name()
                                )
                            };
                            for value in [found.values[lane], found.values_beside[lane]] {
                                let value = normalisation.undo(value);
                                let agree = |expected: f64| (value - expected).abs() <= 1e-5 * width;
                                // Next to holes values may jump on a high face (where a dual cell begins that has
                                // other cells): both that from inside and that on the face itself are right.
                                let same = agree(expected)
                                    || !value.is_finite() && !expected.is_finite()
                                    || inside(point) != point && agree(reference.sample_in(region, point))
                                    || jumps && near_a_cell_face(local, frame);
                                prop_assert!(same, "{}: {value}, not {expected}", place_of());
                            }
                            // On high faces a brick or a region alone does not know the slopes beyond; next to holes there
                            // may be none.
                            let on_high_face = (0..3).any(|axis| local[axis] >= limits[1][axis]);
                            let slopes = found.gradients.map(|axis| f64::from(axis[lane]));
                            let is_none = slopes.iter().any(|slope| slope.is_nan());
                            if !expected.is_finite() || on_high_face || is_none && is_on_kink(point) {
                                continue;
                            }
                            let gradient = |local: [f64; 3]| -> [[f64; 3]; 2] {
                                [inside(place(local)), place(local)].map(|point| {
                                    let slopes = reference.sample_in_with_gradient(region, point).gradient;
                                    std::array::from_fn(|axis| slopes[axis] * cell_size[axis] * normalisation.scale)
                                })
                            };
                            let rounding = rounding_of_weights(point, local, size);
                            let is_among = |around: &[_]| is_among(slopes, around, steepest, rounding);
                            let same = is_among(&gradient(local))
                                || is_among(&beside(local).flat_map(gradient).collect::<Vec<_>>());
                            prop_assert!(same, "{}: slopes are {slopes:?}, not {:?}", place_of(), gradient(local)[0]);
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

fn bricks(volume: &Volume) -> &[BrickValues<f64>] {
    match volume.field().values() {
        FieldValues::F64(bricks) => bricks,
        FieldValues::F32(_) => unreachable!("the cases hold f64"),
    }
}

/// The width of the field's range.
fn width(volume: &Volume) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for brick in bricks(volume) {
        brick.for_each([0; 3], brick.size(), |value| {
            if value.is_finite() {
                (low, high) = (low.min(value), high.max(value));
            }
        });
    }
    high - low
}

/// Whether slopes, in units of the range per cell, are among those `around` them but for what single precision makes of
/// them: they are sums of products, each rounded to 1e-7 of itself, whose weights change by up to `steepest` per cell
/// and may all be off by a share of `rounding`.
fn is_among(found: [f64; 3], around: &[[f64; 3]], steepest: [f64; 3], rounding: f64) -> bool {
    (0..3).all(|axis| {
        let slopes = || around.iter().map(|slopes| slopes[axis]).filter(|slope| slope.is_finite());
        let (low, high) = (slopes().fold(f64::INFINITY, f64::min), slopes().fold(f64::NEG_INFINITY, f64::max));
        let most = |slope: f64| 1e-5 * (1.0 + slope.abs()) + 2e-6 * steepest[axis] + rounding;
        low - most(low) <= found[axis] && found[axis] <= high + most(high)
    })
}

/// Whether a point lies where weights begin or end: next to a hole, slopes there may be none.
fn is_on_kink(point: [f64; 3]) -> bool {
    point.iter().any(|place| (2.0 * place).fract() == 0.0)
}

/// The largest share by which a weight may be off at a point: weights begin and end on faces and centres of cells of
/// any level, whose places in cells of another are thirds or so, rounded like any number as large; the nearer, the
/// more of the weight that is. Those that the point lies on do not count: weights that begin there are exactly 0.
fn rounding_of_weights(point: [f64; 3], local: [f64; 3], finest_cells: &[f64; 3]) -> f64 {
    let share = |axis: usize| {
        let halves = 2.0 * point[axis];
        let distance = match (halves - halves.round()).abs() / 2.0 {
            0.0 => 0.25,
            distance => distance,
        };
        NEAR * (1.0 + local[axis].abs()) * finest_cells[axis] / distance
    };
    share(0).max(share(1)).max(share(2))
}

/// What rounding to single precision changes numbers by, as a share of them.
const NEAR: f64 = 1.2e-7;

/// A point, and those to which rounding may take it: to where slopes are a little other, or over a kink, beyond which they
/// are others altogether. Half cells are exact: on a kink that they are on, the slopes of the high side count.
fn beside(local: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    let step = |axis: usize| match local[axis] {
        place if (2.0 * place).fract() == 0.0 => 0.0,
        place => NEAR * (1.0 + place.abs()),
    };
    let steps = [step(0), step(1), step(2)];
    let place = move |number: i32, axis: usize| {
        local[axis] + steps[axis] * f64::from([0, -1, 1][(number / 3i32.pow(axis as u32) % 3) as usize])
    };
    (0..27).map(move |number| [place(number, 0), place(number, 1), place(number, 2)])
}

/// Whether rounding may take a point into another cell.
fn near_a_cell_face(local: [f64; 3], frame: &RegionFrame) -> bool {
    (0..3).any(|axis| {
        let cells = local[axis] + frame.low[axis];
        (cells - cells.round()).abs() < 1e-4
    })
}

/// Points of a box, with a share of `on_faces` of their coordinates on its faces.
fn random_points(random: &mut Random, [low, high]: [[f64; 3]; 2], on_faces: f64) -> LocalPoints {
    let mut points = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            let share = random.unit();
            let on_face = random.chance(on_faces);
            let share = if on_face { share.round() } else { 0.001 + 0.998 * share };
            let place = (low[axis] + (high[axis] - low[axis]) * share) as f32;
            // Not by chance where cells of some level have their centres: beside it a weight is 0.
            let beside_centres = if (place * 256.0).fract() == 0.0 { place.next_up() } else { place };
            points[axis][lane] = if on_face { place } else { beside_centres };
        }
    }
    points
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn regions_are_sampled_like_points_one_by_one(seed: u64) {
        let mut random = Random(seed);
        Case::new(random_mesh(seed, &mut random), noise).check(&mut random, 0.2)?;
    }

    #[test]
    fn cells_without_a_number_touch_the_same_points(seed: u64) {
        let mut random = Random(seed);
        let case = Case::new(random_mesh(seed, &mut random), |level, cell| match noise(level, cell) {
            value if value < 0.03 => f64::NAN,
            value if value < 0.04 => f64::INFINITY,
            value => value,
        });
        // Not on faces: where a weight is 0, what is no number may or may not take part.
        case.check(&mut random, 0.0)?;
    }

    #[test]
    fn offsets_and_magnitudes_cost_no_digits(seed: u64) {
        let mut random = Random(seed);
        let mesh = random_mesh(seed, &mut random);
        for (offset, scale) in [(1e6, 1.0), (-1e9, 1.0), (0.0, 1e80), (1e80, 1e72), (0.0, 1e-60)] {
            Case::new(mesh.clone(), |level, cell| offset + scale * noise(level, cell)).check(&mut random, 0.2)?;
        }
    }

    #[test]
    fn pieces_fill_regions_and_bound_their_samples(seed: u64) {
        let mut random = Random(seed);
        let case = Case::new(random_mesh(seed, &mut random), |level, cell| match noise(level, cell) {
            value if seed.is_multiple_of(2) && value < 0.02 => f64::NAN,
            value => value,
        });
        for method in methods() {
            let volume = case.volume(method);
            check_pieces(&case, &volume, &volume.padded().pieces, &mut random)?;
            check_pieces(&case, &volume, &volume.in_place().pieces, &mut random)?;
        }
    }
}

/// Holds a tree of pieces against samples in each of them.
fn check_pieces(case: &Case, volume: &Volume, nodes: &[PieceNode], random: &mut Random) -> Result<(), TestCaseError> {
    let boxes = case.index.region_boxes();
    let mut filled = vec![0; boxes.len()];
    let mut visited = 0;
    let mut stack = vec![(0usize, case.index.domain())];
    let reference = Sampler::new(&case.index, bricks(volume), volume.method());
    while let Some((place, cells)) = stack.pop() {
        let node = &nodes[place];
        visited += 1;
        if let Some(region) = node.region {
            let region = region as usize;
            prop_assert!(boxes[region].contains_box(&cells), "a piece outside its region");
            let corners = [cells.low, cells.high].map(|corner| corner.map(|cell| cell as f64));
            for _ in 0..4 {
                let value = reference.sample_in(region, random.point(corners));
                let unit = f64::from(volume.normalisation().apply(value));
                let [low, high] = node.range.map(f64::from);
                let inside = low - 1e-6 <= unit && unit <= high + 1e-6;
                prop_assert!(inside || !value.is_finite(), "{}: {unit} not in {low} to {high}", volume.method());
            }
        }
        match node.cut {
            Some(cut) => {
                let axis = usize::from(cut.axis);
                prop_assert!(cells.low[axis] < cut.plane && cut.plane < cells.high[axis], "a cut outside its node");
                let (mut below, mut above) = (cells, cells);
                below.high[axis] = cut.plane;
                above.low[axis] = cut.plane;
                for (child, part) in [(place + 1, below), (cut.high as usize, above)] {
                    prop_assert!(node.region.is_none() || nodes[child].region == node.region);
                    prop_assert!(nodes[child].range[0] >= node.range[0] && nodes[child].range[1] <= node.range[1]);
                    prop_assert!(nodes[child].roughness <= node.roughness);
                    stack.push((child, part));
                }
            }
            None => filled[node.region.unwrap() as usize] += cells.cells(),
        }
    }
    prop_assert_eq!(visited, nodes.len());
    for (filled, cells) in filled.into_iter().zip(&boxes) {
        prop_assert_eq!(filled, cells.cells());
    }
    Ok(())
}

#[test]
fn twenty_levels_keep_their_digits() {
    Case::new(own!(nested_cubes(20)), noise).check(&mut Random(5), 0.2).unwrap();
}

#[test]
fn bricks_of_one_cell_have_neighbours_too() {
    // A slab one cell thin, a row of cells and a single one, all next to each other.
    let boxes = [([0, 0, 0], [4, 4, 1]), ([0, 0, 1], [1, 1, 4]), ([2, 3, 2], [3, 4, 3]), ([3, 3, 2], [4, 4, 3])];
    let level = |ratio: i64, bricks: &[([i64; 3], [i64; 3])]| LevelDescription {
        ratio: [ratio; 3],
        cell_size: [1.0 / ratio as f64, 0.5 / ratio as f64, 2.0 / ratio as f64],
        domain: IndexBox::new([0; 3], [4 * ratio; 3]),
        bricks: bricks.iter().map(|&(low, high)| IndexBox::new(low, high)).collect(),
    };
    let holes = Hierarchy::new([0.0; 3], vec![level(1, &boxes)]).unwrap();
    let whole = Hierarchy::new([0.0; 3], vec![level(1, &[([0; 3], [4; 3])]), level(3, &[([3, 3, 6], [6, 6, 9])])]);
    for hierarchy in [holes, whole.unwrap()] {
        Case::new(hierarchy, noise).check(&mut Random(7), 0.2).unwrap();
    }
}

#[test]
fn coarse_cells_reach_into_holes() {
    // Both levels end at the same hole: beyond, level 1 has what level 0 makes of it.
    let level = |ratio: i64, low: [i64; 3], high: [i64; 3]| LevelDescription {
        ratio: [ratio; 3],
        cell_size: [1.0 / ratio as f64; 3],
        domain: IndexBox::new([0; 3], [4 * ratio; 3]),
        bricks: vec![IndexBox::new(low, high)],
    };
    let levels = vec![level(1, [0; 3], [2, 4, 4]), level(2, [2, 0, 0], [4, 8, 8])];
    let mesh = Hierarchy::new([0.0; 3], levels).unwrap();
    for seed in 0..8 {
        Case::new(mesh.clone(), noise).check(&mut Random(seed), 0.2).unwrap();
    }
}
