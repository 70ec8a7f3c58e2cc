//! Writes VTKHDF of type OverlappingAMR: one HDF5 file, values in any order.

use std::path::Path;

use amray::hierarchy::{Level, Voxel};
use rust_hdf5::{H5Group, Hdf5Error};

use crate::hdf5_output::{Hdf5Output, ValueList, failure, set_text};
use crate::vtk::arrays::section;
use crate::vtk::geometry::extent;
use crate::vtk::vtkhdf::{GROUP, KIND};
use crate::{AmrContent, FormatError};

/// The version of the format: OverlappingAMR has been in it since the first.
const VERSION: [i64; 2] = [1, 0];

/// A VTKHDF file that is being written; it takes its name when it is finished.
///
/// Values can come from several threads at once and in any order. A brick that is never written holds zeros.
pub struct VtkhdfWriter {
    levels: Vec<LevelWriter>,
    output: Hdf5Output,
}

struct LevelWriter {
    /// One for each component.
    arrays: Vec<ValueList>,
    /// Where each brick's values start, and where the last one's end.
    offsets: Vec<usize>,
}

impl VtkhdfWriter {
    /// Lays down everything but the values, of which only the place is reserved.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where indices exceed 32 bits or a name is none for HDF5, [`FormatError::Io`] where the
    /// file cannot be written.
    pub fn create(path: &Path, content: &AmrContent) -> Result<Self, FormatError> {
        if let Some(name) = content.components.iter().find(|name| name.contains('/') || ["", "."].contains(name)) {
            let problem = format!("{name:?} is no name in HDF5: expected one without a slash");
            return Err(FormatError::malformed(path, "fields", problem));
        }
        let boxes = content.hierarchy.levels().iter().enumerate().map(|(number, level)| {
            boxes(level).ok_or_else(|| {
                let problem = format!("bricks in {} do not fit VTK's 32-bit indices", level.domain());
                FormatError::malformed(path, format!("level {number}"), problem)
            })
        });
        let boxes = boxes.collect::<Result<Vec<_>, _>>()?;
        let output = Hdf5Output::create(path)?;
        let levels = write(&output.root(), content, &boxes).map_err(failure(path))?;
        Ok(Self { levels, output })
    }

    /// Writes some values of a brick's component, from the one counted `first` on, x fastest, rounded to the file's number
    /// type.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written.
    ///
    /// # Panics
    /// Where there is no such level, brick or component, or not as many values.
    pub fn write<T: Voxel>(
        &self,
        level: usize,
        brick: usize,
        component: usize,
        first: usize,
        values: &[T],
    ) -> Result<(), FormatError> {
        let LevelWriter { arrays, offsets } = &self.levels[level];
        let start = offsets[brick] + first;
        assert!(start + values.len() <= offsets[brick + 1], "values of level {level}, brick {brick}");
        arrays[component].write(start, values).map_err(failure(self.output.path()))
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the file cannot be written or renamed.
    pub fn finish(self) -> Result<(), FormatError> {
        drop(self.levels);
        self.output.finish()
    }
}

/// A level's bricks in 32-bit numbers.
fn boxes(level: &Level) -> Option<Vec<i32>> {
    let numbers = level.bricks().iter().flat_map(extent);
    numbers.map(|index| i32::try_from(index).ok()).collect()
}

fn write(root: &H5Group, content: &AmrContent, boxes: &[Vec<i32>]) -> Result<Vec<LevelWriter>, Hdf5Error> {
    let vtk = root.create_group(GROUP)?;
    vtk.set_attr_array_numeric("Version", &VERSION)?;
    set_text(&vtk, "Type", KIND)?;
    set_text(&vtk, "GridDescription", "XYZ")?;
    vtk.set_attr_array_numeric("Origin", &content.hierarchy.origin())?;
    let levels = content.hierarchy.levels().iter().zip(boxes).enumerate();
    levels.map(|(number, (level, boxes))| write_level(&vtk, number, level, boxes, content)).collect()
}

fn write_level(
    vtk: &H5Group,
    number: usize,
    level: &Level,
    boxes: &[i32],
    content: &AmrContent,
) -> Result<LevelWriter, Hdf5Error> {
    let group = vtk.create_group(&format!("Level{number}"))?;
    group.set_attr_array_numeric("Spacing", &level.cell_size())?;
    let set = group.new_dataset::<i32>().shape([level.bricks().len(), 6]).create("AMRBox")?;
    // Nothing is allocated for an empty data set, and writing to it fails.
    if !boxes.is_empty() {
        set.write_raw(boxes)?;
    }
    let mut offsets = vec![0];
    for brick in level.bricks() {
        offsets.push(offsets[offsets.len() - 1] + content.centering.values_of(brick).cells() as usize);
    }
    let mut arrays = Vec::new();
    for name in ["CellData", "PointData", "FieldData"] {
        let values = group.create_group(name)?;
        if name == section(content.centering) {
            for component in content.components {
                arrays.push(ValueList::create(&values, component, offsets[level.bricks().len()], content.voxel_type)?);
            }
        }
    }
    Ok(LevelWriter { arrays, offsets })
}
