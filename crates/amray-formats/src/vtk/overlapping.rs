//! AMR data as an XML index of images: vtkOverlappingAMR (`.vthb`), its old form vtkHierarchicalBoxDataSet (`.vth`), and
//! vtkNonOverlappingAMR, which keeps leaves alone.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, Field, IndexBox};
use amray_encoding::shown;
use amray_encoding::vtk::{Document, Element};

use super::arrays::{self, Component, StatedArray};
use super::geometry::{self, StatedLevel, index_box};
use super::image::{Image, at};
use crate::mapped_file::{self, start_of};
use crate::relative_path::path_below;
use crate::store::Store;
use crate::stored_bricks::{self, StoredBricks, StoredVoxel, read_each};
use crate::structured::is_spacing;
use crate::{DataSet, FormatError, OpenOptions, Summary};

const KINDS: [&str; 3] = ["vtkOverlappingAMR", "vtkHierarchicalBoxDataSet", LEAVES];
/// Data without coarse cells under finer ones.
const LEAVES: &str = "vtkNonOverlappingAMR";
/// The type of data is told within so many bytes.
const BEGINNING: u64 = 4096;
/// More levels than any data have.
const MOST_LEVELS: usize = 64;
/// How far from a whole number the place of a brick may be, in cells.
const TOLERANCE: f64 = 0.05;

/// AMR data as VTK's XML writers make them.
pub struct VthbFile {
    summary: Summary,
    leaf_only: bool,
    /// The bricks' images, in the order of the hierarchy.
    images: Vec<PathBuf>,
    components: Vec<Component>,
    options: OpenOptions,
}

/// What the index says of a level.
struct ListedLevel {
    spacing: Option<[f64; 3]>,
    bricks: Vec<ListedBrick>,
}

/// What the index says of a brick.
struct ListedBrick {
    cells: Option<IndexBox>,
    image: PathBuf,
}

impl VthbFile {
    /// Whether the file is an index of AMR data.
    ///
    /// # Errors
    /// [`FormatError::Io`] where it cannot be read.
    pub(crate) fn recognises(path: &Path) -> Result<bool, FormatError> {
        Ok(Document::kind_of(&start_of(path, BEGINNING)?).is_some_and(|kind| KINDS.contains(&kind.as_str())))
    }

    /// Opens the index, and an image of it to know the fields.
    ///
    /// # Errors
    /// [`FormatError`] where a file is not there or damaged, or the data have no three dimensions.
    pub fn open(path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        let map = mapped_file::map(path)?;
        let document = Document::parse(&map).map_err(at(path))?;
        let kind = KINDS.into_iter().find(|kind| *kind == document.kind()).unwrap_or(KINDS[0]);
        let index = document.data(kind).map_err(at(path))?;
        if let Some(description) = index.attribute("grid_description").filter(|axes| *axes != "XYZ") {
            let problem = format!("grid_description is {}, expected XYZ (three dimensions)", shown(description));
            return Err(at(path)(index.error(problem)));
        }
        let mut warnings = Vec::new();
        let mut levels = levels(path, index, &mut warnings)?;
        let leaf_only = kind == LEAVES;
        if !leaf_only {
            levels.truncate(options.level_count(path, levels.len())?);
        }
        let origin = index.numbers("origin").map_err(at(path))?;
        let (origin, stated) = placed(path, origin, &levels)?;
        let hierarchy = Arc::new(geometry::hierarchy(path, origin, stated)?);
        let images: Vec<PathBuf> = levels.into_iter().flat_map(|level| level.bricks).map(|brick| brick.image).collect();
        // Coarse levels are made of leaves by means of cells.
        let kept = |array: &StatedArray| !leaf_only || array.centering == Centering::Cells;
        let (fields, components) = match images.first() {
            Some(image) => read_image(image, |image| Ok(arrays::fields(image.stated().filter(kept))))?,
            None => (Vec::new(), Vec::new()),
        };
        let summary = Summary { format: "VTK AMR (XML)", path: path.into(), time: None, hierarchy, fields, warnings };
        Ok(Self { summary, leaf_only, images, components, options: *options })
    }
}

