//! Athena++ output (.athdf): one HDF5 file of mesh blocks, the leaves of an octree.
//!
//! The format is described in the wiki of Athena++, *HDF5 Format*. Blocks are all of one size and lie at a level and at a
//! logical location, which counts blocks of that level. Nothing is stored under finer blocks.

mod mesh;
mod xdmf;

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, Hierarchy};

use crate::hdf5::{Blocks, Hdf5, Hdf5Group, Hdf5Set, Storage};
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions};
use mesh::Mesh;
pub(crate) use xdmf::named_in_xdmf;

/// An Athena++ file.
pub(crate) struct AthenaFile {
    hdf5: Hdf5,
    time: Option<f64>,
    hierarchy: Arc<Hierarchy>,
    mesh: Mesh,
    fields: Vec<FieldInfo>,
    /// Where the fields' values lie.
    variables: Vec<Variable>,
    sets: Vec<(Hdf5Set, Storage)>,
    warnings: Vec<String>,
    options: OpenOptions,
}

/// A place in [`AthenaFile::sets`], and which of its variables.
struct Variable {
    set: usize,
    number: u64,
}

impl AthenaFile {
    /// Whether the HDF5 file is Athena++'s.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where its root group is damaged.
    pub(crate) fn recognises(hdf5: &Hdf5) -> Result<bool, FormatError> {
        let root = hdf5.root()?;
        Ok(root.has_attribute("DatasetNames") && root.has_attribute("VariableNames"))
    }

    /// Reads the geometry of a file that [`AthenaFile::recognises`] knows.
    ///
    /// # Errors
    /// [`FormatError`] where the file is damaged, has no mesh, or holds what is not rendered: a grid that is stretched or
    /// has fewer than three dimensions.
    pub(crate) fn read(hdf5: Hdf5, options: &OpenOptions) -> Result<Self, FormatError> {
        let root = hdf5.root()?;
        let mesh = Mesh::read(&root)?;
        let wrong = |source| FormatError::Hierarchy { path: hdf5.path().into(), source };
        let hierarchy = Arc::new(mesh.hierarchy().map_err(wrong)?);
        let mut warnings = Vec::new();
        match root.text("Coordinates")?.as_deref() {
            None | Some("cartesian" | "minkowski") => {}
            Some(other) => {
                warnings.push(format!("the coordinates are {other}, but are shown as if they were Cartesian"));
            }
        }
        let (mut sets, mut variables, mut fields) = (Vec::new(), Vec::new(), Vec::new());
        let names = root.text_list("VariableNames")?.unwrap_or_default();
        let counts = root.integer_list("NumVariables")?.unwrap_or_default();
        for (set, name) in root.text_list("DatasetNames")?.unwrap_or_default().iter().enumerate() {
            let values = root.data_set(name)?;
            let count = values.shape().first().copied().unwrap_or(0);
            if counts.get(set).is_some_and(|&stated| u64::try_from(stated) != Ok(count)) {
                return Err(values.malformed(&format!("{count} variables, expected {} by NumVariables", counts[set])));
            }
            // One past the last one there could be a name for.
            for number in 0..count.min(names.len() as u64 + 1) {
                let name = names.get(variables.len()).ok_or_else(|| {
                    values.malformed(&format!("more variables than the {} VariableNames", names.len()))
                })?;
                let (name, voxel_type) = (name.clone(), values.voxel_type_in_memory()?);
                fields.push(FieldInfo { name, voxel_type, unit: None });
                variables.push(Variable { set, number });
            }
            let storage = values.storage()?;
            sets.push((values, storage));
        }
        let time = root.float("Time")?;
        Ok(Self { hdf5, time, hierarchy, mesh, fields, variables, sets, warnings, options: *options })
    }
}

impl StoredBricks for AthenaFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let Variable { set, number } = self.variables[field];
        let (values, storage) = &self.sets[set];
        let store = Store::new::<T>(self.hierarchy.cells(), &self.options)?;
        let numbers = self.mesh.blocks();
        let (ghosts, size) = (self.mesh.ghosts(), self.mesh.block_size());
        let blocks = Blocks { leading: &[number], numbers: Some(&numbers), ghosts, size };
        let done = stored_bricks::counted(numbers.len(), progress);
        values.blocks(self.hdf5.map(), storage, &blocks, &store, &done)
    }
}

impl DataSet for AthenaFile {
    fn format(&self) -> &'static str {
        "Athena++ HDF5"
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
        &self.warnings
    }
}

/// An attribute that has a value per axis.
fn per_axis<T: Copy>(root: &Hdf5Group, name: &str, found: Option<Vec<T>>) -> Result<[T; 3], FormatError> {
    let found = found.ok_or_else(|| root.malformed(&format!("no attribute {name}: the extents cannot be known")))?;
    <[T; 3]>::try_from(&found[..])
        .map_err(|_| root.malformed(&format!("attribute {name} holds {} values, expected 3", found.len())))
}
