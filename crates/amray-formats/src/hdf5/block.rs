//! Bricks in data sets of several dimensions: blocks of cells, x fastest, perhaps behind other indices and ghost layers.

use std::ops::Range;
use std::sync::Arc;

use amray::hierarchy::{BrickValues, ValueBuffer, Voxel, VoxelType, contiguous_strides};
use hdf5_reader::Datatype;
use memmap2::Mmap;

use super::number::describe;
use super::{H5Type, Hdf5Set, Storage};
use crate::FormatError;
use crate::number::{NumberType, voxel_type};
use crate::store::Store;

/// Where a brick lies in a data set of the dimensions (leading..., z, y, x).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<'a> {
    /// The indices in front, one for each dimension more than three.
    pub(crate) leading: &'a [u64],
    /// Layers of ghost cells on both sides of x, y and z.
    pub(crate) ghosts: [u64; 3],
    /// Cells along x, y and z, without ghosts.
    pub(crate) size: [u64; 3],
}

impl Hdf5Set {
    /// The number type that its values have in memory: integers become the floats that hold all of them, or, of eight
    /// bytes, nearly.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are no numbers of a usual size.
    pub(crate) fn voxel_type_in_memory(&self) -> Result<VoxelType, FormatError> {
        Ok(voxel_type(self.number_type()?))
    }

    /// The values of a brick of the type [`voxel_type_in_memory`](Self::voxel_type_in_memory): where they are if they are
    /// stored in one piece and as this machine has them, else in the `store`. `storage` is that of the data set.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the brick leaves the data set or cannot be read.
    pub(crate) fn block<T: Voxel>(
        &self,
        map: &Arc<Mmap>,
        storage: &Storage,
        block: &Block,
        store: &Store,
    ) -> Result<BrickValues<T>, FormatError> {
        let ranges = self.ranges(block)?;
        let size = block.size.map(|cells| cells as usize);
        match storage {
            Storage::Contiguous(bytes) if self.is_native() && self.voxel_type()?.bytes() == size_of::<T>() => {
                // Inside the data set, whose size fits the file: no product overflows.
                let shape: Vec<usize> = self.shape().iter().map(|&length| length as usize).collect();
                let first = ranges.iter().zip(&shape).fold(0, |at, (range, length)| at * length + range.start as usize);
                let [.., rows, row] = shape[..] else { unreachable!("`ranges` found three dimensions") };
                let buffer = ValueBuffer::mapped(Arc::clone(map));
                let offset = bytes.start + first * size_of::<T>();
                BrickValues::new(buffer, offset, contiguous_strides([row, rows, 0]), size)
                    .map_err(|error| self.malformed(&error.to_string()))
            }
            _ => store.keep(self.read::<T>(&ranges)?, size),
        }
    }

    /// The ranges of a block in each dimension.
    fn ranges(&self, Block { leading, ghosts, size }: &Block) -> Result<Vec<Range<u64>>, FormatError> {
        let shape = self.shape();
        let wrong = || {
            let dimensions = leading.len() + 3;
            self.malformed(&format!(
                "shape {shape:?}, expected {dimensions} dimensions with {size:?} cells and {ghosts:?} ghost layers at \
                 {leading:?}"
            ))
        };
        if shape.len() != leading.len() + 3 {
            return Err(wrong());
        }
        let leading = leading.iter().map(|&index| index..index.saturating_add(1));
        let cells = (0..3).rev().map(|axis| ghosts[axis]..ghosts[axis].saturating_add(size[axis]));
        let ranges: Vec<Range<u64>> = leading.chain(cells).collect();
        match ranges.iter().zip(shape).all(|(range, length)| range.end <= *length) {
            true => Ok(ranges),
            false => Err(wrong()),
        }
    }

    /// The values of a box (from the first to before the last index, per axis), last axis fastest.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it leaves the data set or cannot be read.
    pub(crate) fn read<T: Voxel>(&self, ranges: &[Range<u64>]) -> Result<Vec<T>, FormatError> {
        match self.number_type()? {
            NumberType::F32 => self.converted(ranges, |value: f32| f64::from(value)),
            NumberType::F64 => self.converted(ranges, |value: f64| value),
            NumberType::U8 => self.converted(ranges, |value: u8| f64::from(value)),
            NumberType::I8 => self.converted(ranges, |value: i8| f64::from(value)),
            NumberType::U16 => self.converted(ranges, |value: u16| f64::from(value)),
            NumberType::I16 => self.converted(ranges, |value: i16| f64::from(value)),
            NumberType::U32 => self.converted(ranges, |value: u32| f64::from(value)),
            NumberType::I32 => self.converted(ranges, |value: i32| f64::from(value)),
            NumberType::U64 => self.converted(ranges, |value: u64| value as f64),
            NumberType::I64 => self.converted(ranges, |value: i64| value as f64),
        }
    }

    fn converted<N: H5Type, T: Voxel>(
        &self,
        ranges: &[Range<u64>],
        number: impl Fn(N) -> f64,
    ) -> Result<Vec<T>, FormatError> {
        Ok(self.read_box::<N>(ranges)?.into_iter().map(|value| T::from_f64(number(value))).collect())
    }

    fn number_type(&self) -> Result<NumberType, FormatError> {
        Ok(match self.datatype() {
            Datatype::FloatingPoint { size: 4, .. } => NumberType::F32,
            Datatype::FloatingPoint { size: 8, .. } => NumberType::F64,
            Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
                (1, false) => NumberType::U8,
                (1, true) => NumberType::I8,
                (2, false) => NumberType::U16,
                (2, true) => NumberType::I16,
                (4, false) => NumberType::U32,
                (4, true) => NumberType::I32,
                (8, false) => NumberType::U64,
                (8, true) => NumberType::I64,
                _ => return Err(self.malformed(&format!("integers of {size} bytes, expected 1, 2, 4 or 8"))),
            },
            other => return Err(self.malformed(&format!("{}, expected numbers", describe(other)))),
        })
    }
}
