//! Enzo dumps: a text file of parameters, one of grids (.hierarchy), and HDF5 files of values (.cpu0000 and so on).
//!
//! The format is described in Enzo's documentation, *Enzo Output Formats* (packed AMR). Values are those of active cells
//! alone, and coarse cells under finer grids are stored.

mod grids;
mod units;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, Hierarchy, VoxelType};

use crate::hdf5::{Block, Hdf5, Hdf5Group};
use crate::key_values::Text;
use crate::mapped_file::start_of;
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions};
use grids::Grid;

/// An Enzo dump.
pub(crate) struct EnzoDump {
    path: PathBuf,
    time: f64,
    hierarchy: Arc<Hierarchy>,
    /// In the order of the hierarchy's bricks.
    grids: Vec<Grid>,
    files: BTreeMap<PathBuf, Hdf5>,
    fields: Vec<FieldInfo>,
    warnings: Vec<String>,
    options: OpenOptions,
}

impl EnzoDump {
    /// The parameter file of the dump that a path belongs to: its directory, or any of its files. `None` where it is none.
    pub(crate) fn find(path: &Path) -> Option<PathBuf> {
        let parameters = |hierarchy: &Path| hierarchy.with_extension("");
        let is_dump = |hierarchy: &PathBuf| {
            let head =
                fs::metadata(hierarchy).is_ok_and(|file| file.is_file()).then(|| first_line(hierarchy)).flatten();
            head.is_some_and(|line| line.replace(' ', "").starts_with("Grid=1")) && parameters(hierarchy).is_file()
        };
        if path.is_dir() {
            let entries = fs::read_dir(path).ok()?.flatten().map(|entry| entry.path());
            let mut found: Vec<PathBuf> =
                entries.filter(|path| path.extension().is_some_and(|ending| ending == "hierarchy")).collect();
            found.sort();
            return found.iter().find(|hierarchy| is_dump(hierarchy)).map(|hierarchy| parameters(hierarchy));
        }
        let mut beside = path.as_os_str().to_owned();
        beside.push(".hierarchy");
        // The file is the parameters, the grids, or one of values.
        let candidates = [PathBuf::from(beside), path.with_extension("hierarchy")];
        candidates.iter().find(|hierarchy| is_dump(hierarchy)).map(|hierarchy| parameters(hierarchy))
    }

    /// Opens the dump with the parameter file `path`.
    ///
    /// # Errors
    /// [`FormatError`] where a file is missing or damaged, or the data have fewer than three dimensions.
    pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        let parameters = Text::read(path)?;
        let mut beside = path.as_os_str().to_owned();
        beside.push(".hierarchy");
        let root = grids::root(&parameters)?;
        let mut grids = grids::read(&Text::read(Path::new(&beside))?, &root)?;
        let levels = grids.last().map_or(0, |grid| grid.level + 1);
        let levels = options.level_count(path, levels)?;
        grids.retain(|grid| grid.level < levels);
        let wrong = |source| FormatError::Hierarchy { path: path.into(), source };
        let bricks = grids.iter().map(|grid| (grid.level, grid.cells));
        let hierarchy = Arc::new(root.hierarchy(levels, bricks).map_err(wrong)?);
        let mut files = BTreeMap::new();
        for grid in &grids {
            if !files.contains_key(&grid.file) {
                let none =
                    || FormatError::malformed(&grid.file, "the file", "not HDF5, expected a file of Enzo's values");
                files.insert(grid.file.clone(), Hdf5::open(&grid.file)?.ok_or_else(none)?);
            }
        }
        let time = parameters.find("InitialTime")?.number()?;
        let (fields, warnings) = (Vec::new(), Vec::new());
        let mut dump = Self { path: path.into(), time, hierarchy, grids, files, fields, warnings, options: *options };
        dump.find_fields(&units::of_fields(&parameters))?;
        Ok(dump)
    }

    /// Fields are what every grid has, with a value for each of its cells.
    fn find_fields(&mut self, units: &BTreeMap<String, String>) -> Result<(), FormatError> {
        let mut counts: Vec<(String, usize, VoxelType)> = Vec::new();
        for grid in &self.grids {
            let group = self.group(grid)?;
            for name in group.member_names()? {
                if name.starts_with("particle_") {
                    continue;
                }
                // Particles of all kinds lie in groups of their own.
                let Ok(set) = group.data_set(&name) else { continue };
                let size = grid.cells.size();
                let shape = [size[2], size[1], size[0]].map(|cells| cells as u64);
                let Ok(voxel_type) = set.voxel_type_in_memory() else { continue };
                if *set.shape() != shape {
                    continue;
                }
                match counts.iter_mut().find(|(known, ..)| *known == name) {
                    Some((_, count, known)) if *known == voxel_type => *count += 1,
                    Some(_) => {}
                    None => counts.push((name, 1, voxel_type)),
                }
            }
        }
        for (name, count, voxel_type) in counts {
            if count == self.grids.len() {
                let unit = units.get(&name).cloned();
                self.fields.push(FieldInfo { name, voxel_type, unit });
            } else {
                let missing = self.grids.len() - count;
                self.warnings.push(format!("{name} is left out: {missing} of {} grids lack it", self.grids.len()));
            }
        }
        Ok(())
    }

    /// The values of a grid.
    fn group(&self, grid: &Grid) -> Result<Hdf5Group, FormatError> {
        let name = format!("Grid{:08}", grid.id);
        let root = self.files[&grid.file].root()?;
        root.group(&name)?.ok_or_else(|| root.malformed(&format!("no group {name}, expected it by the file of grids")))
    }
}

impl StoredBricks for EnzoDump {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let name = &self.fields[field].name;
        let store = Store::new::<T>(self.hierarchy.cells(), &self.options)?;
        stored_bricks::read_each(&self.grids, progress, |grid| {
            let set = self.group(grid)?.data_set(name)?;
            let block = Block { leading: &[], ghosts: [0; 3], size: grid.cells.size().map(i64::cast_unsigned) };
            set.block(self.files[&grid.file].map(), &set.storage()?, &block, &store)
        })
    }
}

impl DataSet for EnzoDump {
    fn format(&self) -> &'static str {
        "Enzo"
    }

    fn time(&self) -> Option<f64> {
        Some(self.time)
    }

    fn hierarchy(&self) -> &Arc<Hierarchy> {
        &self.hierarchy
    }

    fn fields(&self) -> &[FieldInfo] {
        &self.fields
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, &self.path, Centering::Cells, field, progress)
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// The first line of a file that holds something.
fn first_line(path: &Path) -> Option<String> {
    const LOOKED_AT: u64 = 1 << 12;
    let start = start_of(path, LOOKED_AT).ok()?;
    let text = String::from_utf8_lossy(&start);
    text.lines().find(|line| !line.trim().is_empty()).map(str::to_owned)
}
