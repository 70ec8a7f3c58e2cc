//! The properties that define the reconstructions, held on random hierarchies against a brute-force evaluation.

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Field, FieldValues, Hierarchy, IndexBox, LevelDescription};
use amray::index::{Index, ValueRanges};
use amray::reconstruction::{Method, Sampler};
use amray_testing::{BruteForce, Random, RandomMesh, Shape};
use proptest::prelude::*;

/// A hierarchy, its index, and a field of f64 values.
struct Case {
    hierarchy: Arc<Hierarchy>,
    index: Index,
    field: Field,
}

impl Case {
    fn new(hierarchy: Hierarchy, value: impl Fn(usize, [i64; 3]) -> f64) -> Self {
        let hierarchy = Arc::new(hierarchy);
        let field = Field::from_fn("value", &hierarchy, value);
        Self { index: Index::build(hierarchy.clone()), hierarchy, field }
    }

    fn bricks(&self) -> &[BrickValues<f64>] {
        match self.field.values() {
            FieldValues::F64(bricks) => bricks,
            FieldValues::F32(_) => unreachable!("the cases hold f64"),
        }
    }

    fn sample(&self, method: Method, point: [f64; 3]) -> f64 {
        Sampler::new(&self.index, self.bricks(), method).sample_world(point)
    }

    /// A point of the domain; often near a brick's face, where levels meet.
    fn point(&self, random: &mut Random) -> [f64; 3] {
        if random.chance(0.3) {
            return random.point(self.hierarchy.bounds());
        }
        let levels = self.hierarchy.levels();
        let level = random.integer(0, levels.len() as i64 - 1) as usize;
        let bricks = levels[level].bricks();
        let brick = bricks[random.integer(0, bricks.len() as i64 - 1) as usize];
        let grown = brick.grown([1; 3]).intersection(&levels[level].domain());
        let corners = [grown.low, grown.high].map(|corner| corner.map(|index| index as f64));
        self.hierarchy.to_world(level, random.point(corners))
    }

    /// World positions of the leaf cells' centres, with their values.
    fn leaf_centers(&self) -> Vec<([f64; 3], f64)> {
        let mut centers = Vec::new();
        for (place, brick) in self.hierarchy.bricks().enumerate() {
            for cell in brick.cells.iter() {
                let found = self.index.find_cell(brick.level, cell).unwrap();
                assert_eq!((found.level, found.brick), (brick.level, place));
                if !found.covered {
                    let center = self.hierarchy.to_world(brick.level, cell.map(|index| index as f64 + 0.5));
                    centers.push((center, self.field.value(place, found.cell)));
                }
            }
        }
        centers
    }
}

/// A value that depends on nothing but the cell.
fn noise(level: usize, [i, j, k]: [i64; 3]) -> f64 {
    let mut random = Random(level as u64 ^ (i as u64) << 8 ^ (j as u64) << 24 ^ (k as u64) << 40);
    random.bits();
    random.unit()
}

fn shape(seed: u64) -> Shape {
    Shape { holes: seed.is_multiple_of(3), improper_nesting: seed.is_multiple_of(4), ..Shape::default() }
}

fn noisy_case(seed: u64, shape: Shape) -> (Case, Random) {
    let mut random = Random(seed);
    let mesh = RandomMesh::new(&mut random, shape);
    (Case::new(mesh.cut(&mut random), noise), random)
}

const CONTINUOUS: [Method; 4] = [Method::Blend, Method::Basis, Method::Octant, Method::Prolong];

