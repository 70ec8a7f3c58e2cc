//! AMReX plotfiles: a directory with a text file `Header`, and per level a text file `Cell_H` and files of values.
//!
//! The format is what AMReX's `WriteMultiLevelPlotfile` and `VisMF::Write` write (AMReX documentation, *I/O*).
//! Particles and face- or node-centred data, which lie in directories of their own, are left alone.

// A path such as `Scanner::number` fixes the scanner's lifetime, where `LineReader::parse` needs any.
#![allow(clippy::redundant_closure_for_method_calls)]

mod fab;
mod header;
mod multifab;
mod real_format;
mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, Hierarchy, HierarchyError, LevelDescription};
use rayon::prelude::*;

use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel};
use crate::{DataSet, FieldInfo, FormatError, OpenOptions, Summary};
use fab::{DataFile, Fab};
use header::{Coordinates, Header};
use multifab::MultiFab;

/// An AMReX plotfile. Opening it reads its text files and the headers of its FABs, and maps its files of values.
#[derive(Debug)]
pub struct AmrexPlotfile {
    summary: Summary,
    fabs: Vec<Fab>,
    options: OpenOptions,
}

impl AmrexPlotfile {
    /// Whether `path` is a plotfile's directory, its file `Header` or a file of a level (`Cell_H`, `Cell_D_00000`), by
    /// what the `Header` holds. A plotfile of one or two dimensions is one too, although [`AmrexPlotfile::open`] refuses it.
    pub fn recognises(path: &Path) -> bool {
        header_path(path).is_some_and(|path| header::recognises(&path))
    }

    /// Opens the plotfile at `path`: its directory, its file `Header`, or a level's `Cell_H` or `Cell_D_00000`.
    ///
    /// # Errors
    /// [`FormatError::Unrecognised`] where there is no `Header`; otherwise what is wrong with which file, line, level
    /// and brick. A FAB that reaches past the end of its file is found here.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        let header_path = header_path(path).ok_or_else(|| FormatError::Unrecognised {
            path: path.into(),
            found: "neither a directory with a file Header nor a file of a plotfile".into(),
            expected: "an AMReX plotfile".into(),
        })?;
        let directory = header_path.parent().unwrap_or(Path::new(""));
        let header = Header::read(&header_path, options)?;
        let multifabs: Vec<MultiFab> = header
            .levels
            .iter()
            .map(|level| MultiFab::read(&directory.join(&level.multifab), header.fields.len(), level.grids))
            .collect::<Result<_, _>>()?;
        let hierarchy = hierarchy(&header, &multifabs).map_err(FormatError::hierarchy(path))?;

        let mut fabs = Vec::with_capacity(hierarchy.brick_count());
        for (level, multifab) in multifabs.iter().enumerate() {
            fabs.extend(locate_fabs(level, multifab)?);
        }
        let voxel_type = fabs[0].voxel_type();
        let fields =
            header.fields.iter().map(|name| FieldInfo { name: name.clone(), voxel_type, unit: None }).collect();
        if let Some((brick, fab)) = hierarchy.bricks().zip(&fabs).find(|(_, fab)| fab.voxel_type() != voxel_type) {
            let place = format!("level {}, brick {}", brick.level, brick.number);
            let (found, expected) = (fab.voxel_type().bytes(), voxel_type.bytes());
            let problem = format!("values of {found} bytes, expected {expected}, as in the first brick");
            return Err(FormatError::malformed(path, place, problem));
        }
        let warnings = warning(header.coordinates).into_iter().collect();
        let summary = Summary {
            format: "AMReX plotfile",
            path: path.into(),
            time: Some(header.time),
            hierarchy: Arc::new(hierarchy),
            fields,
            warnings,
        };
        Ok(Self { summary, fabs, options: *options })
    }
}

impl StoredBricks for AmrexPlotfile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let store = Store::new::<T>(self.hierarchy().cells(), &self.options)?;
        stored_bricks::read_each(&self.fabs, progress, |fab| fab.values(field, &store))
    }
}

impl DataSet for AmrexPlotfile {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, Centering::Cells, field, progress)
    }
}

/// The file `Header` of the directory `path`, or `path` itself where it is such a file, or the one of the plotfile that
/// the file `path` of a level belongs to.
fn header_path(path: &Path) -> Option<PathBuf> {
    let header = match path.is_dir() {
        true => path.join("Header"),
        false if path.file_name()? == "Header" => path.to_path_buf(),
        false => plotfile_of(path)?.join("Header"),
    };
    header.is_file().then_some(header)
}

/// The plotfile that a file such as `Level_0/Cell_H` or `Level_0/Cell_D_00000` would lie in.
fn plotfile_of(path: &Path) -> Option<PathBuf> {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    // The directories of a bare name are those that it is looked up in.
    let path = std::path::absolute(path).ok()?;
    let (name, level) = (path.file_name()?.to_str()?, path.parent()?);
    let is_value = name == "Cell_H" || name.strip_prefix("Cell_D_").is_some_and(is_number);
    let is_level = level.file_name()?.to_str()?.strip_prefix("Level_").is_some_and(is_number);
    (path.is_file() && is_value && is_level).then(|| level.parent().map(Path::to_path_buf)).flatten()
}

fn hierarchy(header: &Header, multifabs: &[MultiFab]) -> Result<Hierarchy, HierarchyError> {
    let describe = |(level, multifab): (&header::HeaderLevel, &MultiFab)| LevelDescription {
        ratio: level.ratio,
        cell_size: level.cell_size,
        domain: level.domain,
        bricks: multifab.boxes.clone(),
    };
    Hierarchy::new(header.origin, header.levels.iter().zip(multifabs).map(describe).collect())
}

/// Finds the values of a level's bricks, which are known to hold cells. The headers of FABs are read in parallel:
/// each lies on another page of its file.
fn locate_fabs(level: usize, multifab: &MultiFab) -> Result<Vec<Fab>, FormatError> {
    let files: Vec<DataFile> = multifab.files.iter().map(|path| DataFile::open(path)).collect::<Result<_, _>>()?;
    let located: Vec<Result<Fab, FormatError>> = multifab
        .boxes
        .par_iter()
        .zip(&multifab.fabs)
        .enumerate()
        .map(|(brick, (&cells, &place))| {
            let file = &files[place.file];
            Fab::locate(file, place, cells, multifab).map_err(|problem| {
                FormatError::malformed(file.path(), format!("level {level}, brick {brick}"), problem)
            })
        })
        .collect();
    // One after the other, so that the first damaged brick is reported and not any one.
    let fabs: Vec<Fab> = located.into_iter().collect::<Result<_, _>>()?;
    let mut taken = vec![0; files.len()];
    for (fab, place) in fabs.iter().zip(&multifab.fabs) {
        taken[place.file] += u128::from(fab.bytes());
    }
    // Converted copies of FABs that share their bytes could need far more memory than the files have.
    if let Some((file, taken)) = files.iter().zip(taken).find(|(file, taken)| *taken > u128::from(file.bytes())) {
        let problem = format!("the FABs take {taken} bytes, expected at most the file's {}", file.bytes());
        return Err(FormatError::malformed(file.path(), format!("level {level}"), problem));
    }
    Ok(fabs)
}

fn warning(coordinates: Coordinates) -> Option<String> {
    let kind = match coordinates {
        Coordinates::Cartesian => return None,
        Coordinates::Cylindrical => "cylindrical",
        Coordinates::Spherical => "spherical",
    };
    Some(format!("the coordinates are {kind}, but are shown as if they were Cartesian"))
}

#[cfg(test)]
mod tests;
