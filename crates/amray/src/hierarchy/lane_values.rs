//! The values of one brick at sixteen cells at once, read in place.
#![allow(unsafe_code)] // Gathers read at computed places, all of them inside what `BrickValues::new` checked.

use fearless_simd::prelude::*;

use super::{BrickValues, IndexBox, Normalisation, Voxel};
use crate::simd::{Floats, Gather, Integers, LANES, LaneSet, lanes_of, mask_of};

/// A normalisation as kernels apply it.
#[derive(Clone, Copy, Debug)]
pub struct LaneNormalisation {
    double: Normalisation,
    /// Nearest to the double one's.
    low: f32,
    scale: f32,
    /// What `low` is off by, normalised: with it, an offset much larger than the range costs no digits.
    shift: f32,
}

impl LaneNormalisation {
    pub(crate) fn new(double: Normalisation) -> Self {
        let low = double.low as f32;
        Self { double, low, scale: double.scale as f32, shift: double.apply(f64::from(low)) }
    }

    /// Whether it can be applied to values of a type: single precision must hold it for those of single precision.
    pub(crate) fn serves<T>(&self) -> bool {
        size_of::<T>() > size_of::<f32>() || self.low.is_finite() && self.scale.is_normal() && self.shift.is_finite()
    }

    /// The number that stands for a value.
    pub(crate) fn of_value(&self, value: f64) -> f32 {
        self.double.apply(value)
    }

    /// The number that stands for a difference of values.
    pub(crate) fn of_slope(&self, slope: f64) -> f32 {
        (slope * self.double.scale) as f32
    }

    /// The difference of single-precision values is exact beside itself.
    #[inline(always)]
    fn apply<S: Gather>(&self, simd: S, values: Floats<S>) -> Floats<S> {
        (values - self.low).mul_add(Floats::splat(simd, self.scale), Floats::splat(simd, self.shift))
    }
}

/// A number type that is read at sixteen places at once. All become normalised single precision.
pub trait LaneVoxel: Sized {
    /// The values at `start + index`.
    ///
    /// # Safety
    /// All sixteen places must be readable; they need not be aligned.
    unsafe fn gather<S: Gather>(
        simd: S,
        start: *const Self,
        index: Integers<S>,
        normalisation: &LaneNormalisation,
    ) -> Floats<S>;

    /// The values at `start + index` and right behind them.
    ///
    /// # Safety
    /// All thirty-two places must be readable; they need not be aligned.
    unsafe fn gather_pairs<S: Gather>(
        simd: S,
        start: *const Self,
        index: Integers<S>,
        normalisation: &LaneNormalisation,
    ) -> [Floats<S>; 2];
}

impl LaneVoxel for f32 {
    #[inline(always)]
    unsafe fn gather<S: Gather>(
        simd: S,
        start: *const f32,
        index: Integers<S>,
        normalisation: &LaneNormalisation,
    ) -> Floats<S> {
        // SAFETY: the caller vouches for all places.
        normalisation.apply(simd, unsafe { simd.gather(start, index) })
    }

    #[inline(always)]
    unsafe fn gather_pairs<S: Gather>(
        simd: S,
        start: *const f32,
        index: Integers<S>,
        normalisation: &LaneNormalisation,
    ) -> [Floats<S>; 2] {
        // SAFETY: the caller vouches for all places.
        let [first, second] = unsafe { simd.gather_pairs(start, index) };
        [normalisation.apply(simd, first), normalisation.apply(simd, second)]
    }
}

impl LaneVoxel for f64 {
    #[inline(always)]
    unsafe fn gather<S: Gather>(
        simd: S,
        start: *const f64,
        index: Integers<S>,
        normalisation: &LaneNormalisation,
    ) -> Floats<S> {
        // SAFETY: the caller vouches for all places.
        unsafe { simd.gather_scaled(start, index, normalisation.double.low, normalisation.double.scale) }
    }

    #[inline(always)]
    unsafe fn gather_pairs<S: Gather>(
        simd: S,
        start: *const f64,
        index: Integers<S>,
        normalisation: &LaneNormalisation,
    ) -> [Floats<S>; 2] {
        let Normalisation { low, scale } = normalisation.double;
        // SAFETY: the caller vouches for all places.
        unsafe {
            [simd.gather_scaled(start, index, low, scale), simd.gather_scaled(start.wrapping_add(1), index, low, scale)]
        }
    }
}

