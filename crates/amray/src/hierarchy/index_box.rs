//! Boxes of integer cell indices: all topology is decided here, exactly.

use std::fmt;

/// A box of cells of one level: `low` is the first cell, `high` is one past the last, per axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct IndexBox {
    /// The lowest cell, inclusive.
    pub low: [i64; 3],
    /// One past the highest cell.
    pub high: [i64; 3],
}

impl IndexBox {
    /// The box from `low` (inclusive) to `high` (exclusive).
    pub const fn new(low: [i64; 3], high: [i64; 3]) -> Self {
        Self { low, high }
    }

    /// The box from its first to its last cell, as most file formats store it. `None` where `last + 1` overflows.
    pub fn from_corners(first: [i64; 3], last: [i64; 3]) -> Option<Self> {
        let [i, j, k] = last.map(|index| index.checked_add(1));
        Some(Self::new(first, [i?, j?, k?]))
    }

    /// Cells per axis; negative where `high < low`.
    pub fn size(&self) -> [i64; 3] {
        std::array::from_fn(|axis| self.high[axis] - self.low[axis])
    }

    /// The number of cells; 0 for an empty box.
    ///
    /// Saturates at `u64::MAX`; [`Hierarchy::new`](super::Hierarchy::new) refuses boxes that large.
    pub fn cells(&self) -> u64 {
        if self.is_empty() {
            return 0;
        }
        (0..3).fold(1u64, |cells, axis| cells.saturating_mul(self.low[axis].abs_diff(self.high[axis])))
    }

    /// Whether the box holds no cell.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.high[axis] <= self.low[axis])
    }

    /// Whether `cell` lies in the box.
    pub fn contains(&self, cell: [i64; 3]) -> bool {
        (0..3).all(|axis| self.low[axis] <= cell[axis] && cell[axis] < self.high[axis])
    }

    /// Whether every cell of `other` lies in the box.
    pub fn contains_box(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.low[axis] && other.high[axis] <= self.high[axis])
    }

    /// Whether the two boxes share a cell.
    pub fn intersects(&self, other: &Self) -> bool {
        !self.intersection(other).is_empty()
    }

    /// The cells that both boxes hold; may be empty.
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|axis| self.low[axis].max(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].min(other.high[axis])),
        }
    }

    /// The cell of the box that is nearest to `cell`. The box must not be empty.
    pub fn clamp(&self, cell: [i64; 3]) -> [i64; 3] {
        std::array::from_fn(|axis| cell[axis].clamp(self.low[axis], self.high[axis] - 1))
    }

    /// The same space in cells that are `ratio` times finer. `None` where an index overflows.
    pub fn checked_refined(&self, ratio: [i64; 3]) -> Option<Self> {
        let refine = |corner: [i64; 3]| {
            let [i, j, k] = std::array::from_fn(|axis| corner[axis].checked_mul(ratio[axis]));
            Some([i?, j?, k?])
        };
        Some(Self::new(refine(self.low)?, refine(self.high)?))
    }

    /// The same space in cells that are `ratio` times finer.
    pub fn refined(&self, ratio: [i64; 3]) -> Self {
        Self {
            low: std::array::from_fn(|axis| self.low[axis] * ratio[axis]),
            high: std::array::from_fn(|axis| self.high[axis] * ratio[axis]),
        }
    }

    /// The smallest box of cells `ratio` times coarser that covers this one.
    pub fn coarsened(&self, ratio: [i64; 3]) -> Self {
        Self {
            low: std::array::from_fn(|axis| self.low[axis].div_euclid(ratio[axis])),
            high: std::array::from_fn(|axis| div_ceil(self.high[axis], ratio[axis])),
        }
    }

    /// The cells, `ratio` times coarser, whose low corners lie in this box: boxes that tile a domain share out its
    /// coarser cells without counting one twice, even where they cut through them.
    pub fn cells_starting_inside(&self, ratio: [i64; 3]) -> Self {
        let first_at = |corner: [i64; 3]| std::array::from_fn(|axis| div_ceil(corner[axis], ratio[axis]));
        Self::new(first_at(self.low), first_at(self.high))
    }

    /// The box with `cells` more cells on both sides of each axis.
    pub fn grown(&self, cells: [i64; 3]) -> Self {
        Self {
            low: std::array::from_fn(|axis| self.low[axis] - cells[axis]),
            high: std::array::from_fn(|axis| self.high[axis] + cells[axis]),
        }
    }

    /// Every cell of the box, x fastest.
    pub fn iter(&self) -> impl Iterator<Item = [i64; 3]> + use<> {
        let IndexBox { low, high } = *self;
        (low[2]..high[2])
            .flat_map(move |k| (low[1]..high[1]).flat_map(move |j| (low[0]..high[0]).map(move |i| [i, j, k])))
    }
}

/// `value / divisor`, rounded up; `divisor` is positive.
fn div_ceil(value: i64, divisor: i64) -> i64 {
    value.div_euclid(divisor) + i64::from(value.rem_euclid(divisor) != 0)
}

/// First and last cell, as the codes print them: `((0,0,0) (15,15,15))`.
impl fmt::Display for IndexBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [i, j, k] = self.low;
        let [li, lj, lk] = self.high.map(|index| index.wrapping_sub(1));
        write!(f, "(({i},{j},{k}) ({li},{lj},{lk}))")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_contains() {
        let cells = IndexBox::from_corners([-2, 0, 3], [1, 0, 4]).unwrap();
        assert_eq!(cells.size(), [4, 1, 2]);
        assert_eq!(cells.cells(), 8);
        assert_eq!(cells.iter().count(), 8);
        assert!(cells.contains([-2, 0, 4]) && !cells.contains([2, 0, 4]));
        assert_eq!(cells.to_string(), "((-2,0,3) (1,0,4))");
        assert_eq!(IndexBox::new([0; 3], [2, -1, -1]).cells(), 0);
        assert_eq!(IndexBox::from_corners([0; 3], [i64::MAX, 0, 0]), None);
        assert_eq!(IndexBox::new([i64::MIN; 3], [i64::MAX; 3]).cells(), u64::MAX);
    }

    #[test]
    fn refining_and_coarsening_round_outward() {
        let fine = IndexBox::new([-3, 2, 0], [3, 4, 5]);
        assert_eq!(fine.coarsened([2, 2, 4]), IndexBox::new([-2, 1, 0], [2, 2, 2]));
        assert_eq!(fine.refined([2, 1, 3]), IndexBox::new([-6, 2, 0], [6, 4, 15]));
        assert_eq!(fine.checked_refined([i64::MAX; 3]), None);
        assert_eq!(fine.cells_starting_inside([2, 2, 4]), IndexBox::new([-1, 1, 0], [2, 2, 2]));
    }

    #[test]
    fn meets() {
        let a = IndexBox::new([0; 3], [4; 3]);
        let b = IndexBox::new([3, 3, 3], [6; 3]);
        assert_eq!(a.intersection(&b), IndexBox::new([3; 3], [4; 3]));
        assert!(a.intersects(&b) && !a.intersects(&IndexBox::new([4, 0, 0], [5; 3])));
        assert!(a.grown([2; 3]).contains_box(&b) && !a.contains_box(&b));
        assert_eq!(a.clamp([-1, 2, 9]), [0, 2, 3]);
    }
}
