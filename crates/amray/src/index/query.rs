//! Which cell is at a place: one cell, or the eight corners of a dual cell in one descent.

use super::{Index, Node, Region};
use crate::hierarchy::IndexBox;

/// An actual cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// The cell's level.
    pub level: usize,
    /// The place of its brick in [`Hierarchy::bricks`](crate::hierarchy::Hierarchy::bricks).
    pub brick: usize,
    /// The cell, counted from the brick's low corner.
    pub cell: [usize; 3],
    /// Whether finer levels cover all of it.
    pub covered: bool,
}

/// Two planes of cells per axis, low and high: their eight crossings are the corners of a dual cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planes {
    /// Cell indices of one level, inside its domain.
    pub cells: [[i64; 2]; 3],
    /// Which planes to look at: bit `2 * axis + side`. A plane that carries no weight need not be visited.
    pub active: u8,
}

impl Planes {
    /// All six planes are to be looked at.
    pub const ALL: u8 = 0b11_11_11;

    const fn bit(axis: usize, side: usize) -> u8 {
        1 << (2 * axis + side)
    }

    /// The corners (x + 2 y + 4 z, 0 low and 1 high per axis) whose three planes are active.
    pub fn corners(active: u8) -> impl Iterator<Item = usize> {
        (0..8usize).filter(move |corner| (0..3).all(|axis| active & Self::bit(axis, corner >> axis & 1) != 0))
    }
}

impl Index {
    /// The region that holds a cell of the finest level. The cell must lie in the domain.
    #[inline]
    pub fn find_region(&self, cell: [i64; 3]) -> usize {
        let mut node = 0;
        loop {
            match self.nodes[node] {
                Node::Leaf(region) => return region as usize,
                Node::Inner { axis, plane, high } => {
                    node = if cell[usize::from(axis)] < plane { node + 1 } else { high as usize };
                }
            }
        }
    }

    /// The finest actual cell that contains a cell of the finest level: the paper's `findLeaf`. `None` in holes and
    /// outside the domain.
    pub fn find_leaf(&self, cell: [i64; 3]) -> Option<Found> {
        self.domain.contains(cell).then(|| self.found(self.find_region(cell), cell, usize::MAX))?
    }

    /// The closest existing cell of `cell`, a logical cell of `level`: itself where it is actual, else the finest
    /// coarser one that contains it, else none. The paper's `findCell`.
    pub fn find_cell(&self, level: usize, cell: [i64; 3]) -> Option<Found> {
        let center = self.center(level, cell);
        self.domain.contains(center).then(|| self.found(self.find_region(center), center, level))?
    }

    /// Calls `visit` with every active corner of a dual cell of `level` and its closest existing cell: the paper's
    /// `findDual`. All corners go down the tree together, as long as the six planes stay on one side of each cut.
    #[inline]
    pub fn find_dual(&self, level: usize, planes: &Planes, visit: &mut impl FnMut(usize, Option<Found>)) {
        let centers = std::array::from_fn(|axis| {
            planes.cells[axis].map(|cell| {
                let size = self.hierarchy.levels()[level].finest_cells()[axis];
                cell * size + size / 2
            })
        });
        self.dual_below(0, level, &centers, planes.active, visit);
    }

    fn dual_below(
        &self,
        mut node: usize,
        level: usize,
        centers: &[[i64; 2]; 3],
        mut active: u8,
        visit: &mut impl FnMut(usize, Option<Found>),
    ) {
        loop {
            match self.nodes[node] {
                Node::Leaf(region) => {
                    for corner in Planes::corners(active) {
                        let center = std::array::from_fn(|axis| centers[axis][corner >> axis & 1]);
                        visit(corner, self.found(region as usize, center, level));
                    }
                    return;
                }
                Node::Inner { axis, plane, high } => {
                    let axis = usize::from(axis);
                    let (low_plane, high_plane) = (Planes::bit(axis, 0), Planes::bit(axis, 1));
                    let below = (u8::from(centers[axis][0] < plane) * low_plane)
                        | (u8::from(centers[axis][1] < plane) * high_plane);
                    let of_axis = active & (low_plane | high_plane);
                    let others = active & !(low_plane | high_plane);
                    let (low, rest) = (of_axis & below, of_axis & !below);
                    if low != 0 && rest != 0 {
                        self.dual_below(node + 1, level, centers, others | low, visit);
                    }
                    // The last side is gone down without recursion.
                    if rest != 0 {
                        node = high as usize;
                        active = others | rest;
                    } else {
                        node += 1;
                    }
                }
            }
        }
    }

    /// The cell of `region`, of `level` or coarser, that contains `cell` (of the finest level).
    #[inline]
    fn found(&self, region: usize, cell: [i64; 3], level: usize) -> Option<Found> {
        let region: &Region = &self.regions[region];
        let finest = region.finest_level()?;
        let (found, brick) = self.finest_brick(region, level.min(finest))?;
        let description = &self.hierarchy.levels()[found];
        let low = description.brick_at(brick).low;
        let size = description.finest_cells();
        let logical: [i64; 3] = std::array::from_fn(|axis| cell[axis].div_euclid(size[axis]));
        let mut covered = found < finest;
        if covered && self.may_cover_partly {
            covered = self.is_wholly_covered(found, logical);
        }
        let cell = std::array::from_fn(|axis| (logical[axis] - low[axis]) as usize);
        Some(Found { level: found, brick, cell, covered })
    }

    fn is_wholly_covered(&self, level: usize, cell: [i64; 3]) -> bool {
        let cells =
            IndexBox::new(cell, cell.map(|index| index + 1)).refined(self.hierarchy.levels()[level].finest_cells());
        let mut covered = true;
        self.for_each_region_in(&cells, &mut |region, _| covered &= self.regions[region].finest_level() > Some(level));
        covered
    }

    /// The cell of the finest level at, or just above, the centre of a cell.
    fn center(&self, level: usize, cell: [i64; 3]) -> [i64; 3] {
        let size = self.hierarchy.levels()[level].finest_cells();
        std::array::from_fn(|axis| cell[axis].saturating_mul(size[axis]).saturating_add(size[axis] / 2))
    }
}
