//! Athena++ output (.athdf): one HDF5 file of mesh blocks, the leaves of an octree.
//!
//! The format is described in the wiki of Athena++, *HDF5 Format*. Blocks are all of one size and lie at a level and at a
//! logical location, which counts blocks of that level. Nothing is stored under finer blocks.

mod mesh;
mod xdmf;

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field};

use crate::hdf5::{Hdf5, Hdf5Group, Hdf5Set, Storage, one_line};
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions, Summary};
use mesh::Mesh;
pub(crate) use xdmf::named_in_xdmf;

/// An Athena++ file.
pub(crate) struct AthenaFile {
    summary: Summary,
    hdf5: Hdf5,
    mesh: Mesh,
    /// Where the fields' values lie.
    variables: Vec<Variable>,
    sets: Vec<(Hdf5Set, Storage)>,
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
        let hierarchy = Arc::new(mesh.hierarchy().map_err(FormatError::hierarchy(hdf5.path()))?);
        let mut warnings = Vec::new();
        match root.text("Coordinates")?.as_deref() {
            None | Some("cartesian" | "minkowski") => {}
            Some(other) => {
                let other = one_line(other);
                warnings.push(format!("the coordinates are {other}, but are shown as if they were Cartesian"));
            }
        }
        let sets = data_sets(&root, &mesh)?;
        let (variables, fields) = variables(&root, &sets)?;
        let (path, time) = (hdf5.path().into(), root.float("Time")?);
        let summary = Summary { format: "Athena++ HDF5", path, time, hierarchy, fields, warnings };
        Ok(Self { summary, hdf5, mesh, variables, sets, options: *options })
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
        let store = Store::new::<T>(self.hierarchy().cells(), &self.options)?;
        let numbers = self.mesh.blocks();
        let leading = [number];
        let blocks = self.mesh.blocks_in(&leading, &numbers);
        let done = stored_bricks::counted(numbers.len(), progress);
        values.blocks(self.hdf5.map(), storage, &blocks, &store, &done)
    }
}

impl DataSet for AthenaFile {
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

/// The data sets that the file names, which must hold all blocks.
fn data_sets(root: &Hdf5Group, mesh: &Mesh) -> Result<Vec<(Hdf5Set, Storage)>, FormatError> {
    let names = root.text_list("DatasetNames")?.unwrap_or_default();
    let counts = root.integer_list("NumVariables")?;
    if let Some(counts) = counts.as_ref().filter(|counts| counts.len() != names.len()) {
        let (found, expected) = (counts.len(), names.len());
        return Err(root.malformed(&format!("NumVariables holds {found} counts, expected {expected} by DatasetNames")));
    }
    let numbers = mesh.blocks();
    let find = |(set, name): (usize, &String)| {
        let values = root.data_set(name)?;
        values.expect_blocks(&mesh.blocks_in(&[0], &numbers))?;
        let (found, stated) = (values.shape()[0], counts.as_ref().map(|counts| counts[set]));
        match stated.filter(|&stated| u64::try_from(stated) != Ok(found)) {
            Some(stated) => Err(values.malformed(&format!("{found} variables, expected {stated} by NumVariables"))),
            None => values.storage().map(|storage| (values, storage)),
        }
    };
    names.iter().enumerate().map(find).collect()
}

/// The variables of all data sets, each with its name. Their number follows from the shapes of the data sets.
fn variables(root: &Hdf5Group, sets: &[(Hdf5Set, Storage)]) -> Result<(Vec<Variable>, Vec<FieldInfo>), FormatError> {
    let names = root.text_list("VariableNames")?.unwrap_or_default();
    let counts = || sets.iter().map(|(values, _)| values.shape()[0]);
    let total = counts().fold(0, u64::saturating_add);
    if total != names.len() as u64 {
        let found = names.len();
        let problem = format!("VariableNames holds {found} names, expected {total} by the shapes of the data sets");
        return Err(root.malformed(&problem));
    }
    let places = counts().enumerate().flat_map(|(set, count)| (0..count).map(move |number| Variable { set, number }));
    let variables: Vec<Variable> = places.collect();
    let field = |(variable, name): (&Variable, String)| {
        let voxel_type = sets[variable.set].0.voxel_type_in_memory()?;
        Ok(FieldInfo { name: one_line(&name), voxel_type, unit: None })
    };
    let fields = variables.iter().zip(names).map(field).collect::<Result<_, FormatError>>()?;
    Ok((variables, fields))
}

/// An attribute that has a value per axis.
fn per_axis<T: Copy>(root: &Hdf5Group, name: &str, found: Option<Vec<T>>) -> Result<[T; 3], FormatError> {
    let found = found.ok_or_else(|| root.malformed(&format!("no attribute {name}: the extents cannot be known")))?;
    <[T; 3]>::try_from(&found[..])
        .map_err(|_| root.malformed(&format!("attribute {name} holds {} values, expected 3", found.len())))
}
