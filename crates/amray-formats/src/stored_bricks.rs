//! From bricks as files store them to fields: what all formats share that have their values brick by brick.

use std::sync::atomic::{AtomicUsize, Ordering};

use amray::hierarchy::{BrickValues, Centering, Field, FieldValues, Voxel, VoxelType};
use rayon::prelude::*;

use crate::hdf5::H5Type;
use crate::{DataSet, FieldInfo, FormatError};

/// A number type that files store, in either byte order.
pub(crate) trait StoredVoxel: Voxel + H5Type {
    /// The number with its bytes in the other order.
    fn swap_bytes(self) -> Self;
}

impl StoredVoxel for f32 {
    fn swap_bytes(self) -> Self {
        Self::from_bits(self.to_bits().swap_bytes())
    }
}

impl StoredVoxel for f64 {
    fn swap_bytes(self) -> Self {
        Self::from_bits(self.to_bits().swap_bytes())
    }
}

/// A data set whose fields are stored brick by brick.
pub(crate) trait StoredBricks: DataSet {
    /// Reads or maps a field in all bricks, in their order. `T` is the type that [`FieldInfo::voxel_type`] tells.
    ///
    /// # Errors
    /// As [`DataSet::read_field`].
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError>;
}

/// [`DataSet::read_field`] of a data set of stored bricks.
pub(crate) fn read_field(
    data: &impl StoredBricks,
    centering: Centering,
    field: usize,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Field, FormatError> {
    let FieldInfo { name, voxel_type, .. } = &data.fields()[field];
    let values: FieldValues = match voxel_type {
        VoxelType::F32 => data.bricks::<f32>(field, progress)?.into(),
        VoxelType::F64 => data.bricks::<f64>(field, progress)?.into(),
    };
    let wrong = |source| FormatError::Field { path: data.summary().path.clone(), source };
    Field::centered(name, centering, values, data.hierarchy()).map_err(wrong)
}

/// Reads something at each of the `places`, in parallel. `progress` is told the share of them that is done.
pub(crate) fn read_each<P: Sync, R: Send>(
    places: &[P],
    progress: &(dyn Fn(f64) + Sync),
    read: impl Fn(&P) -> Result<R, FormatError> + Sync,
) -> Result<Vec<R>, FormatError> {
    let done = counted(places.len(), progress);
    let read_one = |place: &P| {
        let found = read(place);
        done();
        found
    };
    places.par_iter().map(read_one).collect()
}

/// To be called whenever one of `count` things is done; `progress` is told the share of them.
pub(crate) fn counted(count: usize, progress: &(dyn Fn(f64) + Sync)) -> impl Fn() + Sync {
    let done = AtomicUsize::new(0);
    move || progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64)
}
