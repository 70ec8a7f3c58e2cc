//! ImageData (`.vti`): a regular grid with arrays in its cells and at its points.

use std::path::Path;
use std::sync::Arc;

use amray::hierarchy::{BrickValues, Centering, ValueBuffer, Voxel, contiguous_strides};
use amray_encoding::shown;
use amray_encoding::vtk::{ArrayLocation, DataArray, Document, Element, VtkError};
use memmap2::Mmap;

use super::arrays::{self, Component, StatedArray, section};
use crate::FormatError;
use crate::number::{self, ByteOrder};
use crate::store::Store;

/// The type of data, as the file has it.
const KIND: &str = "ImageData";
const AXES: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// An image whose arrays have not been decoded.
#[derive(Debug)]
pub(crate) struct Image<'a> {
    path: &'a Path,
    document: Document<'a>,
    grid: Grid,
}

/// What an image says of its one piece.
#[derive(Debug)]
struct Grid {
    /// Along x, y and z, at least one each.
    cells: [u64; 3],
    /// The low corner of the first cell.
    corner: [f64; 3],
    spacing: [f64; 3],
    arrays: Vec<ImageArray>,
}

/// An array of an image.
#[derive(Clone, Debug)]
pub(crate) struct ImageArray {
    pub(crate) centering: Centering,
    /// Whether the file names it as the scalars to show.
    pub(crate) is_active: bool,
    pub(crate) array: DataArray,
}

impl ImageArray {
    /// Whether it holds VTK's flags of cells or points, and no data.
    pub(crate) fn is_flags(&self) -> bool {
        self.array.name == arrays::FLAGS
    }
}

impl<'a> Image<'a> {
    /// Whether a file that begins so holds an image.
    pub(crate) fn recognises(beginning: &[u8]) -> bool {
        Document::kind_of(beginning).is_some_and(|kind| kind == KIND)
    }

    /// Reads all but the values.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the file is damaged, or holds what is no grid of one piece along x, y and z.
    pub(crate) fn parse(path: &'a Path, bytes: &'a [u8]) -> Result<Self, FormatError> {
        let document = Document::parse(bytes).map_err(at(path))?;
        let grid = Grid::of(&document).map_err(at(path))?;
        Ok(Self { path, document, grid })
    }

    /// Values along x, y and z: one for each cell, or for each point.
    pub(crate) fn size(&self, centering: Centering) -> [u64; 3] {
        match centering {
            Centering::Cells => self.grid.cells,
            Centering::Nodes => self.grid.cells.map(|cells| cells.saturating_add(1)),
        }
    }

    /// The position of the first cell's low corner, which is the first point.
    pub(crate) fn corner(&self) -> [f64; 3] {
        self.grid.corner
    }

    /// The distance between points.
    pub(crate) fn spacing(&self) -> [f64; 3] {
        self.grid.spacing
    }

    /// All arrays of numbers, those in cells first.
    pub(crate) fn arrays(&self) -> &[ImageArray] {
        &self.grid.arrays
    }

    /// The byte order of its binary arrays.
    pub(crate) fn byte_order(&self) -> ByteOrder {
        self.document.byte_order()
    }

    /// Where in the file an array is.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is not in one place.
    pub(crate) fn location(&self, array: &DataArray) -> Result<ArrayLocation, FormatError> {
        array.location(&self.document).map_err(|problem| self.error(&array.name, problem))
    }

