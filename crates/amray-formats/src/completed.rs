//! Data sets of leaf cells alone, as octree codes write them: small blocks are joined, and the coarse levels that the
//! file leaves out are added.

use std::path::Path;
use std::sync::Arc;

use amray::hierarchy::{Field, Rebricking};

use crate::{DataSet, Definition, FormatError, OpenOptions, Summary};

/// Blocks are joined where they hold fewer cells than this on average: larger ones cost little, and can stay in a
/// mapped file.
const SMALL_BLOCK: u64 = 16 * 16 * 16;
/// Blocks are joined up to so many cells per axis.
const TILE: i64 = 32;

/// A data set of leaf cells, completed.
pub(crate) struct Completed {
    leaves: Box<dyn DataSet>,
    /// What is done to every field, one after the other.
    steps: Vec<Rebricking>,
    /// Of the leaves, with the completed hierarchy, without the levels that were not asked for.
    summary: Summary,
}

impl Completed {
    /// Completes a data set that was opened with all of its levels; `path` is for errors.
    pub(crate) fn new(leaves: Box<dyn DataSet>, path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        let wrong = FormatError::hierarchy(path);
        let mut steps = Vec::new();
        let mut hierarchy = leaves.hierarchy().clone();
        if hierarchy.cells() < SMALL_BLOCK * hierarchy.brick_count() as u64 {
            let merged = hierarchy.merged(TILE).map_err(&wrong)?;
            hierarchy = merged.hierarchy().clone();
            steps.push(merged);
        }
        let completed = hierarchy.completed().map_err(&wrong)?;
        hierarchy = completed.hierarchy().clone();
        steps.push(completed);
        let levels = options.level_count(path, hierarchy.levels().len())?;
        if levels < hierarchy.levels().len() {
            hierarchy = Arc::new(hierarchy.truncated(levels - 1));
        }
        let summary = Summary { hierarchy, ..leaves.summary().clone() };
        Ok(Self { leaves, steps, summary })
    }
}

impl DataSet for Completed {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        let leaves = self.leaves.read_field(field, progress)?;
        let completed = self.steps.iter().fold(leaves, |field, step| step.apply(&field));
        Ok(completed.truncated(self.hierarchy()))
    }

    fn expressions(&self) -> &[Definition] {
        self.leaves.expressions()
    }
}
