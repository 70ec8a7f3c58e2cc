//! The kd-tree on random hierarchies: every query against a search through all bricks.

use std::collections::HashSet;
use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
use amray::index::{Index, Planes, Ray, ValueRanges};
use amray::reconstruction::Method;
use amray_testing::{Random, RandomMesh, Shape};
use proptest::prelude::*;

fn random_index(seed: u64) -> (Arc<Hierarchy>, Index, Random) {
    let mut random = Random(seed);
    let shape = Shape { holes: seed.is_multiple_of(3), improper_nesting: seed.is_multiple_of(4), ..Shape::default() };
    let hierarchy = Arc::new(RandomMesh::new(&mut random, shape).cut(&mut random));
    (hierarchy.clone(), Index::build(hierarchy), random)
}

/// The finest brick on `level` or coarser over a cell of the finest level: (level, place in `bricks()`).
fn search(hierarchy: &Hierarchy, level: usize, cell: [i64; 3]) -> Option<(usize, usize)> {
    let holds = |(place, brick): (usize, amray::hierarchy::Brick)| {
        let cells = brick.cells.refined(hierarchy.levels()[brick.level].finest_cells());
        (brick.level <= level && cells.contains(cell)).then_some((brick.level, place))
    };
    hierarchy.bricks().enumerate().filter_map(holds).max()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn finds_what_a_search_finds(seed: u64) {
        let (hierarchy, index, mut random) = random_index(seed);
        let domain = index.domain();
        for _ in 0..200 {
            let cell = std::array::from_fn(|axis| random.integer(domain.low[axis] - 1, domain.high[axis]));
            let found = index.find_leaf(cell).map(|found| (found.level, found.brick));
            prop_assert_eq!(found, search(&hierarchy, usize::MAX, cell));
            if let Some(found) = index.find_leaf(cell) {
                let description = &hierarchy.levels()[found.level];
                let low = description.brick_at(found.brick).low;
                let size = description.finest_cells();
                let logical: [i64; 3] = std::array::from_fn(|axis| low[axis] + found.cell[axis] as i64);
                prop_assert!(IndexBox::new(logical, logical.map(|i| i + 1)).refined(size).contains(cell));
                prop_assert!(!found.covered);
            }
        }
    }

    #[test]
    fn a_dual_cell_is_eight_cells(seed: u64) {
        let (hierarchy, index, mut random) = random_index(seed);
        for _ in 0..100 {
            let level = random.integer(0, hierarchy.finest_level() as i64) as usize;
            let domain = hierarchy.levels()[level].domain();
            let planes = Planes {
                cells: std::array::from_fn(|axis| {
                    [(); 2].map(|()| random.integer(domain.low[axis], domain.high[axis] - 1))
                }),
                active: (random.bits() % 64) as u8,
            };
            let mut seen = Vec::new();
            index.find_dual(level, &planes, &mut |corner, found| seen.push((corner, found)));
            seen.sort_unstable_by_key(|&(corner, _)| corner);
            let expected: Vec<_> = Planes::corners(planes.active)
                .map(|corner| {
                    let cell = std::array::from_fn(|axis| planes.cells[axis][corner >> axis & 1]);
                    (corner, index.find_cell(level, cell))
                })
                .collect();
            prop_assert_eq!(seen, expected);
        }
    }

    #[test]
    fn regions_tile_the_domain_and_count_its_cells(seed: u64) {
        let (hierarchy, index, _) = random_index(seed);
        let mut cells = 0;
        index.for_each_region(&mut |_, region| cells += region.cells());
        prop_assert_eq!(cells, index.domain().cells());
        // A leaf cell is one that shows: some cell of the finest level has it for its leaf.
        prop_assume!(index.domain().cells() <= 200_000);
        let mut leaves = vec![HashSet::new(); hierarchy.levels().len()];
        for cell in index.domain().iter() {
            if let Some((level, _)) = search(&hierarchy, usize::MAX, cell) {
                let size = hierarchy.levels()[level].finest_cells();
                let leaf: [i64; 3] = std::array::from_fn(|axis| cell[axis].div_euclid(size[axis]));
                leaves[level].insert(leaf);
            }
        }
        let expected: Vec<u64> = leaves.iter().map(|cells| cells.len() as u64).collect();
        prop_assert_eq!(index.leaf_cells(), expected);
        let field = Field::from_fn("level", &hierarchy, |level, _| level as f32);
        let volume = Volume::new(Arc::new(index), field, Method::Nearest);
        let folded = volume.fold_leaf_cells(
            || 0,
            |count, cell| {
                assert_eq!(cell.value, cell.level as f64);
                *count += 1;
            },
            |a, b| a + b,
        );
        prop_assert_eq!(folded, leaves.iter().map(HashSet::len).sum::<usize>());
    }

    #[test]
    fn pieces_of_a_level_are_disjoint_and_complete(seed: u64) {
        let (hierarchy, index, mut random) = random_index(seed);
        for (level, description) in hierarchy.levels().iter().enumerate() {
            let domain = description.domain();
            let corners = [(); 2].map(|()| domain.clamp(std::array::from_fn(|axis| {
                random.integer(domain.low[axis], domain.high[axis] - 1)
            })));
            let cells = IndexBox::new(
                std::array::from_fn(|axis| corners[0][axis].min(corners[1][axis])),
                std::array::from_fn(|axis| corners[0][axis].max(corners[1][axis]) + 1),
            );
            let mut found = 0;
            index.for_each_piece(level, &cells, &mut |brick, piece| {
                assert!(description.brick_at(brick).contains_box(&piece));
                found += piece.cells();
            });
            let expected: u64 = description.bricks().iter().map(|brick| brick.intersection(&cells).cells()).sum();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn a_walk_meets_every_region_on_the_ray_in_order(seed: u64) {
        let (_, index, mut random) = random_index(seed);
        let corners = [index.domain().low, index.domain().high].map(|corner| corner.map(|index| index as f64));
        for _ in 0..20 {
            let start = random.point(corners);
            let mut direction = random.point([[-1.0; 3], [1.0; 3]]);
            if random.chance(0.3) {
                direction[random.integer(0, 2) as usize] = 0.0;
            }
            let spans: Vec<_> = index.walk(Ray { start, direction }, 0.0, f64::INFINITY).collect();
            prop_assert!(spans.windows(2).all(|pair| pair[0].leave == pair[1].enter));
            for span in &spans {
                let middle = (span.enter + span.leave) / 2.0;
                let cell: [i64; 3] =
                    std::array::from_fn(|axis| (start[axis] + middle * direction[axis]).floor() as i64);
                if span.leave - span.enter > 1e-9 && index.domain().contains(cell) {
                    prop_assert_eq!(index.find_region(cell), span.region);
                }
            }
            // From a point inside, the walk starts there and ends on the domain's boundary.
            let last = spans.last().unwrap().leave;
            let on_boundary = (0..3).any(|axis| {
                let end = start[axis] + last * direction[axis];
                (end - corners[0][axis]).abs() < 1e-6 || (end - corners[1][axis]).abs() < 1e-6
            });
            prop_assert!(spans[0].enter == 0.0 && on_boundary);
        }
    }
}

/// `levels` levels over a unit cube, each a chequerboard of 16^3 bricks over a part of the coarser one.
fn bricks_of_16(levels: usize) -> Hierarchy {
    let descriptions = (0..levels)
        .map(|level| {
            let size = 128i64 << level;
            let mut bricks = Vec::new();
            let low = if level == 0 { 0 } else { size / 4 };
            for corner in IndexBox::new([low / 16; 3], [(size - low) / 16; 3]).iter() {
                let shown = level == 0 || (corner[0] / 2 + corner[1] / 2 + corner[2] / 2) % 3 != 0;
                if shown {
                    bricks.push(IndexBox::new(corner.map(|i| i * 16), corner.map(|i| (i + 1) * 16)));
                }
            }
            LevelDescription {
                ratio: [if level == 0 { 1 } else { 2 }; 3],
                cell_size: [1.0 / size as f64; 3],
                domain: IndexBox::new([0; 3], [size; 3]),
                bricks,
            }
        })
        .collect();
    Hierarchy::new([0.0; 3], descriptions).unwrap()
}

#[test]
fn the_index_is_small_beside_bricks_of_16() {
    let hierarchy = Arc::new(bricks_of_16(3));
    let index = Index::build(hierarchy.clone());
    let field = Field::from_fn("x", &hierarchy, |_, cell| cell[0] as f32);
    let ranges = ValueRanges::build(&index, &field);
    let share = (index.bytes() + ranges.bytes()) as f64 / (4 * hierarchy.cells()) as f64;
    assert!(share < 0.05, "{share} of single-precision values");
    let regions_per_brick = index.regions().len() as f64 / hierarchy.brick_count() as f64;
    assert!(regions_per_brick < 3.0, "{regions_per_brick}");
}

#[test]
fn bricks_and_levels_do_not_blow_the_tree_up() {
    // Cells at the corner of a huge domain, twenty levels deep.
    let levels = (0..20)
        .map(|level| LevelDescription {
            ratio: [if level == 0 { 1 } else { 2 }; 3],
            cell_size: [(-f64::from(level)).exp2(); 3],
            domain: IndexBox::new([-1 << (level + 8); 3], [1 << (level + 8); 3]),
            bricks: vec![IndexBox::new([-4; 3], [4; 3])],
        })
        .collect();
    let index = Index::build(Arc::new(Hierarchy::new([0.0; 3], levels).unwrap()));
    // Around each brick lie at most 26 others of a 3x3x3 arrangement.
    assert!(index.regions().len() <= 20 * 26, "{} regions", index.regions().len());
    assert_eq!(index.find_leaf([0; 3]).unwrap().level, 19);
    let mut expected = vec![512 - 64; 20];
    expected[19] = 512;
    assert_eq!(index.leaf_cells(), expected);
}
