//! AMR data made of a structured volume, as section 6 of Wald, Brownlee, Usher and Knoll's paper (SA '17) has it: coarser
//! levels are means, and bricks that do not vary are dropped.
//!
//! **Levels.** A coarse cell is the mean of its fine cells, 2x2x2 of them, that are numbers. Cells that have none are not
//! a number.
//!
//! **Bricks.** A brick is kept where a sample in it differs by more than the threshold from the cell of the next coarser
//! level around it, or where only one of both is a number; and so are the bricks of all coarser levels around it. Level 0
//! is always kept. Where nothing is kept on the finest level, its first brick is: it tells the grid of the samples, on which
//! `finest` interpolates. Only where level 0 stands for all samples and is one value, it is all there is.
//!
//! **What is bounded.** Every sample differs by no more than the threshold from the leaf cell around it, so the
//! reconstruction `finest`, between the samples, by no more than the threshold from the volume's trilinear interpolation.
//! With the threshold 0 both are the same, bit for bit.

mod errors;
mod layer;
mod level_file;
mod memory;
mod output;
mod pyramid;
mod shape;

use std::path::Path;

use amray::hierarchy::{Centering, Hierarchy, Voxel, VoxelType};
use thiserror::Error;

use super::StructuredVolume;
use crate::output::check_writable;
use crate::{AmrContent, AmrFormat, FormatError};
use pyramid::Pyramid;
use shape::LevelShape;

/// The field that is made.
pub const FIELD: &str = "value";

/// How AMR data are made of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refinement {
    /// Cells per side of a brick: an even number from 4 to 256.
    pub brick: usize,
    /// By how much samples may differ from what stands for them: a finite number, not below 0.
    pub threshold: f64,
    /// The number of levels; as many as make level 0 a single brick if not given.
    pub levels: Option<usize>,
    /// Bytes that may be used, besides some 200 per kept brick.
    pub memory: u64,
}

/// What has been made.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The mesh.
    pub hierarchy: Hierarchy,
    /// The largest difference between a sample and the leaf cell around it: at the samples' positions, that is the
    /// difference of `finest`.
    pub max_error: f64,
    /// The mean difference, over all samples that are numbers.
    pub mean_error: f64,
}

/// AMR data that cannot be made.
#[derive(Debug, Error)]
pub enum RefinementError {
    /// A parameter out of range.
    #[error("{name} is {found}, expected {expected}")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// Not even two slices of the volume fit.
    #[error("{given} bytes of memory, expected at least {needed}")]
    Memory {
        /// What may be used.
        given: u64,
        /// What must be.
        needed: u64,
    },
    /// The volume cannot be read, or the output not be written.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// What is known before the first sample is read.
struct Plan<'a> {
    refinement: &'a Refinement,
    /// Coarsest first.
    levels: Vec<LevelShape>,
    /// Where temporary files go.
    directory: &'a Path,
    /// Slices that are read at a time.
    slab: usize,
    /// Bytes that the volume's reader may keep.
    reader_memory: u64,
}

impl Plan<'_> {
    fn finest(&self) -> &LevelShape {
        &self.levels[self.levels.len() - 1]
    }
}

impl Refinement {
    /// Writes AMR data made of `volume`, in the format that the ending of `path` asks for. Reads the volume twice, slab by
    /// slab; coarser levels wait in temporary files beside `path`. `progress` is told the share that is done, 0 to 1.
    ///
    /// # Errors
    /// [`RefinementError`]; the file at `path` is then as it was before.
    pub fn write(
        &self,
        volume: &StructuredVolume,
        path: &Path,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Refined, RefinementError> {
        self.check(volume)?;
        match volume.voxel_type() {
            VoxelType::F32 => self.write_as::<f32>(volume, path, progress),
            VoxelType::F64 => self.write_as::<f64>(volume, path, progress),
        }
    }

    fn write_as<T: Voxel>(
        &self,
        volume: &StructuredVolume,
        path: &Path,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Refined, RefinementError> {
        let format = AmrFormat::of(path)?;
        check_writable(path)?;
        let plan = self.plan(volume, path)?;
        let pyramid = Pyramid::build::<T>(volume, &plan, &|share| progress(share / 2.0))?;
        let bricks = plan.levels.iter().zip(&pyramid.kept);
        let bricks = bricks.map(|(level, kept)| output::bricks(level, kept, self.brick).collect()).collect();
        let used = &plan.levels[..pyramid.used];
        let hierarchy =
            shape::hierarchy(used, bricks, volume.spacing(), volume.origin()).map_err(FormatError::hierarchy(path))?;
        let writer = format.create(
            path,
            &AmrContent {
                hierarchy: &hierarchy,
                components: &[FIELD],
                centering: Centering::Cells,
                voxel_type: volume.voxel_type(),
                time: 0.0,
            },
        )?;
        let errors = output::write::<T>(volume, &plan, pyramid, &writer, &|share| progress(0.5 + share / 2.0))?;
        writer.finish()?;
        Ok(Refined { hierarchy, max_error: errors.max, mean_error: errors.mean() })
    }

    fn plan<'a>(&'a self, volume: &StructuredVolume, path: &'a Path) -> Result<Plan<'a>, RefinementError> {
        let levels = shape::levels(volume.size(), self.brick, self.levels);
        // Readers that gather slices in memory take half of it.
        let reader_memory = if volume.is_transposed() { self.memory / 2 } else { 0 };
        let slab = memory::slab(&levels, self.brick, volume.voxel_type().bytes(), self.memory - reader_memory)
            .map_err(|needed| RefinementError::Memory { given: self.memory, needed: needed + reader_memory })?;
        let directory = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        Ok(Plan { refinement: self, levels, directory, slab, reader_memory })
    }

    fn check(&self, volume: &StructuredVolume) -> Result<(), RefinementError> {
        let require = |holds: bool, name, found: &dyn ToString, expected: String| {
            let found = found.to_string();
            if holds { Ok(()) } else { Err(RefinementError::Parameter { name, found, expected }) }
        };
        let Self { brick, threshold, levels, .. } = *self;
        let fits = (4..=256).contains(&brick) && brick.is_multiple_of(2);
        require(fits, "the brick size", &brick, "an even number from 4 to 256".into())?;
        let bounds = threshold.is_finite() && threshold >= 0.0;
        require(bounds, "the threshold", &threshold, "a finite number, not below 0".into())?;
        let (levels, most) = (levels.unwrap_or(1), shape::most_levels(volume.size()));
        require((1..=most).contains(&levels), "the number of levels", &levels, format!("1 to {most}"))
    }
}
