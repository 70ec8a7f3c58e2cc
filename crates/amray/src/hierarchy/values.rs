//! The values of one brick: a view of numbers that stay where they are (owned, memory-mapped or borrowed).
#![allow(unsafe_code)] // A view reads foreign memory in place; every read is inside bounds checked in `BrickValues::new`.

use std::any::Any;
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

use memmap2::Mmap;
use thiserror::Error;

use super::IndexBox;
use super::lane_values::LaneVoxel;

/// A number type that a cell can hold.
pub trait Voxel: Copy + PartialOrd + Send + Sync + fmt::Debug + sealed::AnyBitPattern + LaneVoxel + 'static {
    /// The value as f64, exactly.
    fn to_f64(self) -> f64;
    /// The value nearest to `value`.
    fn from_f64(value: f64) -> Self;
}

mod sealed {
    /// Types for which every pattern of bits is a value, so that file contents can be read as they are.
    pub trait AnyBitPattern {}
    impl AnyBitPattern for f32 {}
    impl AnyBitPattern for f64 {}
}

/// The number types a field can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VoxelType {
    /// IEEE single precision.
    F32,
    /// IEEE double precision.
    F64,
}

impl VoxelType {
    /// Bytes per value.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl Voxel for f32 {
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

impl Voxel for f64 {
    fn to_f64(self) -> f64 {
        self
    }
    fn from_f64(value: f64) -> Self {
        value
    }
}

/// Where values live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residence {
    /// In memory that amray allocated.
    Owned,
    /// In a memory-mapped file: pages come in when they are touched and can leave again.
    Mapped,
    /// In memory that somebody else owns.
    Borrowed,
}

/// A piece of memory that holds the values of one or more bricks, kept alive as long as a view refers to it.
#[derive(Clone)]
pub struct ValueBuffer {
    start: *const u8,
    bytes: usize,
    residence: Residence,
    /// Only held: dropping the last clone releases the memory.
    owner: Arc<dyn Any + Send + Sync>,
}

// SAFETY: the memory is only read, and `owner`, which may be dropped on any thread, is Send + Sync itself.
unsafe impl Send for ValueBuffer {}
// SAFETY: as above; shared reads need no synchronisation.
unsafe impl Sync for ValueBuffer {}

impl ValueBuffer {
    /// A buffer that owns `values`.
    pub fn owned<T: Voxel>(values: Vec<T>) -> Self {
        let start = values.as_ptr().cast();
        let bytes = values.len() * size_of::<T>();
        // Moving the Vec into the Arc does not move the values it points to.
        Self { start, bytes, residence: Residence::Owned, owner: Arc::new(values) }
    }

    /// A buffer over a memory-mapped file.
    ///
    /// The file must not be truncated while the map lives: the operating system answers reads past its new end with
    /// a bus error.
    pub fn mapped(map: Arc<Mmap>) -> Self {
        Self { start: map.as_ptr(), bytes: map.len(), residence: Residence::Mapped, owner: map }
    }

    /// A buffer over memory that `owner` keeps alive.
    ///
    /// # Safety
    /// `start` must stay valid for reads of `bytes` bytes, and the bytes unchanged, until `owner` is dropped.
    pub unsafe fn borrowed(start: *const u8, bytes: usize, owner: Arc<dyn Any + Send + Sync>) -> Self {
        Self { start, bytes, residence: Residence::Borrowed, owner }
    }

    /// Gives the pages of a mapped file back to the operating system, which reads them again when they are touched.
    /// Other buffers, and systems that know no such request, are left alone.
    pub fn release(&self) {
        #[cfg(unix)]
        if let Some(map) = self.owner.downcast_ref::<Mmap>() {
            // SAFETY: the map is of a file and only ever read: its pages come back with the same bytes.
            // A system that refuses keeps the pages, which is no harm.
            let _ = unsafe { map.unchecked_advise(memmap2::UncheckedAdvice::DontNeed) };
        }
    }

