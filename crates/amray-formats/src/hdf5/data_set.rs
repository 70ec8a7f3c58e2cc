//! Data sets: where their values lie in the file, small ones whole, large ones box by box.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use amray::hierarchy::VoxelType;
use hdf5_reader::io::Cursor;
use hdf5_reader::messages::HdfMessage;
use hdf5_reader::messages::layout::DataLayout;
use hdf5_reader::{ByteOrder, Dataset, Datatype, H5Type, SliceInfo, SliceInfoElem};

use super::number::{describe, float, integer};
use super::{LARGEST_COMPRESSION, Source, listing};
use crate::FormatError;

/// A data set; its values are still in the file.
pub(crate) struct Hdf5Set {
    source: Arc<Source>,
    place: String,
    set: Dataset,
}

/// How a data set's values are stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    /// In one piece: these bytes of the file.
    Contiguous(Range<usize>),
    /// In the object's header.
    Compact(Vec<u8>),
    /// In chunks of this many elements per axis, perhaps compressed.
    Chunked(Vec<u64>),
}

impl Hdf5Set {
    pub(super) fn new(source: Arc<Source>, place: String, set: Dataset) -> Self {
        Self { source, place, set }
    }

    /// An error at this data set.
    pub(crate) fn malformed(&self, problem: &str) -> FormatError {
        self.source.malformed(&self.place, problem)
    }

    /// Its dimensions, the last one fastest.
    pub(crate) fn shape(&self) -> &[u64] {
        self.set.shape()
    }

    pub(super) fn datatype(&self) -> &Datatype {
        self.set.dtype()
    }

    /// The number of elements of a one-dimensional data set.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it has another number of dimensions.
    pub(crate) fn length(&self) -> Result<u64, FormatError> {
        match self.set.shape() {
            [length] => Ok(*length),
            shape => Err(self.malformed(&format!("{} dimensions, expected 1", shape.len()))),
        }
    }

    /// The floating-point type of the elements.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else.
    pub(crate) fn voxel_type(&self) -> Result<VoxelType, FormatError> {
        match self.set.dtype() {
            Datatype::FloatingPoint { size: 4, .. } => Ok(VoxelType::F32),
            Datatype::FloatingPoint { size: 8, .. } => Ok(VoxelType::F64),
            other => Err(self.malformed(&format!("{}, expected floats of 4 or 8 bytes", describe(other)))),
        }
    }

    /// Whether floats are stored in this machine's byte order.
    pub(crate) fn is_native(&self) -> bool {
        let native = if cfg!(target_endian = "little") { ByteOrder::LittleEndian } else { ByteOrder::BigEndian };
        matches!(self.set.dtype(), Datatype::FloatingPoint { byte_order, .. } if *byte_order == native)
    }

