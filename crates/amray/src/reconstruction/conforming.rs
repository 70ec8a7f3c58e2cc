//! Hanging nodes: fine nodes on the face of a coarser leaf cell take what that cell has there, so that node-centred
//! fields are continuous across levels.

use rayon::prelude::*;

use crate::hierarchy::{Brick, BrickValues, Centering, Field, FieldValues, Voxel, with_voxels};
use crate::index::{Found, Index};

use super::dual_cell::linear_weights;
use super::nodal::of_nodes;

/// A node-centred field with the values of hanging nodes changed. Only bricks with such nodes are copied.
pub(crate) fn conforming(index: &Index, field: &Field) -> Field {
    let values: FieldValues = with_voxels!(field.values(), bricks => conforming_bricks(index, bricks).into());
    Field::centered(field.name(), Centering::Nodes, values, index.hierarchy()).expect("every brick keeps its shape")
}

fn conforming_bricks<T: Voxel>(index: &Index, bricks: &[BrickValues<T>]) -> Vec<BrickValues<T>> {
    let mut bricks = bricks.to_vec();
    let all: Vec<Brick> = index.hierarchy().bricks().collect();
    // Coarse levels first: hanging nodes of the next finer one lie between theirs.
    for level in index.hierarchy().levels() {
        let own = level.first_brick()..level.first_brick() + level.bricks().len();
        let (known, changing) = bricks.split_at_mut(own.start);
        changing[..own.len()].par_iter_mut().zip(&all[own]).for_each(|(values, brick)| {
            let hanging = Hanging { index, coarser: known, brick };
            if hanging.may_exist() {
                hanging.change(values);
            }
        });
    }
    bricks
}

/// Looks for the hanging nodes of a brick.
struct Hanging<'a, T> {
    index: &'a Index,
    /// The bricks of all coarser levels.
    coarser: &'a [BrickValues<T>],
    brick: &'a Brick,
}

impl<T: Voxel> Hanging<'_, T> {
    /// Whether there are coarser leaf cells beside the brick.
    fn may_exist(&self) -> bool {
        let around = self.brick.cells.refined(self.size()).grown([1; 3]).intersection(&self.index.domain());
        let mut found = false;
        self.index.for_each_region_in(&around, &mut |region, _| {
            found |= self.index.regions()[region].finest_level().is_some_and(|level| level < self.brick.level);
        });
        found
    }

    fn change(&self, values: &mut BrickValues<T>) {
        let nodes = Centering::Nodes.values_of(&self.brick.cells);
        let mut changed = values.to_vec();
        for (value, node) in changed.iter_mut().zip(nodes.iter()) {
            let on_face = (0..3).any(|axis| node[axis] == nodes.low[axis] || node[axis] == nodes.high[axis] - 1);
            if on_face && let Some(hung) = self.value_of_coarser(node) {
                *value = T::from_f64(hung);
            }
        }
        *values = BrickValues::owned(changed, values.size()).expect("a copy has the brick's shape");
    }

    /// What the coarsest leaf cell that touches a node has there, where it is coarser than the brick.
    fn value_of_coarser(&self, node: [i64; 3]) -> Option<f64> {
        let size = self.size();
        let place: [i64; 3] = std::array::from_fn(|axis| node[axis] * size[axis]);
        let touching = (0..8).filter_map(|side| {
            self.index.find_leaf(std::array::from_fn(|axis| place[axis] - i64::from(side >> axis & 1 == 1)))
        });
        let coarsest = touching.min_by_key(|leaf| leaf.level)?;
        (coarsest.level < self.brick.level).then(|| self.at(&coarsest, place))
    }

    /// Trilinear interpolation of a cell's nodes at a place in cells of the finest level, which the cell touches.
    fn at(&self, leaf: &Found, place: [i64; 3]) -> f64 {
        let level = &self.index.hierarchy().levels()[leaf.level];
        let (size, low) = (level.finest_cells(), level.brick_at(leaf.brick).low);
        let weights = std::array::from_fn(|axis| {
            let cell = low[axis] + leaf.cell[axis] as i64;
            linear_weights(axis, (place[axis] - cell * size[axis]) as f64 / size[axis] as f64, 0.0)
        });
        of_nodes(self.coarser[leaf.brick].corners(leaf.cell), &weights)
    }

    /// Cells of the finest level per cell of the brick.
    fn size(&self) -> [i64; 3] {
        self.index.hierarchy().levels()[self.brick.level].finest_cells()
    }
}
