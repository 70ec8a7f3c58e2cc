//! The values in a Chombo file: where each brick's lie, mapped in place or read.
//!
//! A level's values are one flat array. Per box it holds all components, x fastest and component slowest, with ghost
//! cells around each. Ghost values are not to be trusted and are skipped.

use std::ops::Range;
use std::sync::Arc;

use amray::hierarchy::{BrickValues, IndexBox, OutOfBuffer, ValueBuffer, Voxel, VoxelType};
use memmap2::Mmap;

use super::geometry::INTEGER_VECTOR;
use crate::FormatError;
use crate::hdf5::{H5Type, Hdf5Group, Hdf5Set, Parts, Storage};
use crate::store::Store;

/// Where the values of a level's bricks lie.
pub(super) struct LevelValues {
    set: Hdf5Set,
    voxel_type: VoxelType,
    storage: Storage,
    /// Where each brick starts in the array, and after the last one where it ends.
    offsets: Vec<u64>,
    ghosts: [u64; 3],
}

/// Where one component of a brick lies in the array.
struct Placement {
    /// With ghost cells.
    values: Range<u64>,
    /// From the start of `values` to the first cell that is no ghost.
    first: usize,
    /// Distance between neighbouring cells, in values.
    stride: [usize; 3],
    /// Cells per axis, without ghosts.
    size: [usize; 3],
}

impl LevelValues {
    /// Finds the values of a level's validated bricks, whose `places` are cells or nodes, and checks that there is one per
    /// place and component.
    pub(super) fn locate(
        level: usize,
        group: &Hdf5Group,
        components: usize,
        places: &[IndexBox],
    ) -> Result<Self, FormatError> {
        let ghosts = ghosts(group, components)?;
        let set = group.data_set("data:datatype=0")?;
        let offsets = group.data_set("data:offsets=0")?;
        let starts = offsets.integers()?;
        if starts.len() != places.len() + 1 {
            let (found, expected) = (starts.len(), places.len() + 1);
            return Err(offsets.malformed(&format!("{found} offsets, expected {expected} (one more than boxes)")));
        }
        for (brick, (cells, ends)) in places.iter().zip(starts.windows(2)).enumerate() {
            let expected = values_of(cells, ghosts).and_then(|values| values.checked_mul(components as u64));
            let found = ends[1].checked_sub(ends[0]).and_then(|span| u64::try_from(span).ok());
            if ends[0] < 0 || found.is_none() || found != expected {
                let size = cells.size();
                return Err(offsets.malformed(&format!(
                    "level {level}, brick {brick}: offsets {} to {}, expected {components} components of {size:?} cells \
                     with {ghosts:?} ghost layers between them",
                    ends[0], ends[1]
                )));
            }
        }
        let offsets: Vec<u64> = starts.into_iter().map(i64::cast_unsigned).collect();
        let (needed, length) = (offsets.last().copied().unwrap_or(0), set.length()?);
        if needed > length {
            return Err(set.malformed(&format!("{length} values, expected {needed} by data:offsets=0")));
        }
        let voxel_type = set.voxel_type()?;
        let storage = set.storage()?;
        Ok(Self { set, voxel_type, storage, offsets, ghosts })
    }

    /// The stored number type.
    pub(super) fn voxel_type(&self) -> VoxelType {
        self.voxel_type
    }

    /// A field has one number type on all levels.
    pub(super) fn expect_type(&self, expected: VoxelType) -> Result<(), FormatError> {
        if self.voxel_type == expected {
            return Ok(());
        }
        let [found, expected] = [self.voxel_type, expected].map(VoxelType::bytes);
        Err(self.set.malformed(&format!("floats of {found} bytes, expected {expected} bytes as on level 0")))
    }