/// One brick's values, with what kernels need of its geometry side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneValues<'a, T> {
    start: *const T,
    /// The brick's low corner, from the domain's low corner on.
    low: [i32; 3],
    /// The last cell per axis, from the brick's low corner on.
    last: [i32; 3],
    /// The distance between neighbouring cells per axis, in values.
    stride: [i32; 3],
    layout: Layout,
    values: &'a BrickValues<T>,
}

/// How a brick can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// Neighbours along x lie side by side.
    Pairs,
    /// At distances within 32 bits.
    Near,
    /// At distances beyond.
    Far,
}

// SAFETY: `start` is where the values of `values` start, which is Send and Sync; they are only read.
unsafe impl<T: Voxel> Send for LaneValues<'_, T> {}
// SAFETY: as above; shared reads need no synchronisation.
unsafe impl<T: Voxel> Sync for LaneValues<'_, T> {}

impl<'a, T: Voxel> LaneValues<'a, T> {
    /// The values of the brick `cells` of a level whose domain starts at `domain_low`. Indices from the domain's low
    /// corner on must fit in 32 bits.
    pub(crate) fn new(values: &'a BrickValues<T>, cells: &IndexBox, domain_low: [i64; 3]) -> Self {
        let last = values.size().map(|size| size.saturating_sub(1));
        let reach = |axis: usize| last[axis].saturating_mul(values.stride()[axis]);
        let farthest = (0..3).fold(0, |sum: usize, axis| sum.saturating_add(reach(axis)));
        let layout = match values.stride()[0] {
            _ if farthest > i32::MAX as usize || values.size().contains(&0) => Layout::Far,
            1 if last[0] > 0 => Layout::Pairs,
            _ => Layout::Near,
        };
        let near = |number: usize| if layout == Layout::Far { 0 } else { number as i32 };
        Self {
            start: values.start(),
            low: std::array::from_fn(|axis| (cells.low[axis] - domain_low[axis]) as i32),
            last: last.map(|cell| i32::try_from(cell).unwrap_or(i32::MAX)),
            // No step is ever taken along an axis with one cell, whose stride may be any number.
            stride: std::array::from_fn(|axis| if last[axis] == 0 { 0 } else { near(values.stride()[axis]) }),
            layout,
            values,
        }
    }

    /// The brick's low corner, from the domain's low corner on.
    #[inline(always)]
    pub(crate) fn low(&self) -> [i32; 3] {
        self.low
    }

    /// The last cell per axis, from the brick's low corner on.
    #[inline(always)]
    pub(crate) fn last(&self) -> [i32; 3] {
        self.last
    }

    /// The values of `lanes` at the crossings of two planes per axis, cells of this brick's level from the domain's low
    /// corner on: `corners` tells for each crossing (x + 2 y + 4 z, 0 low and 1 high per axis) which lanes' `values` to
    /// replace. Cells outside the brick are moved to its nearest ones.
    #[inline(always)]
    pub(crate) fn read_corners<S: Gather>(
        &self,
        simd: S,
        cells: &[[Integers<S>; 2]; 3],
        corners: &[LaneSet; 8],
        normalisation: &LaneNormalisation,
        values: &mut [Floats<S>; 8],
    ) {
        if self.layout == Layout::Far {
            return self.read_far(simd, cells, corners, normalisation, values);
        }
        let zero = Integers::splat(simd, 0);
        let mut distances = [[zero; 2]; 3];
        for axis in 0..3 {
            for side in 0..2 {
                distances[axis][side] = self.distance(simd, axis, cells[axis][side]);
            }
        }
        let neighbours = (distances[0][1] - distances[0][0]).simd_eq(Integers::splat(simd, 1));
        let single = if self.layout == Layout::Pairs { !lanes_of(neighbours) } else { LaneSet::MAX };
        for edge in 0..4 {
            let (low, high) = (2 * edge, 2 * edge + 1);
            let both = corners[low] | corners[high];
            if both == 0 {
                continue;
            }
            let row = distances[1][edge & 1] + distances[2][edge >> 1];
            if corners[low] & corners[high] & !single == both {
                // Other lanes stay at one place, which costs no memory traffic.
                let mask = mask_of(simd, both);
                let place = mask.select(row + distances[0][0], zero);
                // SAFETY: all lanes are at cells inside the brick whose next neighbours along x are inside, too: the
                // others are at the first cell, and there are more than one along x.
                let found = unsafe { T::gather_pairs(simd, self.start, place, normalisation) };
                values[low] = mask.select(found[0], values[low]);
                values[high] = mask.select(found[1], values[high]);
                continue;
            }
            for side in 0..2 {
                let corner = low + side;
                if corners[corner] != 0 {
                    let mask = mask_of(simd, corners[corner]);
                    let place = mask.select(row + distances[0][side], zero);
                    // SAFETY: all lanes are at cells inside the brick.
                    let found = unsafe { T::gather(simd, self.start, place, normalisation) };
                    values[corner] = mask.select(found, values[corner]);
                }
            }
        }
    }

