//! Restriction: covered cells take the mean of the finer cells above them.

use rayon::prelude::*;

use super::field::{FieldValues, with_voxels};
use super::overlap::for_each_overlap;
use super::values::{BrickValues, Voxel};
use super::{Centering, Field, Hierarchy, IndexBox};

impl Field {
    /// The field with every cell that the next finer level covers holding the mean of that level's cells, finest levels
    /// first.
    ///
    /// Nodes of a node-centred field that a finer level has too take its value.
    ///
    /// Codes do not always average down what they write (Weyl4 of GRChombo is an example). Only bricks with covered
    /// cells are copied; the others keep their memory. A non-finite fine cell makes the mean non-finite.
    pub fn restricted(&self, hierarchy: &Hierarchy) -> Self {
        let values: FieldValues =
            with_voxels!(self.values(), bricks => restricted(bricks, self.centering(), hierarchy).into());
        Field::centered(self.name(), self.centering(), values, hierarchy)
            .expect("restriction keeps every brick's shape")
    }

    /// The field as if levels finer than those of `hierarchy` did not exist.
    pub fn truncated(&self, hierarchy: &Hierarchy) -> Self {
        let count = hierarchy.brick_count();
        let values: FieldValues = with_voxels!(self.values(), bricks => bricks[..count].to_vec().into());
        Field::centered(self.name(), self.centering(), values, hierarchy)
            .expect("the hierarchy is the field's own, truncated")
    }
}

fn restricted<T: Voxel>(bricks: &[BrickValues<T>], centering: Centering, hierarchy: &Hierarchy) -> Vec<BrickValues<T>> {
    let mut bricks = bricks.to_vec();
    restrict(&mut bricks, centering, hierarchy, |_| true);
    bricks
}

/// Gives covered cells (means) and nodes of the bricks at the places that `which` tells what the finer level has, in copies.
pub(super) fn restrict<T: Voxel>(
    bricks: &mut [BrickValues<T>],
    centering: Centering,
    hierarchy: &Hierarchy,
    which: impl Fn(usize) -> bool + Sync,
) {
    for level in (1..hierarchy.levels().len()).rev() {
        let fine = &hierarchy.levels()[level];
        let coarse = &hierarchy.levels()[level - 1];
        let values_of = |cells: IndexBox| centering.values_of(&cells);
        let footprint = |brick: &IndexBox| values_of(brick.coarsened(fine.ratio()));
        let footprints: Vec<IndexBox> = fine.bricks().iter().map(footprint).collect();
        let stored: Vec<IndexBox> = coarse.bricks().iter().copied().map(values_of).collect();
        let mut covers: Vec<Vec<(usize, IndexBox)>> = vec![Vec::new(); coarse.bricks().len()];
        for_each_overlap(&stored, &footprints, |number, cover, cells| {
            covers[number].push((cover, cells));
            true
        });
        let (coarser, finer) = bricks.split_at_mut(fine.first_brick());
        let coarse_bricks = coarser[coarse.first_brick()..].par_iter_mut().zip(covers).enumerate();
        coarse_bricks.for_each(|(number, (brick, covers))| {
            if covers.is_empty() || !which(coarse.first_brick() + number) {
                return;
            }
            let cells = stored[number];
            let mut values = brick.to_vec();
            for (cover, shared) in covers {
                let source = (&finer[cover], fine.bricks()[cover].low);
                match centering {
                    Centering::Cells => average_down(&mut values, &cells, source, &shared, fine.ratio()),
                    Centering::Nodes => inject(&mut values, &cells, source, &shared, fine.ratio()),
                }
            }
            *brick = BrickValues::owned(values, brick.size()).expect("a copy has the brick's shape");
        });
    }
}

/// Sets the `shared` coarse nodes of `values`, which cover `nodes`, to the fine brick's values there.
fn inject<T: Voxel>(
    values: &mut [T],
    nodes: &IndexBox,
    (fine, fine_low): (&BrickValues<T>, [i64; 3]),
    shared: &IndexBox,
    ratio: [i64; 3],
) {
    for node in shared.iter() {
        let finer = std::array::from_fn(|axis| (node[axis] * ratio[axis] - fine_low[axis]) as usize);
        values[place_in(nodes, node)] = fine.get(finer);
    }
}

/// Where the value of a cell or node lies among those of a box, x fastest.
fn place_in(places: &IndexBox, [i, j, k]: [i64; 3]) -> usize {
    let ([x, y, z], size) = (places.low, places.size());
    (i - x + size[0] * (j - y + size[1] * (k - z))) as usize
}

/// Sets the `shared` coarse cells of `values`, which cover `cells`, to the mean of the fine brick's cells.
fn average_down<T: Voxel>(
    values: &mut [T],
    cells: &IndexBox,
    (fine, fine_low): (&BrickValues<T>, [i64; 3]),
    shared: &IndexBox,
    ratio: [i64; 3],
) {
    let count = (ratio[0] * ratio[1] * ratio[2]) as f64;
    for cell in shared.iter() {
        let finer = IndexBox::new(cell, cell.map(|index| index + 1)).refined(ratio);
        let mut sum = 0.0;
        fine.for_each_in(fine_low, &finer, |value| sum += value.to_f64());
        values[place_in(cells, cell)] = T::from_f64(sum / count);
    }
}
