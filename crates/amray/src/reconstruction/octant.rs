//! Octant: trilinear in the eighths of leaf cells, whose corners are shared by the cells that touch them.

use super::Sampler;
use super::dual_cell::{hat, linear_weights};
use super::number::{Number, WeightedMean};
use crate::hierarchy::Voxel;
use crate::index::{Found, Planes};

impl<T: Voxel> Sampler<'_, T> {
    /// The value in the octant of the point's leaf cell.
    pub(super) fn octant<N: Number>(&self, point: [f64; 3]) -> N {
        self.index.find_leaf(self.cell_of(point)).map_or(N::constant(f64::NAN), |leaf| self.in_octant(&leaf, point))
    }

    /// Trilinear between the corners of the octant of `leaf` that holds the point: the cell's centre, the centres of
    /// three faces and three edges, and a vertex.
    fn in_octant<N: Number>(&self, leaf: &Found, point: [f64; 3]) -> N {
        let description = self.level(leaf.level);
        let size = description.finest_cells();
        let low = description.brick_at(leaf.brick).low;
        // Corners are in half cells of the finest level: [centre, outside] per axis.
        let mut corners = [[0i64; 2]; 3];
        let mut weights = [[N::constant(0.0); 2]; 3];
        for axis in 0..3 {
            let center = (2 * (low[axis] + leaf.cell[axis] as i64) + 1) * size[axis];
            let offset = (2.0 * point[axis] - center as f64) / size[axis] as f64;
            let outward = if offset < 0.0 { -size[axis] } else { size[axis] };
            corners[axis] = [center, center + outward];
            weights[axis] = linear_weights(axis, offset.abs().min(1.0), 2.0 / outward as f64);
        }
        let mut mean = WeightedMean::new();
        for corner in 0..8usize {
            let hat = hat(&weights, corner);
            if !hat.is_zero() {
                let place = std::array::from_fn(|axis| corners[axis][corner >> axis & 1]);
                mean.add(hat, self.octant_corner(place));
            }
        }
        mean.mean()
    }

    /// The value at an octant's corner (in half cells of the finest level), the same from whichever cell it is asked.
    ///
    /// The coarsest level that touches the corner decides. Where the corner is a centre, face, edge or vertex of that
    /// level's cells, it is the mean of those that touch it (their hats are equal there); elsewhere it lies on an
    /// octant's face of a coarser cell, which says what the value is, so that no crack opens.
    fn octant_corner(&self, corner: [i64; 3]) -> f64 {
        let mut coarsest: Option<Found> = None;
        self.for_each_touching(self.index.hierarchy().finest_level(), corner, |touching| {
            if coarsest.is_none_or(|found| touching.level < found.level) {
                coarsest = Some(touching);
            }
        });
        let Some(coarsest) = coarsest else { return f64::NAN };
        let size = self.level(coarsest.level).finest_cells();
        if (0..3).any(|axis| corner[axis] % size[axis] != 0) {
            return self.in_octant(&coarsest, corner.map(|half_cells| half_cells as f64 / 2.0));
        }
        let mut mean = WeightedMean::new();
        self.for_each_touching(coarsest.level, corner, |touching| {
            if touching.level == coarsest.level {
                mean.add(1.0, self.value(&touching));
            }
        });
        mean.mean()
    }

    /// Calls `visit` with the closest existing cell of each cell of `level` that touches the corner.
    fn for_each_touching(&self, level: usize, corner: [i64; 3], mut visit: impl FnMut(Found)) {
        let description = self.level(level);
        let domain = description.domain();
        let mut planes = Planes { cells: [[0; 2]; 3], active: 0 };
        for axis in 0..3 {
            let size = description.finest_cells()[axis];
            let high = corner[axis].div_euclid(2 * size);
            let on_face = corner[axis] % (2 * size) == 0;
            for (side, cell) in [high - 1, high].into_iter().enumerate() {
                let touches = (side == 1 || on_face) && domain.low[axis] <= cell && cell < domain.high[axis];
                planes.cells[axis][side] = cell;
                planes.active |= u8::from(touches) << (2 * axis + side);
            }
        }
        self.index.find_dual(level, &planes, &mut |_, found| found.into_iter().for_each(&mut visit));
    }
}
