//! Where the blocks of an Athena++ file lie.

use amray::hierarchy::{Hierarchy, HierarchyError, IndexBox};

use super::per_axis;
use crate::FormatError;
use crate::hdf5::Hdf5Group;
use crate::refined::Root;

/// Athena++ itself counts locations in 32 bits.
const MOST_LEVELS: i64 = 32;
/// Faces are written in single precision: so many cells may they be off.
const TOLERANCE: f64 = 0.05;

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
        if size.iter().chain(&block).any(|&cells| !(1..=1 << 30).contains(&cells)) {
            return Err(root.malformed(&format!("RootGridSize {size:?} and MeshBlockSize {block:?}, expected counts")));
        }
        if size.contains(&1) {
            return Err(root.malformed(&format!("RootGridSize is {size:?}, expected three dimensions")));
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

    pub(super) fn ghosts(&self) -> [u64; 3] {
        self.ghosts.map(i64::cast_unsigned)
    }

    pub(super) fn block_size(&self) -> [u64; 3] {
        self.block.map(i64::cast_unsigned)
    }

    fn cells(&self, place: [i64; 3]) -> IndexBox {
        IndexBox::new(place, place.map(|index| index + 1)).refined(self.block)
    }

    /// Files with ghost zones do not say so: their blocks are larger, and begin before the place that their location gives.
    fn find_ghosts(&mut self, root: &Hdf5Group, axis: usize) -> Result<(), FormatError> {
        let faces = root.data_set(&format!("x{}f", axis + 1))?;
        let stored = self.block[axis];
        let blocks: usize = self.levels.iter().map(Vec::len).sum();
        if *faces.shape() != [blocks as u64, stored as u64 + 1] {
            let shape = faces.shape();
            return Err(faces.malformed(&format!("shape {shape:?}, expected {blocks} blocks of {} faces", stored + 1)));
        }
        let faces_of = faces.floats()?;
        let first = |block: u64| faces_of[block as usize * (stored as usize + 1)];
        // In cells of the block's level from the domain's low corner on.
        let begin = |level: usize, block: u64| (first(block) - self.root.low[axis]) / self.root.cell_size(level)[axis];
        let placed = || {
            let levels = self.levels.iter().enumerate();
            levels.flat_map(|(level, blocks)| blocks.iter().map(move |&(block, place)| (level, block, place[axis])))
        };
        let Some((level, block, place)) = placed().next() else { return Ok(()) };
        // place * (stored - 2 ghosts) - ghosts is where the block begins.
        let ghosts = ((place * stored) as f64 - begin(level, block)) / (2 * place + 1) as f64;
        let ghosts = if ghosts.is_finite() { ghosts.round() as i64 } else { -1 };
        let inner = stored - 2 * ghosts.clamp(0, stored);
        let off = placed().find(|&(level, block, place)| {
            let distance = (begin(level, block) - (place * inner - ghosts) as f64).abs();
            distance.is_nan() || distance > TOLERANCE * (1.0 + (place * inner) as f64 * 1e-4)
        });
        if ghosts < 0 || inner < 1 || off.is_some() {
            let block = off.map_or(block, |(_, block, _)| block);
            let problem = "the faces do not agree with LogicalLocations and RootGridSize";
            return Err(faces.malformed(&format!("block {block} begins at {}: {problem}", first(block))));
        }
        self.block[axis] = inner;
        self.ghosts[axis] = ghosts;
        Ok(())
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
        if place.iter().any(|index| !(0..1i64 << 40).contains(index)) {
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
