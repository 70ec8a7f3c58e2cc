//! How far the values of each region bend: by how much a long step along a ray can miss them.

use rayon::prelude::*;

use super::PaddedField;
use super::plan::{Plan, RegionPlan};
use crate::hierarchy::IndexBox;
use crate::index::Index;
use crate::simd::{Gather, InstructionSet, Kernel};

/// Per region, the largest sum of its leaf cells' second differences across the three axes, in units of the field's
/// range.
pub(super) fn roughness(index: &Index, plan: &Plan, field: &PaddedField) -> Vec<f32> {
    let instructions = InstructionSet::best();
    let regions = index.region_boxes().into_par_iter().zip(&plan.regions);
    regions.map(|(cells, plan)| instructions.run(Roughness { index, field, plan, cells })).collect()
}

struct Roughness<'a> {
    index: &'a Index,
    field: &'a PaddedField,
    plan: &'a RegionPlan,
    /// The region, in cells of the finest level.
    cells: IndexBox,
}

impl Kernel for Roughness<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Gather>(self, _: S) -> f32 {
        let Self { index, field, plan, cells } = self;
        let Some(level) = plan.level else { return 0.0 };
        let size = index.hierarchy().levels()[usize::from(level)].finest_cells();
        let touched = cells.coarsened(size);
        // From the level's cells to places in the padded brick: where padded coordinates are 0, there is a centre.
        let place = |cell: i64, axis: usize| (cell as f64 + 0.5 - plan.low[axis]) as usize;
        let [row, slice] = plan.brick.strides.map(|stride| stride as usize);
        let values = field.brick(&plan.brick);
        let length = touched.size()[0] as usize;
        let mut most = 0.0f32;
        for z in touched.low[2]..touched.high[2] {
            for y in touched.low[1]..touched.high[1] {
                let start = place(touched.low[0], 0) + row * place(y, 1) + slice * place(z, 2);
                let line = |start: usize| &values[start..start + length];
                let (own, left, right) = (line(start), line(start - 1), line(start + 1));
                let (front, back) = (line(start - row), line(start + row));
                let (below, above) = (line(start - slice), line(start + slice));
                for x in 0..length {
                    let twice = 2.0 * own[x];
                    let bend = (left[x] + right[x] - twice).abs()
                        + (front[x] + back[x] - twice).abs()
                        + (below[x] + above[x] - twice).abs();
                    most = if bend > most { bend } else { most };
                }
            }
        }
        most
    }
}