    /// Where the memory starts.
    pub(super) fn start(&self) -> *const u8 {
        self.start
    }

    /// The length in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Where the values live.
    pub fn residence(&self) -> Residence {
        self.residence
    }
}

impl fmt::Debug for ValueBuffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ValueBuffer").field("bytes", &self.bytes).field("residence", &self.residence).finish()
    }
}

/// A view that reaches past its buffer.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{needed} bytes are needed from byte {offset} on, but the buffer holds {available} bytes")]
pub struct OutOfBuffer {
    /// Where the view starts, in bytes.
    pub offset: usize,
    /// How many bytes it spans (saturated where that overflows).
    pub needed: usize,
    /// How many bytes the buffer holds.
    pub available: usize,
}

/// The values of one brick's cells, wherever they are: a start, a stride per axis, a number of cells per axis.
///
/// Ghost cells are left out by starting behind them and striding over them. The values need not be aligned.
#[derive(Clone, Debug)]
pub struct BrickValues<T> {
    buffer: ValueBuffer,
    offset: usize,
    stride: [usize; 3],
    size: [usize; 3],
    voxel: PhantomData<T>,
}

impl<T: Voxel> BrickValues<T> {
    /// A view of `size` cells per axis whose first value is `offset` bytes into `buffer`; `stride` is the distance
    /// between neighbouring cells per axis, in values.
    ///
    /// # Errors
    /// [`OutOfBuffer`] where a cell's value would lie outside the buffer.
    pub fn new(buffer: ValueBuffer, offset: usize, stride: [usize; 3], size: [usize; 3]) -> Result<Self, OutOfBuffer> {
        let last_value = (0..3).try_fold(0usize, |last, axis| {
            size[axis].saturating_sub(1).checked_mul(stride[axis]).and_then(|far| last.checked_add(far))
        });
        let span = match last_value {
            _ if size.contains(&0) => Some(0),
            Some(last) => last.checked_add(1).and_then(|values| values.checked_mul(size_of::<T>())),
            None => None,
        };
        match span.and_then(|span| span.checked_add(offset)) {
            Some(end) if end <= buffer.bytes => Ok(Self { buffer, offset, stride, size, voxel: PhantomData }),
            _ => Err(OutOfBuffer { offset, needed: span.unwrap_or(usize::MAX), available: buffer.bytes }),
        }
    }

    /// A brick that owns its values, x fastest, without ghost cells.
    ///
    /// # Errors
    /// [`OutOfBuffer`] where `values` holds fewer than the product of `size`.
    pub fn owned(values: Vec<T>, size: [usize; 3]) -> Result<Self, OutOfBuffer> {
        Self::new(ValueBuffer::owned(values), 0, contiguous_strides(size), size)
    }

    /// Cells per axis.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// The distance between neighbouring cells per axis, in values.
    pub fn stride(&self) -> [usize; 3] {
        self.stride
    }

    /// Where the value of the brick's first cell lies; it need not be aligned.
    pub(super) fn start(&self) -> *const T {
        self.buffer.start.wrapping_add(self.offset).cast()
    }

    /// The memory that the values lie in.
    pub fn buffer(&self) -> &ValueBuffer {
        &self.buffer
    }

    /// Where the values live.
    pub fn residence(&self) -> Residence {
        self.buffer.residence
    }

    /// The value of a cell, counted from the brick's low corner.
    ///
    /// # Panics
    /// Where the cell lies outside the brick.
    #[inline]
    pub fn get(&self, cell: [usize; 3]) -> T {
        assert!(
            cell[0] < self.size[0] && cell[1] < self.size[1] && cell[2] < self.size[2],
            "cell {cell:?} outside a brick of {:?} cells",
            self.size
        );
        // SAFETY: the cell is inside `size`.
        unsafe { self.read(self.distance(cell)) }
    }