    /// Where the values lie, held against the file's length.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they were never written, lie outside the file, or are more than it can hold.
    pub(crate) fn storage(&self) -> Result<Storage, FormatError> {
        let Source { map, file, .. } = &*self.source;
        let failed = |error| self.source.failed(&self.place, &error);
        let elements = self.set.num_elements().map_err(failed)?;
        let element = self.set.raw_element_size().map_err(failed)? as u64;
        let bytes = elements.checked_mul(element).and_then(|bytes| usize::try_from(bytes).ok());
        let bytes = bytes.filter(|&bytes| bytes <= map.len().saturating_mul(LARGEST_COMPRESSION)).ok_or_else(|| {
            let length = map.len();
            self.malformed(&format!("{elements} elements of {element} bytes, more than a file of {length} bytes holds"))
        })?;
        if bytes == 0 {
            return Ok(Storage::Compact(Vec::new()));
        }
        let header = file.get_or_parse_header(self.set.address()).map_err(failed)?;
        if header.messages.iter().any(|message| matches!(message, HdfMessage::ExternalFiles(_))) {
            return Err(self.malformed("the values lie in another file, expected them in this one"));
        }
        let layout = header.messages.iter().find_map(|message| match message {
            HdfMessage::DataLayout(message) => Some(&message.layout),
            _ => None,
        });
        let superblock = file.superblock();
        let unwritten = |address| Cursor::is_undefined_offset(address, superblock.offset_size);
        let differs = |stored: u64| Err(self.malformed(&format!("{stored} bytes are stored, expected {bytes}")));
        match layout {
            Some(&DataLayout::Contiguous { address, .. } | &DataLayout::Chunked { address, .. })
                if unwritten(address) =>
            {
                Err(self.malformed("the values were never written"))
            }
            Some(&DataLayout::Contiguous { size, .. }) if size != bytes as u64 => differs(size),
            Some(&DataLayout::Contiguous { address, .. }) => {
                let start = address.checked_add(superblock.base_address).and_then(|start| usize::try_from(start).ok());
                let range = start.and_then(|start| Some(start..start.checked_add(bytes)?));
                range.filter(|range| range.end <= map.len()).map(Storage::Contiguous).ok_or_else(|| {
                    let length = map.len();
                    self.malformed(&format!("{bytes} bytes from byte {address} on reach past a file of {length} bytes"))
                })
            }
            Some(DataLayout::Compact { data }) if data.len() == bytes => Ok(Storage::Compact(data.clone())),
            Some(DataLayout::Compact { data }) => differs(data.len() as u64),
            Some(DataLayout::Chunked { .. }) => {
                let chunk = self.set.chunks().unwrap_or_default().into_iter().map(u64::from).collect::<Vec<_>>();
                if chunk.len() != self.set.ndim() || chunk.contains(&0) {
                    return Err(
                        self.malformed(&format!("chunks of {chunk:?} elements in {} dimensions", self.set.ndim()))
                    );
                }
                Ok(Storage::Chunked(chunk))
            }
            None => Err(self.malformed("nothing says where the values lie")),
        }
    }

    /// All elements, which must be integers, last axis fastest.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else or cannot be read.
    pub(crate) fn integers(&self) -> Result<Vec<i64>, FormatError> {
        let datatype = self.set.dtype();
        self.decoded(|bytes| integer(datatype, bytes))?
            .ok_or_else(|| self.malformed(&format!("{}, expected integers", describe(datatype))))
    }

    /// All elements, which must be numbers, last axis fastest.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else or cannot be read.
    pub(crate) fn floats(&self) -> Result<Vec<f64>, FormatError> {
        let datatype = self.set.dtype();
        self.decoded(|bytes| float(datatype, bytes))?
            .ok_or_else(|| self.malformed(&format!("{}, expected numbers", describe(datatype))))
    }

    /// All elements, which must be strings of a fixed length, without padding.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else or cannot be read.
    pub(crate) fn texts(&self) -> Result<Vec<String>, FormatError> {
        match self.set.dtype() {
            Datatype::String { .. } => Ok(self.decoded(|bytes| Some(trimmed(bytes)))?.unwrap_or_default()),
            other => Err(self.malformed(&format!("{}, expected strings", describe(other)))),
        }
    }

    /// All elements, which must be compounds of a string of a fixed length and a number.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else or cannot be read.
    pub(crate) fn named_numbers(&self) -> Result<Vec<(String, f64)>, FormatError> {
        let expected = "expected compounds of a name and a number";
        let Datatype::Compound { fields, .. } = self.set.dtype() else {
            return Err(self.malformed(&format!("{}, {expected}", describe(self.set.dtype()))));
        };
        let (Some(name), Some(value)) = (
            fields.iter().find(|field| matches!(field.datatype, Datatype::String { .. })),
            fields.iter().find(|field| !matches!(field.datatype, Datatype::String { .. })),
        ) else {
            return Err(self.malformed(expected));
        };
        let decode = |bytes: &[u8]| {
            let text = bytes.get(name.byte_offset as usize..)?;
            let length = value.byte_offset.saturating_sub(name.byte_offset) as usize;
            // Names come first, or last.
            let text = if length > 0 { text.get(..length)? } else { text };
            Some((trimmed(text), float(&value.datatype, bytes.get(value.byte_offset as usize..)?)?))
        };
        self.decoded(decode)?.ok_or_else(|| self.malformed(expected))
    }

