//! The values of one brick (a FAB): where its file holds them, and as what numbers.
//!
//! `FAB`, the number format, the box (ghost cells included) and the number of components are a line of text (from
//! version 2 of `Cell_H` on there is none); then the components one after the other, each x fastest.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use amray::hierarchy::{BrickValues, IndexBox, ValueBuffer, VoxelType, contiguous_strides};
use memmap2::Mmap;

use super::multifab::{FabOnDisk, MultiFab};
use super::real_format::{REAL_FORMAT, RealFormat};
use super::text::{INDEX_BOX, Scanner, shown};
use crate::store::Store;
use crate::stored_bricks::StoredVoxel;
use crate::{FormatError, mapped_file};

/// No FAB header is longer than this.
const LONGEST_HEADER: usize = 1024;

/// A file that holds FABs, mapped into memory.
#[derive(Clone, Debug)]
pub(super) struct DataFile {
    path: PathBuf,
    map: Arc<Mmap>,
}

/// One brick's values, all of which lie inside their file.
#[derive(Clone, Debug)]
pub(super) struct Fab {
    map: Arc<Mmap>,
    /// The place of the first component's first value.
    start: usize,
    /// The cells that are stored, ghost cells included.
    stored: IndexBox,
    /// The brick.
    cells: IndexBox,
    components: u32,
    format: RealFormat,
}

/// What comes before the values.
#[derive(Debug, PartialEq)]
struct FabHeader {
    format: RealFormat,
    stored: IndexBox,
    components: u32,
    /// Its own length.
    bytes: usize,
}

impl DataFile {
    pub(super) fn open(path: &Path) -> Result<Self, FormatError> {
        Ok(Self { path: path.into(), map: mapped_file::map(path)? })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The file's length.
    pub(super) fn bytes(&self) -> u64 {
        self.map.len() as u64
    }
}

impl Fab {
    /// Finds the values of the brick `cells`.
    ///
    /// # Errors
    /// What is wrong with the FAB, in words.
    pub(super) fn locate(
        file: &DataFile,
        place: FabOnDisk,
        cells: IndexBox,
        multifab: &MultiFab,
    ) -> Result<Self, String> {
        let available = file.map.len();
        let offset = usize::try_from(place.offset).ok().filter(|&offset| offset < available).ok_or_else(|| {
            format!("the FAB starts at byte {}, expected a place inside the file's {available} bytes", place.offset)
        })?;
        let header = match multifab.format {
            Some(format) => {
                let stored = cells.grown(multifab.ghosts);
                FabHeader { format, stored, components: multifab.components, bytes: 0 }
            }
            None => FabHeader::parse(&file.map[offset..])?,
        };
        if !header.stored.contains_box(&cells) {
            return Err(format!("the FAB's box is {}, expected one that contains {cells}", header.stored));
        }
        if header.components != multifab.components {
            let expected = multifab.components;
            return Err(format!("the FAB has {} components, expected {expected}, as in Cell_H", header.components));
        }
        let values = u128::from(header.stored.cells()) * u128::from(header.components);
        let needed = header.bytes as u128 + values * header.format.voxel_type.bytes() as u128;
        if needed > (available - offset) as u128 {
            return Err(format!("the FAB takes {needed} bytes from byte {offset} on, but the file has {available}"));
        }
        let FabHeader { format, stored, components, bytes } = header;
        Ok(Self { map: file.map.clone(), start: offset + bytes, stored, cells, components, format })
    }

    /// The bytes of all values.
    pub(super) fn bytes(&self) -> u64 {
        self.stored.cells() * u64::from(self.components) * self.format.voxel_type.bytes() as u64
    }

    /// Single or double precision.
    pub(super) fn voxel_type(&self) -> VoxelType {
        self.format.voxel_type
    }

    /// One component of the brick without its ghost cells: in place where this machine can read the numbers as they
    /// are, else a converted copy. `T` must be the type that [`Fab::voxel_type`] says.
    ///
    /// # Errors
    /// [`FormatError::Io`] where a copy finds no room in the `store`.
    ///
    /// # Panics
    /// Where there is no such component.
    pub(super) fn values<T: StoredVoxel>(
        &self,
        component: usize,
        store: &Store,
    ) -> Result<BrickValues<T>, FormatError> {
        let stored_size = self.stored.size().map(|cells| cells as usize);
        let size = self.cells.size().map(|cells| cells as usize);
        let stride = contiguous_strides(stored_size);
        let first: usize =
            (0..3).map(|axis| (self.cells.low[axis] - self.stored.low[axis]) as usize * stride[axis]).sum();
        let component_values: usize = stored_size.iter().product();
        let offset = self.start + (component * component_values + first) * size_of::<T>();
        let in_place = BrickValues::<T>::new(ValueBuffer::mapped(self.map.clone()), offset, stride, size);
        let in_place = in_place.expect("`locate` found all components inside the file");
        if self.format.byte_order.is_native() {
            return Ok(in_place);
        }
        let mut values = Vec::with_capacity(size.iter().product());
        in_place.for_each([0; 3], size, |value| values.push(value.swap_bytes()));
        store.keep(values, size)
    }
}

impl FabHeader {
    /// The header at the start of `bytes`; what is wrong with it, in words, where it is none.
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let longest = &bytes[..bytes.len().min(LONGEST_HEADER)];
        let length = longest.iter().position(|&byte| byte == b'\n').unwrap_or(longest.len());
        let line = &longest[..length];
        let malformed = |expected: &str| format!("the FAB's header is {}, expected {expected}", shown(line));
        let text = String::from_utf8_lossy(line);
        let mut text = Scanner(&text);
        text.symbol("FAB").ok_or_else(|| malformed("FAB and a number format"))?;
        let format = RealFormat::scan(&mut text).ok_or_else(|| malformed(REAL_FORMAT))?;
        let stored = text.index_box().ok_or_else(|| malformed(INDEX_BOX))?;
        let components = text.number().ok_or_else(|| malformed("a number of components"))?;
        Ok(Self { format, stored, components, bytes: length + 1 })
    }
}

#[cfg(test)]
mod tests {
    use super::super::real_format::ByteOrder;
    use super::*;

    const DOUBLE: &str = "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))";

    #[test]
    fn headers_say_format_box_and_components() {
        let line = format!("FAB {DOUBLE}((-1,0,2) (6,7,9) (0,0,0)) 3\n");
        let expected = FabHeader {
            format: RealFormat { voxel_type: VoxelType::F64, byte_order: ByteOrder::Little },
            stored: IndexBox::new([-1, 0, 2], [7, 8, 10]),
            components: 3,
            bytes: line.len(),
        };
        let mut bytes = line.into_bytes();
        bytes.extend([0, 255, 10]);
        assert_eq!(FabHeader::parse(&bytes), Ok(expected));
    }

    #[test]
    fn broken_headers_are_shown() {
        let error = |text: &str| FabHeader::parse(text.as_bytes()).unwrap_err();
        assert_eq!(error("\u{1}\u{2}\n"), "the FAB's header is \"\\u{1}\\u{2}\", expected FAB and a number format");
        assert_eq!(error("FAB: 8 64 0\n"), format!("the FAB's header is \"FAB: 8 64 0\", expected {REAL_FORMAT}"));
        assert!(error(&format!("FAB {DOUBLE}((0,0) (7,7) (0,0)) 1\n")).ends_with(&format!("expected {INDEX_BOX}")));
        assert!(error(&format!("FAB {DOUBLE}((0,0,0) (7,7,7) (0,0,0)) -1")).ends_with("a number of components"));
        assert!(error(&"x".repeat(5000)).len() < 200);
    }
}
