//! A field: one scalar per cell, brick by brick.

use thiserror::Error;

use super::values::{BrickValues, Residence, ValueBuffer, Voxel, VoxelType};
use super::{Hierarchy, IndexBox};

/// One scalar per cell, or per node, over a hierarchy.
#[derive(Clone, Debug)]
pub struct Field {
    name: String,
    centering: Centering,
    values: FieldValues,
}

/// What a field's values belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Centering {
    /// The centres of cells: a brick has as many values as cells.
    Cells,
    /// The corners of cells: a brick has one value more per axis. Neighbouring bricks both store the nodes between them.
    Nodes,
}

impl Centering {
    /// Where a value lies from the low corner of the cell with its index on, in cells along each axis.
    pub fn place(self) -> f64 {
        match self {
            Self::Cells => 0.5,
            Self::Nodes => 0.0,
        }
    }

    /// Which values a brick of `cells` has: node (i, j, k) is the low corner of cell (i, j, k).
    pub fn values_of(self, cells: &IndexBox) -> IndexBox {
        match self {
            Self::Cells => *cells,
            Self::Nodes => IndexBox::new(cells.low, cells.high.map(|index| index + 1)),
        }
    }
}

/// The bricks' values, in the order of [`Hierarchy::bricks`]; all of one number type.
#[derive(Clone, Debug)]
pub enum FieldValues {
    /// Single precision.
    F32(Vec<BrickValues<f32>>),
    /// Double precision.
    F64(Vec<BrickValues<f64>>),
}

/// Runs `$body` with `$bricks` bound to the typed slice of brick values.
macro_rules! with_voxels {
    ($values:expr, $bricks:ident => $body:expr) => {
        match $values {
            $crate::hierarchy::FieldValues::F32($bricks) => $body,
            $crate::hierarchy::FieldValues::F64($bricks) => $body,
        }
    };
}
pub(crate) use with_voxels;

/// Values that do not fit their hierarchy.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FieldError {
    /// Not one set of values per brick.
    #[error("field {field}: values of {found} bricks, expected {expected}")]
    BrickCount {
        /// The field's name.
        field: String,
        /// Bricks of the hierarchy.
        expected: usize,
        /// Bricks with values.
        found: usize,
    },
    /// A brick whose values have another shape than its cells or nodes.
    #[error("field {field}, level {level}, brick {brick}: {found:?} values, expected {expected:?}")]
    BrickSize {
        /// The field's name.
        field: String,
        /// The level.
        level: usize,
        /// The brick's number on its level.
        brick: usize,
        /// Cells, or nodes, per axis of the brick.
        expected: [i64; 3],
        /// Its values per axis.
        found: [usize; 3],
    },
}

impl Field {
    /// A field with one value per cell for every brick of `hierarchy`, in the order of [`Hierarchy::bricks`].
    ///
    /// # Errors
    /// [`FieldError`] where the number of bricks or the shape of one differs.
    pub fn new(name: impl Into<String>, values: FieldValues, hierarchy: &Hierarchy) -> Result<Self, FieldError> {
        Self::centered(name, Centering::Cells, values, hierarchy)
    }

    /// A field with one value per cell or node, as `centering` says, for every brick of `hierarchy`.
    ///
    /// # Errors
    /// As [`Field::new`].
    pub fn centered(
        name: impl Into<String>,
        centering: Centering,
        values: FieldValues,
        hierarchy: &Hierarchy,
    ) -> Result<Self, FieldError> {
        let field = Self { name: name.into(), centering, values };
        let sizes: Vec<_> = with_voxels!(&field.values, bricks => bricks.iter().map(BrickValues::size).collect());
        if sizes.len() != hierarchy.brick_count() {
            return Err(FieldError::BrickCount {
                field: field.name,
                expected: hierarchy.brick_count(),
                found: sizes.len(),
            });
        }
        for (brick, found) in hierarchy.bricks().zip(sizes) {
            let expected = centering.values_of(&brick.cells).size();
            if expected != found.map(|values| values as i64) {
                let (level, brick) = (brick.level, brick.number);
                return Err(FieldError::BrickSize { field: field.name, level, brick, expected, found });
            }
        }
        Ok(field)
    }

