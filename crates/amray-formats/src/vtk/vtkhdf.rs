//! AMR data in one HDF5 file: VTKHDF of type OverlappingAMR (`.vtkhdf`).
//!
//! A level has its boxes and, per array, the values of all of them, one box after the other, x fastest.

use std::ops::Range;
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, Hierarchy, ValueBuffer, contiguous_strides};

use super::arrays::{self, Component, FLAGS, StatedArray};
use super::geometry::{self, StatedLevel, index_box};
use crate::hdf5::{Hdf5, Hdf5Group, Hdf5Set, Storage};
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel, read_each};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions};

/// The group that all of VTK's data are in.
pub(super) const GROUP: &str = "VTKHDF";
pub(super) const KIND: &str = "OverlappingAMR";

/// An OverlappingAMR in VTKHDF.
pub struct VtkhdfFile {
    hdf5: Hdf5,
    time: Option<f64>,
    hierarchy: Arc<Hierarchy>,
    fields: Vec<FieldInfo>,
    components: Vec<Component>,
    warnings: Vec<String>,
    options: OpenOptions,
}

impl VtkhdfFile {
    /// Whether the HDF5 file is VTK's.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where its root group is damaged.
    pub(crate) fn recognises(hdf5: &Hdf5) -> Result<bool, FormatError> {
        Ok(hdf5.root()?.group(GROUP)?.is_some_and(|group| group.has_attribute("Type")))
    }

    /// Reads the geometry of a file that [`VtkhdfFile::recognises`] knows.
    ///
    /// # Errors
    /// [`FormatError`] where the file is damaged or holds other data than a three-dimensional OverlappingAMR.
    pub(crate) fn read(hdf5: Hdf5, options: &OpenOptions) -> Result<Self, FormatError> {
        let vtk = required(&hdf5.root()?, GROUP)?;
        let kind = vtk.text("Type")?.unwrap_or_default();
        if kind != KIND {
            return Err(vtk.malformed(&format!("Type is {kind:?}, expected {KIND:?}")));
        }
        if let Some(description) = vtk.text("GridDescription")?.filter(|axes| axes != "XYZ") {
            return Err(vtk.malformed(&format!("GridDescription is {description:?}, expected \"XYZ\"")));
        }
        let mut warnings = Vec::new();
        let time = match vtk.group("Steps")? {
            Some(steps) => only_step(&steps)?,
            None => None,
        };
        let mut groups = Vec::new();
        while let Some(level) = vtk.group(&format!("Level{}", groups.len()))? {
            groups.push(level);
        }
        if groups.is_empty() {
            return Err(vtk.malformed("no group Level0"));
        }
        groups.truncate(options.level_count(hdf5.path(), groups.len())?);
        let origin = three(&vtk, "Origin")?.unwrap_or_default();
        let levels = groups.iter().map(stated_level).collect::<Result<_, _>>()?;
        let hierarchy = geometry::hierarchy(hdf5.path(), origin, levels)?;
        let (fields, components) = fields(&groups, &hierarchy, &mut warnings)?;
        let options = *options;
        Ok(Self { hdf5, time, hierarchy: Arc::new(hierarchy), fields, components, warnings, options })
    }

    /// The arrays of a field, one per level that has bricks, each with the level's number.
    fn sets(&self, name: &str, centering: Centering) -> Result<Vec<Option<Hdf5Set>>, FormatError> {
        let vtk = required(&self.hdf5.root()?, GROUP)?;
        let set = |(number, level): (usize, &amray::hierarchy::Level)| {
            if level.bricks().is_empty() {
                return Ok(None);
            }
            let arrays = required(&required(&vtk, &format!("Level{number}"))?, section(centering))?;
            match arrays.member_names()?.iter().any(|member| member == name) {
                true => arrays.data_set(name).map(Some),
                false => Ok(None),
            }
        };
        self.hierarchy.levels().iter().enumerate().map(set).collect()
    }
}

