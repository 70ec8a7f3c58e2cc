//! Brick faces by number: building the tree compares small integers and counts in tables, however deep the levels are.

use rayon::prelude::*;

use crate::hierarchy::{Hierarchy, IndexBox};

/// The places at which bricks start or end, per axis, in cells of the finest level and in order.
pub(super) struct Faces([Vec<i64>; 3]);

/// A box from face to face, by the faces' numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FaceBox {
    pub(super) low: [u32; 3],
    pub(super) high: [u32; 3],
}

impl Faces {
    /// The faces of all bricks, and the domain's own.
    pub(super) fn new(hierarchy: &Hierarchy, domain: &IndexBox) -> Self {
        let mut axes = [const { Vec::new() }; 3];
        axes.par_iter_mut().enumerate().for_each(|(axis, faces)| {
            faces.extend([domain.low[axis], domain.high[axis]]);
            for level in hierarchy.levels() {
                let size = level.finest_cells()[axis];
                // Neighbours in the list often share a face: fewer to sort.
                for brick in level.bricks() {
                    let (low, high) = (brick.low[axis] * size, brick.high[axis] * size);
                    if faces[faces.len() - 2..] != [low, high] {
                        faces.extend([low, high]);
                    }
                }
            }
            faces.sort_unstable();
            faces.dedup();
        });
        Self(axes)
    }

    /// Where a face is, in cells of the finest level.
    #[inline]
    pub(super) fn place(&self, axis: usize, face: u32) -> i64 {
        self.0[axis][face as usize]
    }

    /// The numbers of the faces of `cells` (of the finest level), which must be among the faces.
    pub(super) fn numbered(&self, cells: &IndexBox) -> FaceBox {
        let number = |corner: [i64; 3]| {
            std::array::from_fn(|axis| self.0[axis].partition_point(|&face| face < corner[axis]) as u32)
        };
        FaceBox { low: number(cells.low), high: number(cells.high) }
    }

    /// The cells of the finest level in a box.
    pub(super) fn cells(&self, faces: &FaceBox) -> IndexBox {
        IndexBox {
            low: std::array::from_fn(|axis| self.place(axis, faces.low[axis])),
            high: std::array::from_fn(|axis| self.place(axis, faces.high[axis])),
        }
    }
}
