//! Sets of blocks of cells: bits in tiles, so that millions of blocks are small and neighbours are found by shifting.

use std::collections::BTreeMap;

use amray::hierarchy::IndexBox;

/// Blocks per side of a tile: one word holds a row.
pub(super) const TILE_SIDE: i64 = 32;
const ROWS: usize = (TILE_SIDE * TILE_SIDE) as usize;

/// The blocks of a set that lie in one cube of the lattice, counted from its low corner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    /// Rows along x, y faster than z; bit i is the block at x = i.
    rows: Box<[u32; ROWS]>,
}

impl Tile {
    pub(super) fn empty() -> Self {
        Self { rows: Box::new([0; ROWS]) }
    }

    pub(super) fn row(&self, y: i64, z: i64) -> u32 {
        self.rows[row_number(y, z)]
    }

    pub(super) fn insert(&mut self, block: [i64; 3]) {
        self.rows[row_number(block[1], block[2])] |= 1 << block[0];
    }

    /// The blocks that both tiles hold.
    pub(super) fn intersection(&self, other: &Self) -> Self {
        let mut both = self.clone();
        both.rows.iter_mut().zip(other.rows.iter()).for_each(|(row, other)| *row &= other);
        both
    }
}

fn row_number(y: i64, z: i64) -> usize {
    (y + TILE_SIDE * z) as usize
}

/// A set of blocks.
#[derive(Debug, Default)]
pub(super) struct BlockSet {
    tiles: BTreeMap<[i64; 3], Tile>,
}

impl BlockSet {
    pub(super) fn insert(&mut self, block: [i64; 3]) {
        let place = block.map(|index| index.div_euclid(TILE_SIDE));
        let tile = self.tiles.entry(place).or_insert_with(Tile::empty);
        tile.insert(block.map(|index| index.rem_euclid(TILE_SIDE)));
    }

    pub(super) fn insert_box(&mut self, blocks: &IndexBox) {
        blocks.iter().for_each(|block| self.insert(block));
    }

    /// The tiles that hold any block, with their places in the lattice of tiles, always in the same order.
    pub(super) fn tiles(&self) -> impl Iterator<Item = ([i64; 3], &Tile)> {
        self.tiles.iter().map(|(&place, tile)| (place, tile))
    }

    /// The blocks of one tile whose 26 neighbours are all in the set, or outside `domain`.
    pub(super) fn interior(&self, place: [i64; 3], domain: &IndexBox) -> Tile {
        /// A row, or a plane of rows, with the ones next to the tile on both sides.
        const PADDED: usize = TILE_SIDE as usize + 2;
        let low = place.map(|index| index * TILE_SIDE);
        let around = |axis: usize, number: usize| low[axis] + number as i64 - 1;
        let inside = |axis: usize, index: i64| (domain.low[axis]..domain.high[axis]).contains(&index);

        let beyond_x = (0..PADDED).filter(|&x| !inside(0, around(0, x))).fold(0u64, |bits, x| bits | 1 << x);
        let mut along_x = vec![[u32::MAX; PADDED]; PADDED];
        for (z, plane) in along_x.iter_mut().enumerate() {
            for (y, row) in plane.iter_mut().enumerate() {
                let (y, z) = (around(1, y), around(2, z));
                if inside(1, y) && inside(2, z) {
                    let bits = self.padded_row(place[0], y, z) | beyond_x;
                    *row = (bits & bits >> 1 & bits >> 2) as u32;
                }
            }
        }
        let mut interior = Tile::empty();
        for z in 0..TILE_SIDE as usize {
            for y in 0..TILE_SIDE as usize {
                let nine = along_x[z..z + 3].iter().flat_map(|plane| &plane[y..y + 3]);
                interior.rows[row_number(y as i64, z as i64)] = nine.fold(u32::MAX, |all, row| all & row);
            }
        }
        interior
    }

    /// The row of a tile with one block more on either side: bit 0 is the last block of the tile before it.
    fn padded_row(&self, tile_x: i64, y: i64, z: i64) -> u64 {
        let row = |step: i64| {
            let place = [tile_x + step, y.div_euclid(TILE_SIDE), z.div_euclid(TILE_SIDE)];
            let tile = self.tiles.get(&place);
            u64::from(tile.map_or(0, |tile| tile.row(y.rem_euclid(TILE_SIDE), z.rem_euclid(TILE_SIDE))))
        };
        row(-1) >> (TILE_SIDE - 1) | row(0) << 1 | (row(1) & 1) << (TILE_SIDE + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(tile: &Tile) -> Vec<[i64; 3]> {
        let all = IndexBox::new([0; 3], [TILE_SIDE; 3]);
        all.iter().filter(|&[x, y, z]| tile.row(y, z) >> x & 1 == 1).collect()
    }

    #[test]
    fn blocks_fall_into_tiles() {
        let mut set = BlockSet::default();
        set.insert([31, 0, 0]);
        set.insert([32, 64, 5]);
        let found: Vec<_> = set.tiles().map(|(place, tile)| (place, blocks(tile))).collect();
        assert_eq!(found, [([0, 0, 0], vec![[31, 0, 0]]), ([1, 2, 0], vec![[0, 0, 5]])]);
    }

    #[test]
    fn the_interior_keeps_one_block_of_distance_across_tiles() {
        let domain = IndexBox::new([0; 3], [70, 70, 70]);
        let filled = IndexBox::new([20, 0, 25], [70, 40, 40]);
        let mut set = BlockSet::default();
        set.insert_box(&filled);
        // Missing blocks take their neighbours away; the domain's own faces (x = 70, y = 0) do not.
        set.tiles.get_mut(&[1, 0, 1]).unwrap().rows[row_number(10, 2)] &= !(1 << 3);
        let hole = [35, 10, 34];
        let expected = |block: [i64; 3]| {
            IndexBox::new([21, 0, 26], [70, 39, 39]).contains(block)
                && !IndexBox::new(hole, hole.map(|index| index + 1)).grown([1; 3]).contains(block)
        };
        let mut seen = 0;
        for tile in IndexBox::new([0; 3], [3; 3]).iter() {
            let found = blocks(&set.interior(tile, &domain));
            for block in IndexBox::new([0; 3], [TILE_SIDE; 3]).iter() {
                let place = [0, 1, 2].map(|axis| tile[axis] * TILE_SIDE + block[axis]);
                if domain.contains(place) {
                    assert_eq!(found.contains(&block), expected(place), "{place:?}");
                    seen += usize::from(expected(place));
                }
            }
        }
        assert_eq!(seen, 49 * 39 * 13 - 27);
    }
}