    /// A field with owned values, each cell's computed from its level and index.
    pub fn from_fn<T: Voxel>(
        name: impl Into<String>,
        hierarchy: &Hierarchy,
        value: impl Fn(usize, [i64; 3]) -> T,
    ) -> Self
    where
        FieldValues: From<Vec<BrickValues<T>>>,
    {
        Self::centered_from_fn(name, Centering::Cells, hierarchy, value)
    }

    /// A field with owned values, each cell's or node's computed from its level and index.
    pub fn centered_from_fn<T: Voxel>(
        name: impl Into<String>,
        centering: Centering,
        hierarchy: &Hierarchy,
        value: impl Fn(usize, [i64; 3]) -> T,
    ) -> Self
    where
        FieldValues: From<Vec<BrickValues<T>>>,
    {
        let bricks = hierarchy.bricks().map(|brick| {
            let places = centering.values_of(&brick.cells);
            let values = places.iter().map(|place| value(brick.level, place)).collect();
            BrickValues::owned(values, size_of_box(&places)).expect("one value per place was made")
        });
        Self { name: name.into(), centering, values: bricks.collect::<Vec<_>>().into() }
    }

    /// The field's name, as the file spells it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the values belong to.
    pub fn centering(&self) -> Centering {
        self.centering
    }

    /// The bricks' values.
    pub fn values(&self) -> &FieldValues {
        &self.values
    }

    /// The number of bricks with values.
    pub fn brick_count(&self) -> usize {
        with_voxels!(&self.values, bricks => bricks.len())
    }

    /// The number type.
    pub fn voxel_type(&self) -> VoxelType {
        match self.values {
            FieldValues::F32(_) => VoxelType::F32,
            FieldValues::F64(_) => VoxelType::F64,
        }
    }

    /// The value of a cell, or node, as f64; `brick` counts as [`Hierarchy::bricks`] does, `cell` from the brick's low
    /// corner.
    ///
    /// # Panics
    /// Where the brick or the cell does not exist.
    pub fn value(&self, brick: usize, cell: [usize; 3]) -> f64 {
        with_voxels!(&self.values, bricks => bricks[brick].get(cell).to_f64())
    }

    /// The memory that values lie in, each piece once.
    pub fn buffers(&self) -> Vec<ValueBuffer> {
        let mut buffers: Vec<ValueBuffer> =
            with_voxels!(&self.values, bricks => bricks.iter().map(|brick| brick.buffer().clone()).collect());
        buffers.sort_unstable_by_key(ValueBuffer::start);
        buffers.dedup_by_key(|buffer| buffer.start());
        buffers
    }

    /// Bytes of the cells' values (ghost cells left out) that live in `residence`.
    pub fn bytes(&self, residence: Residence) -> u64 {
        let voxel = self.voxel_type().bytes() as u64;
        with_voxels!(&self.values, bricks => bricks
            .iter()
            .filter(|brick| brick.residence() == residence)
            .map(|brick| brick.size().iter().map(|&cells| cells as u64).product::<u64>() * voxel)
            .sum())
    }
}

impl From<Vec<BrickValues<f32>>> for FieldValues {
    fn from(bricks: Vec<BrickValues<f32>>) -> Self {
        Self::F32(bricks)
    }
}

impl From<Vec<BrickValues<f64>>> for FieldValues {
    fn from(bricks: Vec<BrickValues<f64>>) -> Self {
        Self::F64(bricks)
    }
}

/// Cells per axis of a validated brick.
fn size_of_box(cells: &IndexBox) -> [usize; 3] {
    cells.size().map(|cells| usize::try_from(cells).expect("a brick has at least one cell per axis"))
}
