//! Packets of sixteen points against the reference, with every instruction set.

use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::{
    BrickValues, Field, FieldValues, Hierarchy, IndexBox, LevelDescription, Normalisation, ValueBuffer, Voxel,
};
use amray::index::Index;
use amray::reconstruction::{Method, PacketPoints, PacketSampler, PacketSamples, Sampler};
use amray::simd::InstructionSet;
use amray_testing::{Random, RandomMesh, Shape, nested_cubes};
use proptest::prelude::*;

const LANES: usize = 16;

/// A hierarchy, its index, and the values of its bricks.
struct Case<T> {
    index: Index,
    bricks: Vec<BrickValues<T>>,
}

impl<T: Voxel> Case<T>
where
    FieldValues: From<Vec<BrickValues<T>>>,
{
    fn new(hierarchy: Hierarchy, value: impl Fn(usize, [i64; 3]) -> T) -> Self {
        let hierarchy = Arc::new(hierarchy);
        let bricks = hierarchy.bricks().map(|brick| {
            let values: Vec<T> = brick.cells.iter().map(|cell| value(brick.level, cell)).collect();
            BrickValues::owned(values, brick.cells.size().map(|cells| cells as usize)).unwrap()
        });
        let bricks = bricks.collect();
        Self { index: Index::build(hierarchy), bricks }
    }

    /// Holds all methods, with all instruction sets, against the reference at some packets of points.
    fn check(&self, normalisation: Normalisation, packets: &[PacketPoints]) -> Result<(), TestCaseError> {
        for method in Method::ALL {
            let reference = Sampler::new(&self.index, &self.bricks, method);
            let packed = PacketSampler::new(&self.index, &self.bricks, method, normalisation);
            for set in InstructionSet::available() {
                let nothing = PacketSamples { values: [0.0; LANES], levels: [0; LANES] };
                let mut found = vec![nothing; packets.len()];
                packed.sample_packets(set, packets, &mut found);
                let mut with_gradients = vec![(nothing, [[0.0; LANES]; 3]); packets.len()];
                packed.sample_packets_with_gradients(set, packets, &mut with_gradients);
                for ((points, found), (beside, gradients)) in packets.iter().zip(found).zip(with_gradients) {
                    for lane in 0..LANES {
                        let point = points.map(|axis| axis[lane]);
                        let expected = (reference.sample(point) - normalisation.low) * normalisation.scale;
                        for value in [found.values[lane], beside.values[lane]].map(f64::from) {
                            let same = (value - expected).abs() < 1e-5 || !value.is_finite() && !expected.is_finite();
                            prop_assert!(same, "{method}, {} at {point:?}: {value}, not {expected}", set.name());
                        }
                        let level = self.leaf_level(point).map_or(-1, |level| level as i32);
                        prop_assert_eq!(found.levels[lane], level, "{} at {:?}", method, point);
                        prop_assert_eq!(beside.levels[lane], level, "{} at {:?}", method, point);
                        if !expected.is_finite() {
                            continue;
                        }
                        let expected = self.gradient(&reference, point).map(|slope| slope * normalisation.scale);
                        let slopes = gradients.map(|axis| f64::from(axis[lane]));
                        // A cell without a number that has no weight at the point itself may still have a slope, or not.
                        if slopes.iter().any(|slope| !slope.is_finite()) {
                            let is_beside = points_beside(point).any(|point| !reference.sample(point).is_finite());
                            prop_assert!(is_beside, "{method}, {} at {point:?}: slopes {slopes:?}", set.name());
                            continue;
                        }
                        for (slope, expected) in slopes.into_iter().zip(expected) {
                            // Sums of sixteen and more products of values and weights, each rounded to 1e-7 of itself.
                            let same = (slope - expected).abs() < 1e-5 * (1.0 + expected.abs())
                                || !slope.is_finite() && !expected.is_finite();
                            prop_assert!(
                                same,
                                "{method}, {} at {point:?}: slopes {slopes:?}, one of them not {expected}",
                                set.name()
                            );
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The reference's gradient at a point, or the domain's point nearest to it, per cell of the finest level.
    fn gradient(&self, reference: &Sampler<T>, point: [f64; 3]) -> [f64; 3] {
        let (domain, hierarchy) = (self.index.domain(), self.index.hierarchy());
        let point = std::array::from_fn(|axis| point[axis].clamp(domain.low[axis] as f64, domain.high[axis] as f64));
        let cell = domain.clamp(point.map(|position| position.floor() as i64));
        let slopes = reference.sample_in_with_gradient(self.index.find_region(cell), point).gradient;
        let cell_size = hierarchy.levels()[hierarchy.finest_level()].cell_size();
        std::array::from_fn(|axis| slopes[axis] * cell_size[axis])
    }

    fn leaf_level(&self, point: [f64; 3]) -> Option<usize> {
        let cell = self.index.domain().clamp(point.map(|position| position.floor() as i64));
        self.index.find_leaf(cell).map(|leaf| leaf.level)
    }

    /// Packets of points near each other, and of points anywhere; some outside the domain, some on a lattice of cells'
    /// faces and centres.
    fn packets(&self, random: &mut Random, count: usize) -> Vec<PacketPoints> {
        let domain = self.index.domain().grown([1; 3]);
        let bounds = [domain.low, domain.high].map(|corner| corner.map(|cell| cell as f64));
        let levels = self.index.hierarchy().levels();
        (0..count)
            .map(|number| {
                let middle = random.point(bounds);
                let level = random.integer(0, levels.len() as i64 - 1) as usize;
                let cells = levels[level].finest_cells().map(|cells| cells as f64);
                let mut packet = [[0.0; LANES]; 3];
                for lane in 0..LANES {
                    let mut point = random.point(bounds);
                    if number % 2 == 0 {
                        point = std::array::from_fn(|axis| middle[axis] + (random.unit() - 0.5) * 2.0 * cells[axis]);
                    }
                    for axis in 0..3 {
                        if random.chance(0.1) {
                            point[axis] = (point[axis] / cells[axis] * 2.0).round() / 2.0 * cells[axis];
                        }
                        packet[axis][lane] = point[axis];
                    }
                }
                packet
            })
            .collect()
    }
}

/// Points next to a point, on all its sides.
fn points_beside(point: [f64; 3]) -> impl Iterator<Item = [f64; 3]> {
    const NEAR: f64 = 1e-6;
    let step = |number: i32, axis: u32| f64::from([0, -1, 1][(number / 3i32.pow(axis) % 3) as usize]);
    (0..27).map(move |number| {
        std::array::from_fn(|axis| point[axis] + NEAR * (1.0 + point[axis].abs()) * step(number, axis as u32))
    })
}

/// A value from 0 to 1 that depends on nothing but the cell.
fn noise(level: usize, [i, j, k]: [i64; 3]) -> f64 {
    let mut random = Random(level as u64 ^ (i as u64) << 8 ^ (j as u64) << 24 ^ (k as u64) << 40);
    random.bits();
    random.unit()
}

const UNIT: Normalisation = Normalisation { low: 0.0, scale: 1.0 };

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn packets_agree_with_the_reference(seed: u64) {
        let mut random = Random(seed);
        let shape = Shape {
            holes: seed.is_multiple_of(3),
            improper_nesting: seed.is_multiple_of(4),
            ..Shape::default()
        };
        let mesh = RandomMesh::new(&mut random, shape);
        let case = Case::<f64>::new(mesh.cut(&mut random), noise);
        let packets = case.packets(&mut random, 12);
        case.check(UNIT, &packets)?;
    }

    #[test]
    fn cells_without_a_number_touch_the_same_points(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape { holes: seed.is_multiple_of(3), ..Shape::default() });
        let case = Case::<f32>::new(mesh.cut(&mut random), |level, cell| {
            match noise(level, cell) {
                value if value < 0.01 => f32::NAN,
                value if value < 0.02 => f32::INFINITY,
                value => value as f32,
            }
        });
        let packets = case.packets(&mut random, 12);
        case.check(UNIT, &packets)?;
    }

    #[test]
    fn offsets_and_magnitudes_cost_no_digits(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape::default()).cut(&mut random);
        let normalisation = Normalisation::of_range([1e80, 1e80 + 1e72]);
        let case = Case::<f64>::new(mesh, |level, cell| 1e80 + 1e72 * noise(level, cell));
        let packets = case.packets(&mut random, 6);
        case.check(normalisation, &packets)?;
    }
}

#[test]
fn twenty_levels_keep_their_digits() {
    let case = Case::<f64>::new(nested_cubes(20), noise);
    let mut random = Random(5);
    let cells = (8i64 << 19) as f64;
    let packets: Vec<PacketPoints> = (0..200)
        .map(|_| {
            let size = (random.unit() * 20.0).exp2();
            let mut packet = [[0.0; LANES]; 3];
            for lane in 0..LANES {
                for axis in &mut packet {
                    axis[lane] = (cells / 3.0 + (random.unit() - 0.5) * 8.0 * size).clamp(0.0, cells);
                }
            }
            packet
        })
        .collect();
    case.check(UNIT, &packets).unwrap();
}

#[test]
fn domains_beyond_32_bits_are_sampled_too() {
    let case = Case::<f64>::new(nested_cubes(31), noise);
    let packets = case.packets(&mut Random(5), 4);
    case.check(UNIT, &packets).unwrap();
}

#[test]
fn values_are_read_where_they_are() {
    // Ghost cells, an axis order of its own, no alignment.
    let size = [5usize, 4, 3];
    for (stride, offset) in [([1, 7, 50], 3), ([20, 1, 4], 0), ([2, 11, 60], 5)] {
        let mut bytes = vec![0u8; 2000];
        let level = LevelDescription {
            ratio: [1; 3],
            cell_size: [1.0; 3],
            domain: IndexBox::new([-2; 3], [3, 2, 1]),
            bricks: vec![IndexBox::new([-2; 3], [3, 2, 1])],
        };
        for cell in IndexBox::new([0; 3], size.map(|cells| cells as i64)).iter() {
            let place: usize = (0..3).map(|axis| cell[axis] as usize * stride[axis]).sum();
            let place = offset + place * size_of::<f32>();
            bytes[place..place + 4].copy_from_slice(&(noise(0, cell) as f32).to_ne_bytes());
        }
        let owner = Arc::new(bytes);
        #[allow(unsafe_code)]
        // SAFETY: `owner` keeps the bytes alive and nobody writes to them.
        let buffer = unsafe { ValueBuffer::borrowed(owner.as_ptr(), owner.len(), owner) };
        let bricks = vec![BrickValues::<f32>::new(buffer, offset, stride, size).unwrap()];
        let hierarchy = Hierarchy::new([0.0; 3], vec![level]).unwrap();
        let case = Case { index: Index::build(Arc::new(hierarchy)), bricks };
        let packets = case.packets(&mut Random(7), 20);
        case.check(UNIT, &packets).unwrap();
    }
}

#[test]
fn volumes_are_sampled_like_points_one_by_one() {
    let hierarchy = Arc::new(nested_cubes(4));
    // One cell is far beyond what single precision holds.
    let field = Field::from_fn("value", &hierarchy, |level, cell| {
        if (level, cell) == (0, [6, 1, 1]) { 1e200 } else { 1e9 + noise(level, cell) }
    });
    let FieldValues::F64(bricks) = field.values().clone() else { unreachable!("the field was made of f64") };
    let index = Arc::new(Index::build(hierarchy));
    let mut random = Random(3);
    let mut points: Vec<[f64; 3]> = (0..3000).map(|_| random.point([[-0.1; 3], [1.1; 3]])).collect();
    points.extend([[0.0; 3], [1.0; 3], [0.8, 0.2, 0.2], [f64::NAN; 3], [f64::INFINITY, 0.5, 0.5]]);
    for method in Method::ALL {
        let reference = Sampler::new(&index, &bricks, method);
        let volume = Volume::new(index.clone(), field.clone(), method);
        for (&point, found) in points.iter().zip(volume.sample(&points)) {
            let expected = reference.sample_world(point);
            // Of the range, which is 1 but where the large cell takes part.
            let tolerance = if expected > 2e9 { 1e-5 * expected } else { 1e-5 };
            let same = (found - expected).abs() < tolerance || found.is_nan() && expected.is_nan();
            assert!(same, "{method} at {point:?}: {found}, not {expected}");
        }
    }
}