/// Equal up to rounding, or both not a number.
fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance || a.is_nan() && b.is_nan()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_method_matches_brute_force(seed: u64) {
        let (case, mut random) = noisy_case(seed, shape(seed));
        let brute = BruteForce::new(&case.hierarchy, &case.field);
        for _ in 0..60 {
            let point = case.point(&mut random);
            for method in Method::ALL {
                let (found, expected) = (case.sample(method, point), brute.sample(method, point));
                prop_assert!(close(found, expected, 1e-9), "{method} at {point:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn constants_are_reproduced(seed: u64) {
        let mut random = Random(seed);
        let case = Case::new(RandomMesh::new(&mut random, shape(seed)).cut(&mut random), |_, _| 0.7);
        for _ in 0..50 {
            let point = case.point(&mut random);
            let inside = !case.sample(Method::Nearest, point).is_nan();
            for method in Method::ALL {
                let found = case.sample(method, point);
                prop_assert!(!inside || close(found, 0.7, 1e-12), "{method} at {point:?}: {found}");
            }
        }
    }

    #[test]
    fn one_level_alone_is_trilinear(seed: u64) {
        let (case, mut random) = noisy_case(seed, Shape { levels: 1, ..Shape::default() });
        let domain = case.hierarchy.levels()[0].domain();
        for _ in 0..50 {
            let point = random.point(case.hierarchy.bounds());
            let position = case.hierarchy.to_cells(0, point).map(|position| position - 0.5);
            let mut expected = 0.0;
            for corner in 0..8i64 {
                let cell = std::array::from_fn(|axis| position[axis].floor() as i64 + (corner >> axis & 1));
                let hat: f64 = (0..3).map(|axis| 1.0 - (position[axis] - cell[axis] as f64).abs()).product();
                expected += hat * noise(0, domain.clamp(cell));
            }
            for method in [Method::Finest, Method::Current, Method::Blend, Method::Basis, Method::Octant, Method::Prolong] {
                let found = case.sample(method, point);
                // Without clamped copies, basis and octant leave out corners outside the domain: the same by symmetry.
                prop_assert!(close(found, expected, 1e-9), "{method} at {point:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn continuous_methods_are_continuous(seed: u64) {
        let improper_nesting = seed.is_multiple_of(4);
        let (case, mut random) = noisy_case(seed, Shape { improper_nesting, ..Shape::default() });
        prop_assume!(!improper_nesting || case.hierarchy.warnings().is_empty());
        let finest = case.hierarchy.finest_level();
        let steps = 1e-7;
        for _ in 0..60 {
            // Two points on either side of a face of some cell.
            let level = random.integer(0, finest as i64) as usize;
            let mut cells = case.hierarchy.to_cells(level, case.point(&mut random));
            let axis = random.integer(0, 2) as usize;
            cells[axis] = (cells[axis] * 2.0).round() / 2.0;
            let mut others = cells;
            cells[axis] -= steps;
            others[axis] += steps;
            let [a, b] = [cells, others].map(|cells| case.hierarchy.to_world(level, cells));
            for method in CONTINUOUS {
                let (a_value, b_value) = (case.sample(method, a), case.sample(method, b));
                // The slope is at most a few values per cell of the finest level (up to 64 times finer).
                let jump = (a_value - b_value).abs();
                prop_assert!(jump < 1e-3 || jump.is_nan(), "{method} jumps by {jump} between {a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn leaf_centers_are_interpolated(seed: u64) {
        // Without its parent level, a fine brick may end at a coarse cell's centre.
        let (case, _) = noisy_case(seed, Shape { improper_nesting: false, ..shape(seed) });
        for (center, value) in case.leaf_centers() {
            for method in [Method::Current, Method::Blend, Method::Octant, Method::Prolong] {
                let found = case.sample(method, center);
                prop_assert!(close(found, value, 1e-6), "{method} at {center:?}: {found}, expected {value}");
            }
        }
    }

    #[test]
    fn prolong_reproduces_linear_fields_across_levels(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape { base: [10, 12], levels: 3, ..Shape::default() });
        let hierarchy = mesh.cut(&mut random);
        let linear = |[x, y, z]: [f64; 3]| 0.3 + x - 2.0 * y + 0.5 * z;
        let centers = hierarchy.clone();
        let case = Case::new(hierarchy, |level, cell| {
            linear(centers.to_world(level, cell.map(|index| index as f64 + 0.5)))
        });
        // Beyond the domain's boundary there is nothing to extrapolate from: stay as far inside as cells are copied.
        let [low, high] = case.hierarchy.bounds();
        let cell_size = case.hierarchy.levels()[0].cell_size();
        let margin = case.hierarchy.levels().len() as f64 + 0.5;
        let inside = [
            std::array::from_fn(|axis| low[axis] + margin * cell_size[axis]),
            std::array::from_fn(|axis| high[axis] - margin * cell_size[axis]),
        ];
        for _ in 0..100 {
            let point = random.point(inside);
            let found = case.sample(Method::Prolong, point);
            prop_assert!(close(found, linear(point), 1e-9), "at {point:?}: {found}, expected {}", linear(point));
        }
    }

    #[test]
    fn values_stay_in_the_range_of_their_region(seed: u64) {
        let (case, mut random) = noisy_case(seed, shape(seed));
        let ranges = ValueRanges::build(&case.index, &case.field);
        for _ in 0..100 {
            let point = case.point(&mut random);
            let cells = case.hierarchy.to_cells(case.hierarchy.finest_level(), point);
            let region = case.index.find_region(cells.map(|position| position.floor() as i64));
            let [low, high] = ranges.region(region).map(f64::from);
            for method in Method::ALL {
                let value = case.sample(method, point);
                prop_assert!(
                    value.is_nan() || low - 1e-12 <= value && value <= high + 1e-12,
                    "{method} at {point:?}: {value} outside {low}..{high}"
                );
            }
        }
    }

    #[test]
    fn cutting_levels_into_other_bricks_changes_nothing(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, shape(seed));
        let [first, second] = [(); 2].map(|()| Case::new(mesh.cut(&mut random), noise));
        for _ in 0..60 {
            let point = first.point(&mut random);
            for method in Method::ALL {
                let (a, b) = (first.sample(method, point), second.sample(method, point));
                prop_assert!(close(a, b, 1e-12), "{method} at {point:?}: {a} and {b}");
            }
        }
    }

    #[test]
    fn coarser_levels_alone_are_what_max_level_shows(seed: u64) {
        let (case, mut random) = noisy_case(seed, shape(seed));
        let keep = random.integer(0, case.hierarchy.finest_level() as i64) as usize;
        let coarse = Case::new(case.hierarchy.truncated(keep), noise);
        let field = case.field.truncated(&coarse.hierarchy);
        let brute = BruteForce::new(&coarse.hierarchy, &field);
        for _ in 0..30 {
            let point = coarse.point(&mut random);
            for method in Method::ALL {
                let (found, expected) = (coarse.sample(method, point), brute.sample(method, point));
                prop_assert!(close(found, expected, 1e-9), "{method} at {point:?}: {found}, expected {expected}");
            }
        }
    }

    #[test]
    fn mirroring_and_permuting_the_axes_changes_nothing(seed: u64) {
        let (case, mut random) = noisy_case(seed, shape(seed));
        let mirrored = random.chance(0.5);
        let shift = random.integer(0, 2) as usize;
        let turned = turned(&case, mirrored, shift);
        let [low, high] = case.hierarchy.bounds();
        for _ in 0..40 {
            let point = case.point(&mut random);
            let place: [f64; 3] = std::array::from_fn(|axis| {
                let from = (axis + shift) % 3;
                // Mirrored at the domain's middle, in the frame where the low corner is the origin.
                if mirrored { high[from] - point[from] } else { point[from] - low[from] }
            });
            for method in Method::ALL {
                let (a, b) = (case.sample(method, point), turned.sample(method, place));
                prop_assert!(close(a, b, 1e-6), "{method} at {point:?}: {a}, turned {b}");
            }
        }
    }
}

/// The case with its axes moved by `shift` and, where asked for, all of them mirrored; its low corner is the origin.
fn turned(case: &Case, mirrored: bool, shift: usize) -> Case {
    let levels = case.hierarchy.levels();
    let turn_cell = |domain: IndexBox, cell: [i64; 3]| -> [i64; 3] {
        std::array::from_fn(|axis| {
            let from = (axis + shift) % 3;
            if mirrored { domain.high[from] - 1 - cell[from] } else { cell[from] - domain.low[from] }
        })
    };
    let turn_box = |domain: IndexBox, cells: IndexBox| {
        let [a, b] = [cells.low, cells.high.map(|index| index - 1)].map(|cell| turn_cell(domain, cell));
        IndexBox::new(
            std::array::from_fn(|axis| a[axis].min(b[axis])),
            std::array::from_fn(|axis| a[axis].max(b[axis]) + 1),
        )
    };
    let descriptions = levels
        .iter()
        .map(|level| LevelDescription {
            ratio: std::array::from_fn(|axis| level.ratio()[(axis + shift) % 3]),
            cell_size: std::array::from_fn(|axis| level.cell_size()[(axis + shift) % 3]),
            domain: turn_box(level.domain(), level.domain()),
            bricks: level.bricks().iter().map(|&brick| turn_box(level.domain(), brick)).collect(),
        })
        .collect();
    let original = |level: usize, cell: [i64; 3]| -> f64 {
        let domain = levels[level].domain();
        let mut source = [0; 3];
        for axis in 0..3 {
            let from = (axis + shift) % 3;
            source[from] = if mirrored { domain.high[from] - 1 - cell[axis] } else { domain.low[from] + cell[axis] };
        }
        noise(level, source)
    };
    Case::new(Hierarchy::new([0.0; 3], descriptions).unwrap(), original)
}

#[test]
fn not_a_number_touches_only_what_uses_it() {
    let level = LevelDescription {
        ratio: [1; 3],
        cell_size: [1.0; 3],
        domain: IndexBox::new([0; 3], [8; 3]),
        bricks: vec![IndexBox::new([0; 3], [8; 3])],
    };
    let hierarchy = Hierarchy::new([0.0; 3], vec![level]).unwrap();
    let case = Case::new(hierarchy, |_, cell| if cell == [4, 4, 4] { f64::NAN } else { cell[0] as f64 });
    for method in Method::ALL {
        assert!(case.sample(method, [4.4, 4.5, 4.5]).is_nan(), "{method}");
        assert_eq!(case.sample(method, [3.5, 4.5, 4.5]), 3.0, "{method}: weight zero does not touch");
        assert!(case.sample(method, [8.1, 4.0, 4.0]).is_nan(), "{method}: outside");
        assert_eq!(case.sample(method, [8.0, 8.0, 8.0]), 7.0, "{method}: the boundary belongs to the domain");
    }
    let ranges = ValueRanges::build(&case.index, &case.field);
    assert_eq!(ranges.whole(), [0.0, 7.0]);
}
