//! Node-centred fields: trilinear inside leaf cells, continuous across levels, the same in every engine and layout.

use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::{Centering, Field, Hierarchy};
use amray::index::Index;
use amray::reconstruction::Method;
use amray_testing::{BruteForce, Random, RandomMesh, Shape, noise};
use proptest::prelude::*;

/// A node-centred volume with `value(level, node)` at each node.
fn volume(hierarchy: Hierarchy, value: impl Fn(usize, [i64; 3]) -> f64) -> Volume {
    let hierarchy = Arc::new(hierarchy);
    let field = Field::centered_from_fn("value", Centering::Nodes, &hierarchy, value);
    Volume::new(Arc::new(Index::build(hierarchy)), field, Method::default())
}

/// A random mesh, properly nested.
fn mesh(random: &mut Random) -> Hierarchy {
    RandomMesh::new(random, Shape { levels: 3, ..Shape::default() }).cut(random)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn samples_are_as_defined(seed: u64) {
        let mut random = Random(seed);
        let hierarchy = mesh(&mut random);
        let volume = volume(hierarchy.clone(), noise);
        let stored = Field::centered_from_fn("value", Centering::Nodes, &hierarchy, noise);
        let definition = BruteForce::new(&hierarchy, &stored);
        let points: Vec<[f64; 3]> = (0..300).map(|_| random.point(hierarchy.bounds())).collect();
        let exact = volume.sample_with_gradients(&points);
        for ((point, packed), exact) in points.iter().zip(volume.sample(&points)).zip(exact) {
            let expected = definition.sample(Method::Nodal, *point);
            prop_assert!((exact.value - expected).abs() < 1e-9, "{point:?}: {}, expected {expected}", exact.value);
            prop_assert!((packed - expected).abs() < 1e-5, "{point:?}: {packed}, expected {expected}");
        }
    }

    #[test]
    fn values_do_not_jump_where_levels_meet(seed: u64) {
        let mut random = Random(seed);
        let hierarchy = mesh(&mut random);
        let volume = volume(hierarchy.clone(), noise);
        let finest = hierarchy.finest_level();
        for _ in 0..200 {
            // A place on a brick's face, and its two sides.
            let level = random.integer(0, finest as i64) as usize;
            let bricks = hierarchy.levels()[level].bricks();
            let brick = bricks[random.integer(0, bricks.len() as i64 - 1) as usize];
            let mut cells = random.point([brick.low, brick.high].map(|corner| corner.map(|index| index as f64)));
            let axis = random.integer(0, 2) as usize;
            cells[axis] = if random.chance(0.5) { brick.low[axis] } else { brick.high[axis] } as f64;
            let sides = [-1e-9, 1e-9].map(|step| {
                let mut beside = cells;
                beside[axis] += step;
                hierarchy.to_world(level, beside)
            });
            let values = sides.map(|side| volume.sample_with_gradients(&[side])[0].value);
            if values.iter().all(|value| value.is_finite()) {
                prop_assert!((values[0] - values[1]).abs() < 1e-6, "{cells:?} of level {level}: {values:?}");
            }
        }
    }

    #[test]
    fn linear_fields_stay_linear(seed: u64) {
        let mut random = Random(seed);
        let hierarchy = mesh(&mut random);
        let linear = |[x, y, z]: [f64; 3]| 3.0 + x - 2.0 * y + 0.5 * z;
        let places = hierarchy.clone();
        let volume = volume(hierarchy.clone(), |level, node| linear(places.to_world(level, node.map(|index| index as f64))));
        let points: Vec<[f64; 3]> = (0..100).map(|_| random.point(hierarchy.bounds())).collect();
        for (point, sample) in points.iter().zip(volume.sample_with_gradients(&points)) {
            prop_assert!((sample.value - linear(*point)).abs() < 1e-9 * (1.0 + linear(*point).abs()));
            for (slope, expected) in sample.gradient.into_iter().zip([1.0, -2.0, 0.5]) {
                prop_assert!((slope - expected).abs() < 1e-6, "{:?}", sample.gradient);
            }
        }
    }
}

#[test]
fn restriction_gives_coarse_nodes_what_finer_ones_hold() {
    let hierarchy = amray_testing::nested(8, 3, 4);
    let field = Field::centered_from_fn("value", Centering::Nodes, &hierarchy, noise);
    let restricted = field.restricted(&hierarchy);
    let finest = hierarchy.levels()[2].bricks();
    for (place, brick) in hierarchy.bricks().enumerate() {
        for node in Centering::Nodes.values_of(&brick.cells).iter() {
            let inside = std::array::from_fn(|axis| (node[axis] - brick.cells.low[axis]) as usize);
            let of_level = |level: usize| -> [i64; 3] { node.map(|index| index << (level - brick.level)) };
            let has = |level: usize| {
                let touches =
                    |cells: &amray::hierarchy::IndexBox| Centering::Nodes.values_of(cells).contains(of_level(level));
                hierarchy.levels()[level].bricks().iter().any(touches)
            };
            let source =
                (brick.level..=2).rev().find(|&level| level == brick.level || (brick.level + 1..=level).all(has));
            let source = source.unwrap();
            assert_eq!(restricted.value(place, inside), noise(source, of_level(source)), "{brick:?}, {node:?}");
        }
    }
    assert!(!finest.is_empty());
}
