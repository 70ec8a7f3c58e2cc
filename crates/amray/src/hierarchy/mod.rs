//! What the data is: levels of bricks with their geometry, and fields of values over them. No search, no pictures.
//!
//! A [`Hierarchy`] holds geometry alone, so that all fields, and all time steps of an unchanging mesh, share one.

mod complete;
mod error;
mod field;
mod index_box;
mod lane_values;
mod merge;
mod normalisation;
mod overlap;
mod rebricking;
mod restrict;
mod validation;
mod values;

pub use error::{HierarchyError, HierarchyWarning};
pub(crate) use field::with_voxels;
pub use field::{Centering, Field, FieldError, FieldValues};
pub use index_box::IndexBox;
pub(crate) use lane_values::{LaneNormalisation, LaneValues};
pub use normalisation::Normalisation;
pub use rebricking::Rebricking;
pub use values::{BrickValues, OutOfBuffer, Residence, ValueBuffer, Voxel, VoxelType, bytes_of, contiguous_strides};

/// Levels of bricks over one domain.
///
/// World position = origin + index * cell size, per axis and on every level: cell (0, 0, 0) of each level has its low
/// corner at the origin, wherever the domain's own low corner lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy {
    origin: [f64; 3],
    levels: Vec<Level>,
    warnings: Vec<HierarchyWarning>,
}

/// What a reader knows of a level before it is validated.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelDescription {
    /// Cells per cell of the next coarser level, per axis; `[1, 1, 1]` on level 0.
    pub ratio: [i64; 3],
    /// A cell's width per axis, in world units.
    pub cell_size: [f64; 3],
    /// The domain in this level's cells.
    pub domain: IndexBox,
    /// The bricks, in the order of the file.
    pub bricks: Vec<IndexBox>,
}

/// One resolution of a hierarchy. Level 0 is the coarsest.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    ratio: [i64; 3],
    cell_size: [f64; 3],
    domain: IndexBox,
    bricks: Vec<IndexBox>,
    first_brick: usize,
    finest_cells: [i64; 3],
}

/// One brick of a hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Brick {
    /// The brick's level.
    pub level: usize,
    /// The brick's number on its level, as in the file.
    pub number: usize,
    /// Its cells, in indices of its level.
    pub cells: IndexBox,
}

impl Hierarchy {
    /// A validated hierarchy.
    ///
    /// `origin` is the world position of the low corner of cell (0, 0, 0), which may lie outside the domain.
    /// Level 0 need not fill the domain, and may even be empty where finer levels hold all cells.
    ///
    /// # Errors
    /// [`HierarchyError`] names the first level and brick that contradict the rest. Bricks of one level must not
    /// overlap, must lie in the domain, and must start and end on faces of the next coarser level's cells.
    pub fn new(origin: [f64; 3], levels: Vec<LevelDescription>) -> Result<Self, HierarchyError> {
        validation::validated(origin, levels)
    }

    /// World position of the low corner of cell (0, 0, 0) of every level.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// The levels, coarsest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The number of the finest level.
    pub fn finest_level(&self) -> usize {
        self.levels.len() - 1
    }

    /// What is unusual about the hierarchy but does not keep it from being rendered.
    pub fn warnings(&self) -> &[HierarchyWarning] {
        &self.warnings
    }

    /// The number of bricks of all levels.
    pub fn brick_count(&self) -> usize {
        self.levels.last().map_or(0, |level| level.first_brick + level.bricks.len())
    }

    /// All bricks, level by level, coarsest first: the order in which a [`Field`] holds its values.
    pub fn bricks(&self) -> impl Iterator<Item = Brick> + '_ {
        self.levels.iter().enumerate().flat_map(|(level, description)| {
            description.bricks.iter().enumerate().map(move |(number, &cells)| Brick { level, number, cells })
        })
    }

    /// The number of cells of all bricks, covered ones included.
    pub fn cells(&self) -> u64 {
        self.bricks().map(|brick| brick.cells.cells()).sum()
    }

    /// The domain's low and high corner in world units.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let Level { domain, cell_size, .. } = &self.levels[0];
        [domain.low, domain.high]
            .map(|corner| std::array::from_fn(|axis| self.origin[axis] + corner[axis] as f64 * cell_size[axis]))
    }

    /// The domain's longest side in world units.
    pub fn longest_side(&self) -> f64 {
        let [low, high] = self.bounds();
        (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
    }

    /// `point` in cells of `level`, from cell (0, 0, 0) on.
    pub fn to_cells(&self, level: usize, point: [f64; 3]) -> [f64; 3] {
        let cell_size = self.levels[level].cell_size;
        std::array::from_fn(|axis| (point[axis] - self.origin[axis]) / cell_size[axis])
    }

    /// The world position of a place given in cells of `level`; a cell's centre is its index plus one half.
    pub fn to_world(&self, level: usize, cells: [f64; 3]) -> [f64; 3] {
        let cell_size = self.levels[level].cell_size;
        std::array::from_fn(|axis| self.origin[axis] + cells[axis] * cell_size[axis])
    }

    /// The levels as [`Hierarchy::new`] takes them.
    pub fn descriptions(&self) -> Vec<LevelDescription> {
        let describe = |level: &Level| LevelDescription {
            ratio: level.ratio,
            cell_size: level.cell_size,
            domain: level.domain,
            bricks: level.bricks.clone(),
        };
        self.levels.iter().map(describe).collect()
    }

    /// The hierarchy as if levels finer than `finest` did not exist (all of it where there are none). It has no brick
    /// where only finer levels have some.
    pub fn truncated(&self, finest: usize) -> Self {
        let count = self.levels.len().min(finest.saturating_add(1));
        let mut levels = self.levels[..count].to_vec();
        let excess = levels[count - 1].finest_cells;
        for level in &mut levels {
            level.finest_cells = std::array::from_fn(|axis| level.finest_cells[axis] / excess[axis]);
        }
        let warnings = self.warnings.iter().filter(|warning| warning.level() < count).cloned().collect();
        Self { origin: self.origin, levels, warnings }
    }
}

impl Level {
    /// Cells per cell of the next coarser level, per axis; `[1, 1, 1]` on level 0.
    pub fn ratio(&self) -> [i64; 3] {
        self.ratio
    }

    /// A cell's width per axis, in world units.
    pub fn cell_size(&self) -> [f64; 3] {
        self.cell_size
    }

    /// The domain in this level's cells.
    pub fn domain(&self) -> IndexBox {
        self.domain
    }

    /// The level's bricks.
    pub fn bricks(&self) -> &[IndexBox] {
        &self.bricks
    }

    /// How many bricks the coarser levels hold: the place of this level's first brick in [`Hierarchy::bricks`].
    pub fn first_brick(&self) -> usize {
        self.first_brick
    }

    /// The box of the brick that [`Hierarchy::bricks`] counts as `place`.
    ///
    /// # Panics
    /// Where it is a brick of another level.
    #[inline]
    pub fn brick_at(&self, place: usize) -> IndexBox {
        self.bricks[place - self.first_brick]
    }

    /// Cells of the hierarchy's finest level per cell of this one, per axis.
    pub fn finest_cells(&self) -> [i64; 3] {
        self.finest_cells
    }

    /// The number of cells of the level's bricks, covered ones included.
    pub fn cells(&self) -> u64 {
        self.bricks.iter().map(IndexBox::cells).sum()
    }
}

#[cfg(test)]
mod tests;
