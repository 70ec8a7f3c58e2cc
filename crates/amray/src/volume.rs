//! A volume: one field over its index, with a reconstruction. What everything that looks at data starts from.

use std::sync::Arc;

use rayon::prelude::*;

use crate::hierarchy::{Field, Hierarchy, IndexBox, with_voxels};
use crate::index::{Index, ValueRanges};
use crate::reconstruction::{Method, Sampler};

/// One field over its index, with a reconstruction.
#[derive(Clone, Debug)]
pub struct Volume {
    index: Arc<Index>,
    field: Field,
    ranges: ValueRanges,
    method: Method,
}

/// A leaf cell: a cell that no finer level covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafCell {
    /// The cell's value; may be non-finite.
    pub value: f64,
    /// The cell's level.
    pub level: usize,
    /// The cell's volume in world units.
    pub volume: f64,
}

impl Volume {
    /// The volume of `field`, which must belong to the index's hierarchy.
    pub fn new(index: Arc<Index>, field: Field, method: Method) -> Self {
        let ranges = ValueRanges::build(&index, &field);
        Self { index, field, ranges, method }
    }

    /// The spatial index.
    pub fn index(&self) -> &Arc<Index> {
        &self.index
    }

    /// The mesh.
    pub fn hierarchy(&self) -> &Arc<Hierarchy> {
        self.index.hierarchy()
    }

    /// The field.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// What values the samples in each region can take.
    pub fn ranges(&self) -> &ValueRanges {
        &self.ranges
    }

    /// The reconstruction.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The value at each of the world positions, in parallel; NaN outside the domain and in holes.
    pub fn sample(&self, points: &[[f64; 3]]) -> Vec<f64> {
        with_voxels!(self.field.values(), bricks => {
            let sampler = Sampler::new(&self.index, bricks, self.method);
            points.par_iter().map(|&point| sampler.sample_world(point)).collect()
        })
    }

    /// Folds all leaf cells, in parallel: `fold` adds a cell to a partial result that began as `start()`, and `merge`
    /// joins two of them, in the order of the regions, so that the result does not depend on the number of threads.
    pub fn fold_leaf_cells<A: Send>(
        &self,
        start: impl Fn() -> A + Sync,
        fold: impl Fn(&mut A, LeafCell) + Sync,
        merge: impl Fn(A, A) -> A,
    ) -> A {
        // Regions per partial result.
        const CHUNK: usize = 256;
        let mut regions = Vec::with_capacity(self.index.regions().len());
        self.index.for_each_region(&mut |region, cells| regions.push((region, cells)));
        let partial: Vec<A> = regions
            .par_chunks(CHUNK)
            .map(|regions| {
                let mut result = start();
                for (region, cells) in regions {
                    self.for_each_leaf_cell(*region, cells, &mut |cell| fold(&mut result, cell));
                }
                result
            })
            .collect();
        partial.into_iter().fold(start(), merge)
    }

    /// Lowest and highest finite value over the leaf cells; `None` where there is no finite value.
    pub fn leaf_range(&self) -> Option<[f64; 2]> {
        let range = self.fold_leaf_cells(
            || [f64::INFINITY, f64::NEG_INFINITY],
            |range, cell| {
                if cell.value.is_finite() {
                    *range = [range[0].min(cell.value), range[1].max(cell.value)];
                }
            },
            |a, b| [a[0].min(b[0]), a[1].max(b[1])],
        );
        (range[0] <= range[1]).then_some(range)
    }

    fn for_each_leaf_cell(&self, region: usize, cells: &IndexBox, visit: &mut impl FnMut(LeafCell)) {
        let region = &self.index.regions()[region];
        let Some(level) = region.finest_level() else { return };
        let description = &self.hierarchy().levels()[level];
        let volume = description.cell_size().iter().product();
        let Some((_, place)) = self.index.finest_brick(region, level) else { return };
        let low = description.bricks()[place - description.first_brick()].low;
        let owned = cells.cells_starting_inside(description.finest_cells());
        let inside = |corner: [i64; 3]| std::array::from_fn(|axis| (corner[axis] - low[axis]) as usize);
        with_voxels!(self.field.values(), bricks => {
            bricks[place].for_each(inside(owned.low), inside(owned.high), |value| {
                visit(LeafCell { value: crate::hierarchy::Voxel::to_f64(value), level, volume });
            });
        });
    }
}
