//! Bricks that are joined, and bricks that are added under leaf cells: random octrees and random meshes.

use std::collections::HashMap;

use amray::Volume;
use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
use amray::index::Index;
use amray::reconstruction::Method;
use amray_testing::{Case, Random, RandomMesh, Shape, noise};
use proptest::prelude::*;
use std::sync::Arc;

/// Leaf blocks of `side` cells of an octree that starts with `roots` blocks per axis; `low` is its first block.
fn octree(random: &mut Random, roots: [i64; 3], low: [i64; 3], side: i64, levels: usize) -> Hierarchy {
    let mut blocks = vec![Vec::new(); levels];
    let mut level: Vec<[i64; 3]> =
        IndexBox::new(low, std::array::from_fn(|axis| low[axis] + roots[axis])).iter().collect();
    for finer in 0..levels {
        let last = finer + 1 == levels;
        let (split, leaves): (Vec<_>, Vec<_>) = level.into_iter().partition(|_| !last && random.chance(0.4));
        blocks[finer] = leaves;
        let children = |block: [i64; 3]| IndexBox::new(block, block.map(|index| index + 1)).refined([2; 3]).iter();
        level = split.into_iter().flat_map(children).collect();
    }
    let box_of = |block: [i64; 3]| IndexBox::new(block, block.map(|index| index + 1)).refined([side; 3]);
    let domain = IndexBox::new(low, std::array::from_fn(|axis| low[axis] + roots[axis])).refined([side; 3]);
    let descriptions = blocks.into_iter().enumerate().map(|(number, mut blocks)| {
        // In no order that helps.
        for last in (1..blocks.len()).rev() {
            blocks.swap(last, random.integer(0, last as i64) as usize);
        }
        LevelDescription {
            ratio: [if number == 0 { 1 } else { 2 }; 3],
            cell_size: [1.0 / (1u64 << number) as f64; 3],
            domain: domain.refined([1 << number; 3]),
            bricks: blocks.into_iter().map(box_of).collect(),
        }
    });
    Hierarchy::new([0.5, 0.0, -2.0], descriptions.collect()).unwrap()
}

/// All cells with their values.
fn cells(hierarchy: &Hierarchy, field: &Field) -> HashMap<(usize, [i64; 3]), f64> {
    let mut cells = HashMap::new();
    for (place, brick) in hierarchy.bricks().enumerate() {
        for cell in brick.cells.iter() {
            let inside = std::array::from_fn(|axis| (cell[axis] - brick.cells.low[axis]) as usize);
            assert!(cells.insert((brick.level, cell), field.value(place, inside)).is_none());
        }
    }
    cells
}