    /// All elements, which must be compounds of two strings of a fixed length: a name and a text.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else or cannot be read.
    pub(crate) fn named_texts(&self) -> Result<Vec<(String, String)>, FormatError> {
        let expected = "expected compounds of a name and a text";
        let Datatype::Compound { fields, .. } = self.set.dtype() else {
            return Err(self.malformed(&format!("{}, {expected}", describe(self.set.dtype()))));
        };
        let [name, text] = &fields[..] else { return Err(self.malformed(expected)) };
        if ![name, text].iter().all(|field| matches!(field.datatype, Datatype::String { .. })) {
            return Err(self.malformed(expected));
        }
        let [name, text] = [name, text].map(|field| field.byte_offset as usize);
        let decode = |bytes: &[u8]| Some((trimmed(bytes.get(name..text)?), trimmed(bytes.get(text..)?)));
        self.decoded(decode)?.ok_or_else(|| self.malformed(expected))
    }

    /// The integer members `members` of all elements, which must be compounds. Other members and padding are skipped.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where they are something else or cannot be read.
    pub(crate) fn compounds<const N: usize>(&self, members: [&str; N]) -> Result<Vec<[i64; N]>, FormatError> {
        let datatype = self.set.dtype();
        let Datatype::Compound { fields, .. } = datatype else {
            let expected = members.join(", ");
            return Err(self.malformed(&format!("{}, expected compounds of {expected}", describe(datatype))));
        };
        let mut found = Vec::with_capacity(N);
        for member in members {
            let Some(field) = fields.iter().find(|field| field.name == member) else {
                let names = listing(fields.iter().map(|field| field.name.as_str()));
                return Err(self.malformed(&format!("compounds of {names}, expected a member {member}")));
            };
            found.push(field);
        }
        let decode = |bytes: &[u8]| {
            let mut values = [0; N];
            for (value, field) in values.iter_mut().zip(&found) {
                *value = integer(&field.datatype, bytes.get(field.byte_offset as usize..)?)?;
            }
            Some(values)
        };
        self.decoded(decode)?.ok_or_else(|| self.malformed(&format!("expected integers in {}", members.join(", "))))
    }

    /// The elements of a box (from its first to before its last element, per axis), last axis fastest. `T` must be the
    /// stored type, in either byte order.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the box leaves the data set or its elements cannot be read.
    pub(crate) fn read_box<T: H5Type>(&self, ranges: &[Range<u64>]) -> Result<Vec<T>, FormatError> {
        let shape = self.set.shape();
        // The library would silently clip the box.
        if ranges.len() != shape.len() || ranges.iter().zip(shape).any(|(range, &length)| range.end > length) {
            return Err(self.malformed(&format!("elements {ranges:?} lie outside {shape:?}")));
        }
        let slice = |range: &Range<u64>| SliceInfoElem::Slice { start: range.start, end: range.end, step: 1 };
        let selection = SliceInfo { selections: ranges.iter().map(slice).collect() };
        let array = self.set.read_slice::<T>(&selection).map_err(|error| self.source.failed(&self.place, &error))?;
        let (values, _) = array.into_raw_vec_and_offset();
        let expected = ranges.iter().map(|range| range.end.saturating_sub(range.start)).product::<u64>();
        if values.len() as u64 != expected {
            return Err(self.malformed(&format!("{} elements in {ranges:?}, expected {expected}", values.len())));
        }
        Ok(values)
    }

    /// All elements through `decode`; `None` where that fails.
    fn decoded<T>(&self, decode: impl Fn(&[u8]) -> Option<T>) -> Result<Option<Vec<T>>, FormatError> {
        let failed = |error| self.source.failed(&self.place, &error);
        let bytes: Cow<[u8]> = match self.storage()? {
            Storage::Contiguous(range) => Cow::Borrowed(&self.source.map[range]),
            Storage::Compact(bytes) => Cow::Owned(bytes),
            Storage::Chunked(_) => Cow::Owned(self.set.read_raw_bytes().map_err(failed)?),
        };
        let element = self.set.raw_element_size().map_err(failed)?;
        // `storage` gives no bytes for elements without a size.
        Ok(bytes.chunks_exact(element.max(1)).map(decode).collect())
    }
}

/// A string that may be padded with zeros or spaces.
fn trimmed(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    super::one_line(String::from_utf8_lossy(&bytes[..end]).trim_end())
}