/// The time of the one step that there is.
fn only_step(steps: &Hdf5Group) -> Result<Option<f64>, FormatError> {
    match steps.integer("NSteps")? {
        Some(1) | None => Ok(steps.data_set("Values")?.floats()?.first().copied()),
        Some(count) => {
            Err(steps.malformed(&format!("{count} time steps in one file, expected 1: write a file for each")))
        }
    }
}

fn required(group: &Hdf5Group, name: &str) -> Result<Hdf5Group, FormatError> {
    group.group(name)?.ok_or_else(|| group.malformed(&format!("no group {name}")))
}

/// The group of a level's arrays.
pub(super) fn section(centering: Centering) -> &'static str {
    match centering {
        Centering::Cells => "CellData",
        Centering::Nodes => "PointData",
    }
}

/// An attribute of three numbers.
fn three(group: &Hdf5Group, name: &str) -> Result<Option<[f64; 3]>, FormatError> {
    let Some(numbers) = group.float_list(name)? else { return Ok(None) };
    let wrong = |numbers: Vec<f64>| group.malformed(&format!("{name} is {} numbers, expected 3", numbers.len()));
    numbers.try_into().map(Some).map_err(wrong)
}

fn stated_level(level: &Hdf5Group) -> Result<StatedLevel, FormatError> {
    let spacing =
        three(level, "Spacing")?.filter(|spacing| spacing.iter().all(|width| width.is_normal() && *width > 0.0));
    let spacing = spacing.ok_or_else(|| level.malformed("no Spacing of three positive numbers"))?;
    let boxes = level.data_set("AMRBox")?;
    let corners = boxes.integers()?;
    let (corners, rest) = corners.as_chunks::<6>();
    if !rest.is_empty() || !matches!(boxes.shape(), [_, 6]) {
        return Err(boxes.malformed(&format!("shape {:?}, expected six numbers for each box", boxes.shape())));
    }
    let cells = |(number, &corners): (usize, &[i64; 6])| {
        index_box(corners).ok_or_else(|| {
            let expected = "expected the first and last cell along x, y and z";
            boxes.malformed(&format!("box {number} is {corners:?}, {expected}"))
        })
    };
    Ok(StatedLevel { spacing, bricks: corners.iter().enumerate().map(cells).collect::<Result<_, _>>()? })
}

/// The fields that every level with bricks has; others are left out with a warning.
fn fields(
    levels: &[Hdf5Group],
    hierarchy: &Hierarchy,
    warnings: &mut Vec<String>,
) -> Result<(Vec<FieldInfo>, Vec<Component>), FormatError> {
    let mut stated: Vec<(String, Centering, Hdf5Set)> = Vec::new();
    let with_bricks = || {
        levels.iter().zip(hierarchy.levels()).filter(|(_, level)| !level.bricks().is_empty()).map(|(group, _)| group)
    };
    for centering in [Centering::Cells, Centering::Nodes] {
        let mut of_levels = Vec::new();
        for level in with_bricks() {
            let arrays = level.group(section(centering))?;
            of_levels.push(arrays.as_ref().map_or(Ok(Vec::new()), Hdf5Group::member_names)?);
        }
        let (Some(first), Some(names)) = (with_bricks().next(), of_levels.first()) else { continue };
        for name in names.iter().filter(|name| *name != FLAGS) {
            if of_levels.iter().all(|others| others.contains(name)) {
                stated.push((name.clone(), centering, required(first, section(centering))?.data_set(name)?));
            } else {
                warnings.push(format!("array {name:?} is left out: a level lacks it"));
            }
        }
    }
    let mut arrays = Vec::with_capacity(stated.len());
    for (name, centering, set) in &stated {
        let components = match set.shape() {
            [_] => 1,
            [_, components] => *components,
            shape => return Err(set.malformed(&format!("shape {shape:?}, expected one or two dimensions"))),
        };
        match set.voxel_type_in_memory() {
            Ok(voxel_type) => arrays.push(StatedArray { name, centering: *centering, components, voxel_type }),
            Err(_) => warnings.push(format!("array {name:?} is left out: it holds no numbers")),
        }
    }
    Ok(arrays::fields(arrays))
}

