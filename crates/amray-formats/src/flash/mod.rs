//! FLASH files (plot files and checkpoints): one HDF5 file of the blocks of a PARAMESH octree.
//!
//! The format is described in the FLASH4 User's Guide, chapter *I/O*. Blocks are all of one size. Leaves alone are read,
//! for what coarser blocks hold depends on when the file was written; the levels below follow from the leaves.

mod mesh;
mod scalars;

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field};

use crate::hdf5::{Blocks, Hdf5, Hdf5Group};
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions, Summary};
use mesh::Listed;
use scalars::{Numbers, geometry};

/// A FLASH file.
pub(crate) struct FlashFile {
    summary: Summary,
    hdf5: Hdf5,
    /// The names of the fields' data sets.
    sets: Vec<String>,
    /// The leaves' places in the file, in the order of the hierarchy's bricks.
    leaves: Vec<u64>,
    block: [u64; 3],
    options: OpenOptions,
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
        let integers = Numbers::read(&root, "integer scalars")?;
        integers.expect("dimensionality", 3.0, "")?;
        let size = block_size(&root, &integers)?;
        let listed = Listed::read(&root, &integers)?;
        let mesh = listed.mesh(&root, size)?;
        let leaves = listed.leaves(&mesh, size)?;
        let count = leaves.last().map_or(0, |leaf| leaf.level + 1);
        let bricks = leaves.iter().map(|leaf| (leaf.level, leaf.cells));
        let hierarchy = Arc::new(mesh.hierarchy(count, bricks).map_err(FormatError::hierarchy(hdf5.path()))?);
        let time = Numbers::read(&root, "real scalars")?.get("time");
        let leaves: Vec<u64> = leaves.into_iter().map(|leaf| leaf.place).collect();
        let block = size.map(i64::cast_unsigned);
        let (sets, fields) = fields(&root, &blocks_in_sets(&leaves, block))?;
        let warning = |other| format!("the coordinates are {other}, but are shown as if they were Cartesian");
        let warnings = geometry(&root)?.filter(|name| name != "cartesian").map(warning).into_iter().collect();
        let path = hdf5.path().into();
        let summary = Summary { format: "FLASH HDF5", path, time, hierarchy, fields, warnings };
        Ok(Self { summary, hdf5, sets, leaves, block, options: *options })
    }
}

/// Cells of a block.
fn block_size(root: &Hdf5Group, integers: &Numbers) -> Result<[i64; 3], FormatError> {
    let size = [integers.find("nxb")?, integers.find("nyb")?, integers.find("nzb")?].map(|cells| cells as i64);
    match size.iter().all(|cells| (2..=1 << 20).contains(cells)) {
        true => Ok(size),
        false => Err(root.malformed(&format!("blocks of {size:?} cells, expected three dimensions"))),
    }
}

/// Where the leaves lie in the data sets of unknowns.
fn blocks_in_sets(leaves: &[u64], size: [u64; 3]) -> Blocks<'_> {
    Blocks { leading: &[], numbers: Some(leaves), ghosts: [0; 3], size }
}

/// The data sets of the unknowns, which must hold all `blocks`, and the fields that they are.
fn fields(root: &Hdf5Group, blocks: &Blocks) -> Result<(Vec<String>, Vec<FieldInfo>), FormatError> {
    let unknowns = root.data_set("unknown names")?;
    let there = root.data_set_names()?;
    let find = |name: String| {
        // Names fill four characters, but not in all files.
        let known = there.iter().find(|set| set.trim_end() == name);
        let stored = known.ok_or_else(|| unknowns.malformed(&format!("no data set {name}, expected one")))?;
        let set = root.data_set(stored)?;
        set.expect_blocks(blocks)?;
        let voxel_type = set.voxel_type_in_memory()?;
        Ok((stored.clone(), FieldInfo { name, voxel_type, unit: None }))
    };
    let found: Vec<(String, FieldInfo)> =
        unknowns.texts()?.into_iter().map(find).collect::<Result<_, FormatError>>()?;
    Ok(found.into_iter().unzip())
}

impl StoredBricks for FlashFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let set = self.hdf5.root()?.data_set(&self.sets[field])?;
        let storage = set.storage()?;
        let store = Store::new::<T>(self.hierarchy().cells(), &self.options)?;
        let blocks = blocks_in_sets(&self.leaves, self.block);
        let done = stored_bricks::counted(self.leaves.len(), progress);
        set.blocks(self.hdf5.map(), &storage, &blocks, &store, &done)
    }
}

impl DataSet for FlashFile {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, Centering::Cells, field, progress)
    }

    fn leaf_only(&self) -> bool {
        true
    }
}
