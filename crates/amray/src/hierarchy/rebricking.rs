//! Other bricks for the same data: joined ones, and coarse ones where only finer cells are stored.

use std::sync::Arc;

use rayon::prelude::*;

use super::field::{FieldValues, with_voxels};
use super::restrict::restrict;
use super::values::{BrickValues, Voxel};
use super::{Centering, Field, Hierarchy, HierarchyError, IndexBox, LevelDescription};

/// A hierarchy made from another one, and where the values of its bricks come from.
///
/// [`Hierarchy::merged`] and [`Hierarchy::completed`] make them.
#[derive(Clone, Debug)]
pub struct Rebricking {
    hierarchy: Arc<Hierarchy>,
    /// One for each brick.
    sources: Vec<Source>,
}

/// Where the values of a brick come from.
#[derive(Clone, Debug)]
pub(super) enum Source {
    /// Bricks of the other hierarchy that tile it: their places and cells.
    Bricks(Vec<(usize, IndexBox)>),
    /// The means of the finer cells above it.
    Finer,
}

impl Rebricking {
    /// `sources` has one for each brick of the `levels`.
    pub(super) fn new(
        origin: [f64; 3],
        levels: Vec<LevelDescription>,
        sources: Vec<Source>,
    ) -> Result<Self, HierarchyError> {
        Ok(Self { hierarchy: Arc::new(Hierarchy::new(origin, levels)?), sources })
    }

    /// The hierarchy of the new bricks.
    pub fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    /// A field of the other hierarchy in the new bricks. Values of bricks that stayed as they were stay where they are;
    /// the others are copies.
    ///
    /// # Panics
    /// Where the field is not a cell-centred one of the other hierarchy.
    pub fn apply(&self, field: &Field) -> Field {
        assert_eq!(field.centering(), Centering::Cells, "the centering of {}", field.name());
        let values: FieldValues = with_voxels!(field.values(), bricks => self.rebricked(bricks).into());
        Field::new(field.name(), values, &self.hierarchy).expect("every new brick was filled")
    }

    fn rebricked<T: Voxel>(&self, others: &[BrickValues<T>]) -> Vec<BrickValues<T>> {
        let boxes: Vec<IndexBox> = self.hierarchy.bricks().map(|brick| brick.cells).collect();
        let gather = |(source, cells): (&Source, &IndexBox)| match source {
            Source::Bricks(parts) if parts.len() == 1 => others[parts[0].0].clone(),
            Source::Bricks(parts) => joined(others, parts, cells),
            Source::Finer => owned(vec![T::from_f64(f64::NAN); cells.cells() as usize], cells),
        };
        let mut bricks: Vec<_> = self.sources.par_iter().zip(&boxes).map(gather).collect();
        restrict(&mut bricks, Centering::Cells, &self.hierarchy, |place| matches!(self.sources[place], Source::Finer));
        bricks
    }
}

/// A copy of the bricks that tile `cells`.
fn joined<T: Voxel>(others: &[BrickValues<T>], parts: &[(usize, IndexBox)], cells: &IndexBox) -> BrickValues<T> {
    let mut values = vec![T::from_f64(f64::NAN); cells.cells() as usize];
    let size = cells.size();
    for (place, part) in parts {
        let [i, first_j, first_k]: [i64; 3] = std::array::from_fn(|axis| part.low[axis] - cells.low[axis]);
        let [row, rows, planes] = others[*place].size();
        for (j, k) in (0..planes).flat_map(|k| (0..rows).map(move |j| (j, k))) {
            let mut at = (i + size[0] * (first_j + j as i64 + size[1] * (first_k + k as i64))) as usize;
            others[*place].for_each([0, j, k], [row, j + 1, k + 1], |value| {
                values[at] = value;
                at += 1;
            });
        }
    }
    owned(values, cells)
}

fn owned<T: Voxel>(values: Vec<T>, cells: &IndexBox) -> BrickValues<T> {
    BrickValues::owned(values, cells.size().map(|cells| cells as usize)).expect("one value per cell was made")
}
