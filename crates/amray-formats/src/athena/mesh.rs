//! Where the blocks of an Athena++ file lie.

use amray::hierarchy::{Hierarchy, HierarchyError, IndexBox};

use super::per_axis;
use crate::FormatError;
use crate::hdf5::{Blocks, Hdf5Group, Hdf5Set};
use crate::refined::Root;

/// Athena++ itself counts locations in 32 bits.
const MOST_LEVELS: i64 = 32;
const LOCATIONS: i64 = 1 << 32;
/// With fewer cells than locations, no product of both overflows.
const MOST_CELLS: i64 = 1 << 30;
/// So many cells may faces be off,
const TOLERANCE: f64 = 1e-3;
/// and by this part of the largest position: they are computed and written in single precision.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// The blocks of a file.
pub(super) struct Mesh {
    root: Root,
    /// Cells of a block, without ghosts.
    block: [i64; 3],
    /// Ghost layers around each block in the file.
    ghosts: [i64; 3],
    /// Per level, the blocks' numbers in the file and where they are, in blocks of the level.
    levels: Vec<Vec<PlacedBlock>>,
}

/// A block's number in the file, and where it is.
type PlacedBlock = (u64, [i64; 3]);

impl Mesh {
    pub(super) fn read(root: &Hdf5Group) -> Result<Self, FormatError> {
        let size = per_axis(root, "RootGridSize", root.integer_list("RootGridSize")?)?;
        let block = per_axis(root, "MeshBlockSize", root.integer_list("MeshBlockSize")?)?;
        if size.iter().chain(&block).any(|&cells| !(1..=MOST_CELLS).contains(&cells)) {
            return Err(root.malformed(&format!("RootGridSize {size:?} and MeshBlockSize {block:?}, expected counts")));
        }
        for (name, cells) in [("RootGridSize", size), ("MeshBlockSize", block)] {
            if cells.contains(&1) {
                return Err(root.malformed(&format!("{name} is {cells:?}, expected three dimensions of several cells")));
            }
        }
        let (mut low, mut cell_size) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let name = format!("RootGridX{}", axis + 1);
            let [from, to, ratio] = per_axis(root, &name, root.float_list(&name)?)?;
            if ratio != 1.0 {
                let expected = "expected 1: grids with cells of growing width cannot be shown";
                return Err(root.malformed(&format!("{name} has the cell ratio {ratio}, {expected}")));
            }
            low[axis] = from;
            cell_size[axis] = (to - from) / size[axis] as f64;
        }
        let levels = levels(root)?;
        let grid = Root { low, cell_size, cells: size, ratio: 2 };
        let mut mesh = Self { root: grid, block, ghosts: [0; 3], levels };
        for axis in 0..3 {
            mesh.find_ghosts(root, axis)?;
        }
        Ok(mesh)
    }

    pub(super) fn hierarchy(&self) -> Result<Hierarchy, HierarchyError> {
        let levels = self.levels.iter().enumerate();
        let bricks =
            levels.flat_map(|(level, blocks)| blocks.iter().map(move |&(_, place)| (level, self.cells(place))));
        self.root.hierarchy(self.levels.len(), bricks)
    }

    /// The blocks' numbers in the file, in the order of the hierarchy's bricks.
    pub(super) fn blocks(&self) -> Vec<u64> {
        self.levels.iter().flatten().map(|&(number, _)| number).collect()
    }

    /// Where the blocks of some `numbers` lie in a data set.
    pub(super) fn blocks_in<'a>(&self, leading: &'a [u64], numbers: &'a [u64]) -> Blocks<'a> {
        let [ghosts, size] = [self.ghosts, self.block].map(|axes| axes.map(i64::cast_unsigned));
        Blocks { leading, numbers: Some(numbers), ghosts, size }
    }

    fn cells(&self, place: [i64; 3]) -> IndexBox {
        IndexBox::new(place, place.map(|index| index + 1)).refined(self.block)
    }

    /// Files with ghost zones do not say so: their blocks are larger, and begin before the place that their location gives.
    fn find_ghosts(&mut self, root: &Hdf5Group, axis: usize) -> Result<(), FormatError> {
        let faces = Faces::read(root, axis, self.levels.iter().map(Vec::len).sum(), self.block[axis])?;
        let Some((level, block, place)) = self.placed(axis).next() else { return Ok(()) };
        let (stored, first) = (self.block[axis], faces.of(block)[0]);
        // place * (stored - 2 ghosts) - ghosts is where the block begins.
        let ghosts = ((place * stored) as f64 - self.cells_to(first, level, axis)) / (2 * place + 1) as f64;
        let ghosts = if ghosts.is_finite() { ghosts.round() as i64 } else { -1 };
        let inner = stored - 2 * ghosts.clamp(0, stored);
        if ghosts < 0 || inner < 1 {
            let expected = "expected it where LogicalLocations and RootGridSize put it, or some ghost cells before";
            return Err(faces.set.malformed(&format!("block {block} begins at {first}, {expected}")));
        }
        self.block[axis] = inner;
        self.ghosts[axis] = ghosts;
        self.expect_even(&faces, axis)
    }

    /// Checks that all faces are where cells of one width have them.
    fn expect_even(&self, faces: &Faces, axis: usize) -> Result<(), FormatError> {
        let (inner, ghosts) = (self.block[axis], self.ghosts[axis]);
        let (low, width) = (self.root.low[axis], self.root.cell_size[axis]);
        let largest = low.abs().max((low + width * self.root.cells[axis] as f64).abs());
        for (level, block, place) in self.placed(axis) {
            let width = self.root.cell_size(level)[axis];
            let tolerance = TOLERANCE + ROUNDING * largest / width;
            for (number, &face) in faces.of(block).iter().enumerate() {
                let cells = (place * inner - ghosts + number as i64) as f64;
                let off = (self.cells_to(face, level, axis) - cells).abs();
                if off.is_nan() || off > tolerance {
                    let expected = format!("expected {} by its level and location", low + width * cells);
                    return Err(faces.set.malformed(&format!(
                        "face {number} of block {block} is at {face}, {expected}: cells of other widths cannot be shown"
                    )));
                }
            }
        }
        Ok(())
    }

    /// The level and number of each block, and where it is along an axis, in blocks.
    fn placed(&self, axis: usize) -> impl Iterator<Item = (usize, u64, i64)> {
        let levels = self.levels.iter().enumerate();
        levels.flat_map(move |(level, blocks)| blocks.iter().map(move |&(block, place)| (level, block, place[axis])))
    }

    /// A position in cells of a level, from the domain's low corner on.
    fn cells_to(&self, position: f64, level: usize, axis: usize) -> f64 {
        (position - self.root.low[axis]) / self.root.cell_size(level)[axis]
    }
}