    /// The values of the 2x2x2 cells from `cell` on, x fastest.
    ///
    /// # Panics
    /// Where one of the cells lies outside the brick.
    #[inline]
    pub fn corners(&self, cell: [usize; 3]) -> [T; 8] {
        assert!(
            (0..3).all(|axis| cell[axis] < self.size[axis].saturating_sub(1)),
            "the dual cell at {cell:?} reaches outside a brick of {:?} cells",
            self.size
        );
        let first = self.distance(cell);
        let [x, y, z] = self.stride;
        // SAFETY: the highest of the eight cells is inside `size`.
        [0, x, y, x + y, z, x + z, y + z, x + y + z].map(|step| unsafe { self.read(first + step) })
    }

    /// The values of `N` cells in a row along x, from `cell` on.
    ///
    /// # Panics
    /// Where one of the cells lies outside the brick.
    #[inline]
    pub fn run<const N: usize>(&self, cell: [usize; 3]) -> [T; N] {
        assert!(
            N <= self.size[0] && cell[0] <= self.size[0] - N && cell[1] < self.size[1] && cell[2] < self.size[2],
            "{N} cells from {cell:?} on reach outside a brick of {:?} cells",
            self.size
        );
        let first = self.distance(cell);
        if self.stride[0] == 1 {
            // SAFETY: the cells are inside `size` and lie one after the other; the rest as for `read`.
            return unsafe {
                self.buffer.start.add(self.offset).cast::<T>().add(first).cast::<[T; N]>().read_unaligned()
            };
        }
        // SAFETY: the cells are inside `size`.
        std::array::from_fn(|place| unsafe { self.read(first + place * self.stride[0]) })
    }

    /// A copy of all values, x fastest.
    pub fn to_vec(&self) -> Vec<T> {
        let mut values = Vec::with_capacity(self.size.iter().product());
        self.for_each([0; 3], self.size, |value| values.push(value));
        values
    }

    /// Calls `visit` with every value of `cells` (from `low`, inclusive, to `high`, exclusive), x fastest.
    ///
    /// # Panics
    /// Where the box reaches outside the brick.
    #[inline]
    pub fn for_each(&self, low: [usize; 3], high: [usize; 3], mut visit: impl FnMut(T)) {
        assert!((0..3).all(|axis| high[axis] <= self.size[axis]), "{high:?} outside a brick of {:?} cells", self.size);
        for k in low[2]..high[2] {
            for j in low[1]..high[1] {
                let row = self.distance([0, j, k]);
                for i in low[0]..high[0] {
                    // SAFETY: the cell is inside `size`.
                    visit(unsafe { self.read(row + i * self.stride[0]) });
                }
            }
        }
    }

    /// Calls `visit` with every value of `cells`, in indices of the level, x fastest; `low` is the brick's low corner.
    ///
    /// # Panics
    /// Where the box reaches outside the brick.
    #[inline]
    pub fn for_each_in(&self, low: [i64; 3], cells: &IndexBox, visit: impl FnMut(T)) {
        let inside = |corner: [i64; 3]| {
            std::array::from_fn(|axis| usize::try_from(corner[axis] - low[axis]).expect("the box starts in the brick"))
        };
        self.for_each(inside(cells.low), inside(cells.high), visit);
    }

    #[inline]
    fn distance(&self, cell: [usize; 3]) -> usize {
        cell[0] * self.stride[0] + cell[1] * self.stride[1] + cell[2] * self.stride[2]
    }

    /// # Safety
    /// `distance` must be that of a cell inside `size`.
    #[inline]
    unsafe fn read(&self, distance: usize) -> T {
        // SAFETY: `new` checked that every cell inside `size` lies in the buffer; all bit patterns are values of `T`
        // (sealed trait); file formats align nothing, so the read is unaligned.
        unsafe { self.buffer.start.add(self.offset).cast::<T>().add(distance).read_unaligned() }
    }
}

