//! Every reconstruction written down as its definition reads, with a search through all bricks for every cell.

use std::cell::Cell;

use amray::hierarchy::{Field, Hierarchy, IndexBox};
use amray::reconstruction::Method;

/// The corners of a dual cell or of an octant: 0 low and 1 high per axis.
const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]];

/// World positions round: a hat this small belongs to a cell that only touches the point.
const ROUNDING: f64 = 1e-12;

/// A hierarchy and a field without any index.
pub struct BruteForce<'a> {
    hierarchy: &'a Hierarchy,
    field: &'a Field,
    /// Where the last cell of each level was found: neighbouring look-ups mostly end in the same brick.
    recent: Vec<Cell<usize>>,
}

impl<'a> BruteForce<'a> {
    /// A brute-force evaluation of `field`.
    pub fn new(hierarchy: &'a Hierarchy, field: &'a Field) -> Self {
        let recent = hierarchy.levels().iter().map(|_| Cell::new(0)).collect();
        Self { hierarchy, field, recent }
    }

    /// The value at a world position inside the domain.
    pub fn sample(&self, method: Method, point: [f64; 3]) -> f64 {
        let Some((level, cell)) = self.leaf(point) else { return f64::NAN };
        let finest = self.finest();
        match method {
            Method::Nearest => self.actual(level, cell).unwrap(),
            Method::Finest => self.lerp(finest, point).0,
            Method::Current => self.lerp(level, point).0,
            Method::Blend => self.blend(point),
            Method::Basis => self.basis(point),
            Method::Octant => self.octant(level, cell, self.hierarchy.to_cells(finest, point)),
            Method::Prolong => self.prolong(finest as i64, point).unwrap(),
            Method::Nodal => self.nodal(level, cell, self.hierarchy.to_cells(finest, point)),
        }
    }

    fn finest(&self) -> usize {
        self.hierarchy.finest_level()
    }

    /// The stored value of a cell.
    fn actual(&self, level: usize, cell: [i64; 3]) -> Option<f64> {
        let description = &self.hierarchy.levels()[level];
        let holds =
            |brick: &IndexBox| (0..3).all(|axis| brick.low[axis] <= cell[axis] && cell[axis] < brick.high[axis]);
        let bricks = description.bricks();
        let recent = self.recent[level].get();
        let number = if bricks.get(recent).is_some_and(holds) { recent } else { bricks.iter().position(holds)? };
        self.recent[level].set(number);
        let inside = std::array::from_fn(|axis| (cell[axis] - bricks[number].low[axis]) as usize);
        Some(self.field.value(description.first_brick() + number, inside))
    }

    /// The cell of `coarser` that holds a cell of `level`.
    fn parent(&self, level: usize, cell: [i64; 3], coarser: usize) -> [i64; 3] {
        (coarser + 1..=level).rev().fold(cell, |cell, level| {
            let ratio = self.hierarchy.levels()[level].ratio();
            std::array::from_fn(|axis| cell[axis].div_euclid(ratio[axis]))
        })
    }

    /// The closest existing cell: its level and value.
    fn closest(&self, level: usize, cell: [i64; 3]) -> Option<(usize, f64)> {
        (0..=level)
            .rev()
            .find_map(|coarser| self.actual(coarser, self.parent(level, cell, coarser)).map(|value| (coarser, value)))
    }

    /// Whether finer levels cover all of the cell: each of its finest-level cells is asked.
    fn covered(&self, level: usize, cell: [i64; 3]) -> bool {
        let size = self.hierarchy.levels()[level].finest_cells();
        let parts = IndexBox::new(cell, cell.map(|index| index + 1)).refined(size);
        level < self.finest()
            && parts.iter().all(|part| self.closest(self.finest(), part).is_some_and(|(found, _)| found > level))
    }

