//! Where the blocks of a FLASH file lie.

use amray::hierarchy::IndexBox;

use super::scalars::Numbers;
use crate::FormatError;
use crate::hdf5::{Hdf5Group, Hdf5Set};
use crate::refined::Root;

/// `node type` of a leaf.
const LEAF: i64 = 1;
const MOST_LEVELS: i64 = 64;
/// Bounds may be written in single precision: so many cells may they be off.
const TOLERANCE: f64 = 0.05;

/// Where a box begins and ends along each axis.
type Corners = [[f64; 2]; 3];

/// The file's lists of blocks, leaves and others.
pub(super) struct Listed {
    bounds: Hdf5Set,
    corners: Vec<Corners>,
    levels: Vec<i64>,
    kinds: Vec<i64>,
}

/// A leaf, its place in the file, and its cells in indices of its level.
pub(super) struct Leaf {
    pub(super) place: u64,
    pub(super) level: usize,
    pub(super) cells: IndexBox,
}

impl Listed {
    pub(super) fn read(root: &Hdf5Group, integers: &Numbers) -> Result<Self, FormatError> {
        let bounds = root.data_set("bounding box")?;
        let corners = bounds.floats()?;
        let levels = root.data_set("refine level")?.integers()?;
        let kinds = root.data_set("node type")?.integers()?;
        if kinds.len() != levels.len() || corners.len() != levels.len().saturating_mul(6) {
            let (kinds, corners) = (kinds.len(), corners.len() / 6);
            return Err(bounds.malformed(&format!("{corners} blocks, node types {kinds}, levels {}", levels.len())));
        }
        integers.expect("globalnumblocks", levels.len() as f64, " by the lists of blocks")?;
        if let Some(place) = levels.iter().position(|level| !(1..=MOST_LEVELS).contains(level)) {
            return Err(bounds.malformed(&format!("block {place} is of level {}, expected 1 or more", levels[place])));
        }
        let boxes = corners.as_chunks::<6>().0.iter();
        let corners = boxes.map(|&[x, right, y, back, z, top]| [[x, right], [y, back], [z, top]]).collect();
        Ok(Self { bounds, corners, levels, kinds })
    }

    /// The mesh that all blocks of `size` cells lie in.
    pub(super) fn mesh(&self, root: &Hdf5Group, size: [i64; 3]) -> Result<Root, FormatError> {
        let (around, widths) = (self.around(), self.cell_widths(size));
        let domain = stated_domain(root, &around, &widths)?.unwrap_or(around);
        mesh(&domain, &widths).ok_or_else(|| self.bounds.malformed("no block of any size"))
    }

    /// The leaves, those of coarse levels first.
    pub(super) fn leaves(&self, mesh: &Root, size: [i64; 3]) -> Result<Vec<Leaf>, FormatError> {
        let places = (0..self.kinds.len()).filter(|&place| self.kinds[place] == LEAF);
        let leaf = |place: usize| {
            let (corners, level) = (&self.corners[place], self.levels[place] as usize - 1);
            let cells = cells_between(corners, mesh, level, size).ok_or_else(|| {
                let expected = format!("expected {size:?} cells of its level");
                self.bounds.malformed(&format!("block {place} reaches over {corners:?}, {expected}"))
            })?;
            Ok(Leaf { place: place as u64, level, cells })
        };
        let mut leaves = places.map(leaf).collect::<Result<Vec<_>, FormatError>>()?;
        leaves.sort_by_key(|leaf| leaf.level);
        Ok(leaves)
    }

    /// The bounds of all blocks together.
    fn around(&self) -> Corners {
        std::array::from_fn(|axis| {
            let ends = |end: usize| self.corners.iter().map(move |corners| corners[axis][end]);
            [ends(0).fold(f64::INFINITY, f64::min), ends(1).fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    /// The widths of cells of the coarsest level, by the first block; not numbers where there is none.
    fn cell_widths(&self, size: [i64; 3]) -> [f64; 3] {
        let Some((corners, &level)) = self.corners.first().zip(self.levels.first()) else { return [f64::NAN; 3] };
        std::array::from_fn(|axis| {
            let [low, high] = corners[axis];
            (high - low) / size[axis] as f64 * 2f64.powi(level as i32 - 1)
        })
    }
}

/// The domain that the run was told to have, which is more exact than bounds of blocks in single precision.
fn stated_domain(root: &Hdf5Group, around: &Corners, widths: &[f64; 3]) -> Result<Option<Corners>, FormatError> {
    let Some(parameters) = Numbers::read_if_there(root, "real runtime parameters")? else { return Ok(None) };
    let mut domain = *around;
    for (axis, names) in [["xmin", "xmax"], ["ymin", "ymax"], ["zmin", "zmax"]].into_iter().enumerate() {
        for (end, name) in names.into_iter().enumerate() {
            let Some(stated) = parameters.get(name) else { return Ok(None) };
            let found = around[axis][end];
            let off = (stated - found).abs();
            if off.is_nan() || off > TOLERANCE * widths[axis].abs() {
                let problem = format!("{name} is {stated}, expected {found} by the bounding boxes of blocks");
                return Err(parameters.malformed(&problem));
            }
            domain[axis][end] = stated;
        }
    }
    Ok(Some(domain))
}

/// The mesh of a domain in cells of about some widths; `None` where the numbers make none.
fn mesh(domain: &Corners, widths: &[f64; 3]) -> Option<Root> {
    let mut mesh = Root { low: [0.0; 3], cell_size: [0.0; 3], cells: [0; 3], ratio: 2 };
    for axis in 0..3 {
        let [low, high] = domain[axis];
        let cells = ((high - low) / widths[axis]).round();
        if !(low.is_finite() && widths[axis] > 0.0 && (1.0..=1e9).contains(&cells)) {
            return None;
        }
        mesh.low[axis] = low;
        mesh.cells[axis] = cells as i64;
        mesh.cell_size[axis] = (high - low) / cells;
    }
    Some(mesh)
}

/// The cells between corners, in indices of a level; `None` where these are not a block's.
fn cells_between(corners: &Corners, mesh: &Root, level: usize, block: [i64; 3]) -> Option<IndexBox> {
    let mut cells = IndexBox::new([0; 3], [0; 3]);
    let cell_size = mesh.cell_size(level);
    for axis in 0..3 {
        let [low, high] = corners[axis].map(|place| (place - mesh.low[axis]) / cell_size[axis]);
        let near = |place: f64| (place - place.round()).abs() <= TOLERANCE * (1.0 + place.abs() * 1e-4);
        if !(low.abs() < 1e15 && high.abs() < 1e15 && near(low) && near(high)) {
            return None;
        }
        (cells.low[axis], cells.high[axis]) = (low.round() as i64, high.round() as i64);
    }
    (cells.size() == block).then_some(cells)
}
