//! Random volumes become AMR data, which are held to the definition.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::{Field, FieldValues, Hierarchy, IndexBox, LevelDescription, Normalisation, VoxelType};
use amray::index::Index;
use amray::reconstruction::{Method, PacketSampler, PacketSamples};
use amray::simd::InstructionSet;
use amray_formats::structured::StructuredVolume;
use amray_formats::{OpenOptions, open};
use amray_testing::Random;
use proptest::prelude::*;
use proptest::sample::select;

use super::brute_force::{self, Level, cells, differ};
use super::{raw_volume, refinement, write};

/// Points in a packet.
const LANES: usize = 16;

/// How to make a random volume and what to make of it.
#[derive(Clone, Debug)]
struct Case {
    size: [usize; 3],
    brick: usize,
    threshold: f64,
    /// Levels that there may be less.
    fewer: usize,
    voxel_type: VoxelType,
    /// Whether some samples are not numbers.
    holes: bool,
    /// Samples per side of blocks that are alike: coarser levels may then hold all there is.
    block: usize,
    spacing: [f64; 3],
    origin: [f64; 3],
    seed: u64,
}

fn case() -> impl Strategy<Value = Case> {
    let side = || prop_oneof![1usize..=70, 1usize..=20, select(vec![8usize, 16, 32, 64])];
    let width = || 0.1..3.0f64;
    (
        [side(), side(), side()],
        select(vec![4usize, 8, 16]),
        prop_oneof![Just(0.0), 0.01..0.6f64],
        0usize..3,
        select(vec![VoxelType::F32, VoxelType::F64]),
        any::<bool>(),
        select(vec![1usize, 1, 2, 4]),
        [width(), width(), width()],
        [-5.0..5.0f64, -5.0..5.0f64, -5.0..5.0f64],
        any::<u64>(),
    )
        .prop_map(|(size, brick, threshold, fewer, voxel_type, holes, block, spacing, origin, seed)| {
            // Large enough for several levels, and quick.
            let size = [size[0], size[1], size[2].min(1 + 60_000 / (size[0] * size[1]))];
            Case { size, brick, threshold, fewer, voxel_type, holes, block, spacing, origin, seed }
        })
}

impl Case {
    fn levels(&self) -> usize {
        let enough = |count: u32| self.size.iter().all(|&samples| samples.div_ceil(1 << (count - 1)) <= self.brick);
        let count = (1..).find(|&count| enough(count)).unwrap() as usize;
        count.saturating_sub(self.fewer).max(1)
    }

    /// Constant far away, smooth in a ball, and random at some places.
    fn values(&self) -> Vec<f64> {
        let mut random = Random(self.seed);
        let middle = random.point([[0.0; 3], self.size.map(|samples| samples as f64)]);
        let radius = 0.4 * random.unit() * self.size.iter().copied().max().unwrap() as f64;
        let holes = random.point([[0.0; 3], self.size.map(|samples| samples as f64)]);
        let value = |cell: [usize; 3]| {
            let distance =
                |from: [f64; 3]| (0..3).map(|axis| (cell[axis] as f64 - from[axis]).powi(2)).sum::<f64>().sqrt();
            match distance(middle) {
                _ if self.holes && (distance(holes) < 0.5 * radius || random.chance(0.0005)) => f64::NAN,
                _ if random.chance(0.001) => random.unit(),
                distance if distance < radius => (0.4 * distance).sin(),
                _ => 0.1,
            }
        };
        let mut values: Vec<f64> = cells([0; 3], self.size).map(value).collect();
        if self.voxel_type == VoxelType::F32 {
            values.iter_mut().for_each(|value| *value = f64::from(*value as f32));
        }
        let of_block = |cell: [usize; 3]| {
            let [x, y, z] = cell.map(|index| index / self.block * self.block);
            values[x + self.size[0] * (y + self.size[1] * z)]
        };
        cells([0; 3], self.size).map(of_block).collect()
    }
}

/// What a case becomes.
struct Made {
    case: Case,
    /// By brute force, coarsest first.
    levels: Vec<Level>,
    hierarchy: Arc<Hierarchy>,
    field: Field,
    errors: [f64; 2],
}

