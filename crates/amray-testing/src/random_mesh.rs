//! Random hierarchies: which cells each level has, apart from how they are cut into bricks.

use std::collections::HashSet;

use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};

use crate::Random;

/// What kind of mesh to make.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// The most levels.
    pub levels: usize,
    /// The fewest and the most cells of level 0 per axis.
    pub base: [i64; 2],
    /// Whether level 0 may have holes.
    pub holes: bool,
    /// Whether fine cells may lie where the next coarser level has none.
    pub improper_nesting: bool,
}

impl Shape {
    /// Some seeds' meshes have holes, some are nested improperly.
    pub fn any(seed: u64) -> Self {
        Self { holes: seed.is_multiple_of(3), improper_nesting: seed.is_multiple_of(4), ..Self::default() }
    }
}

impl Default for Shape {
    fn default() -> Self {
        Self { levels: 4, base: [3, 7], holes: false, improper_nesting: false }
    }
}

/// The cells of each level of a random mesh.
#[derive(Clone, Debug)]
pub struct RandomMesh {
    origin: [f64; 3],
    levels: Vec<MeshLevel>,
}

#[derive(Clone, Debug)]
struct MeshLevel {
    ratio: [i64; 3],
    cell_size: [f64; 3],
    domain: IndexBox,
    cells: HashSet<[i64; 3]>,
}

/// Random tests stay quick with fewer cells than this on a level.
const MAX_CELLS: usize = 20_000;

impl RandomMesh {
    /// A random mesh: ratios 1 to 4 per axis, any domain corner, cells of any proportion.
    pub fn new(random: &mut Random, shape: Shape) -> Self {
        let low: [i64; 3] = std::array::from_fn(|_| random.integer(-9, 9));
        let size: [i64; 3] = std::array::from_fn(|_| random.integer(shape.base[0], shape.base[1]));
        let domain = IndexBox::new(low, std::array::from_fn(|axis| low[axis] + size[axis]));
        let mut cells: HashSet<_> = domain.iter().collect();
        if shape.holes && random.chance(0.7) {
            let hole = random_box(random, &domain, 3);
            cells.retain(|&cell| !hole.contains(cell));
        }
        if cells.is_empty() {
            cells.insert(domain.low);
        }
        let cell_size = std::array::from_fn(|_| 0.25 + random.unit());
        let mut levels = vec![MeshLevel { ratio: [1; 3], cell_size, domain, cells }];
        let count = random.integer(1, shape.levels as i64);
        while (levels.len() as i64) < count {
            let Some(finer) = finer_level(random, &levels[levels.len() - 1], shape) else { break };
            levels.push(finer);
        }
        Self { origin: std::array::from_fn(|_| random.unit() * 4.0 - 2.0), levels }
    }

    /// The mesh as a hierarchy, its levels cut into bricks at random.
    pub fn cut(&self, random: &mut Random) -> Hierarchy {
        let levels = self
            .levels
            .iter()
            .map(|level| {
                let mut bricks = Vec::new();
                cut_box(random, level, level.domain, &mut bricks);
                LevelDescription { ratio: level.ratio, cell_size: level.cell_size, domain: level.domain, bricks }
            })
            .collect();
        Hierarchy::new(self.origin, levels).expect("random meshes are valid")
    }
}

/// A box of up to `longest` cells per axis.
fn random_box(random: &mut Random, domain: &IndexBox, longest: i64) -> IndexBox {
    let low: [i64; 3] = std::array::from_fn(|axis| random.integer(domain.low[axis], domain.high[axis] - 1));
    IndexBox::new(low, std::array::from_fn(|axis| low[axis] + random.integer(1, longest))).intersection(domain)
}

fn finer_level(random: &mut Random, coarse: &MeshLevel, shape: Shape) -> Option<MeshLevel> {
    let mut ratio = [2; 3];
    if random.chance(0.5) {
        ratio = std::array::from_fn(|_| random.integer(1, 4));
    }
    if ratio == [1; 3] {
        ratio[0] = 2;
    }
    let mut parents: HashSet<[i64; 3]> = HashSet::new();
    for _ in 0..random.integer(1, 3) {
        parents.extend(random_box(random, &coarse.domain, 5).iter());
    }
    if !(shape.improper_nesting && random.chance(0.5)) {
        parents.retain(|parent| coarse.cells.contains(parent));
    }
    let children = (ratio[0] * ratio[1] * ratio[2]) as usize;
    if parents.is_empty() || parents.len() * children > MAX_CELLS {
        return None;
    }
    let cells = parents
        .iter()
        .flat_map(|&parent| IndexBox::new(parent, parent.map(|index| index + 1)).refined(ratio).iter())
        .collect();
    let cell_size = std::array::from_fn(|axis| coarse.cell_size[axis] / ratio[axis] as f64);
    Some(MeshLevel { ratio, cell_size, domain: coarse.domain.refined(ratio), cells })
}

/// Appends bricks that hold just the level's cells inside `part`.
fn cut_box(random: &mut Random, level: &MeshLevel, part: IndexBox, bricks: &mut Vec<IndexBox>) {
    // Bricks start and end on faces of coarser cells.
    let coarse = part.coarsened(level.ratio);
    let splittable: Vec<usize> = (0..3).filter(|&axis| coarse.size()[axis] > 1).collect();
    let inside = part.iter().filter(|cell| level.cells.contains(cell)).count();
    if inside == 0 {
        return;
    }
    let full = inside as u64 == part.cells();
    if splittable.is_empty() || full && random.chance(0.6) {
        bricks.push(part);
        return;
    }
    let axis = splittable[random.integer(0, splittable.len() as i64 - 1) as usize];
    let plane = random.integer(coarse.low[axis] + 1, coarse.high[axis] - 1) * level.ratio[axis];
    let (mut below, mut above) = (part, part);
    below.high[axis] = plane;
    above.low[axis] = plane;
    cut_box(random, level, below, bricks);
    cut_box(random, level, above, bricks);
}