    /// The leaf cell that contains the point.
    fn leaf(&self, point: [f64; 3]) -> Option<(usize, [i64; 3])> {
        (0..=self.finest()).rev().find_map(|level| {
            let domain = self.hierarchy.levels()[level].domain();
            let position = self.hierarchy.to_cells(level, point);
            let cell: [i64; 3] = std::array::from_fn(|axis| {
                (position[axis].floor() as i64).clamp(domain.low[axis], domain.high[axis] - 1)
            });
            self.actual(level, cell).map(|_| (level, cell))
        })
    }

    /// The corners of the dual cell of `level`: hat, logical cell moved into the domain, whether it was moved.
    fn dual(&self, level: usize, point: [f64; 3]) -> Vec<(f64, [i64; 3], bool)> {
        let domain = self.hierarchy.levels()[level].domain();
        let position = self.hierarchy.to_cells(level, point).map(|position| position - 0.5);
        let corner = |sides: [usize; 3]| {
            let cell: [i64; 3] = std::array::from_fn(|axis| position[axis].floor() as i64 + sides[axis] as i64);
            let hat = (0..3).map(|axis| 1.0 - (position[axis] - cell[axis] as f64).abs()).product();
            let moved: [i64; 3] = std::array::from_fn(|axis| cell[axis].clamp(domain.low[axis], domain.high[axis] - 1));
            (hat, moved, moved != cell)
        };
        CORNERS.into_iter().map(corner).filter(|(hat, ..)| *hat > ROUNDING).collect()
    }

    /// The trilinear value of `level` and the share of actual corners.
    fn lerp(&self, level: usize, point: [f64; 3]) -> (f64, f64) {
        let (mut sum, mut weight, mut actual) = (0.0, 0.0, 0.0);
        for (hat, cell, _) in self.dual(level, point) {
            if let Some((found, value)) = self.closest(level, cell) {
                sum += hat * value;
                weight += hat;
                actual += if found == level { hat } else { 0.0 };
            }
        }
        (sum / weight, actual)
    }

    fn blend(&self, point: [f64; 3]) -> f64 {
        let mut f = None;
        for level in 0..=self.finest() {
            let (value, actual) = self.lerp(level, point);
            if actual > 0.0 {
                f = Some(f.map_or(value, |f| actual * value + (1.0 - actual) * f));
            }
        }
        f.unwrap()
    }

