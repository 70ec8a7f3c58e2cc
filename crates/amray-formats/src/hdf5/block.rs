//! Bricks in data sets of several dimensions: blocks of cells, x fastest, perhaps behind other indices and ghost layers.

use std::ops::Range;
use std::sync::Arc;

use amray::hierarchy::{BrickValues, ValueBuffer, Voxel, VoxelType, contiguous_strides};
use hdf5_reader::Datatype;
use memmap2::Mmap;

use super::number::describe;
use super::{H5Type, Hdf5Set, Parts, Storage};
use crate::FormatError;
use crate::number::{NumberType, voxel_type};
use crate::store::Store;

/// Where bricks of one size lie in a data set of the dimensions (leading..., number of the block, z, y, x).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<'a> {
    /// The indices in front.
    pub(crate) leading: &'a [u64],
    /// The blocks' numbers; `None` where the data set is one block and has no such dimension.
    pub(crate) numbers: Option<&'a [u64]>,
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

    /// The values of bricks of the type [`voxel_type_in_memory`](Self::voxel_type_in_memory): where they are if they are
    /// stored in one piece and as this machine has them, else in the `store`. `storage` is that of the data set; `done` is
    /// called for every brick.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where a brick leaves the data set or cannot be read.
    pub(crate) fn blocks<T: Voxel>(
        &self,
        map: &Arc<Mmap>,
        storage: &Storage,
        blocks: &Blocks,
        store: &Store,
        done: &(dyn Fn() + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let parts = self.parts(blocks)?;
        let size = blocks.size.map(|cells| cells as usize);
        match storage {
            Storage::Contiguous(bytes) if self.is_native() && self.voxel_type()?.bytes() == size_of::<T>() => {
                let buffer = ValueBuffer::mapped(Arc::clone(map));
                let mapped = |along: &Range<u64>| {
                    done();
                    self.mapped(&buffer, bytes, &parts, along, size)
                };
                parts.along.iter().map(mapped).collect()
            }
            _ => self.read(storage, &parts, &|_, values: Vec<T>| {
                done();
                store.keep(values, size)
            }),
        }
    }

    /// A brick where it is in the file, at the indices `along` the axis of `parts`.
    fn mapped<T: Voxel>(
        &self,
        buffer: &ValueBuffer,
        bytes: &Range<usize>,
        parts: &Parts,
        along: &Range<u64>,
        size: [usize; 3],
    ) -> Result<BrickValues<T>, FormatError> {
        // Inside the data set, whose size fits the file: no product overflows.
        let shape: Vec<usize> = self.shape().iter().map(|&length| length as usize).collect();
        let ranges = parts.ranges(along.clone());
        let first = ranges.iter().zip(&shape).fold(0, |at, (range, length)| at * length + range.start as usize);
        let [.., rows, row] = shape[..] else { unreachable!("`parts` found three dimensions") };
        let offset = bytes.start + first * size_of::<T>();
        BrickValues::new(buffer.clone(), offset, contiguous_strides([row, rows, 0]), size)
            .map_err(|error| self.malformed(&error.to_string()))
    }

    /// Checks that the data set has all blocks, and that each is as large as it is said to be.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it has not.
    pub(crate) fn expect_blocks(&self, Blocks { leading, numbers, ghosts, size }: &Blocks) -> Result<(), FormatError> {
        let stored: Vec<u64> =
            (0..3).rev().map(|axis| ghosts[axis].saturating_mul(2).saturating_add(size[axis])).collect();
        let last = numbers.and_then(|numbers| numbers.iter().max());
        let dimensions = leading.len() + usize::from(numbers.is_some()) + stored.len();
        let shape = self.shape();
        let mut front = leading.iter().chain(last).zip(shape);
        if shape.len() == dimensions && shape.ends_with(&stored) && front.all(|(index, length)| index < length) {
            return Ok(());
        }
        let blocks = last.map_or_else(String::new, |last| format!(" of at least {} blocks", last.saturating_add(1)));
        Err(self
            .malformed(&format!("shape {shape:?}, expected {dimensions} dimensions{blocks} that end in {stored:?}")))
    }

    /// The ranges of blocks in each dimension.
    fn parts(&self, blocks: &Blocks) -> Result<Parts, FormatError> {
        self.expect_blocks(blocks)?;
        let Blocks { leading, numbers, ghosts, size } = blocks;
        let mut inner: Vec<Range<u64>> = (0..3).rev().map(|axis| ghosts[axis]..ghosts[axis] + size[axis]).collect();
        let along: Vec<Range<u64>> = match numbers {
            Some(numbers) => numbers.iter().map(|&number| number..number + 1).collect(),
            None => vec![inner.remove(0)],
        };
        Ok(Parts { leading: leading.to_vec(), along, inner })
    }

    /// Reads bricks as [`read_parts`](Self::read_parts) does, whatever the stored number type is.
    ///
    /// # Errors
    /// [`FormatError`] as `read_parts`, or where the values are no numbers.
    pub(crate) fn read<T: Voxel>(
        &self,
        storage: &Storage,
        parts: &Parts,
        keep: Keep<T>,
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let stored = Stored { set: self, storage, parts, keep };
        match self.number_type()? {
            NumberType::F32 => stored.converted(|value: f32| f64::from(value)),
            NumberType::F64 => stored.converted(|value: f64| value),
            NumberType::U8 => stored.converted(|value: u8| f64::from(value)),
            NumberType::I8 => stored.converted(|value: i8| f64::from(value)),
            NumberType::U16 => stored.converted(|value: u16| f64::from(value)),
            NumberType::I16 => stored.converted(|value: i16| f64::from(value)),
            NumberType::U32 => stored.converted(|value: u32| f64::from(value)),
            NumberType::I32 => stored.converted(|value: i32| f64::from(value)),
            NumberType::U64 => stored.converted(|value: u64| value as f64),
            NumberType::I64 => stored.converted(|value: i64| value as f64),
        }
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

/// What becomes of the values of a brick with a number.
pub(crate) type Keep<'a, T> = &'a (dyn Fn(usize, Vec<T>) -> Result<BrickValues<T>, FormatError> + Sync);

/// Bricks to be read, whatever their number type.
struct Stored<'a, T> {
    set: &'a Hdf5Set,
    storage: &'a Storage,
    parts: &'a Parts,
    keep: Keep<'a, T>,
}

impl<T: Voxel> Stored<'_, T> {
    fn converted<N: H5Type + Copy>(
        &self,
        number: impl Fn(N) -> f64 + Sync,
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        self.set.read_parts(self.storage, self.parts, |part, values: &[N]| {
            (self.keep)(part, values.iter().map(|&value| T::from_f64(number(value))).collect())
        })
    }
}
