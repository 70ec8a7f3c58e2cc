//! A hierarchy with its index and a field: what tests of reconstructions ask for values.

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Field, FieldValues, Hierarchy, IndexBox, LevelDescription};
use amray::index::Index;
use amray::reconstruction::{Method, Sampler};

use crate::{Random, RandomMesh, Shape};

/// A hierarchy, its index, and a field of f64 values.
pub struct Case {
    /// The mesh.
    pub hierarchy: Arc<Hierarchy>,
    /// Its index.
    pub index: Index,
    /// The values.
    pub field: Field,
}

impl Case {
    /// A case with `value(level, cell)` in each cell.
    pub fn new(hierarchy: Hierarchy, value: impl Fn(usize, [i64; 3]) -> f64) -> Self {
        let hierarchy = Arc::new(hierarchy);
        let field = Field::from_fn("value", &hierarchy, value);
        Self { index: Index::build(hierarchy.clone()), hierarchy, field }
    }

    /// [`noise`] on a random mesh, and the generator that made it.
    pub fn noisy(seed: u64, shape: Shape) -> (Self, Random) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, shape);
        (Self::new(mesh.cut(&mut random), noise), random)
    }

    /// A case with the value that `function` has at each cell's centre, a world position.
    pub fn of_centers(hierarchy: Hierarchy, function: impl Fn([f64; 3]) -> f64) -> Self {
        let centers = hierarchy.clone();
        Self::new(hierarchy, |level, cell| function(centers.to_world(level, cell.map(|index| index as f64 + 0.5))))
    }

    /// A sampler of the field.
    pub fn sampler(&self, method: Method) -> Sampler<'_, f64> {
        Sampler::new(&self.index, self.bricks(), method)
    }

    /// The value at a world position.
    pub fn sample(&self, method: Method, point: [f64; 3]) -> f64 {
        self.sampler(method).sample_world(point)
    }

    /// A point of the domain; often near a brick's face, where levels meet.
    pub fn point(&self, random: &mut Random) -> [f64; 3] {
        if random.chance(0.3) {
            return random.point(self.hierarchy.bounds());
        }
        let levels = self.hierarchy.levels();
        let level = random.integer(0, levels.len() as i64 - 1) as usize;
        let bricks = levels[level].bricks();
        let brick = bricks[random.integer(0, bricks.len() as i64 - 1) as usize];
        let grown = brick.grown([1; 3]).intersection(&levels[level].domain());
        let corners = [grown.low, grown.high].map(|corner| corner.map(|index| index as f64));
        self.hierarchy.to_world(level, random.point(corners))
    }

    /// World positions of the leaf cells' centres, with their values.
    pub fn leaf_centers(&self) -> Vec<([f64; 3], f64)> {
        let mut centers = Vec::new();
        for (place, brick) in self.hierarchy.bricks().enumerate() {
            for cell in brick.cells.iter() {
                let found = self.index.find_cell(brick.level, cell).unwrap();
                assert_eq!((found.level, found.brick), (brick.level, place));
                if !found.covered {
                    let center = self.hierarchy.to_world(brick.level, cell.map(|index| index as f64 + 0.5));
                    centers.push((center, self.field.value(place, found.cell)));
                }
            }
        }
        centers
    }

    /// The case of [`noise`] with its axes moved by `shift` and, where asked for, all of them mirrored; its low corner
    /// is the origin.
    pub fn turned(&self, mirrored: bool, shift: usize) -> Self {
        let levels = self.hierarchy.levels();
        let turn_cell = |domain: IndexBox, cell: [i64; 3]| -> [i64; 3] {
            std::array::from_fn(|axis| {
                let from = (axis + shift) % 3;
                if mirrored { domain.high[from] - 1 - cell[from] } else { cell[from] - domain.low[from] }
            })
        };
        let turn_box = |domain: IndexBox, cells: IndexBox| {
            let [a, b] = [cells.low, cells.high.map(|index| index - 1)].map(|cell| turn_cell(domain, cell));
            IndexBox::new(
                std::array::from_fn(|axis| a[axis].min(b[axis])),
                std::array::from_fn(|axis| a[axis].max(b[axis]) + 1),
            )
        };
        let descriptions = levels
            .iter()
            .map(|level| LevelDescription {
                ratio: std::array::from_fn(|axis| level.ratio()[(axis + shift) % 3]),
                cell_size: std::array::from_fn(|axis| level.cell_size()[(axis + shift) % 3]),
                domain: turn_box(level.domain(), level.domain()),
                bricks: level.bricks().iter().map(|&brick| turn_box(level.domain(), brick)).collect(),
            })
            .collect();
        let original = |level: usize, cell: [i64; 3]| -> f64 {
            let domain = levels[level].domain();
            let mut source = [0; 3];
            for axis in 0..3 {
                let from = (axis + shift) % 3;
                source[from] =
                    if mirrored { domain.high[from] - 1 - cell[axis] } else { domain.low[from] + cell[axis] };
            }
            noise(level, source)
        };
        Self::new(Hierarchy::new([0.0; 3], descriptions).unwrap(), original)
    }

    /// Where [`turned`](Self::turned) takes a world position.
    pub fn turned_point(&self, mirrored: bool, shift: usize, point: [f64; 3]) -> [f64; 3] {
        let [low, high] = self.hierarchy.bounds();
        std::array::from_fn(|axis| {
            let from = (axis + shift) % 3;
            // Mirrored at the domain's middle, in the frame where the low corner is the origin.
            if mirrored { high[from] - point[from] } else { point[from] - low[from] }
        })
    }

    fn bricks(&self) -> &[BrickValues<f64>] {
        match self.field.values() {
            FieldValues::F64(bricks) => bricks,
            FieldValues::F32(_) => unreachable!("the cases hold f64"),
        }
    }
}

/// A value that depends on nothing but the cell.
pub fn noise(level: usize, [i, j, k]: [i64; 3]) -> f64 {
    let mut random = Random(level as u64 ^ (i as u64) << 8 ^ (j as u64) << 24 ^ (k as u64) << 40);
    random.bits();
    random.unit()
}
