//! Nodal: values at nodes, trilinear inside each leaf cell. What node-centred fields have.

use super::Sampler;
use super::dual_cell::{hat, linear_weights};
use super::number::{Number, WeightedMean};
use crate::hierarchy::Voxel;
use crate::index::Region;

impl<T: Voxel> Sampler<'_, T> {
    /// The hat-weighted mean of the eight nodes of the cell of `level`, the region's finest, that holds the point. On a
    /// face between cells that is the one on the high side, but on the high faces of the brick.
    pub(super) fn nodal<N: Number>(&self, region: &Region, level: usize, point: [f64; 3]) -> N {
        let Some((_, place)) = self.index.finest_brick(region, level) else { return N::constant(f64::NAN) };
        let description = self.level(level);
        let low = description.brick_at(place).low;
        let brick = &self.bricks[place];
        let mut base = [0; 3];
        let mut weights = [[N::constant(0.0); 2]; 3];
        for axis in 0..3 {
            let size = description.finest_cells()[axis] as f64;
            let position = point[axis] / size - low[axis] as f64;
            base[axis] = (position as usize).min(brick.size()[axis] - 2);
            weights[axis] = linear_weights(axis, position - base[axis] as f64, 1.0 / size);
        }
        of_nodes(brick.corners(base), &weights)
    }
}

/// The mean of a cell's eight nodes, x fastest, by the weights of the low and high ones per axis. A node of no weight
/// does not take part, not even one that is not a number.
pub(super) fn of_nodes<T: Voxel, N: Number>(nodes: [T; 8], weights: &[[N; 2]; 3]) -> N {
    let mut mean = WeightedMean::new();
    for (corner, value) in nodes.into_iter().enumerate() {
        let hat: N = hat(weights, corner);
        if !hat.is_zero() {
            mean.add(hat, value.to_f64());
        }
    }
    mean.mean()
}