    /// The values at one cell a lane, from the domain's low corner on; cells outside the brick are moved to its nearest
    /// ones.
    #[inline(always)]
    pub(crate) fn read<S: Gather>(
        &self,
        simd: S,
        cells: &[Integers<S>; 3],
        lanes: LaneSet,
        normalisation: &LaneNormalisation,
    ) -> Floats<S> {
        let [x, y, z] = *cells;
        if self.layout == Layout::Far {
            let mut values = [Floats::splat(simd, 0.0); 8];
            self.read_far(simd, &[[x; 2], [y; 2], [z; 2]], &[lanes, 0, 0, 0, 0, 0, 0, 0], normalisation, &mut values);
            return values[0];
        }
        let place = self.distance(simd, 0, x) + self.distance(simd, 1, y) + self.distance(simd, 2, z);
        let place = mask_of(simd, lanes).select(place, Integers::splat(simd, 0));
        // SAFETY: all lanes are at cells inside the brick.
        unsafe { T::gather(simd, self.start, place, normalisation) }
    }

    /// How far the value of a cell, from the domain's low corner on, is from the first one's along an axis; cells outside
    /// the brick are moved to its nearest ones.
    #[inline(always)]
    fn distance<S: Gather>(&self, simd: S, axis: usize, cells: Integers<S>) -> Integers<S> {
        let last = Integers::splat(simd, self.last[axis]);
        (cells - self.low[axis]).max(Integers::splat(simd, 0)).min(last) * self.stride[axis]
    }

    /// The values of the 2x2x2 cells from `base` on, counted from the brick's low corner, x fastest. Where they reach
    /// outside the brick they are moved into it.
    #[inline(always)]
    pub(crate) fn read_dual<S: Gather>(
        &self,
        simd: S,
        base: &[Integers<S>; 3],
        lanes: LaneSet,
        normalisation: &LaneNormalisation,
    ) -> [Floats<S>; 8] {
        let zero = Integers::splat(simd, 0);
        if self.layout != Layout::Pairs {
            let mut values = [Floats::splat(simd, 0.0); 8];
            let mut cells = [[zero; 2]; 3];
            for axis in 0..3 {
                let low = base[axis] + self.low[axis];
                cells[axis] = [low, low + 1];
            }
            self.read_corners(simd, &cells, &[lanes; 8], normalisation, &mut values);
            return values;
        }
        let mut place = zero;
        for axis in 0..3 {
            let highest = Integers::splat(simd, (self.last[axis] - 1).max(0));
            place += base[axis].max(zero).min(highest) * self.stride[axis];
        }
        let place = mask_of(simd, lanes).select(place, zero);
        let [_, y, z] = self.stride;
        let mut values = [Floats::splat(simd, 0.0); 8];
        for (edge, step) in [0, y, z, y + z].into_iter().enumerate() {
            // SAFETY: all lanes are at cells inside the brick, and so are their next neighbours: `place` is at most the
            // last but one per axis, and along an axis with one cell alone no step is taken (along x there are more).
            let [low, high] =
                unsafe { T::gather_pairs(simd, self.start.wrapping_add(step as usize), place, normalisation) };
            values[2 * edge] = low;
            values[2 * edge + 1] = high;
        }
        values
    }

    /// Lane by lane.
    #[inline(never)]
    fn read_far<S: Gather>(
        &self,
        simd: S,
        cells: &[[Integers<S>; 2]; 3],
        corners: &[LaneSet; 8],
        normalisation: &LaneNormalisation,
        values: &mut [Floats<S>; 8],
    ) {
        let size = self.values.size();
        for (corner, &lanes) in corners.iter().enumerate() {
            let mut found = *values[corner];
            for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                let cell = std::array::from_fn(|axis| {
                    let cell = cells[axis][corner >> axis & 1][lane].saturating_sub(self.low[axis]);
                    (cell.max(0) as usize).min(size[axis].saturating_sub(1))
                });
                found[lane] = normalisation.of_value(self.values.get(cell).to_f64());
            }
            values[corner] = Floats::from_slice(simd, &found);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use memmap2::MmapOptions;

    use super::*;
    use crate::hierarchy::ValueBuffer;
    use crate::simd::{InstructionSet, Kernel};

    /// Reads dual cells around `base` in all the ways there are.
    struct Reads<'a> {
        brick: LaneValues<'a, f32>,
        base: [[i32; LANES]; 3],
    }