impl Made {
    fn of(case: Case) -> Self {
        let values = case.values();
        let (directory, volume) = raw_volume(case.size, &values, case.voxel_type);
        let volume: StructuredVolume = volume.placed(Some(case.spacing), Some(case.origin)).unwrap();
        let path = directory.path().join("a.hdf5");
        let asked = (case.fewer > 0).then(|| case.levels());
        let refined = write(refinement(case.brick, case.threshold, asked), &volume, &path).unwrap();
        let data = open(&path, &OpenOptions::default()).unwrap();
        assert!(data.warnings().is_empty() && data.fields()[0].voxel_type == case.voxel_type);
        let levels = brute_force::levels(case.size, &values, case.levels(), case.voxel_type);
        let field = data.read_field(0, &|_| {}).unwrap();
        let errors = [refined.max_error, refined.mean_error];
        Self { case, levels, hierarchy: data.hierarchy().clone(), field, errors }
    }

    /// The bricks of each level by their place in the grid.
    fn places(&self) -> Vec<HashMap<[usize; 3], usize>> {
        let place = |cells: &IndexBox| cells.low.map(|index| index as usize / self.case.brick);
        let of_level = |level: &amray::hierarchy::Level| {
            level
                .bricks()
                .iter()
                .enumerate()
                .map(|(number, cells)| (place(cells), level.first_brick() + number))
                .collect()
        };
        self.hierarchy.levels().iter().map(of_level).collect()
    }

    /// The one level that the samples are.
    fn original(&self) -> (Arc<Hierarchy>, Field) {
        let Case { size, spacing, origin, .. } = self.case;
        let domain = IndexBox::new([0; 3], size.map(|samples| samples as i64));
        let level = LevelDescription { ratio: [1; 3], cell_size: spacing, domain, bricks: vec![domain] };
        let low = [0, 1, 2].map(|axis| origin[axis] - spacing[axis] / 2.0);
        let hierarchy = Arc::new(Hierarchy::new(low, vec![level]).unwrap());
        let finest = self.levels.last().unwrap();
        let value = |cell: [i64; 3]| finest.value(cell.map(|index| index as usize));
        let field = match self.case.voxel_type {
            VoxelType::F32 => Field::from_fn("value", &hierarchy, |_, cell| value(cell) as f32),
            VoxelType::F64 => Field::from_fn("value", &hierarchy, |_, cell| value(cell)),
        };
        (hierarchy, field)
    }

    /// World positions between the first and the last sample.
    fn points(&self, count: usize) -> Vec<[f64; 3]> {
        let Case { size, spacing, origin, seed, .. } = self.case;
        let mut random = Random(!seed);
        let position = |random: &mut Random, axis: usize| {
            // Clear of the last sample by more than rounding.
            let last = ((size[axis] - 1) as f64 - 1e-6).max(0.0);
            origin[axis] + spacing[axis] * last * random.unit()
        };
        (0..count).map(|_| [0, 1, 2].map(|axis| position(&mut random, axis))).collect()
    }
}