    /// The values of one component in all bricks, at their `places`: where they are if the file's bytes are this machine's
    /// numbers, else owned and without ghosts. `T` is the stored type. `advance` is told of places that are done.
    pub(super) fn read<T: Voxel + H5Type>(
        &self,
        map: &Arc<Mmap>,
        component: usize,
        places: &[IndexBox],
        store: &Store,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        match &self.storage {
            Storage::Contiguous(bytes) if self.set.is_native() => {
                let buffer = ValueBuffer::mapped(Arc::clone(map));
                let mapped = |(brick, cells)| self.mapped(&buffer, bytes, self.placement(brick, component, cells));
                let values = places.iter().enumerate().map(mapped).collect::<Result<_, _>>();
                advance(places.iter().map(IndexBox::cells).sum());
                values.map_err(|error| self.set.malformed(&error.to_string()))
            }
            _ => self.read_copies(component, places, store, advance),
        }
    }

    fn mapped<T: Voxel>(
        &self,
        buffer: &ValueBuffer,
        bytes: &Range<usize>,
        placement: Placement,
    ) -> Result<BrickValues<T>, OutOfBuffer> {
        let Placement { values, first, stride, size } = placement;
        // `locate` found all values inside `bytes`.
        let offset = bytes.start + (values.start as usize + first) * size_of::<T>();
        BrickValues::new(buffer.clone(), offset, stride, size)
    }

    fn read_copies<T: Voxel + H5Type>(
        &self,
        component: usize,
        places: &[IndexBox],
        store: &Store,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let placement = |brick: usize| self.placement(brick, component, &places[brick]);
        let along = (0..places.len()).map(|brick| placement(brick).values).collect();
        let parts = Parts { leading: Vec::new(), along, inner: Vec::new() };
        self.set.read_parts(&self.storage, &parts, |brick, values| {
            advance(places[brick].cells());
            let placement = placement(brick);
            store.keep(placement.without_ghosts(values), placement.size)
        })
    }

    fn placement(&self, brick: usize, component: usize, cells: &IndexBox) -> Placement {
        // `locate` checked these products; validated bricks are not empty.
        let size = cells.size().map(|cells| cells as usize);
        let ghosts = self.ghosts.map(|layers| layers as usize);
        let padded: [usize; 3] = std::array::from_fn(|axis| size[axis] + 2 * ghosts[axis]);
        let stride = [1, padded[0], padded[0] * padded[1]];
        let count = stride[2] * padded[2];
        let start = self.offsets[brick] + (component * count) as u64;
        let first = (0..3).map(|axis| ghosts[axis] * stride[axis]).sum();
        Placement { values: start..start + count as u64, first, stride, size }
    }
}

impl Placement {
    /// The cells of `values` that are no ghosts, x fastest.
    fn without_ghosts<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let Self { first, stride, size, .. } = self;
        let cells = size.iter().product();
        if values.len() == cells {
            return values.to_vec();
        }
        let mut kept = Vec::with_capacity(cells);
        for k in 0..size[2] {
            for j in 0..size[1] {
                let row = first + j * stride[1] + k * stride[2];
                kept.extend_from_slice(&values[row..row + size[0]]);
            }
        }
        kept
    }
}

/// Ghost layers per axis around each box in the file. `outputGhost` counts them; `ghost` is what the run had in memory.
fn ghosts(level: &Hdf5Group, components: usize) -> Result<[u64; 3], FormatError> {
    let Some(attributes) = level.group("data_attributes")? else { return Ok([0; 3]) };
    if let Some(found) = attributes.integer("comps")?
        && usize::try_from(found) != Ok(components)
    {
        return Err(attributes.malformed(&format!("comps is {found}, expected {components} by num_components")));
    }
    let ghosts = attributes.integers("outputGhost", INTEGER_VECTOR)?.unwrap_or_default();
    match ghosts.map(u64::try_from) {
        [Ok(x), Ok(y), Ok(z)] => Ok([x, y, z]),
        _ => Err(attributes.malformed(&format!("outputGhost is {ghosts:?}, expected no negative numbers"))),
    }
}

/// The number of values of one component of a brick, ghost cells included.
fn values_of(cells: &IndexBox, ghosts: [u64; 3]) -> Option<u64> {
    (0..3).try_fold(1u64, |values, axis| {
        let padded = ghosts[axis].checked_mul(2)?.checked_add(cells.low[axis].abs_diff(cells.high[axis]))?;
        values.checked_mul(padded)
    })
}
