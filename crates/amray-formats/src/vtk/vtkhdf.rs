//! AMR data in one HDF5 file: VTKHDF of type OverlappingAMR (`.vtkhdf`).
//!
//! A level has its boxes and, per array, the values of all of them, one box after the other, x fastest.

use std::ops::Range;
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, Hierarchy, IndexBox, ValueBuffer, Voxel, contiguous_strides};

use super::arrays::{self, Component, FLAGS, StatedArray, section};
use super::geometry::{self, StatedLevel, index_box};
use crate::hdf5::{Hdf5, Hdf5Group, Hdf5Set, Parts, Storage};
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::structured::is_spacing;
use crate::{DataSet, FieldInfo, FormatError, OpenOptions, Summary};

/// The group that all of VTK's data are in.
pub(super) const GROUP: &str = "VTKHDF";
pub(super) const KIND: &str = "OverlappingAMR";

/// An OverlappingAMR in VTKHDF.
pub struct VtkhdfFile {
    summary: Summary,
    hdf5: Hdf5,
    components: Vec<Component>,
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
        let (path, hierarchy) = (hdf5.path().into(), Arc::new(hierarchy));
        let summary = Summary { format: "VTKHDF AMR", path, time, hierarchy, fields, warnings };
        Ok(Self { summary, hdf5, components, options: *options })
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

/// An attribute of three numbers.
fn three(group: &Hdf5Group, name: &str) -> Result<Option<[f64; 3]>, FormatError> {
    let Some(numbers) = group.float_list(name)? else { return Ok(None) };
    let wrong = |numbers: Vec<f64>| group.malformed(&format!("{name} is {} numbers, expected 3", numbers.len()));
    numbers.try_into().map(Some).map_err(wrong)
}

fn stated_level(level: &Hdf5Group) -> Result<StatedLevel, FormatError> {
    let spacing = three(level, "Spacing")?.filter(is_spacing);
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

/// The values of a level's bricks in its arrays: which rows are theirs, and their number along x, y and z.
struct LevelRows {
    rows: Vec<Range<u64>>,
    sizes: Vec<[usize; 3]>,
}

impl LevelRows {
    fn of(bricks: &[IndexBox], centering: Centering) -> Self {
        let (mut rows, mut sizes, mut start) = (Vec::new(), Vec::new(), 0u64);
        for cells in bricks {
            let places = centering.values_of(cells);
            let end = start.saturating_add(places.cells());
            rows.push(start..end);
            sizes.push(places.size().map(|values| values as usize));
            start = end;
        }
        Self { rows, sizes }
    }

    /// The number of values.
    fn count(&self) -> u64 {
        self.rows.last().map_or(0, |rows| rows.end)
    }

    /// Reads a component of an array, where it is no vector the only one.
    fn read<T: Voxel>(
        &self,
        set: &Hdf5Set,
        storage: &Storage,
        component: u64,
        store: &Store,
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let column = (set.shape().len() > 1).then(|| component..component + 1);
        let parts = Parts { leading: Vec::new(), along: self.rows.clone(), inner: column.into_iter().collect() };
        set.read(storage, &parts, &|brick, values| store.keep(values, self.sizes[brick]))
    }
}

impl StoredBricks for VtkhdfFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let component = &self.components[field];
        let levels = self.hierarchy().levels().iter();
        let levels: Vec<LevelRows> = levels.map(|level| LevelRows::of(level.bricks(), component.centering)).collect();
        let store =
            Store::new::<T>(levels.iter().fold(0, |all: u64, rows| all.saturating_add(rows.count())), &self.options)?;
        let mut bricks = Vec::with_capacity(self.hierarchy().brick_count());
        for (level, rows) in levels.iter().enumerate().filter(|(_, rows)| rows.count() > 0) {
            bricks.extend(self.level(level, rows, component, &store)?);
            progress(bricks.len() as f64 / self.hierarchy().brick_count() as f64);
        }
        Ok(bricks)
    }
}

impl VtkhdfFile {
    /// The values of a level's bricks, without hidden ones.
    fn level<T: StoredVoxel>(
        &self,
        level: usize,
        rows: &LevelRows,
        component: &Component,
        store: &Store,
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let vtk = required(&self.hdf5.root()?, GROUP)?;
        let group = required(&required(&vtk, &format!("Level{level}"))?, section(component.centering))?;
        let set = group.data_set(&component.array)?;
        check_shape(&set, rows.count(), component.components)?;
        let values = self.values(&set, rows, component, store)?;
        if !group.member_names()?.iter().any(|name| name == FLAGS) {
            return Ok(values);
        }
        let flags = group.data_set(FLAGS)?;
        check_shape(&flags, rows.count(), 1)?;
        let flags = rows.read::<f32>(&flags, &flags.storage()?, 0, &Store::Memory)?;
        let shown = |(values, flags): (BrickValues<T>, BrickValues<f32>)| {
            let flags: Vec<u8> = flags.to_vec().into_iter().map(|flag| flag as u8).collect();
            arrays::without_hidden(values, &flags, component.centering, store)
        };
        values.into_iter().zip(flags).map(shown).collect()
    }

    /// The values of a level's bricks: mapped where they are if they are stored in one piece and as this machine has them.
    fn values<T: StoredVoxel>(
        &self,
        set: &Hdf5Set,
        rows: &LevelRows,
        component: &Component,
        store: &Store,
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        match set.storage()? {
            Storage::Contiguous(bytes) if set.is_native() && set.voxel_type()?.bytes() == size_of::<T>() => {
                // All rows are in the data set, which fits the file: no product overflows.
                let [step, first] = [component.components, component.component].map(|number| number as usize);
                let buffer = ValueBuffer::mapped(Arc::clone(self.hdf5.map()));
                let mapped = |(rows, &size): (&Range<u64>, &[usize; 3])| {
                    let offset = bytes.start + (rows.start as usize * step + first) * size_of::<T>();
                    let stride = contiguous_strides(size).map(|stride| stride * step);
                    BrickValues::new(buffer.clone(), offset, stride, size)
                        .map_err(|error| set.malformed(&error.to_string()))
                };
                rows.rows.iter().zip(&rows.sizes).map(mapped).collect()
            }
            storage => rows.read(set, &storage, component.component, store),
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
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, self.components[field].centering, field, progress)
    }
}