/// The mean of a cell's finer ones; `None` where some are missing.
fn mean_of_finer(
    known: &HashMap<(usize, [i64; 3]), f64>,
    hierarchy: &Hierarchy,
    level: usize,
    cell: [i64; 3],
) -> Option<f64> {
    let ratio = hierarchy.levels().get(level + 1)?.ratio();
    let finer = IndexBox::new(cell, cell.map(|index| index + 1)).refined(ratio);
    let values: Option<Vec<f64>> = finer.iter().map(|cell| known.get(&(level + 1, cell)).copied()).collect();
    values.map(|values| values.iter().sum::<f64>() / values.len() as f64)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn joined_bricks_hold_the_same_cells(seed: u64, tile in 1i64..40) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape::default());
        let case = Case::new(mesh.cut(&mut random), noise);
        let merged = case.hierarchy.merged(tile).unwrap();
        prop_assert!(merged.hierarchy().brick_count() <= case.hierarchy.brick_count());
        let field = merged.apply(&case.field);
        prop_assert_eq!(cells(merged.hierarchy(), &field), cells(&case.hierarchy, &case.field));
    }

    #[test]
    fn octrees_are_completed_with_means(seed: u64, side in 1i64..5, levels in 1usize..5) {
        let mut random = Random(seed);
        let side = 2 * side;
        let roots = [random.integer(1, 3), random.integer(1, 3), random.integer(1, 2)];
        let low = [random.integer(-2, 2), 0, random.integer(-9, 9)];
        let hierarchy = octree(&mut random, roots, low, side, levels);
        let leaves = Field::from_fn("value", &hierarchy, noise);
        let merged = hierarchy.merged(16).unwrap();
        let completed = merged.hierarchy().completed().unwrap();
        let field = completed.apply(&merged.apply(&leaves));
        prop_assert!(completed.hierarchy().warnings().is_empty(), "{:?}", completed.hierarchy().warnings());
        let (stored, all) = (cells(&hierarchy, &leaves), cells(completed.hierarchy(), &field));
        // Every level has cells wherever a finer one has.
        for &(level, cell) in stored.keys().filter(|(level, _)| *level > 0) {
            prop_assert!(all.contains_key(&(level - 1, cell.map(|index| index.div_euclid(2)))));
        }
        for (&(level, cell), &value) in &all {
            match stored.get(&(level, cell)) {
                Some(&leaf) => prop_assert_eq!(value, leaf),
                None => {
                    let mean = mean_of_finer(&all, completed.hierarchy(), level, cell);
                    prop_assert!((value - mean.unwrap()).abs() < 1e-14, "{value} {mean:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_added_changes_no_leaf(seed: u64) {
        let mut random = Random(seed);
        // Fine bricks may stick out here, and cover coarse cells in part.
        let mesh = RandomMesh::new(&mut random, Shape { holes: true, improper_nesting: true, ..Shape::default() });
        let case = Case::new(mesh.cut(&mut random), noise);
        let completed = case.hierarchy.completed().unwrap();
        let field = completed.apply(&case.field);
        let (stored, all) = (cells(&case.hierarchy, &case.field), cells(completed.hierarchy(), &field));
        for (&(level, cell), &value) in &all {
            match stored.get(&(level, cell)) {
                Some(&before) => prop_assert_eq!(value, before),
                None => {
                    let mean = mean_of_finer(&all, completed.hierarchy(), level, cell);
                    prop_assert!((value - mean.unwrap()).abs() < 1e-14, "{value} {mean:?}");
                }
            }
        }
        let volume = Volume::new(Arc::new(Index::build(completed.hierarchy().clone())), field, Method::Nearest);
        for _ in 0..500 {
            let point = case.point(&mut random);
            let (found, expected) = (volume.sample_with_gradients(&[point])[0].value, case.sample(Method::Nearest, point));
            prop_assert!(found == expected || found.is_nan() && expected.is_nan(), "{point:?}: {found}, {expected}");
        }
    }
}

#[test]
fn blocks_of_an_octree_become_few_bricks() {
    let hierarchy = octree(&mut Random(5), [16; 3], [0; 3], 2, 1);
    assert_eq!(hierarchy.brick_count(), 4096);
    assert_eq!(hierarchy.merged(32).unwrap().hierarchy().brick_count(), 1);
    assert_eq!(hierarchy.merged(16).unwrap().hierarchy().brick_count(), 8);
}

#[test]
fn a_cell_of_which_a_part_is_missing_gets_no_brick_below() {
    let level = |ratio: i64, size: i64, bricks: Vec<IndexBox>| LevelDescription {
        ratio: [ratio; 3],
        cell_size: [8.0 / size as f64; 3],
        domain: IndexBox::new([0; 3], [size; 3]),
        bricks,
    };
    let one = vec![IndexBox::new([0; 3], [2; 3])];
    let levels = vec![level(1, 8, Vec::new()), level(2, 16, Vec::new()), level(2, 32, one)];
    let completed = Hierarchy::new([0.0; 3], levels).unwrap().completed().unwrap();
    // Two cells of the finest level per axis make one of level 1: half a cell of level 0.
    let bricks: Vec<usize> = completed.hierarchy().levels().iter().map(|level| level.bricks().len()).collect();
    assert_eq!(bricks, [0, 0, 1]);
}
