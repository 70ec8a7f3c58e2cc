//! FLASH files (plot files and checkpoints): one HDF5 file of the blocks of a PARAMESH octree.
//!
//! The format is described in the FLASH4 User's Guide, chapter *I/O*. Blocks are all of one size. Leaves alone are read,
//! for what coarser blocks hold depends on when the file was written; the levels below follow from the leaves.

mod scalars;

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, Hierarchy, IndexBox};

use crate::hdf5::{Blocks, Hdf5, Hdf5Group};
use crate::refined::Root;
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions};
use scalars::Scalars;

/// `node type` of a leaf.
const LEAF: i64 = 1;
const MOST_LEVELS: i64 = 64;
/// Bounds may be written in single precision: so many cells may they be off.
const TOLERANCE: f64 = 0.05;

/// A FLASH file.
pub(crate) struct FlashFile {
    hdf5: Hdf5,
    time: Option<f64>,
    hierarchy: Arc<Hierarchy>,
    fields: Vec<FieldInfo>,
    /// The leaves' places in the file, in the order of the hierarchy's bricks.
    leaves: Vec<u64>,
    block: [u64; 3],
    options: OpenOptions,
}

/// A leaf, and its cells in indices of its level.
struct Leaf {
    place: u64,
    level: usize,
    cells: IndexBox,
}

impl FlashFile {
    /// Whether the HDF5 file is FLASH's.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where its root group is damaged.
    pub(crate) fn recognises(hdf5: &Hdf5) -> Result<bool, FormatError> {
        let names = hdf5.root()?.member_names()?;
        Ok(["node type", "refine level", "bounding box"].iter().all(|set| names.iter().any(|name| name == set)))
    }

    /// Reads the geometry of a file that [`FlashFile::recognises`] knows.
    ///
    /// # Errors
    /// [`FormatError`] where the file is damaged or has fewer than three dimensions.
    pub(crate) fn read(hdf5: Hdf5, options: &OpenOptions) -> Result<Self, FormatError> {
        let root = hdf5.root()?;
        let integers = Scalars::integers(&root)?;
        let size = |name: &str| integers.find(name);
        let block = [size("nxb")?, size("nyb")?, size("nzb")?].map(|cells| cells as i64);
        if block.iter().any(|cells| !(2..=1 << 20).contains(cells)) {
            return Err(root.malformed(&format!("blocks of {block:?} cells, expected three dimensions")));
        }
        let bounds = root.data_set("bounding box")?;
        let corners = bounds.floats()?;
        let levels = root.data_set("refine level")?.integers()?;
        let kinds = root.data_set("node type")?.integers()?;
        if kinds.len() != levels.len() || corners.len() != levels.len().saturating_mul(6) {
            let (kinds, corners) = (kinds.len(), corners.len() / 6);
            return Err(bounds.malformed(&format!("{corners} blocks, node types {kinds}, levels {}", levels.len())));
        }
        let corners: Vec<[[f64; 2]; 3]> = corners
            .as_chunks::<6>()
            .0
            .iter()
            .map(|&[x, right, y, back, z, top]| [[x, right], [y, back], [z, top]])
            .collect();
        if let Some(place) = levels.iter().position(|level| !(1..=MOST_LEVELS).contains(level)) {
            return Err(bounds.malformed(&format!("block {place} is of level {}, expected 1 or more", levels[place])));
        }
        let mesh = mesh_around(&corners, &levels, block).ok_or_else(|| bounds.malformed("no block of any size"))?;
        let mut leaves = Vec::new();
        for (place, (corners, &level)) in
            corners.iter().zip(&levels).enumerate().filter(|(place, _)| kinds[*place] == LEAF)
        {
            let level = level as usize - 1;
            let cells = cells_between(corners, &mesh, level, block).ok_or_else(|| {
                bounds.malformed(&format!(
                    "block {place} reaches over {corners:?}, expected {block:?} cells of its level"
                ))
            })?;
            leaves.push(Leaf { place: place as u64, level, cells });
        }
        leaves.sort_by_key(|leaf| leaf.level);
        let wrong = |source| FormatError::Hierarchy { path: hdf5.path().into(), source };
        let count = leaves.last().map_or(0, |leaf| leaf.level + 1);
        let bricks = leaves.iter().map(|leaf| (leaf.level, leaf.cells));
        let hierarchy = Arc::new(mesh.hierarchy(count, bricks).map_err(wrong)?);
        let time = Scalars::reals(&root)?.find("time").ok();
        let leaves = leaves.into_iter().map(|leaf| leaf.place).collect();
        let fields = fields(&root)?;
        let block = block.map(i64::cast_unsigned);
        Ok(Self { hdf5, time, hierarchy, fields, leaves, block, options: *options })
    }
}

/// The mesh that all blocks lie in; `None` where the numbers make none.
fn mesh_around(corners: &[[[f64; 2]; 3]], levels: &[i64], block: [i64; 3]) -> Option<Root> {
    let (first, level) = (corners.first()?, *levels.first()?);
    let mut mesh = Root { low: [0.0; 3], cell_size: [0.0; 3], cells: [0; 3], ratio: 2 };
    for axis in 0..3 {
        let low = corners.iter().map(|corners| corners[axis][0]).fold(f64::INFINITY, f64::min);
        let high = corners.iter().map(|corners| corners[axis][1]).fold(f64::NEG_INFINITY, f64::max);
        let width = (first[axis][1] - first[axis][0]) / block[axis] as f64 * 2f64.powi(level as i32 - 1);
        let cells = ((high - low) / width).round();
        if !(low.is_finite() && width > 0.0 && (1.0..=1e9).contains(&cells)) {
            return None;
        }
        mesh.low[axis] = low;
        mesh.cells[axis] = cells as i64;
        mesh.cell_size[axis] = (high - low) / cells;
    }
    Some(mesh)
}

/// The cells between corners, in indices of a level; `None` where these are not a block's.
fn cells_between(corners: &[[f64; 2]; 3], mesh: &Root, level: usize, block: [i64; 3]) -> Option<IndexBox> {
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

/// The unknowns, whose names fill four characters.
fn fields(root: &Hdf5Group) -> Result<Vec<FieldInfo>, FormatError> {
    let names = root.data_set("unknown names")?.texts()?;
    let info = |name: String| {
        let voxel_type = root.data_set(&stored_name(&name))?.voxel_type_in_memory()?;
        Ok(FieldInfo { name, voxel_type, unit: None })
    };
    names.into_iter().map(info).collect()
}

/// A field's name as its data set has it.
fn stored_name(name: &str) -> String {
    format!("{name:4}")
}

impl StoredBricks for FlashFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let set = self.hdf5.root()?.data_set(&stored_name(&self.fields[field].name))?;
        let storage = set.storage()?;
        let store = Store::new::<T>(self.hierarchy.cells(), &self.options)?;
        let blocks = Blocks { leading: &[], numbers: Some(&self.leaves), ghosts: [0; 3], size: self.block };
        let done = stored_bricks::counted(self.leaves.len(), progress);
        set.blocks(self.hdf5.map(), &storage, &blocks, &store, &done)
    }
}

impl DataSet for FlashFile {
    fn format(&self) -> &'static str {
        "FLASH HDF5"
    }

    fn time(&self) -> Option<f64> {
        self.time
    }

    fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    fn fields(&self) -> &[FieldInfo] {
        &self.fields
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, self.hdf5.path(), Centering::Cells, field, progress)
    }

    fn leaf_only(&self) -> bool {
        true
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}
