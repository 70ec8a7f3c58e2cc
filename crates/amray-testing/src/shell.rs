//! A mesh as octree codes make it, for measurements: blocks of cells refined where they meet a sphere's surface.

use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};

use crate::tiles;

/// Level 0 has this many blocks per axis.
const BLOCKS: i64 = 4;
/// Cells of a block per axis: what is refined as a whole.
const BLOCK: i64 = 16;
/// The sphere's radius, in units of the domain's side.
const RADIUS: f64 = 0.35;

/// A unit cube, each level at a ratio of 2 around a sphere's surface in its middle. Coarse cells stay under fine ones.
///
/// The cells depend on the number of levels alone. In bricks of 16 cells per axis, 4, 5 and 6 levels are 6016, 25 280
/// and 101 184 bricks; in bricks of 8 eight times as many.
#[derive(Clone, Copy, Debug)]
pub struct Shell {
    /// The number of levels.
    pub levels: usize,
    /// Cells of a brick per axis: 8, 16 or 32.
    pub brick: i64,
}

impl Shell {
    /// The mesh, its bricks in the order of a tree's descent.
    pub fn hierarchy(&self) -> Hierarchy {
        let mut blocks: Vec<[i64; 3]> = IndexBox::new([0; 3], [BLOCKS; 3]).iter().collect();
        let mut cells = tiles(&IndexBox::new([0; 3], [BLOCKS * BLOCK; 3]), self.brick);
        let levels = (0..self.levels).map(|level| {
            let side = BLOCKS << level;
            let description = LevelDescription {
                ratio: [if level == 0 { 1 } else { 2 }; 3],
                cell_size: [1.0 / (side * BLOCK) as f64; 3],
                domain: IndexBox::new([0; 3], [side * BLOCK; 3]),
                bricks: std::mem::take(&mut cells),
            };
            let refined = blocks.iter().filter(|&&block| meets_the_sphere(block, side));
            let refined: Vec<IndexBox> =
                refined.map(|block| IndexBox::new(block.map(|i| 2 * i), block.map(|i| 2 * i + 2))).collect();
            cells = refined.iter().flat_map(|blocks| tiles(&blocks.refined([BLOCK; 3]), self.brick)).collect();
            blocks = refined.iter().flat_map(IndexBox::iter).collect();
            description
        });
        Hierarchy::new([0.0; 3], levels.collect()).expect("blocks are refined as a whole")
    }
}

/// Whether the sphere's surface passes through a block of a level with `side` blocks per axis.
fn meets_the_sphere(block: [i64; 3], side: i64) -> bool {
    let middle = side as f64 / 2.0;
    let radius = RADIUS * side as f64;
    let (mut nearest, mut farthest) = (0.0, 0.0);
    for low in block.map(|low| low as f64) {
        let (a, b) = ((low - middle).abs(), (low + 1.0 - middle).abs());
        // No block straddles the middle: the number of blocks per axis is even.
        nearest += a.min(b).powi(2);
        farthest += a.max(b).powi(2);
    }
    nearest <= radius * radius && radius * radius <= farthest
}
