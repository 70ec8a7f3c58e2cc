//! RAMSES outputs: a directory of an info file, and for each process a file of its mesh and one of its values.
//!
//! The format is described in RAMSES' documentation and by its own output routines. Grids of 2x2x2 cells are joined to
//! bricks as they are read. Coarse cells under finer ones are stored.

mod amr;
mod bricks;
mod descriptor;
mod files;
mod fortran;
mod hydro;
mod info;
mod levels;

use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, VoxelType};
use rayon::prelude::*;

use crate::mapped_file::start_of;
use crate::number::NumberType;
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions, Summary};
use amr::Mesh;
use bricks::Brick;
pub(crate) use files::OutputFiles;
use hydro::HydroFile;
use info::Info;
use levels::{GRID, Levels};

/// Far more than the names of any run's variables.
const LONGEST_DESCRIPTOR: u64 = 1 << 20;

/// A RAMSES output.
pub(crate) struct RamsesOutput {
    summary: Summary,
    /// In the order of the hierarchy's bricks, each with its level among those of grids.
    bricks: Vec<(usize, Brick)>,
    /// One for each process.
    values: Vec<HydroFile>,
    options: OpenOptions,
}

impl RamsesOutput {
    /// Reads the mesh, and finds the values.
    ///
    /// # Errors
    /// [`FormatError`] where a file is missing or damaged, or the data have fewer than three dimensions.
    pub(crate) fn open(files: &OutputFiles, options: &OpenOptions) -> Result<Self, FormatError> {
        let path = files.info();
        let info = Info::read(&path)?;
        let (meshes, values) = read_all(files, &info)?;
        let levels = Levels::new(meshes, info.level_min).ok_or_else(|| {
            FormatError::malformed(&path, "level 1", "no grid in any file, expected one in each coarse cell")
        })?;
        let (root, first_level) = (levels.root(info.box_length), levels.first);
        let count = options.level_count(&path, levels.count())?;
        let bricks = levels.bricks(count).map_err(|(level, place)| {
            FormatError::malformed(&path, format!("level {level}"), format!("several grids are at {place:?}"))
        })?;
        let boxes = bricks.iter().map(|(level, cells, _)| (*level, *cells));
        let hierarchy = Arc::new(root.hierarchy(count, boxes).map_err(FormatError::hierarchy(&path))?);
        let bricks = bricks.into_iter().map(|(level, _, brick)| (first_level + level, brick)).collect();
        let (time, fields, warnings) = (Some(info.time), Vec::new(), Vec::new());
        let summary = Summary { format: "RAMSES", path, time, hierarchy, fields, warnings };
        let mut output = Self { summary, bricks, values, options: *options };
        output.find_fields(files, &info)?;
        Ok(output)
    }

    fn find_fields(&mut self, files: &OutputFiles, info: &Info) -> Result<(), FormatError> {
        let count = self.values[0].variables;
        if let Some(cpu) = self.values.iter().position(|values| values.variables != count) {
            let problem = format!("{}, expected {count} as in other files", self.values[cpu].variables);
            return Err(FormatError::malformed(&files.hydro(cpu), "nvar", problem));
        }
        let single = self.values.iter().filter_map(|values| values.number).all(|number| number == NumberType::F32);
        let voxel_type = if single { VoxelType::F32 } else { VoxelType::F64 };
        let descriptor = files.hydro_descriptor();
        let text = if descriptor.is_file() {
            String::from_utf8_lossy(&start_of(&descriptor, LONGEST_DESCRIPTOR)?).into_owned()
        } else {
            let name = descriptor.file_name().unwrap_or_default().to_string_lossy();
            self.summary.warnings.push(format!("no {name}: the variables' names are not known"));
            String::new()
        };
        let unit = |name: &str| info.units.as_ref().and_then(|units| units.of_variable(name));
        let field = |name: String| FieldInfo { unit: unit(&name), name, voxel_type };
        self.summary.fields = descriptor::names(&text, count).into_iter().map(field).collect();
        Ok(())
    }
}

/// Reads the files of all processes.
fn read_all(files: &OutputFiles, info: &Info) -> Result<(Vec<Mesh>, Vec<HydroFile>), FormatError> {
    let read = |cpu| {
        let path = files.amr(cpu);
        let mesh = Mesh::read(&path, cpu)?;
        if mesh.header.cpus != info.cpus {
            let problem = format!("{}, expected {} by the info file", mesh.header.cpus, info.cpus);
            return Err(FormatError::malformed(&path, "ncpu", problem));
        }
        let values = HydroFile::open(&files.hydro(cpu), cpu, &mesh)?;
        Ok((mesh, values))
    };
    let all: Vec<(Mesh, HydroFile)> = (0..info.cpus).into_par_iter().map(read).collect::<Result<_, _>>()?;
    let (meshes, values): (Vec<Mesh>, Vec<HydroFile>) = all.into_iter().unzip();
    if let Some(cpu) = meshes.iter().position(|mesh| mesh.header != meshes[0].header) {
        let problem = format!("{:?}, expected {:?} as in other files", meshes[cpu].header, meshes[0].header);
        return Err(FormatError::malformed(&files.amr(cpu), "the header", problem));
    }
    Ok((meshes, values))
}

impl StoredBricks for RamsesOutput {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        self.values.par_iter().try_for_each(|values| values.check(field))?;
        let store = Store::new::<T>(self.hierarchy().cells(), &self.options)?;
        stored_bricks::read_each(&self.bricks, progress, |(level, brick)| {
            let size = brick.grids.size().map(|grids| (grids * GRID) as usize);
            let mut values = vec![T::from_f64(0.0); size.iter().product()];
            for (place, source) in brick.grids.iter().zip(&brick.sources) {
                let corner: [usize; 3] =
                    std::array::from_fn(|axis| ((place[axis] - brick.grids.low[axis]) * GRID) as usize);
                let file = &self.values[source.cpu as usize];
                for cell in 0..hydro::CELLS {
                    let [x, y, z] = [corner[0] + (cell & 1), corner[1] + (cell >> 1 & 1), corner[2] + (cell >> 2)];
                    let value = file.value(*level, source.grid as usize, field, cell);
                    values[x + size[0] * (y + size[1] * z)] = T::from_f64(value);
                }
            }
            store.keep(values, size)
        })
    }
}

impl DataSet for RamsesOutput {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, Centering::Cells, field, progress)
    }
}