/// A brick's values: the rows of the level's arrays that are its own.
struct Rows {
    level: usize,
    rows: Range<u64>,
    /// Values along x, y and z.
    size: [usize; 3],
}

impl StoredBricks for VtkhdfFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let component = &self.components[field];
        let sets = self.sets(&component.array, component.centering)?;
        let flags = self.sets(FLAGS, component.centering)?;
        let storages =
            sets.iter().map(|set| set.as_ref().map(Hdf5Set::storage).transpose()).collect::<Result<Vec<_>, _>>()?;
        let mut bricks = Vec::with_capacity(self.hierarchy.brick_count());
        let mut values = 0u64;
        for (level, description) in self.hierarchy.levels().iter().enumerate() {
            let mut start = 0u64;
            for cells in description.bricks() {
                let places = component.centering.values_of(cells);
                let end = start.saturating_add(places.cells());
                bricks.push(Rows { level, rows: start..end, size: places.size().map(|values| values as usize) });
                start = end;
            }
            if let Some(set) = &sets[level] {
                check_shape(set, start, component.components)?;
            }
            values = start.saturating_add(values);
        }
        let store = Store::new::<T>(values, &self.options)?;
        read_each(&bricks, progress, |rows| {
            let (Some(set), Some(storage)) = (&sets[rows.level], &storages[rows.level]) else {
                return Err(required(&self.hdf5.root()?, GROUP)?.malformed(&format!("no array {}", component.array)));
            };
            let values = self.values::<T>(set, storage, rows, component, &store)?;
            match &flags[rows.level] {
                Some(flags) => {
                    check_shape(flags, rows.rows.end, 1)?;
                    let flags: Vec<f32> = flags.read(std::slice::from_ref(&rows.rows))?;
                    let flags: Vec<u8> = flags.into_iter().map(|flag| flag as u8).collect();
                    arrays::without_hidden(values, &flags, component.centering, &store)
                }
                None => Ok(values),
            }
        })
    }
}

impl VtkhdfFile {
    /// The values of a brick: mapped where they are if they are stored in one piece and as this machine has them.
    fn values<T: StoredVoxel>(
        &self,
        set: &Hdf5Set,
        storage: &Storage,
        brick: &Rows,
        component: &Component,
        store: &Store,
    ) -> Result<BrickValues<T>, FormatError> {
        // All rows are in the data set, which fits the file: no product overflows.
        let Rows { rows, size, .. } = brick;
        let [step, first] = [component.components, component.component].map(|number| number as usize);
        match storage {
            Storage::Contiguous(bytes) if set.is_native() && set.voxel_type()?.bytes() == size_of::<T>() => {
                let buffer = ValueBuffer::mapped(Arc::clone(self.hdf5.map()));
                let offset = bytes.start + (rows.start as usize * step + first) * size_of::<T>();
                BrickValues::new(buffer, offset, contiguous_strides(*size).map(|stride| stride * step), *size)
                    .map_err(|error| set.malformed(&error.to_string()))
            }
            _ => {
                let ranges = [rows.clone(), component.component..component.component + 1];
                store.keep(set.read::<T>(&ranges[..set.shape().len()])?, *size)
            }
        }
    }
}

/// An array has a row for each value, and as many columns as components.
fn check_shape(set: &Hdf5Set, values: u64, components: u64) -> Result<(), FormatError> {
    let fits = match *set.shape() {
        [rows] => rows >= values && components == 1,
        [rows, columns] => rows >= values && columns == components,
        _ => false,
    };
    match fits {
        true => Ok(()),
        false => {
            let shape = set.shape();
            Err(set.malformed(&format!("shape {shape:?}, expected {values} values of {components} components")))
        }
    }
}

impl DataSet for VtkhdfFile {
    fn format(&self) -> &'static str {
        "VTKHDF AMR"
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
        stored_bricks::read_field(self, self.hdf5.path(), self.components[field].centering, field, progress)
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
