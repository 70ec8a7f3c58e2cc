//! Where a brick is to be refined: around the cells whose density differs much from a neighbour's.

use amray::hierarchy::IndexBox;

use super::field;
use super::refinement::Refinement;

/// What changes is refined with so many cells around it.
const BUFFER: i64 = 1;

/// The blocks to refine because of a brick's cells and their next neighbours upward: of two neighbours, the brick that
/// holds the lower one looks at both. `side` is the level's number of cells per side.
pub(super) fn tagged_blocks(brick: &IndexBox, side: i64, how: &Refinement) -> Vec<[i64; 3]> {
    let domain = IndexBox::new([0; 3], [side; 3]);
    let cells = IndexBox::new(brick.low, brick.high.map(|index| side.min(index + 1)));
    let density: Vec<f64> = cells.iter().map(|cell| field::at_centre(cell, side)[0]).collect();
    let [columns, rows, _] = cells.size();
    let strides = [1, columns as usize, (columns * rows) as usize];
    let mut blocks = MarkedBlocks::within(&cells.grown([how.widest_buffer(); 3]), &domain, how.block());
    for (number, cell) in cells.iter().enumerate() {
        for axis in 0..3 {
            let mut neighbour = cell;
            neighbour[axis] += 1;
            if neighbour[axis] == cells.high[axis] {
                continue;
            }
            let contrast = contrast(density[number], density[number + strides[axis]]);
            if contrast > how.threshold {
                let pair = IndexBox::new(cell, neighbour.map(|index| index + 1));
                blocks.mark(&pair.grown([how.buffer(contrast); 3]));
            }
        }
    }
    blocks.list()
}

/// 0 for equal densities, towards 1 where one is many times the other.
fn contrast(a: f64, b: f64) -> f64 {
    (a - b).abs() / (a + b)
}

impl Refinement {
    /// How many cells to refine around two neighbours of this contrast.
    ///
    /// What the next level is going to refine again needs a margin: its blocks and their neighbours must lie in the
    /// bricks that are made now. There, a jump has the same contrast again and a slope one that is `ratio` times
    /// smaller; nothing tells them apart here, so the middle is expected.
    fn buffer(&self, contrast: f64) -> i64 {
        let expected = contrast / (self.ratio as f64).sqrt();
        if expected > self.threshold { self.widest_buffer() } else { BUFFER }
    }

    /// `n` cells of this level are `n * ratio` of the next, of which it keeps `n` and gives up one block.
    fn widest_buffer(&self) -> i64 {
        BUFFER.max(self.block().div_euclid(self.ratio - 1))
    }
}

/// Marks on the blocks of a small box.
struct MarkedBlocks {
    domain: IndexBox,
    block: i64,
    blocks: IndexBox,
    marked: Vec<bool>,
}

impl MarkedBlocks {
    fn within(cells: &IndexBox, domain: &IndexBox, block: i64) -> Self {
        let blocks = cells.intersection(domain).coarsened([block; 3]);
        Self { domain: *domain, block, blocks, marked: vec![false; blocks.cells() as usize] }
    }

    fn mark(&mut self, cells: &IndexBox) {
        let [columns, rows, _] = self.blocks.size();
        for block in cells.intersection(&self.domain).coarsened([self.block; 3]).iter() {
            let [x, y, z] = [0, 1, 2].map(|axis| block[axis] - self.blocks.low[axis]);
            self.marked[(x + columns * (y + rows * z)) as usize] = true;
        }
    }

    fn list(self) -> Vec<[i64; 3]> {
        self.blocks.iter().zip(self.marked).filter_map(|(block, marked)| marked.then_some(block)).collect()
    }
}
