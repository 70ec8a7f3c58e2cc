//! One brick as an image: a `.vti` file whose values are appended as they are.

use std::fmt::Write;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write as _};
use std::path::Path;

use amray::hierarchy::{Brick, Voxel, VoxelType, bytes_of};
use amray_encoding::vtk::escaped;

use crate::AmrContent;
use crate::vtk::arrays::section;

/// Bytes of the length in front of each array.
const LENGTH: usize = size_of::<u64>();

/// What all images have in common.
pub(super) struct Images {
    voxel_type: VoxelType,
    components: usize,
}

/// One image's place for values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The first byte of the first array's length.
    start: u64,
    /// In each component.
    pub(super) values: usize,
}

impl Images {
    pub(super) fn of(content: &AmrContent) -> Self {
        Self { voxel_type: content.voxel_type, components: content.components.len() }
    }

    /// Makes an image whose values are all 0.
    pub(super) fn create(&self, path: &Path, brick: &Brick, content: &AmrContent) -> io::Result<Place> {
        let values = content.centering.values_of(&brick.cells).cells() as usize;
        let array = values * self.voxel_type.bytes();
        let head = head(brick, content, array);
        let mut file = File::create_new(path)?;
        file.write_all(head.as_bytes())?;
        let place = Place { start: head.len() as u64, values };
        for component in 0..self.components {
            file.seek(SeekFrom::Start(self.array(place, component)))?;
            file.write_all(&(array as u64).to_le_bytes())?;
        }
        file.seek(SeekFrom::Start(self.array(place, self.components)))?;
        file.write_all(b"\n  </AppendedData>\n</VTKFile>\n")?;
        Ok(place)
    }

    /// Writes values of a component, from the one counted `first` on.
    pub(super) fn write<T: Voxel>(
        &self,
        path: &Path,
        place: Place,
        component: usize,
        first: usize,
        values: &[T],
    ) -> io::Result<()> {
        assert!(component < self.components, "no component {component} among {}", self.components);
        let mut file = File::options().write(true).open(path)?;
        let start = self.array(place, component) + (LENGTH + first * self.voxel_type.bytes()) as u64;
        file.seek(SeekFrom::Start(start))?;
        let numbers = values.iter().map(|value| value.to_f64());
        match self.voxel_type {
            VoxelType::F32 => file.write_all(bytes_of(&numbers.map(f32::from_f64).collect::<Vec<_>>())),
            VoxelType::F64 => file.write_all(bytes_of(&numbers.collect::<Vec<_>>())),
        }
    }

    /// The first byte of a component's length.
    fn array(&self, place: Place, component: usize) -> u64 {
        place.start + (component * (LENGTH + place.values * self.voxel_type.bytes())) as u64
    }
}

/// What is before the values; arrays have `array` bytes each.
fn head(brick: &Brick, content: &AmrContent, array: usize) -> String {
    let width = content.hierarchy.levels()[brick.level].cell_size();
    let origin = content.hierarchy.origin();
    let corner = [0, 1, 2].map(|axis| origin[axis] + brick.cells.low[axis] as f64 * width[axis]);
    let [x, y, z] = brick.cells.size();
    let extent = format!("0 {x} 0 {y} 0 {z}");
    let byte_order = if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };
    let number = match content.voxel_type {
        VoxelType::F32 => "Float32",
        VoxelType::F64 => "Float64",
    };
    let section = section(content.centering);
    let mut arrays = String::new();
    for (component, name) in content.components.iter().enumerate() {
        let (name, offset) = (escaped(name), component * (LENGTH + array));
        // Writing to a string cannot fail.
        let _ = writeln!(
            arrays,
            "        <DataArray type=\"{number}\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>"
        );
    }
    format!(
        "<?xml version=\"1.0\"?>
<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{byte_order}\" header_type=\"UInt64\">
  <ImageData WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\">
    <Piece Extent=\"{extent}\">
      <{section}>
{arrays}      </{section}>
    </Piece>
  </ImageData>
  <AppendedData encoding=\"raw\">
   _",
        numbers(corner),
        numbers(width)
    )
}

/// Three numbers that are read back as they are.
pub(super) fn numbers([x, y, z]: [f64; 3]) -> String {
    format!("{x:?} {y:?} {z:?}")
}
