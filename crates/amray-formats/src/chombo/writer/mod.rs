//! Writes what Chombo's `WriteAMRHierarchyHDF5` writes: one HDF5 file, brick by brick, in any order.
//!
//! Layout: Chombo's AMRIO.H and the files of its examples. No ghost cells. Cells that are not cubes, or ratios that
//! differ between axes, become `vec_dx` and `vec_ref_ratio` as Chombo's anisotropic variant has them.

mod layout;
mod tables;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use amray::hierarchy::{Hierarchy, Voxel, VoxelType};
use rust_hdf5::{H5Dataset, H5File, Hdf5Error};

use crate::FormatError;
use crate::output::OutputFile;
use layout::Layout;

/// A Chombo file that is being written; it takes its name when it is finished.
///
/// Values can come from several threads at once and in any order. A brick that is never written holds zeros.
pub struct ChomboWriter {
    path: PathBuf,
    voxel_type: VoxelType,
    components: usize,
    levels: Vec<LevelWriter>,
    // Dropping the file completes it on disk: it must go before the temporary name does.
    file: H5File,
    output: OutputFile,
}

struct LevelWriter {
    values: H5Dataset,
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
    pub fn create(
        path: &Path,
        hierarchy: &Hierarchy,
        components: &[&str],
        voxel_type: VoxelType,
        time: f64,
    ) -> Result<Self, FormatError> {
        let (origin, tables) = tables::of(path, hierarchy, components.len())?;
        let output = OutputFile::create(path)?;
        let layout = Layout { components, voxel_type, time, origin };
        let (file, levels) = layout.write(output.temporary_path(), tables).map_err(failure(path))?;
        Ok(Self { path: path.into(), voxel_type, components: components.len(), levels, file, output })
    }

    /// Writes one component of one brick: a value per cell, x fastest, rounded to the file's number type.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written.
    ///
    /// # Panics
    /// Where there is no such level, brick or component, or not one value per cell.
    pub fn write_brick<T: Voxel>(
        &self,
        level: usize,
        brick: usize,
        component: usize,
        values: &[T],
    ) -> Result<(), FormatError> {
        let cells = self.levels[level].cells(brick, self.components);
        assert_eq!(values.len(), cells, "values of level {level}, brick {brick}");
        self.write_cells(level, brick, component, 0, values)
    }

    /// Writes one component of some cells of a brick, from the one counted `first` on, x fastest.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written.
    ///
    /// # Panics
    /// Where there is no such level, brick or component, or not as many cells.
    pub fn write_cells<T: Voxel>(
        &self,
        level: usize,
        brick: usize,
        component: usize,
        first: usize,
        values: &[T],
    ) -> Result<(), FormatError> {
        assert!(component < self.components, "no component {component} among {}", self.components);
        let LevelWriter { values: target, offsets } = &self.levels[level];
        let cells = self.levels[level].cells(brick, self.components);
        assert!(first <= cells && values.len() <= cells - first, "cells of level {level}, brick {brick}");
        let (start, count) = (offsets[brick] as usize + component * cells + first, values.len());
        let numbers = values.iter().map(|value| value.to_f64());
        match self.voxel_type {
            VoxelType::F32 => target.write_slice(&[start], &[count], &numbers.map(f32::from_f64).collect::<Vec<_>>()),
            VoxelType::F64 => target.write_slice(&[start], &[count], &numbers.collect::<Vec<_>>()),
        }
        .map_err(failure(&self.path))
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written or renamed.
    pub fn finish(self) -> Result<(), FormatError> {
        let Self { path, levels, file, output, .. } = self;
        drop(levels);
        file.close_no_sync().map_err(failure(&path))?;
        output.finish()
    }
}

impl LevelWriter {
    /// The number of cells of a brick.
    fn cells(&self, brick: usize, components: usize) -> usize {
        (self.offsets[brick + 1] - self.offsets[brick]) as usize / components
    }
}

fn failure(path: &Path) -> impl Fn(Hdf5Error) -> FormatError + use<> {
    let failed = FormatError::io(path, "write");
    move |error| {
        failed(match error {
            Hdf5Error::Io(source) => source,
            other => std::io::Error::other(other.to_string()),
        })
    }
}
