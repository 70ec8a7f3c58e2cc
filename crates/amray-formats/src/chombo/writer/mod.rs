//! Writes what Chombo's `WriteAMRHierarchyHDF5` writes: one HDF5 file, brick by brick, in any order.
//!
//! Layout: Chombo's AMRIO.H and the files of its examples. No ghost cells. Cells that are not cubes, or ratios that
//! differ between axes, become `vec_dx` and `vec_ref_ratio` as Chombo's anisotropic variant has them.

mod layout;
mod tables;
#[cfg(test)]
mod tests;

use std::path::Path;

use amray::hierarchy::{Centering, Voxel};

use crate::hdf5_output::{Hdf5Output, ValueList, failure};
use crate::{AmrContent, FormatError};
use layout::Layout;

/// A Chombo file that is being written; it takes its name when it is finished.
///
/// Values can come from several threads at once and in any order. A brick that is never written holds zeros.
pub struct ChomboWriter {
    components: usize,
    levels: Vec<LevelWriter>,
    output: Hdf5Output,
}

struct LevelWriter {
    values: ValueList,
    /// Where each brick's values start, and where the last one's end.
    offsets: Vec<i64>,
}

impl ChomboWriter {
    /// Lays down everything but the values, of which only the place is reserved.
    ///
    /// World positions are kept: to Chombo, world = index * cell size, so an origin that is a whole number of coarsest
    /// cells moves the indices. Any other becomes the root attribute `origin`, which amray reads; other programs pass over
    /// it and show the data moved by it.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the hierarchy cannot be expressed: indices beyond 32 bits. [`FormatError::Io`] where the file cannot be written.
    pub fn create(path: &Path, content: &AmrContent) -> Result<Self, FormatError> {
        let (origin, tables) = tables::of(path, content)?;
        let output = Hdf5Output::create(path)?;
        let levels = Layout { content, origin }.write(&output.root(), tables).map_err(failure(path))?;
        Ok(Self { components: content.components.len(), levels, output })
    }

    /// Writes some values of a brick's component, from the one counted `first` on, x fastest, rounded to the file's number
    /// type.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written.
    ///
    /// # Panics
    /// Where there is no such level, brick or component, or not as many values.
    pub fn write<T: Voxel>(
        &self,
        level: usize,
        brick: usize,
        component: usize,
        first: usize,
        values: &[T],
    ) -> Result<(), FormatError> {
        assert!(component < self.components, "no component {component} among {}", self.components);
        let LevelWriter { values: target, offsets } = &self.levels[level];
        let all = (offsets[brick + 1] - offsets[brick]) as usize / self.components;
        assert!(first <= all && values.len() <= all - first, "values of level {level}, brick {brick}");
        let start = offsets[brick] as usize + component * all + first;
        target.write(start, values).map_err(failure(self.output.path()))
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written or renamed.
    pub fn finish(self) -> Result<(), FormatError> {
        drop(self.levels);
        self.output.finish()
    }
}

/// Chombo's number for what values belong to; cells go without saying.
fn data_centering(centering: Centering) -> Option<i32> {
    match centering {
        Centering::Cells => None,
        Centering::Nodes => Some(7),
    }
}
