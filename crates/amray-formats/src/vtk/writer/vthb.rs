//! Writes vtkOverlappingAMR as VTK's XML writer does: an index, and a directory of images beside it, one for each brick.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use amray::hierarchy::{Brick, Hierarchy, Level, Voxel};
use amray_encoding::vtk::escaped;
use tempfile::TempDir;

use super::images::{Images, Place, numbers};
use crate::output::OutputFile;
use crate::vtk::geometry::extent;
use crate::{AmrContent, FormatError};

/// An index and images that are being written; they take their names when they are finished.
///
/// Values can come from several threads at once and in any order. A brick that is never written holds zeros.
pub struct VthbWriter {
    path: PathBuf,
    index: String,
    images: Images,
    /// Of the bricks, level by level.
    places: Vec<Place>,
    /// The number of each level's first brick.
    first_bricks: Vec<usize>,
    /// Where the images are until they are complete: in a directory of their own in this one.
    temporary: TempDir,
    name: String,
}

impl VthbWriter {
    /// Makes everything but the values.
    ///
    /// The images lie in a directory that has the index's name without its ending. Where there is one, it must hold the
    /// images of such an index and nothing else; they are replaced in the end.
    ///
    /// # Errors
    /// [`FormatError::Io`] where files cannot be written, or others are in their place.
    pub fn create(path: &Path, content: &AmrContent) -> Result<Self, FormatError> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let directory = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        check_replaceable(&path.with_extension(""), &name)?;
        let temporary = tempfile::Builder::new().prefix(".amray-").suffix(".part").tempdir_in(directory);
        let temporary = temporary.map_err(FormatError::io(path, "write"))?;
        let images = Images::of(content);
        // Not the temporary directory itself: that one nobody else may look into.
        let pieces = temporary.path().join(&name);
        let make = |brick: Brick, number: usize| images.create(&pieces.join(image(&name, number)), &brick, content);
        let places = fs::create_dir(&pieces)
            .and_then(|()| content.hierarchy.bricks().enumerate().map(|(number, brick)| make(brick, number)).collect())
            .map_err(FormatError::io(path, "write"))?;
        let first_bricks = content.hierarchy.levels().iter().map(Level::first_brick).collect();
        let index = index(content.hierarchy, &name);
        Ok(Self { path: path.into(), index, images, places, first_bricks, temporary, name })
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
        let number = self.first_bricks[level] + brick;
        let place = self.places[number];
        assert!(first + values.len() <= place.values, "values of level {level}, brick {brick}");
        let path = self.temporary.path().join(&self.name).join(image(&self.name, number));
        self.images.write(&path, place, component, first, values).map_err(FormatError::io(&self.path, "write"))
    }

    /// Gives the images and the index their names.
    ///
    /// # Errors
    /// [`FormatError::Io`] where they cannot be renamed or written.
    pub fn finish(self) -> Result<(), FormatError> {
        let Self { path, index, temporary, name, .. } = self;
        let directory = path.with_extension("");
        check_replaceable(&directory, &name)?;
        let replace = || {
            if directory.exists() {
                fs::remove_dir_all(&directory)?;
            }
            fs::rename(temporary.path().join(&name), &directory)
        };
        replace().map_err(FormatError::io(&directory, "write"))?;
        OutputFile::write(&path, |file| io::Write::write_all(file, index.as_bytes()))
    }
}

/// The name of a brick's image.
fn image(name: &str, number: usize) -> String {
    format!("{name}_{number}.vti")
}

/// Nothing is deleted but the images of an earlier index of this name.
fn check_replaceable(directory: &Path, name: &str) -> Result<(), FormatError> {
    let entries = match fs::read_dir(directory) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(FormatError::io(directory, "write")(error)),
    };
    for entry in entries {
        let file = entry.map_err(FormatError::io(directory, "read"))?.file_name();
        let number = file.to_str().and_then(|file| file.strip_prefix(name)?.strip_prefix('_')?.strip_suffix(".vti"));
        if number.is_none_or(|number| number.is_empty() || !number.bytes().all(|digit| digit.is_ascii_digit())) {
            let problem = format!("{} is in the way: remove it, or choose another name", file.display());
            return Err(FormatError::io(directory, "write images into")(io::Error::other(problem)));
        }
    }
    Ok(())
}

fn index(hierarchy: &Hierarchy, name: &str) -> String {
    let directory = escaped(name);
    let mut index = format!(
        "<?xml version=\"1.0\"?>
<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\">
  <vtkOverlappingAMR origin=\"{}\" grid_description=\"XYZ\">
",
        numbers(hierarchy.origin())
    );
    // Writing to a string cannot fail.
    for (number, level) in hierarchy.levels().iter().enumerate() {
        let _ = writeln!(index, "    <Block level=\"{number}\" spacing=\"{}\">", numbers(level.cell_size()));
        for (place, cells) in level.bricks().iter().enumerate() {
            let cells = extent(cells).map(|index| index.to_string()).join(" ");
            let file = escaped(&image(name, level.first_brick() + place)).into_owned();
            let _ =
                writeln!(index, "      <DataSet index=\"{place}\" amr_box=\"{cells}\" file=\"{directory}/{file}\"/>");
        }
        index.push_str("    </Block>\n");
    }
    index.push_str("  </vtkOverlappingAMR>\n</VTKFile>\n");
    index
}
