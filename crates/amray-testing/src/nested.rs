//! Cubes inside cubes: the simplest hierarchy of many levels.

use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};

use crate::tiles;

/// A unit cube of `base` cells a side with a refined block in the middle, half as wide per level, `levels` levels of
/// ratio 2, cut into bricks of `brick` cells a side.
pub fn nested(base: i64, levels: usize, brick: i64) -> Hierarchy {
    let descriptions = (0..levels)
        .map(|level| {
            let size = base << level;
            let part = if level == 0 {
                IndexBox::new([0; 3], [size; 3])
            } else {
                IndexBox::new([size / 4; 3], [size - size / 4; 3])
            };
            LevelDescription {
                ratio: [if level == 0 { 1 } else { 2 }; 3],
                cell_size: [1.0 / size as f64; 3],
                domain: IndexBox::new([0; 3], [size; 3]),
                bricks: tiles(&part, brick),
            }
        })
        .collect();
    Hierarchy::new([0.0; 3], descriptions).expect("nested cubes are valid")
}

/// Level 0 of 8^3 cells in a unit cube, and one cube of 8^3 cells per finer level around one point, just below a third
/// of the way along each axis: on no coarse lattice.
pub fn nested_cubes(levels: usize) -> Hierarchy {
    let descriptions = (0..levels).map(|level| {
        let cells = 8i64 << level;
        let middle = cells / 3 / 2 * 2;
        let cube = IndexBox::new([middle - 4; 3], [middle + 4; 3]);
        LevelDescription {
            ratio: [if level == 0 { 1 } else { 2 }; 3],
            cell_size: [1.0 / cells as f64; 3],
            domain: IndexBox::new([0; 3], [cells; 3]),
            bricks: vec![if level == 0 { IndexBox::new([0; 3], [8; 3]) } else { cube }],
        }
    });
    Hierarchy::new([0.0; 3], descriptions.collect()).expect("nested cubes are valid")
}