    fn basis(&self, point: [f64; 3]) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for level in 0..=self.finest() {
            for (hat, cell, moved) in self.dual(level, point) {
                if let (false, false, Some(value)) = (moved, self.covered(level, cell), self.actual(level, cell)) {
                    sum += hat * value;
                    weight += hat;
                }
            }
        }
        sum / weight
    }

    fn prolong(&self, level: i64, point: [f64; 3]) -> Option<f64> {
        let number = usize::try_from(level).ok()?;
        let coarser = self.prolong(level - 1, point);
        let (mut sum, mut weight, mut actual) = (0.0, 0.0, 0.0);
        for (hat, cell, _) in self.dual(number, point) {
            let value = self.actual(number, cell);
            if value.is_some() {
                actual += hat;
            }
            let center = self.hierarchy.to_world(number, cell.map(|index| index as f64 + 0.5));
            if let Some(value) = value.or_else(|| self.prolong(level - 1, center)) {
                sum += hat * value;
                weight += hat;
            }
        }
        if actual == 0.0 {
            return coarser;
        }
        let own = sum / weight;
        Some(coarser.map_or(own, |coarser| actual * own + (1.0 - actual) * coarser))
    }

    /// The value in the octant of a leaf cell; `point` is in cells of the finest level.
    fn octant(&self, level: usize, cell: [i64; 3], point: [f64; 3]) -> f64 {
        let size = self.hierarchy.levels()[level].finest_cells();
        let center: [f64; 3] = std::array::from_fn(|axis| (cell[axis] as f64 + 0.5) * size[axis] as f64);
        let face: [f64; 3] = std::array::from_fn(|axis| {
            let half = 0.5 * size[axis] as f64;
            if point[axis] < center[axis] { center[axis] - half } else { center[axis] + half }
        });
        let share: [f64; 3] =
            std::array::from_fn(|axis| ((point[axis] - center[axis]) / (face[axis] - center[axis])).clamp(0.0, 1.0));
        CORNERS
            .into_iter()
            .map(|sides| {
                let hat: f64 =
                    (0..3).map(|axis| if sides[axis] == 1 { share[axis] } else { 1.0 - share[axis] }).product();
                let corner = std::array::from_fn(|axis| if sides[axis] == 1 { face[axis] } else { center[axis] });
                if hat > 0.0 { hat * self.octant_corner(corner) } else { 0.0 }
            })
            .sum()
    }

    fn octant_corner(&self, corner: [f64; 3]) -> f64 {
        let coarsest = self.touching(self.finest(), corner).into_iter().min().unwrap();
        let (level, cell) = (coarsest.0, self.parent(self.finest(), coarsest.1, coarsest.0));
        let size = self.hierarchy.levels()[level].finest_cells();
        let on_half_lattice = (0..3).all(|axis| (2.0 * corner[axis] / size[axis] as f64).fract() == 0.0);
        if !on_half_lattice {
            return self.octant(level, cell, corner);
        }
        // The dual cell around the corner has the hats; only cells that touch the corner are not 0 there.
        let world = self.hierarchy.to_world(self.finest(), corner);
        let (mut sum, mut weight) = (0.0, 0.0);
        for (hat, cell, moved) in self.dual(level, world) {
            // World positions round: what touches has a hat of 1/8 at the least.
            if let (true, false, Some(value)) = (hat > 0.1, moved, self.actual(level, cell)) {
                sum += hat * value;
                weight += hat;
            }
        }
        sum / weight
    }

    /// The value in a leaf cell of nodes; `point` is in cells of the finest level.
    fn nodal(&self, level: usize, cell: [i64; 3], point: [f64; 3]) -> f64 {
        let size = self.hierarchy.levels()[level].finest_cells();
        CORNERS
            .into_iter()
            .map(|sides| {
                let node: [i64; 3] = std::array::from_fn(|axis| cell[axis] + sides[axis] as i64);
                let distance = |axis: usize| (point[axis] / size[axis] as f64 - node[axis] as f64).abs();
                let hat: f64 = (0..3).map(|axis| 1.0 - distance(axis)).product();
                if hat > 0.0 { hat * self.node(level, node) } else { 0.0 }
            })
            .sum()
    }

    /// A node's value: that of the coarsest leaf cell that touches it, where it is coarser, else the stored one.
    fn node(&self, level: usize, node: [i64; 3]) -> f64 {
        let description = &self.hierarchy.levels()[level];
        let size = description.finest_cells();
        let place = std::array::from_fn(|axis| (node[axis] * size[axis]) as f64);
        let (coarsest, cell) = self.touching(self.finest(), place).into_iter().min().unwrap();
        if coarsest < level {
            return self.nodal(coarsest, self.parent(self.finest(), cell, coarsest), place);
        }
        let holds = |brick: &IndexBox| (0..3).all(|axis| (brick.low[axis]..=brick.high[axis]).contains(&node[axis]));
        let number = description.bricks().iter().position(holds).unwrap();
        let low = description.bricks()[number].low;
        let inside = std::array::from_fn(|axis| (node[axis] - low[axis]) as usize);
        self.field.value(description.first_brick() + number, inside)
    }

    /// The leaf level, and the finest-level cell, on each side of a point given in cells of the finest level.
    fn touching(&self, finest: usize, point: [f64; 3]) -> Vec<(usize, [i64; 3])> {
        let domain = self.hierarchy.levels()[finest].domain();
        CORNERS
            .into_iter()
            .map(|sides| {
                std::array::from_fn(|axis| {
                    let below = if sides[axis] == 1 { 0 } else { i64::from(point[axis].fract() == 0.0) };
                    point[axis].floor() as i64 - below
                })
            })
            .filter(|&cell| domain.contains(cell))
            .filter_map(|cell| self.closest(finest, cell).map(|(level, _)| (level, cell)))
            .collect()
    }
}
