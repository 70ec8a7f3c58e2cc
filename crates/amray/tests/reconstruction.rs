//! The properties that define the reconstructions, held on random hierarchies against a brute-force evaluation.

use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};
use amray::index::ValueRanges;
use amray::reconstruction::Method;
use amray_testing::{BruteForce, Case, Random, RandomMesh, Shape, noise};
use proptest::prelude::*;

const CONTINUOUS: [Method; 4] = [Method::Blend, Method::Basis, Method::Octant, Method::Prolong];

/// Equal up to rounding, or both not a number.
fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance || a.is_nan() && b.is_nan()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_method_matches_brute_force(seed: u64) {
        let (case, mut random) = Case::noisy(seed, Shape::any(seed));
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
        let case = Case::new(RandomMesh::new(&mut random, Shape::any(seed)).cut(&mut random), |_, _| 0.7);
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
        let (case, mut random) = Case::noisy(seed, Shape { levels: 1, ..Shape::default() });
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
        let (case, mut random) = Case::noisy(seed, Shape { improper_nesting, ..Shape::default() });
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
        let (case, _) = Case::noisy(seed, Shape { improper_nesting: false, ..Shape::any(seed) });
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
        let case = Case::of_centers(hierarchy, linear);
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
        let (case, mut random) = Case::noisy(seed, Shape::any(seed));
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
        let mesh = RandomMesh::new(&mut random, Shape::any(seed));
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
        let (case, mut random) = Case::noisy(seed, Shape::any(seed));
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
        let (case, mut random) = Case::noisy(seed, Shape::any(seed));
        let mirrored = random.chance(0.5);
        let shift = random.integer(0, 2) as usize;
        let turned = case.turned(mirrored, shift);
        for _ in 0..40 {
            let point = case.point(&mut random);
            let place = case.turned_point(mirrored, shift, point);
            for method in Method::ALL {
                let (a, b) = (case.sample(method, point), turned.sample(method, place));
                prop_assert!(close(a, b, 1e-6), "{method} at {point:?}: {a}, turned {b}");
            }
        }
    }
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
