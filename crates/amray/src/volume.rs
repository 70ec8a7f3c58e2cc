//! A volume: one field over its index, with a reconstruction. What everything that looks at data starts from.

use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::hierarchy::{Centering, Field, Hierarchy, IndexBox, Normalisation, Voxel, with_voxels};
use crate::index::{Index, ValueRanges};
use crate::layout::{InPlacePlan, Layout, Padded, PieceNode, normalisation, padded_bytes};
use crate::reconstruction::{AnySampler, Method, PacketSampler, Sampler, ValueAndGradient, conforming};

/// Points that a thread samples at a time.
const CHUNK: usize = 1024;

/// One field over its index, with a reconstruction.
#[derive(Clone, Debug)]
pub struct Volume {
    index: Arc<Index>,
    field: Field,
    /// Made when first asked for: samples and statistics do without.
    ranges: OnceLock<ValueRanges>,
    normalisation: OnceLock<Normalisation>,
    /// Made when first rendered from.
    padded: OnceLock<Padded>,
    in_place: OnceLock<InPlacePlan>,
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
    /// The volume of `field`. A node-centred field is trilinear on the nodes of its leaf cells, whatever the `method`:
    /// [`Method::Nodal`]; its hanging nodes (on the faces of coarser leaf cells) take the coarser cells' values, in
    /// copies of their bricks.
    ///
    /// # Panics
    /// Where the field belongs to another hierarchy with a different number of bricks, or where a cell-centred one is to
    /// be nodal.
    pub fn new(index: Arc<Index>, field: Field, method: Method) -> Self {
        assert_eq!(field.brick_count(), index.hierarchy().brick_count(), "bricks of the field and of the index");
        let (field, method) = match field.centering() {
            Centering::Cells => {
                assert_eq!(method.centering(), Centering::Cells, "the reconstruction of {}", field.name());
                (field, method)
            }
            Centering::Nodes => (conforming(&index, &field), Method::Nodal),
        };
        Self {
            index,
            field,
            ranges: OnceLock::new(),
            normalisation: OnceLock::new(),
            padded: OnceLock::new(),
            in_place: OnceLock::new(),
            method,
        }
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

    /// What values the samples in each region can take. The first call looks at every value.
    pub fn ranges(&self) -> &ValueRanges {
        self.ranges.get_or_init(|| ValueRanges::build(&self.index, &self.field))
    }

    /// How values become small numbers for marching.
    pub(crate) fn normalisation(&self) -> Normalisation {
        *self.normalisation.get_or_init(|| normalisation(self))
    }

    /// How to march through the field where it is. The first call looks at every value.
    pub(crate) fn in_place(&self) -> &InPlacePlan {
        self.in_place.get_or_init(|| InPlacePlan::new(self))
    }

    /// Bytes of memory that marching needs besides the field: a padded copy, or notes on regions for values in place.
    pub fn layout_bytes(&self, layout: Layout) -> u64 {
        match layout {
            Layout::Padded => {
                self.padded.get().map_or_else(|| padded_bytes(self.hierarchy(), self.field.centering()), Padded::bytes)
            }
            Layout::InPlace => self.in_place.get().map_or(0, InPlacePlan::bytes),
        }
    }

    /// Makes what marching needs, so that the first picture does not have to.
    pub fn prepare(&self, layout: Layout) {
        match layout {
            Layout::Padded => _ = self.padded(),
            Layout::InPlace => _ = self.in_place(),
        }
    }

    /// The tree of all pieces of regions, in a layout. Trees of volumes of one index differ in values alone.
    pub(crate) fn pieces(&self, layout: Layout) -> &[PieceNode] {
        match layout {
            Layout::Padded => &self.padded().pieces,
            Layout::InPlace => &self.in_place().pieces,
        }
    }

    /// The field's padded copy. The first call copies every value.
    pub(crate) fn padded(&self) -> &Padded {
        self.padded.get_or_init(|| Padded::build(self))
    }

    /// The reconstruction.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The value at each of the world positions, in parallel; NaN outside the domain and in holes.
    pub fn sample(&self, points: &[[f64; 3]]) -> Vec<f64> {
        let mut values = vec![0.0; points.len()];
        self.sample_at(&mut values, |number| points[number]);
        values
    }

    /// Puts the value at the world position `point(i)` into place `i` of `values`, in parallel.
    pub(crate) fn sample_at(&self, values: &mut [f64], point: impl Fn(usize) -> [f64; 3] + Sync) {
        let hierarchy = self.hierarchy();
        let [low, high] = hierarchy.bounds();
        let finest = hierarchy.finest_level();
        with_voxels!(self.field.values(), bricks => {
            let normalisation = Normalisation::probe(bricks);
            let packets = PacketSampler::new(&self.index, bricks, self.method, normalisation);
            let reference = Sampler::new(&self.index, bricks, self.method);
            values.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, values)| {
                let points: Vec<[f64; 3]> = (0..values.len()).map(|place| point(chunk * CHUNK + place)).collect();
                let samples = packets.sample_points(&points, |point| hierarchy.to_cells(finest, point));
                for ((value, sample), point) in values.iter_mut().zip(samples).zip(points) {
                    // Compared in world units, so that the very corners that `bounds` reports are inside.
                    let inside = (0..3).all(|axis| (low[axis]..=high[axis]).contains(&point[axis]));
                    *value = match sample {
                        _ if !inside => f64::NAN,
                        sample if sample.is_finite() => normalisation.undo(sample),
                        // Perhaps a value far from all that the normalisation has seen.
                        _ => reference.sample_world(point),
                    };
                }
            });
        });
    }

    /// The value and the gradient at each of the world positions, in parallel: see
    /// [`Sampler::sample_world_with_gradient`].
    pub fn sample_with_gradients(&self, points: &[[f64; 3]]) -> Vec<ValueAndGradient> {
        with_voxels!(self.field.values(), bricks => {
            let sampler = Sampler::new(&self.index, bricks, self.method);
            points.par_iter().map(|&point| sampler.sample_world_with_gradient(point)).collect()
        })
    }

    /// The sampler of packets of points; its values are normalised.
    pub(crate) fn packet_sampler(&self) -> AnySampler<'_> {
        AnySampler::new(&self.index, self.field.values(), self.method, self.normalisation())
    }

    /// Folds all leaf cells, in parallel; of node-centred fields each is eight, an eighth as large, with the values of its
    /// nodes: `fold` adds a cell to a partial result that began as `start()`, and `merge`
    /// joins two of them, in the order of the regions, so that the result does not depend on the number of threads.
    pub fn fold_leaf_cells<A: Send>(
        &self,
        start: impl Fn() -> A + Sync,
        fold: impl Fn(&mut A, LeafCell) + Sync,
        merge: impl Fn(A, A) -> A,
    ) -> A {
        // Regions per partial result.
        const CHUNK: usize = 256;
        let boxes = self.index.region_boxes();
        let partial: Vec<A> = boxes
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, boxes)| {
                let mut result = start();
                for (place, cells) in boxes.iter().enumerate() {
                    self.for_each_leaf_cell(chunk * CHUNK + place, cells, &mut |cell| fold(&mut result, cell));
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
        let shown = &self.index.regions()[region];
        let Some((level, place)) = shown.finest_level().and_then(|level| self.index.finest_brick(shown, level)) else {
            return;
        };
        let description = &self.hierarchy().levels()[level];
        let volume: f64 = description.cell_size().iter().product();
        let low = description.brick_at(place).low;
        let (corners, share) = match self.field.centering() {
            Centering::Cells => (1, 1.0),
            Centering::Nodes => (8, 0.125),
        };
        with_voxels!(self.field.values(), bricks => self.index.for_each_leaf_box(region, cells, &mut |leaves| {
            for corner in 0..corners {
                let step = |index: [i64; 3]| std::array::from_fn(|axis| index[axis] + (corner >> axis & 1));
                bricks[place].for_each_in(low, &IndexBox::new(step(leaves.low), step(leaves.high)), |value| {
                    visit(LeafCell { value: value.to_f64(), level, volume: volume * share });
                });
            }
        }));
    }
}
