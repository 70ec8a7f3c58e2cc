//! A data set out of nothing, for a first picture, for tests and for measurements: see [`Demo`].

mod blocks;
mod clustering;
mod field;
mod noise;
mod refinement;
mod tagging;
#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use amray::hierarchy::{Centering, Hierarchy, IndexBox, LevelDescription, VoxelType};
use rayon::prelude::*;
use thiserror::Error;

use crate::chombo::ChomboWriter;
use crate::{AmrContent, FormatError};
use refinement::{ALIGNMENT, Mesh, Refinement};

/// The planning's share of the time.
const PLANNING: f64 = 0.25;
/// 64 GB of values.
const MAX_CELLS: u64 = 1 << 32;

/// A synthetic adaptive simulation: the remnant of a supernova in a unit cube, refined where its density changes.
///
/// Fields `density` and `temperature`, in double precision, as values at the cells' centres (covered cells too: they
/// are not the mean of the finer ones). The same parameters give the same bytes on every machine and with any number
/// of threads. Values are computed brick by brick, so memory holds the list of bricks and little else.
///
/// The default makes 126 MB; 6 levels on a base of 64 make 0.4 GB, with a threshold of 0.22 2 GB and with 0.15 4 GB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demo {
    /// How many levels there may be, 1 to 12; fewer are made where nothing is left to refine.
    pub levels: usize,
    /// Cells of level 0 per side, 8 to 1024.
    pub base: usize,
    /// Cells of the next finer level per cell and axis, 2 or 4.
    pub ratio: usize,
    /// Cells per side of the largest brick: a multiple of 8 from 8 to 128.
    pub brick: usize,
    /// Cells are refined whose density and a neighbour's differ by more than this share of their sum, between 0 and 1:
    /// the smaller, the more cells.
    pub threshold: f64,
}

impl Default for Demo {
    fn default() -> Self {
        Self { levels: 4, base: 32, ratio: 2, brick: 16, threshold: 0.4 }
    }
}

/// A demo data set that cannot be made.
#[derive(Debug, Error)]
pub enum DemoError {
    /// A parameter out of range.
    #[error("{name} is {found}, expected {expected}")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// More cells than anybody wants to have by accident.
    #[error(
        "levels 0 to {level} have {cells} cells, expected at most {MAX_CELLS}: ask for fewer levels, \
             a smaller base, or a larger threshold"
    )]
    TooManyCells {
        /// The level that went too far.
        level: usize,
        /// The cells of all levels up to it.
        cells: u64,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl Demo {
    /// Writes the data set as a Chombo file. `progress` is told the share that is done, 0 to 1, possibly from several
    /// threads.
    ///
    /// # Errors
    /// [`DemoError`]; the file at `path` is then as it was before.
    pub fn write(&self, path: &Path, progress: &(dyn Fn(f64) + Sync)) -> Result<(), DemoError> {
        let hierarchy = self.hierarchy(&|share| progress(PLANNING * share))?;
        let content = AmrContent {
            hierarchy: &hierarchy,
            components: &field::COMPONENTS,
            centering: Centering::Cells,
            voxel_type: VoxelType::F64,
            time: 0.0,
        };
        let writer = ChomboWriter::create(path, &content)?;
        let (cells, done) = (hierarchy.cells() as f64, AtomicU64::new(0));
        let bricks: Vec<_> = hierarchy.bricks().collect();
        bricks.into_par_iter().try_for_each(|brick| {
            let [side, ..] = hierarchy.levels()[brick.level].domain().size();
            let values = brick.cells.iter().map(|cell| field::at_centre(cell, side).into());
            let (density, temperature): (Vec<f64>, Vec<f64>) = values.unzip();
            for (component, values) in [density, temperature].iter().enumerate() {
                writer.write(brick.level, brick.number, component, 0, values)?;
            }
            let done = done.fetch_add(brick.cells.cells(), Ordering::Relaxed) + brick.cells.cells();
            progress(PLANNING + (1.0 - PLANNING) * done as f64 / cells);
            Ok::<_, FormatError>(())
        })?;
        Ok(writer.finish()?)
    }

    /// The mesh alone: level by level, what the one before calls for. `progress` as in [`Demo::write`].
    ///
    /// # Errors
    /// [`DemoError::Parameter`] and [`DemoError::TooManyCells`].
    pub fn hierarchy(&self, progress: &(dyn Fn(f64) + Sync)) -> Result<Hierarchy, DemoError> {
        self.check()?;
        let (ratio, brick) = (self.ratio as i64, self.brick as i64);
        let how = Refinement { ratio, brick, threshold: self.threshold };
        let mut meshes = vec![Mesh::coarsest(self.base as i64, brick)];
        let mut cells = 0;
        for level in 0..self.levels {
            let mesh = &meshes[level];
            let of_level = mesh.bricks.iter().map(IndexBox::cells).sum::<u64>();
            cells += of_level;
            if cells > MAX_CELLS {
                return Err(DemoError::TooManyCells { level, cells });
            }
            if level + 1 == self.levels {
                break;
            }
            let done = AtomicU64::new(0);
            let finer = mesh.refined(&how, &|cells| {
                let share = (done.fetch_add(cells, Ordering::Relaxed) + cells) as f64 / of_level as f64;
                progress((level as f64 + share) / (self.levels - 1) as f64);
            });
            if finer.bricks.is_empty() {
                break;
            }
            meshes.push(finer);
        }
        progress(1.0);
        let levels = meshes.into_iter().enumerate().map(|(level, mesh)| LevelDescription {
            ratio: if level == 0 { [1; 3] } else { [ratio; 3] },
            cell_size: [1.0 / mesh.side as f64; 3],
            domain: mesh.domain(),
            bricks: mesh.bricks,
        });
        let made = Hierarchy::new([0.0; 3], levels.collect());
        Ok(made.expect("bricks were made aligned, disjoint and inside the domain"))
    }

    /// Whether every parameter is in its range.
    ///
    /// # Errors
    /// [`DemoError::Parameter`] names the first that is not.
    pub fn check(&self) -> Result<(), DemoError> {
        let require = |holds: bool, name, found: &dyn ToString, expected| {
            let found = found.to_string();
            if holds { Ok(()) } else { Err(DemoError::Parameter { name, found, expected }) }
        };
        let Self { levels, base, ratio, brick, threshold } = *self;
        require((1..=12).contains(&levels), "the number of levels", &levels, "1 to 12")?;
        require((8..=1024).contains(&base), "the base", &base, "8 to 1024 cells per side")?;
        require(ratio == 2 || ratio == 4, "the ratio", &ratio, "2 or 4")?;
        let fits = (8..=128).contains(&brick) && brick.is_multiple_of(ALIGNMENT as usize);
        require(fits, "the brick size", &brick, "a multiple of 8 from 8 to 128 cells")?;
        require(threshold > 0.0 && threshold < 1.0, "the threshold", &threshold, "a number between 0 and 1")?;
        let finest = (base as u64) * (ratio as u64).pow(levels as u32 - 1);
        let expected = "at most 2147483647 cells per side";
        require(i32::try_from(finest).is_ok(), "the finest level's width", &finest, expected)
    }
}