/// Normalised values of `finest` at points.
fn finest(hierarchy: &Arc<Hierarchy>, field: &Field, points: &[[f64; 3]], normalisation: Normalisation) -> Vec<f32> {
    let index = Index::build(hierarchy.clone());
    let packets: Vec<[[f64; LANES]; 3]> = points
        .chunks(LANES)
        .map(|points| {
            let cells: Vec<_> =
                points.iter().map(|&point| hierarchy.to_cells(hierarchy.finest_level(), point)).collect();
            [0, 1, 2].map(|axis| std::array::from_fn(|lane| cells[lane.min(cells.len() - 1)][axis]))
        })
        .collect();
    let mut samples = vec![PacketSamples { values: [0.0; LANES], levels: [0; LANES] }; packets.len()];
    let set = InstructionSet::best();
    match field.values() {
        FieldValues::F32(bricks) => {
            PacketSampler::new(&index, bricks, Method::Finest, normalisation).sample_packets(
                set,
                &packets,
                &mut samples,
            );
        }
        FieldValues::F64(bricks) => {
            PacketSampler::new(&index, bricks, Method::Finest, normalisation).sample_packets(
                set,
                &packets,
                &mut samples,
            );
        }
    }
    samples.iter().flat_map(|packet| packet.values).take(points.len()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn kept_bricks_and_their_values_are_the_definition(case in case()) {
        let made = Made::of(case);
        let Case { brick, threshold, .. } = made.case;
        prop_assert!(made.hierarchy.warnings().is_empty(), "nesting is proper: {:?}", made.hierarchy.warnings());
        let expected = brute_force::kept(&made.levels, brick, threshold);
        prop_assert_eq!(made.hierarchy.levels().len(), expected.len());
        for (number, (places, level)) in made.places().iter().zip(&made.levels).enumerate() {
            let found: BTreeSet<[usize; 3]> = places.keys().copied().collect();
            let stored = brute_force::stored(&made.levels, number);
            let all = cells([0; 3], stored.map(|cells| cells.div_ceil(brick)));
            let expected = if number == 0 { &all.collect() } else { &expected[number] };
            prop_assert_eq!(&found, expected, "level {}", number);
            for (place, &of_field) in places {
                let low = place.map(|index| index * brick);
                let high = [0, 1, 2].map(|axis| (low[axis] + brick).min(stored[axis]));
                for cell in cells(low, high) {
                    let found = made.field.value(of_field, [0, 1, 2].map(|axis| cell[axis] - low[axis]));
                    let inside = (0..3).all(|axis| cell[axis] < level.size[axis]);
                    let expected = if inside { level.value(cell) } else { f64::NAN };
                    prop_assert!(found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan());
                }
            }
        }
    }

    #[test]
    fn every_sample_is_within_the_threshold_of_its_leaf_cell(case in case()) {
        let made = Made::of(case);
        let places = made.places();
        let samples = made.levels.last().unwrap();
        let (mut max, mut sum, mut count) = (0f64, 0.0, 0);
        for sample in cells([0; 3], samples.size) {
            let leaf = (0..places.len()).rev().find_map(|number| {
                let cell = [0, 1, 2].map(|axis| sample[axis] / made.levels[number].samples[axis]);
                let brick = places[number].get(&cell.map(|index| index / made.case.brick))?;
                Some(made.field.value(*brick, cell.map(|index| index % made.case.brick)))
            });
            let (value, leaf) = (samples.value(sample), leaf.expect("level 0 is whole"));
            prop_assert!(!differ(value, leaf, made.case.threshold), "{:?}: {} for {}", sample, leaf, value);
            if value.is_finite() {
                max = max.max((value - leaf).abs());
                sum += (value - leaf).abs();
                count += 1;
            }
        }
        let mean = sum / f64::from(count.max(1));
        prop_assert_eq!(made.errors[0], max);
        prop_assert!((made.errors[1] - mean).abs() <= 1e-12, "{} for {}", made.errors[1], mean);
    }

    #[test]
    fn finest_is_the_trilinear_interpolation_within_the_threshold(case in case()) {
        let made = Made::of(case);
        let (hierarchy, field) = made.original();
        let points = made.points(2000);
        let normalisation = Normalisation { low: -1.0, scale: 0.5 };
        let expected = finest(&hierarchy, &field, &points, normalisation);
        let found = finest(&made.hierarchy, &made.field, &points, normalisation);
        for (place, (expected, found)) in expected.into_iter().zip(found).enumerate() {
            if made.case.threshold == 0.0 {
                let same = expected.to_bits() == found.to_bits() || expected.is_nan() && found.is_nan();
                prop_assert!(same, "{:?}: {} for {}", points[place], found, expected);
            } else {
                // Numbers are half as wide as values, and round.
                let bound = 0.5 * made.case.threshold + 1e-6;
                let within = (expected - found).abs() as f64 <= bound || expected.is_nan() && found.is_nan();
                prop_assert!(within, "{:?}: {} for {}", points[place], found, expected);
            }
        }
    }

    #[test]
    fn padding_hides_no_sample_and_shows_nothing(case in case()) {
        let made = Made::of(Case { holes: false, ..case });
        let index = Arc::new(Index::build(made.hierarchy.clone()));
        let inside = made.points(500);
        let Case { size, spacing, origin, seed, .. } = made.case;
        let [low, high] = made.hierarchy.bounds();
        let mut random = Random(seed);
        // Beyond the last samples' own cells, on one axis at least.
        let end = [0, 1, 2].map(|axis| origin[axis] + spacing[axis] * (size[axis] as f64 - 0.5 + 1e-6));
        let mut beyond: Vec<[f64; 3]> = (0..500).map(|_| random.point([low, high])).collect();
        for axis in (0..3).filter(|&axis| end[axis] < high[axis]) {
            for _ in 0..300 {
                let mut point = random.point([low, high]);
                point[axis] = end[axis] + random.unit() * (high[axis] - end[axis]);
                beyond.push(point);
            }
        }
        beyond.retain(|point| (0..3).any(|axis| point[axis] > end[axis]));
        for method in Method::ALL {
            let volume = Volume::new(index.clone(), made.field.clone(), method);
            let shown = volume.sample(&inside);
            let hidden = inside.iter().zip(shown).find(|(_, value)| !value.is_finite());
            prop_assert!(hidden.is_none(), "{:?} {:?}", method, hidden);
            let nothing = volume.sample(&beyond);
            let invented = beyond.iter().zip(nothing).find(|(_, value)| value.is_finite());
            prop_assert!(invented.is_none(), "{:?} {:?}", method, invented);
        }
    }
}