    impl Kernel for Reads<'_> {
        type Output = [[f32; LANES]; 17];
        fn run<S: Gather>(self, simd: S) -> Self::Output {
            let normalisation = LaneNormalisation::new(Normalisation { low: 0.0, scale: 1.0 });
            let base = self.base.map(|cells| Integers::from_slice(simd, &cells));
            let cells = base.map(|low| [low, low + 1]);
            let mut corners = [Floats::splat(simd, f32::NAN); 8];
            self.brick.read_corners(simd, &cells, &[LaneSet::MAX; 8], &normalisation, &mut corners);
            let dual = self.brick.read_dual(simd, &base, LaneSet::MAX, &normalisation);
            let single = self.brick.read(simd, &base, LaneSet::MAX, &normalisation);
            std::array::from_fn(|place| match place {
                0..8 => *corners[place],
                8..16 => *dual[place - 8],
                _ => *single,
            })
        }
    }

    #[test]
    fn distances_beyond_32_bits_are_read() {
        // Memory that is never touched but at eight places.
        let (size, stride) = ([2usize, 2, 2], [1usize, 1 << 20, 3 << 30]);
        let bytes = ((3usize << 30) + (1 << 20) + 2) * size_of::<f32>();
        let mut map = MmapOptions::new().len(bytes).no_reserve_swap().map_anon().unwrap();
        for corner in 0..8usize {
            let place = (0..3).map(|axis| (corner >> axis & 1) * stride[axis]).sum::<usize>() * size_of::<f32>();
            map[place..place + 4].copy_from_slice(&(corner as f32).to_ne_bytes());
        }
        let buffer = ValueBuffer::mapped(Arc::new(map.make_read_only().unwrap()));
        let values = BrickValues::<f32>::new(buffer, 0, stride, size).unwrap();
        let brick = LaneValues::new(&values, &IndexBox::new([0; 3], [2; 3]), [0; 3]);
        assert_eq!(brick.layout, Layout::Far);
        for set in InstructionSet::available() {
            let found = set.run(Reads { brick, base: [[0; LANES]; 3] });
            for (place, found) in found.into_iter().enumerate() {
                assert_eq!(found, [(place % 8) as f32; LANES], "{}", set.name());
            }
        }
    }

    #[test]
    fn cells_outside_are_moved_into_the_brick() {
        let count = |size: [usize; 3]| size.iter().product::<usize>();
        for (size, stride) in
            [([3, 2, 4], [1, 3, 6]), ([3, 2, 4], [8, 4, 1]), ([1, 2, 3], [1, 1, 2]), ([2, 1, 1], [1, 7, 9])]
        {
            let values = BrickValues::new(
                ValueBuffer::owned((0..count(size)).map(|value| value as f32).collect::<Vec<_>>()),
                0,
                stride,
                size,
            );
            let values = values.unwrap();
            let low = [5i64, -3, 2];
            let cells = IndexBox::new(low, std::array::from_fn(|axis| low[axis] + size[axis] as i64));
            let brick = LaneValues::new(&values, &cells, [-4; 3]);
            let far = 1 << 30;
            let places = [-far, -70, -1, 0, 1, 2, 3, 4, 9, 10, 11, 12, 13, 80, far - 1, far];
            let base = [places, std::array::from_fn(|lane| places[(lane * 7) % LANES]), places];
            for set in InstructionSet::available() {
                let found = set.run(Reads { brick, base });
                for lane in 0..LANES {
                    let cell: [usize; 3] = std::array::from_fn(|axis| {
                        let inside = i64::from(base[axis][lane]) - (low[axis] + 4);
                        inside.clamp(0, size[axis] as i64 - 1) as usize
                    });
                    assert_eq!(found[16][lane], values.get(cell), "{} at {cell:?}", set.name());
                    assert_eq!(found[0][lane], values.get(cell), "{} at {cell:?}", set.name());
                }
            }
        }
    }
}
