//! Chombo HDF5 files, as Chombo, GRChombo and codes built on them write them.
//!
//! The format is that of `WriteAMRHierarchyHDF5` in Chombo's `AMRIO.cpp` and of the level data in `CH_HDF5.cpp`: root
//! attributes, and a group `level_N` per level with its `boxes` and one flat array of values.

mod expressions;
mod geometry;
mod values;
mod writer;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use amray::hierarchy::{BrickValues, Centering, Field, IndexBox, Level, VoxelType};

use crate::hdf5::{Hdf5, Hdf5Group};
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, Definition, FieldInfo, FormatError, OpenOptions, Summary};
use values::LevelValues;
pub use writer::ChomboWriter;

/// What a file must hold to be taken for Chombo's.
const EXPECTED: &str =
    "Chombo HDF5 (a group level_0, and Chombo_global or the attributes num_levels and num_components)";

/// A Chombo HDF5 file.
pub struct ChomboFile {
    summary: Summary,
    hdf5: Hdf5,
    centering: Centering,
    expressions: Vec<Definition>,
    levels: Vec<LevelValues>,
    options: OpenOptions,
}

impl ChomboFile {
    /// Whether the HDF5 file is Chombo's.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where its root group is damaged.
    pub(crate) fn recognises(hdf5: &Hdf5) -> Result<bool, FormatError> {
        let root = hdf5.root()?;
        if root.group("Chombo_global")?.is_some() {
            return Ok(true);
        }
        let counts = root.has_attribute("num_levels") || root.has_attribute("num_components");
        Ok(counts && root.group("level_0")?.is_some())
    }

    /// Opens a file and reads its geometry, not its values.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] where the file is no Chombo file, another [`FormatError`] where it is damaged,
    /// has a level without boxes, or holds what is not rendered: two dimensions, or values on edges or faces.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        match Hdf5::open(path)? {
            Some(hdf5) if Self::recognises(&hdf5)? => Self::read(hdf5, options),
            Some(hdf5) => Err(hdf5.unrecognised(EXPECTED)),
            None => {
                let found = "not an HDF5 file".into();
                Err(FormatError::Unrecognised { path: path.into(), found, expected: EXPECTED.into() })
            }
        }
    }

    /// Reads the geometry of a file that [`ChomboFile::recognises`] knows.
    ///
    /// # Errors
    /// As [`ChomboFile::open`].
    pub(crate) fn read(hdf5: Hdf5, options: &OpenOptions) -> Result<Self, FormatError> {
        let root = hdf5.root()?;
        let centering = centering(&root)?;
        let mut warnings = Vec::new();

        let levels = count(&root, "num_levels")?;
        let levels = (0..options.level_count(hdf5.path(), levels)?)
            .map(|number| geometry::level_group(&root, number))
            .collect::<Result<Vec<_>, _>>()?;
        let hierarchy = geometry::hierarchy(hdf5.path(), &root, &levels, &mut warnings)?;
        let time = match root.float("time")? {
            Some(time) => Some(time),
            None => levels.first().map_or(Ok(None), |level| level.float("time"))?,
        };

        let components = count(&root, "num_components")?;
        let levels = levels
            .iter()
            .zip(hierarchy.levels())
            .enumerate()
            .map(|(number, (group, level))| LevelValues::locate(number, group, components, &places(level, centering)))
            .collect::<Result<Vec<_>, _>>()?;
        let voxel_type = levels.first().map_or(VoxelType::F64, LevelValues::voxel_type);
        for level in &levels {
            level.expect_type(voxel_type)?;
        }
        // By now every component of every brick is known to have its place in the file: the count can be believed.
        let fields = field_names(&root, components, &mut warnings);
        let fields = fields.into_iter().map(|name| FieldInfo { name, voxel_type, unit: None }).collect();
        let summary = Summary {
            format: "Chombo HDF5",
            path: hdf5.path().into(),
            time,
            hierarchy: Arc::new(hierarchy),
            fields,
            warnings,
        };
        let (expressions, options) = (expressions::read(&root), *options);
        Ok(Self { summary, hdf5, centering, expressions, levels, options })
    }
}

impl StoredBricks for ChomboFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let places: Vec<_> = self.hierarchy().levels().iter().map(|level| places(level, self.centering)).collect();
        let all = places.iter().flatten().map(IndexBox::cells).sum::<u64>();
        let store = Store::new::<T>(all, &self.options)?;
        let done = AtomicU64::new(0);
        let advance = |places: u64| progress((done.fetch_add(places, Ordering::Relaxed) + places) as f64 / all as f64);
        let mut bricks = Vec::with_capacity(self.hierarchy().brick_count());
        for (values, places) in self.levels.iter().zip(&places) {
            bricks.extend(values.read::<T>(self.hdf5.map(), field, places, &store, &advance)?);
        }
        Ok(bricks)
    }
}

impl DataSet for ChomboFile {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, self.centering, field, progress)
    }

    fn expressions(&self) -> &[Definition] {
        &self.expressions
    }
}

/// The values that a level's bricks hold.
fn places(level: &Level, centering: Centering) -> Vec<IndexBox> {
    level.bricks().iter().map(|brick| centering.values_of(brick)).collect()
}

/// Values belong to cells, or to nodes (`data_centering` 7). Two-dimensional data, and values on edges and faces, are
/// refused.
fn centering(root: &Hdf5Group) -> Result<Centering, FormatError> {
    if let Some(global) = root.group("Chombo_global")?
        && let Some(dimensions) = global.integer("SpaceDim")?
        && dimensions != 3
    {
        return Err(global.malformed(&format!("SpaceDim is {dimensions}, expected 3: only 3-D data can be rendered")));
    }
    match root.integer("data_centering")? {
        None | Some(0) => Ok(Centering::Cells),
        Some(7) => Ok(Centering::Nodes),
        Some(centering) => {
            let expected = "expected 0 (cells) or 7 (nodes)";
            Err(root.malformed(&format!("data_centering is {centering}, {expected}")))
        }
    }
}

/// A root attribute that counts something there must be at least one of.
fn count(root: &Hdf5Group, name: &str) -> Result<usize, FormatError> {
    let count = root.integer(name)?.ok_or_else(|| root.malformed(&format!("no attribute {name}")))?;
    match usize::try_from(count) {
        Ok(count) if count > 0 => Ok(count),
        _ => Err(root.malformed(&format!("{name} is {count}, expected at least 1"))),
    }
}

/// The names of the components: `component_0` and so on where the file gives none.
fn field_names(root: &Hdf5Group, components: usize, warnings: &mut Vec<String>) -> Vec<String> {
    let mut names: Vec<String> = Vec::with_capacity(components);
    for component in 0..components {
        let attribute = format!("component_{component}");
        let name = match root.text(&attribute) {
            Ok(Some(name)) if !name.is_empty() && !name.contains(char::is_control) => name,
            Ok(None) => attribute,
            _ => {
                warnings.push(format!("the name of component {component} is unreadable: it is called {attribute}"));
                attribute
            }
        };
        names.push(name);
    }
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort_unstable();
    if let Some(twice) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        warnings.push(format!("several components are called {}: the name stands for the first", twice[0]));
    }
    names
}
