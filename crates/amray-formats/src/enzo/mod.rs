//! Enzo dumps: a text file of parameters, one of grids (.hierarchy), and HDF5 files of values (.cpu0000 and so on).
//!
//! The format is described in Enzo's documentation, *Enzo Output Formats* (packed AMR). Values are those of active cells
//! alone, and coarse cells under finer grids are stored.

mod candidates;
mod grids;
mod units;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field};

use crate::hdf5::{Blocks, Hdf5, Hdf5Group, listing, one_line};
use crate::key_values::Text;
use crate::mapped_file::start_of;
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions, Summary};
use candidates::Candidate;
use grids::Grid;

/// An Enzo dump.
pub(crate) struct EnzoDump {
    summary: Summary,
    /// In the order of the hierarchy's bricks.
    grids: Vec<Grid>,
    files: BTreeMap<PathBuf, Hdf5>,
    options: OpenOptions,
}

impl EnzoDump {
    /// The parameter file of the dump that a path belongs to: its directory, or any of its files. `None` where it is none.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] where `path` is a directory of several dumps.
    pub(crate) fn find(path: &Path) -> Result<Option<PathBuf>, FormatError> {
        if path.is_dir() {
            let mut dumps = dumps_in(path);
            return if dumps.len() > 1 { Err(several(path, &dumps)) } else { Ok(dumps.pop()) };
        }
        // The file is the parameters, the grids, or one of values.
        let candidates = [hierarchy_beside(path), path.with_extension("hierarchy")];
        Ok(candidates.iter().find_map(|hierarchy| parameters_beside(hierarchy)))
    }

    /// Opens the dump with the parameter file `path`.
    ///
    /// # Errors
    /// [`FormatError`] where a file is missing or damaged, or the data have fewer than three dimensions.
    pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        let parameters = Text::read(path)?;
        let root = grids::root(&parameters)?;
        let mut grids = grids::read(&Text::read(&hierarchy_beside(path))?, &root)?;
        let levels = grids.last().map_or(0, |grid| grid.level + 1);
        let levels = options.level_count(path, levels)?;
        grids.retain(|grid| grid.level < levels);
        let bricks = grids.iter().map(|grid| (grid.level, grid.cells));
        let hierarchy = Arc::new(root.hierarchy(levels, bricks).map_err(FormatError::hierarchy(path))?);
        let mut files = BTreeMap::new();
        for grid in &grids {
            if !files.contains_key(&grid.file) {
                let none =
                    || FormatError::malformed(&grid.file, "the file", "not HDF5, expected a file of Enzo's values");
                files.insert(grid.file.clone(), Hdf5::open(&grid.file)?.ok_or_else(none)?);
            }
        }
        let time = Some(parameters.find("InitialTime")?.number()?);
        let (path, fields, warnings) = (path.into(), Vec::new(), Vec::new());
        let summary = Summary { format: "Enzo", path, time, hierarchy, fields, warnings };
        let mut dump = Self { summary, grids, files, options: *options };
        dump.find_fields(&units::of_fields(&parameters))?;
        Ok(dump)
    }

    /// Fields are what every grid has, with a value for each of its cells.
    fn find_fields(&mut self, units: &BTreeMap<String, String>) -> Result<(), FormatError> {
        let candidates = Candidate::all(&self.grids, |grid| self.group(grid))?;
        for candidate in candidates {
            match candidate.problem(self.grids.len()) {
                Some(problem) => {
                    self.summary.warnings.push(format!("{} is left out: {problem}", one_line(&candidate.name)));
                }
                None => {
                    let Candidate { name, voxel_type, .. } = candidate;
                    let Some(voxel_type) = voxel_type else { continue };
                    let unit = units.get(&name).cloned();
                    self.summary.fields.push(FieldInfo { name, voxel_type, unit });
                }
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
        let name = &self.fields()[field].name;
        let store = Store::new::<T>(self.hierarchy().cells(), &self.options)?;
        let read = |grid: &Grid| {
            let set = self.group(grid)?.data_set(name)?;
            let size = grid.cells.size().map(i64::cast_unsigned);
            let block = Blocks { leading: &[], numbers: None, ghosts: [0; 3], size };
            set.blocks(self.files[&grid.file].map(), &set.storage()?, &block, &store, &|| {})
        };
        Ok(stored_bricks::read_each(&self.grids, progress, read)?.into_iter().flatten().collect())
    }
}

impl DataSet for EnzoDump {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, Centering::Cells, field, progress)
    }
}

/// The parameter files of all dumps in a directory, in the order of their names.
fn dumps_in(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten().map(|entry| entry.path());
    let hierarchies = entries.filter(|path| path.extension().is_some_and(|ending| ending == "hierarchy"));
    let mut found: Vec<PathBuf> = hierarchies.filter_map(|hierarchy| parameters_beside(&hierarchy)).collect();
    found.sort();
    found
}

/// The parameter file beside a file of grids; `None` where it is none or stands alone.
fn parameters_beside(hierarchy: &Path) -> Option<PathBuf> {
    let line = fs::metadata(hierarchy).is_ok_and(|file| file.is_file()).then(|| first_line(hierarchy))??;
    let parameters = hierarchy.with_extension("");
    (line.replace(' ', "").starts_with("Grid=1") && parameters.is_file()).then_some(parameters)
}

/// The file of grids beside a parameter file.
fn hierarchy_beside(parameters: &Path) -> PathBuf {
    let mut path = parameters.as_os_str().to_owned();
    path.push(".hierarchy");
    path.into()
}

/// The error for a directory of several dumps.
fn several(directory: &Path, dumps: &[PathBuf]) -> FormatError {
    let names = dumps.iter().map(|dump| dump.file_name().unwrap_or_default().to_string_lossy().into_owned());
    let names: Vec<String> = names.collect();
    let found = format!("{} Enzo dumps ({})", dumps.len(), listing(names.iter().map(String::as_str)));
    let expected = "one: pass the parameter file of one of them".into();
    FormatError::Unrecognised { path: directory.into(), found, expected }
}

/// The first line of a file that holds something.
fn first_line(path: &Path) -> Option<String> {
    const LOOKED_AT: u64 = 1 << 12;
    let start = start_of(path, LOOKED_AT).ok()?;
    let text = String::from_utf8_lossy(&start);
    text.lines().find(|line| !line.trim().is_empty()).map(str::to_owned)
}