    /// The arrays that may be fields.
    pub(super) fn stated(&self) -> impl Iterator<Item = StatedArray<'_>> {
        self.grid.arrays.iter().map(|ImageArray { centering, array, .. }| StatedArray {
            name: &array.name,
            centering: *centering,
            components: array.components,
            voxel_type: number::voxel_type(array.number),
        })
    }

    /// The values of one component of an array: where they are if they are stored as this machine has them, else in the
    /// `store`. `map` is of the file.
    ///
    /// # Errors
    /// [`FormatError`] where there is no such array or it is damaged.
    pub(super) fn values<T: Voxel>(
        &self,
        map: &Arc<Mmap>,
        Component { array: name, centering, components, component }: &Component,
        store: &Store,
    ) -> Result<BrickValues<T>, FormatError> {
        let wrong = |problem: String| self.error(name, problem);
        let array = self.find(name, *centering).ok_or_else(|| wrong("there is no such array".into()))?;
        if array.components != *components {
            return Err(wrong(format!("{} components, expected {components} as elsewhere", array.components)));
        }
        let size = self.size(*centering);
        let count = count(size);
        let all = count.saturating_mul(u128::from(*components));
        let [step, first] = [*components, *component].map(|number| number as usize);
        let in_place = match array.number.bytes() == size_of::<T>() && number::is_float(array.number) {
            true => array.in_place(&self.document, all).map_err(wrong)?,
            false => None,
        };
        // What is in place, or has been read, fits this machine's memory.
        let values = match in_place {
            Some(bytes) => {
                let size = size.map(|values| values as usize);
                let stride = contiguous_strides(size).map(|stride| stride * step);
                let buffer = ValueBuffer::mapped(Arc::clone(map));
                BrickValues::new(buffer, bytes.start + first * size_of::<T>(), stride, size)
                    .map_err(|error| wrong(error.to_string()))?
            }
            None => {
                let mut values: Vec<T> = array.values(&self.document, all, T::from_f64).map_err(wrong)?;
                if step > 1 {
                    values = values.into_iter().skip(first).step_by(step).collect();
                }
                store.keep(values, size.map(|values| values as usize))?
            }
        };
        match self.find(arrays::FLAGS, *centering) {
            Some(flags) => {
                let flags = flags.values(&self.document, count, |flag| flag as u8);
                let flags = flags.map_err(|problem| self.error(arrays::FLAGS, problem))?;
                arrays::without_hidden(values, &flags, *centering, store)
            }
            None => Ok(values),
        }
    }

    fn find(&self, name: &str, centering: Centering) -> Option<&DataArray> {
        let is = |array: &&ImageArray| array.centering == centering && array.array.name == name;
        self.grid.arrays.iter().find(is).map(|found| &found.array)
    }

    /// An error at an array.
    fn error(&self, array: &str, problem: String) -> FormatError {
        FormatError::malformed(self.path, format!("array {}", shown(array)), problem)
    }
}

impl Grid {
    fn of(document: &Document<'_>) -> Result<Self, VtkError> {
        let image = document.data(KIND)?;
        if let Some(direction) = image.numbers::<f64, 9>("Direction")?.filter(|direction| *direction != AXES) {
            return Err(image.error(format!("Direction is {direction:?}, expected axes along x, y and z")));
        }
        let mut pieces = image.children_named("Piece");
        let (Some(piece), None) = (pieces.next(), pieces.next()) else {
            let count = image.children_named("Piece").count();
            return Err(image.error(format!("{count} pieces, expected 1")));
        };
        let extent = |element: &Element, name| element.numbers::<i64, 6>(name);
        let extent = extent(piece, "Extent")?.or(extent(image, "WholeExtent")?);
        let [left, right, front, back, bottom, top] =
            extent.ok_or_else(|| piece.error("there is no Extent, expected six numbers"))?;
        let lengths = [(left, right), (front, back), (bottom, top)]
            .map(|(low, high)| high.checked_sub(low).and_then(|cells| u64::try_from(cells).ok()).unwrap_or(0));
        if lengths.contains(&0) {
            let extent = piece.attribute("Extent").unwrap_or_default();
            return Err(piece.error(format!("Extent is {}, expected a cell or more along each axis", shown(extent))));
        }
        let spacing = image.numbers("Spacing")?.unwrap_or([1.0; 3]);
        let origin = image.numbers("Origin")?.unwrap_or([0.0; 3]);
        let low = [left, front, bottom];
        let corner = [0, 1, 2].map(|axis| origin[axis] + low[axis] as f64 * spacing[axis]);
        let mut arrays = Vec::new();
        for centering in [Centering::Cells, Centering::Nodes] {
            for data in piece.children_named(section(centering)) {
                for element in data.children() {
                    arrays.extend(DataArray::of(element, document)?.map(|array| {
                        let is_active = data.attribute("Scalars") == Some(&array.name);
                        ImageArray { centering, is_active, array }
                    }));
                }
            }
        }
        Ok(Self { cells: lengths, corner, spacing, arrays })
    }
}

/// The number of values of a size.
fn count(size: [u64; 3]) -> u128 {
    size.iter().fold(1, |count: u128, &length| count.saturating_mul(length.into()))
}

/// Errors of a file at `path`, for `map_err`.
pub(super) fn at(path: &Path) -> impl Fn(VtkError) -> FormatError {
    |VtkError { place, problem }| FormatError::malformed(path, place, problem)
}