/// The positions of all blocks' faces along an axis.
struct Faces {
    set: Hdf5Set,
    positions: Vec<f64>,
    per_block: usize,
}

impl Faces {
    fn read(root: &Hdf5Group, axis: usize, blocks: usize, cells: i64) -> Result<Self, FormatError> {
        let set = root.data_set(&format!("x{}f", axis + 1))?;
        let per_block = cells as usize + 1;
        if *set.shape() != [blocks as u64, per_block as u64] {
            let problem = format!("shape {:?}, expected {blocks} blocks of {per_block} faces", set.shape());
            return Err(set.malformed(&problem));
        }
        let positions = set.floats()?;
        Ok(Self { set, positions, per_block })
    }

    fn of(&self, block: u64) -> &[f64] {
        let start = block as usize * self.per_block;
        &self.positions[start..start + self.per_block]
    }
}

/// The blocks of each level.
fn levels(root: &Hdf5Group) -> Result<Vec<Vec<PlacedBlock>>, FormatError> {
    let (of_blocks, places) = (root.data_set("Levels")?, root.data_set("LogicalLocations")?);
    let (numbers, locations) = (of_blocks.integers()?, places.integers()?);
    if locations.len() != numbers.len().saturating_mul(3) {
        let found = locations.len();
        return Err(places.malformed(&format!("{found} numbers, expected 3 for each of {} blocks", numbers.len())));
    }
    let mut levels = Vec::new();
    for ((block, &level), place) in numbers.iter().enumerate().zip(locations.as_chunks::<3>().0) {
        if !(0..MOST_LEVELS).contains(&level) {
            let expected = format!("expected 0 to {}", MOST_LEVELS - 1);
            return Err(of_blocks.malformed(&format!("block {block} is of level {level}, {expected}")));
        }
        if place.iter().any(|index| !(0..LOCATIONS).contains(index)) {
            return Err(places.malformed(&format!("block {block} is at {place:?}, outside of any domain")));
        }
        let level = level as usize;
        if levels.len() <= level {
            levels.resize_with(level + 1, Vec::new);
        }
        levels[level].push((block as u64, *place));
    }
    Ok(levels)
}