/// The levels that an index lists; bricks that have no file are left out with a warning.
fn levels(path: &Path, index: &Element, warnings: &mut Vec<String>) -> Result<Vec<ListedLevel>, FormatError> {
    let directory = path.parent().unwrap_or(Path::new(""));
    let mut levels: Vec<ListedLevel> = Vec::new();
    for block in index.children_named("Block") {
        let level: usize = block.number("level").map_err(at(path))?.unwrap_or(levels.len());
        if level >= MOST_LEVELS {
            return Err(at(path)(block.error(format!("level is {level}, expected less than {MOST_LEVELS}"))));
        }
        while levels.len() <= level {
            levels.push(ListedLevel { spacing: None, bricks: Vec::new() });
        }
        levels[level].spacing = block.numbers("spacing").map_err(at(path))?.or(levels[level].spacing);
        let mut without = 0;
        for brick in block.children_named("DataSet") {
            let Some(file) = brick.attribute("file") else {
                without += 1;
                continue;
            };
            let below = path_below(file).ok_or_else(|| {
                at(path)(brick.error(format!("file is {}, expected one below the index's directory", shown(file))))
            })?;
            let cells = match brick.numbers("amr_box").map_err(at(path))? {
                Some(corners) => Some(index_box(corners).ok_or_else(|| {
                    let expected = "expected the first and last cell along x, y and z";
                    at(path)(brick.error(format!("amr_box is {corners:?}, {expected}")))
                })?),
                None => None,
            };
            levels[level].bricks.push(ListedBrick { cells, image: directory.join(below) });
        }
        if without > 0 {
            warnings.push(format!("level {level}: {without} bricks have no file and are left out"));
        }
    }
    if levels.is_empty() {
        return Err(at(path)(index.error("there is no element Block in it")));
    }
    Ok(levels)
}

/// The levels, and where cell (0, 0, 0) begins. Old files and those of leaves state neither origin, spacing nor boxes: then
/// the images do.
fn placed(
    path: &Path,
    origin: Option<[f64; 3]>,
    levels: &[ListedLevel],
) -> Result<([f64; 3], Vec<StatedLevel>), FormatError> {
    let mut origin = origin;
    let mut stated = Vec::with_capacity(levels.len());
    for (number, level) in levels.iter().enumerate() {
        let mut spacing = level.spacing;
        let mut bricks = Vec::with_capacity(level.bricks.len());
        for ListedBrick { cells, image } in &level.bricks {
            if let (Some(cells), Some(_), Some(_)) = (cells, spacing, origin) {
                bricks.push(*cells);
                continue;
            }
            let (corner, width, size) =
                read_image(image, |image| Ok((image.corner(), image.spacing(), image.size(Centering::Cells))))?;
            let width = *spacing.get_or_insert(width);
            let low = cells.map_or([0; 3], |cells| cells.low);
            let origin = origin.get_or_insert([0, 1, 2].map(|axis| corner[axis] - low[axis] as f64 * width[axis]));
            bricks.push(match cells {
                Some(cells) => *cells,
                None => cells_at(corner, size, *origin, width).ok_or_else(|| {
                    let problem =
                        format!("the image begins at {corner:?}, expected whole cells of {width:?} from {origin:?} on");
                    FormatError::malformed(image, format!("level {number}"), problem)
                })?,
            });
        }
        let spacing = spacing.filter(is_spacing);
        let spacing = spacing.ok_or_else(|| {
            FormatError::malformed(path, format!("level {number}"), "no spacing, expected three positive numbers")
        })?;
        stated.push(StatedLevel { spacing, bricks });
    }
    Ok((origin.unwrap_or_default(), stated))
}

/// The cells of an image that begins at `corner`.
fn cells_at(corner: [f64; 3], size: [u64; 3], origin: [f64; 3], width: [f64; 3]) -> Option<IndexBox> {
    let mut low = [0; 3];
    let mut last = [0; 3];
    for axis in 0..3 {
        let place = (corner[axis] - origin[axis]) / width[axis];
        if !(place.abs() < 1e15 && (place - place.round()).abs() <= TOLERANCE) {
            return None;
        }
        low[axis] = place.round() as i64;
        last[axis] = low[axis].checked_add(i64::try_from(size[axis]).ok()? - 1)?;
    }
    IndexBox::from_corners(low, last)
}

/// Maps and parses an image.
fn read_image<R>(path: &Path, read: impl FnOnce(&Image<'_>) -> Result<R, FormatError>) -> Result<R, FormatError> {
    read(&Image::parse(path, &mapped_file::map(path)?)?)
}

impl StoredBricks for VthbFile {
    fn bricks<T: StoredVoxel>(
        &self,
        field: usize,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Vec<BrickValues<T>>, FormatError> {
        let component = &self.components[field];
        let bricks: Vec<(&PathBuf, IndexBox)> =
            self.images.iter().zip(self.hierarchy().bricks().map(|brick| brick.cells)).collect();
        let values = bricks.iter().map(|(_, cells)| component.centering.values_of(cells).cells()).sum();
        let store = Store::new::<T>(values, &self.options)?;
        read_each(&bricks, progress, |(path, cells)| {
            let map = mapped_file::map(path)?;
            let image = Image::parse(path, &map)?;
            let (found, expected) = (image.size(Centering::Cells), cells.size().map(i64::cast_unsigned));
            if found != expected {
                let problem = format!("{found:?} cells, expected {expected:?} as {} says", self.summary.path.display());
                return Err(FormatError::malformed(path, "Extent", problem));
            }
            image.values(&map, component, &store)
        })
    }
}

impl DataSet for VthbFile {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn read_field(&self, field: usize, progress: &(dyn Fn(f64) + Sync)) -> Result<Field, FormatError> {
        stored_bricks::read_field(self, self.components[field].centering, field, progress)
    }

    fn leaf_only(&self) -> bool {
        self.leaf_only
    }
}
