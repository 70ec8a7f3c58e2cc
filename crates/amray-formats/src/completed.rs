//! Data sets of leaf cells alone, as octree codes write them: small blocks are joined, and the coarse levels that the
//! file leaves out are added.

use std::path::Path;
use std::sync::Arc;

use amray::hierarchy::{Field, Hierarchy, Rebricking};

use crate::{DataSet, Definition, FieldInfo, FormatError, OpenOptions};

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
    /// Without the levels that were not asked for.
    hierarchy: Arc<Hierarchy>,
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
        Ok(Self { leaves, steps, hierarchy })
    }
}

impl DataSet for Completed {
    fn format(&self) -> &'static str {
        self.leaves.format()
    }

    fn time(&self) -> Option<f64> {
        self.leaves.time()
    }

    fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    fn fields(&self) -> &[FieldInfo] {
        self.leaves.fields()
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        let leaves = self.leaves.read_field(field, progress)?;
        let completed = self.steps.iter().fold(leaves, |field, step| step.apply(&field));
        Ok(completed.truncated(&self.hierarchy))
    }

    fn expressions(&self) -> &[Definition] {
        self.leaves.expressions()
    }

    fn warnings(&self) -> &[String] {
        self.leaves.warnings()
    }
}
