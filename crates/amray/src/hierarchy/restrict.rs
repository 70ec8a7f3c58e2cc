//! Restriction: covered cells take the mean of the finer cells above them.

use rayon::prelude::*;

use super::field::{FieldValues, with_voxels};
use super::overlap::for_each_overlap;
use super::values::{BrickValues, Voxel};
use super::{Field, Hierarchy, IndexBox};

impl Field {
    /// The field with every cell that the next finer level covers holding the mean of that level's cells, finest levels
    /// first.
    ///
    /// Codes do not always average down what they write (Weyl4 of GRChombo is an example). Only bricks with covered
    /// cells are copied; the others keep their memory. A non-finite fine cell makes the mean non-finite.
    pub fn restricted(&self, hierarchy: &Hierarchy) -> Self {
        let values: FieldValues = with_voxels!(self.values(), bricks => restricted(bricks, hierarchy).into());
        Field::new(self.name(), values, hierarchy).expect("restriction keeps every brick's shape")
    }

    /// The field as if levels finer than those of `hierarchy` did not exist.
    pub fn truncated(&self, hierarchy: &Hierarchy) -> Self {
        let count = hierarchy.brick_count();
        let values: FieldValues = with_voxels!(self.values(), bricks => bricks[..count].to_vec().into());
        Field::new(self.name(), values, hierarchy).expect("the hierarchy is the field's own, truncated")
    }
}

fn restricted<T: Voxel>(bricks: &[BrickValues<T>], hierarchy: &Hierarchy) -> Vec<BrickValues<T>> {
    let mut bricks = bricks.to_vec();
    restrict(&mut bricks, hierarchy, |_| true);
    bricks
}

/// Sets covered cells of the bricks at the places that `which` tells to means of the finer cells, in copies.
pub(super) fn restrict<T: Voxel>(
    bricks: &mut [BrickValues<T>],
    hierarchy: &Hierarchy,
    which: impl Fn(usize) -> bool + Sync,
) {
    for level in (1..hierarchy.levels().len()).rev() {
        let fine = &hierarchy.levels()[level];
        let coarse = &hierarchy.levels()[level - 1];
        let footprints: Vec<IndexBox> = fine.bricks().iter().map(|brick| brick.coarsened(fine.ratio())).collect();
        let mut covers: Vec<Vec<(usize, IndexBox)>> = vec![Vec::new(); coarse.bricks().len()];
        for_each_overlap(coarse.bricks(), &footprints, |number, cover, cells| {
            covers[number].push((cover, cells));
            true
        });
        let (coarser, finer) = bricks.split_at_mut(fine.first_brick());
        let coarse_bricks = coarser[coarse.first_brick()..].par_iter_mut().zip(covers).enumerate();
        coarse_bricks.for_each(|(number, (brick, covers))| {
            if covers.is_empty() || !which(coarse.first_brick() + number) {
                return;
            }
            let cells = coarse.bricks()[number];
            let mut values = Vec::with_capacity(cells.cells() as usize);
            brick.for_each([0; 3], brick.size(), |value| values.push(value));
            for (cover, shared) in covers {
                let source = (&finer[cover], fine.bricks()[cover].low);
                average_down(&mut values, &cells, source, &shared, fine.ratio());
            }
            *brick = BrickValues::owned(values, brick.size()).expect("a copy has the brick's shape");
        });
    }
}

/// Sets the `shared` coarse cells of `values`, which cover `cells`, to the mean of the fine brick's cells.
fn average_down<T: Voxel>(
    values: &mut [T],
    cells: &IndexBox,
    (fine, fine_low): (&BrickValues<T>, [i64; 3]),
    shared: &IndexBox,
    ratio: [i64; 3],
) {
    let size = cells.size();
    let count = (ratio[0] * ratio[1] * ratio[2]) as f64;
    for cell in shared.iter() {
        let finer = IndexBox::new(cell, cell.map(|index| index + 1)).refined(ratio);
        let mut sum = 0.0;
        fine.for_each_in(fine_low, &finer, |value| sum += value.to_f64());
        let [i, j, k]: [i64; 3] = std::array::from_fn(|axis| cell[axis] - cells.low[axis]);
        values[(i + size[0] * (j + size[1] * k)) as usize] = T::from_f64(sum / count);
    }
}
