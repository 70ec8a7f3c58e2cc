//! What could be fields: data sets that hold a value for each cell of their grid.

use amray::hierarchy::VoxelType;

use super::grids::Grid;
use crate::FormatError;
use crate::hdf5::{Hdf5Group, Hdf5Set};

/// Data sets of one name in several grids.
pub(super) struct Candidate {
    pub(super) name: String,
    /// The type in the first grid that has one.
    pub(super) voxel_type: Option<VoxelType>,
    /// In so many grids.
    count: usize,
    mixed: bool,
    /// The first one that cannot be read.
    damage: Option<FormatError>,
}

impl Candidate {
    /// All of them, by the `group` of each grid.
    pub(super) fn all(
        grids: &[Grid],
        group: impl Fn(&Grid) -> Result<Hdf5Group, FormatError>,
    ) -> Result<Vec<Self>, FormatError> {
        let mut found: Vec<Self> = Vec::new();
        for grid in grids {
            let group = group(grid)?;
            for name in group.data_set_names()?.into_iter().filter(|name| !name.starts_with("particle_")) {
                let read = group.data_set(&name).and_then(|set| voxel_type(&set, grid)).transpose();
                let Some(read) = read else { continue };
                match found.iter_mut().find(|known| known.name == name) {
                    Some(known) => known.add(read),
                    None => {
                        let mut new = Self { name, voxel_type: None, count: 0, mixed: false, damage: None };
                        new.add(read);
                        found.push(new);
                    }
                }
            }
        }
        Ok(found)
    }

    fn add(&mut self, read: Result<VoxelType, FormatError>) {
        match read {
            Ok(voxel_type) => {
                self.count += 1;
                self.mixed |= *self.voxel_type.get_or_insert(voxel_type) != voxel_type;
            }
            Err(error) => {
                self.damage.get_or_insert(error);
            }
        }
    }

    /// Why it is no field of so many grids.
    pub(super) fn problem(&self, grids: usize) -> Option<String> {
        if let Some(damage) = &self.damage {
            return Some(damage.to_string());
        }
        if self.name.contains(char::is_control) {
            return Some("its name has control characters".into());
        }
        if self.mixed {
            return Some("single precision in some grids, double precision in others".into());
        }
        (self.count < grids).then(|| format!("{} of {grids} grids lack it", grids - self.count))
    }
}

/// The type of values of a grid's cells; `None` where the data set is of something else, such as particles.
fn voxel_type(set: &Hdf5Set, grid: &Grid) -> Result<Option<VoxelType>, FormatError> {
    let [x, y, z] = grid.cells.size().map(i64::cast_unsigned);
    match set.shape() {
        shape if shape == [z, y, x] => set.voxel_type_in_memory().map(Some),
        shape if shape.len() == 3 => Err(set.malformed(&format!("shape {shape:?}, expected {:?}", [z, y, x]))),
        _ => Ok(None),
    }
}