/// The bytes of values, in this machine's order: what a mapped file must hold to be read in place.
pub fn bytes_of<T: Voxel>(values: &[T]) -> &[u8] {
    // SAFETY: the values are plain numbers without padding (sealed trait), and any byte may be read as a `u8`.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

/// Strides of values stored x fastest without gaps.
pub fn contiguous_strides(size: [usize; 3]) -> [usize; 3] {
    [1, size[0], size[0].saturating_mul(size[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strides_step_over_ghost_cells() {
        // 2x2x2 cells in the middle of 4x4x4 values: one ghost layer.
        let values: Vec<f32> = (0..64).map(|value| value as f32).collect();
        let brick = BrickValues::<f32>::new(ValueBuffer::owned(values), (1 + 4 + 16) * 4, [1, 4, 16], [2; 3]).unwrap();
        assert_eq!(brick.get([0, 0, 0]), 21.0);
        assert_eq!(brick.get([1, 1, 1]), 42.0);
        assert_eq!(brick.corners([0, 0, 0]), [21.0, 22.0, 25.0, 26.0, 37.0, 38.0, 41.0, 42.0]);
        let mut seen = Vec::new();
        brick.for_each([1, 0, 0], [2, 2, 1], |value| seen.push(value));
        assert_eq!(seen, [22.0, 26.0]);
    }

    #[test]
    fn a_run_is_a_row_of_cells() {
        let values: Vec<f32> = (0..64).map(|value| value as f32).collect();
        let buffer = ValueBuffer::owned(values);
        let rows = BrickValues::<f32>::new(buffer.clone(), 0, [1, 4, 16], [4; 3]).unwrap();
        assert_eq!(rows.run([1, 2, 3]), [57.0, 58.0, 59.0]);
        let columns = BrickValues::<f32>::new(buffer, 0, [16, 4, 1], [4; 3]).unwrap();
        assert_eq!(columns.run([1, 2, 3]), [27.0, 43.0, 59.0]);
    }

    #[test]
    #[should_panic(expected = "reach outside")]
    fn a_run_past_the_end_is_outside() {
        BrickValues::owned(vec![0f32; 8], [2; 3]).unwrap().run::<2>([1, 0, 0]);
    }

    #[test]
    #[should_panic(expected = "reaches outside")]
    fn a_dual_cell_past_every_number_is_outside() {
        BrickValues::owned(vec![0f32; 8], [2; 3]).unwrap().corners([usize::MAX, 0, 0]);
    }

    #[test]
    fn values_need_no_alignment() {
        let mut bytes = vec![0u8; 3];
        bytes.extend([1.5f64, -2.0].iter().flat_map(|value| value.to_ne_bytes()));
        let owner = Arc::new(bytes);
        // SAFETY: `owner` keeps the bytes alive and nobody writes to them.
        let buffer = unsafe { ValueBuffer::borrowed(owner.as_ptr(), owner.len(), owner) };
        let brick = BrickValues::<f64>::new(buffer, 3, [1, 2, 2], [2, 1, 1]).unwrap();
        assert_eq!([brick.get([0; 3]), brick.get([1, 0, 0])], [1.5, -2.0]);
        assert_eq!(brick.residence(), Residence::Borrowed);
    }

    #[test]
    fn a_view_past_the_end_is_refused() {
        let buffer = ValueBuffer::owned(vec![0f64; 8]);
        assert!(BrickValues::<f64>::new(buffer.clone(), 0, [1, 2, 4], [2; 3]).is_ok());
        assert!(BrickValues::<f64>::new(buffer.clone(), 1, [1, 2, 4], [2; 3]).is_err());
        assert!(BrickValues::<f64>::new(buffer.clone(), 0, [1, 2, 5], [2; 3]).is_err());
        assert!(BrickValues::<f64>::new(buffer.clone(), usize::MAX, [1, 2, 4], [2; 3]).is_err());
        assert!(BrickValues::<f64>::new(buffer, 0, [usize::MAX; 3], [usize::MAX; 3]).is_err());
    }
}
