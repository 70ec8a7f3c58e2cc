//! How a file's binary arrays are stored, and reading their bytes from front to back.

use std::io::{self, BufRead, Read, Take};

use flate2::bufread::ZlibDecoder;

use super::base64::Base64;
use super::element::Element;
use crate::{ByteOrder, NumberType, shown};

/// Zlib makes at most so many bytes of one.
const MOST_BY_ZLIB: u64 = 1032;
/// LZ4 makes less than so many bytes of one.
const MOST_BY_LZ4: u64 = 256;

/// How binary arrays are stored, all of a file alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Storage {
    pub(super) byte_order: ByteOrder,
    /// The type of lengths before the data.
    pub(super) length: NumberType,
    pub(super) compressor: Option<Compressor>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
}

/// How one binary array is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoding {
    pub(super) storage: Storage,
    pub(super) is_base64: bool,
}

/// The bytes of an array, decoded and decompressed as they are read.
pub struct ArrayReader<R> {
    input: Input<R>,
    storage: Storage,
    blocks: Blocks,
}

enum Input<R> {
    Raw(R),
    Base64(Base64<R>),
}

/// What is left of an array.
enum Blocks {
    /// So many bytes, not compressed.
    Whole(u64),
    Compressed(Compressed),
}

struct Compressed {
    compressor: Compressor,
    /// The sizes that the blocks have compressed.
    sizes: Vec<u64>,
    next: usize,
    /// Of all blocks but the last, decompressed.
    size: u64,
    last_size: u64,
    /// The block that is being handed out.
    bytes: Vec<u8>,
    used: usize,
}

/// An error of damaged content.
pub(super) fn damaged(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

impl Storage {
    /// What the element `VTKFile` says.
    pub(super) fn of(element: &Element) -> Result<Self, String> {
        let byte_order = match element.attribute("byte_order") {
            Some("BigEndian") => ByteOrder::Big,
            Some("LittleEndian") | None => ByteOrder::Little,
            Some(other) => return Err(format!("byte_order {}, expected LittleEndian or BigEndian", shown(other))),
        };
        let length = match element.attribute("header_type") {
            Some("UInt64") => NumberType::U64,
            Some("UInt32") | None => NumberType::U32,
            Some(other) => return Err(format!("header_type {}, expected UInt32 or UInt64", shown(other))),
        };
        let compressor = match element.attribute("compressor") {
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some("") | None => None,
            Some(other) => {
                let expected = "vtkZLibDataCompressor, vtkLZ4DataCompressor or none";
                return Err(format!("the compressor {} is not known, expected {expected}", shown(other)));
            }
        };
        Ok(Self { byte_order, length, compressor })
    }

    /// A length; those that are too large to be exact are too large for any file.
    fn length_of(&self, stored: &[u8]) -> u64 {
        self.length.value(self.byte_order, stored) as u64
    }
}

impl Encoding {
    /// Begins to read an array of `expected` bytes, the first of which `input` has next.
    ///
    /// # Errors
    /// Of kind `InvalidData` or `UnexpectedEof` where the array is damaged or has another length.
    pub fn open<R: BufRead>(self, input: R, expected: u128) -> io::Result<ArrayReader<R>> {
        let input = if self.is_base64 { Input::Base64(Base64::new(input)) } else { Input::Raw(input) };
        ArrayReader::new(self.storage, input, expected)
    }
}

impl<R: BufRead> ArrayReader<R> {
    /// Reads what is before the data: the number of bytes or, where they are compressed, the number of blocks, the size of
    /// all blocks but the last, that of the last (0 if it is like the others), and the compressed size of each. Nothing is
    /// decompressed where there are not as many as `expected`.
    fn new(storage: Storage, mut input: Input<R>, expected: u128) -> io::Result<Self> {
        let check = |found: u128| match found == expected {
            true => Ok(()),
            false => Err(damaged(format!("there are {found} bytes, expected {expected}"))),
        };
        let length_bytes = storage.length.bytes();
        let mut lengths = |count: u64| -> io::Result<Vec<u64>> {
            let mut stored = Vec::new();
            let bytes = count.saturating_mul(length_bytes as u64);
            match input.by_ref().take(bytes).read_to_end(&mut stored)? as u64 == bytes {
                true => Ok(stored.chunks_exact(length_bytes).map(|length| storage.length_of(length)).collect()),
                false => Err(io::Error::from(io::ErrorKind::UnexpectedEof)),
            }
        };
        let blocks = match storage.compressor {
            None => {
                let count = lengths(1)?[0];
                check(count.into())?;
                Blocks::Whole(count)
            }
            Some(compressor) => {
                let head = lengths(3)?;
                let (count, size, last_size) = (head[0], head[1], head[2]);
                let last_size = if last_size > 0 { last_size.min(size) } else { size };
                check((u128::from(count) * u128::from(size)).saturating_sub(u128::from(size - last_size)))?;
                let sizes = lengths(count)?;
                Blocks::Compressed(Compressed {
                    compressor,
                    sizes,
                    next: 0,
                    size,
                    last_size,
                    bytes: Vec::new(),
                    used: 0,
                })
            }
        };
        Ok(Self { input, storage, blocks })
    }

    /// The byte order of what is read.
    pub fn byte_order(&self) -> ByteOrder {
        self.storage.byte_order
    }
}

impl<R: BufRead> Read for ArrayReader<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match &mut self.blocks {
            Blocks::Whole(left) => {
                let count = self.input.by_ref().take(*left).read(bytes)?;
                *left -= count as u64;
                Ok(count)
            }
            Blocks::Compressed(blocks) => {
                while blocks.used == blocks.bytes.len() && blocks.next < blocks.sizes.len() {
                    blocks.decompress(&mut self.input)?;
                }
                let count = bytes.len().min(blocks.bytes.len() - blocks.used);
                bytes[..count].copy_from_slice(&blocks.bytes[blocks.used..blocks.used + count]);
                blocks.used += count;
                Ok(count)
            }
        }
    }
}

impl<R: BufRead> Read for Input<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Raw(input) => input.read(bytes),
            Self::Base64(input) => input.read(bytes),
        }
    }
}

impl Compressed {
    /// Takes the next block from `input`.
    fn decompress(&mut self, input: &mut impl Read) -> io::Result<()> {
        let block = self.next;
        self.next += 1;
        let size = if self.next == self.sizes.len() { self.last_size } else { self.size };
        let mut compressed = Vec::new();
        let mut stored: Take<_> = input.take(self.sizes[block]);
        if (stored.read_to_end(&mut compressed)? as u64) < self.sizes[block] {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.bytes.clear();
        self.used = 0;
        self.compressor.decompress(&compressed, size, &mut self.bytes).map_err(|problem| {
            let blocks = self.sizes.len();
            damaged(format!("block {} of {blocks} does not decompress to {size} bytes: {problem}", block + 1))
        })
    }
}

impl Compressor {
    /// Appends what a block holds.
    fn decompress(self, compressed: &[u8], size: u64, bytes: &mut Vec<u8>) -> Result<(), String> {
        let most = match self {
            Self::Zlib => MOST_BY_ZLIB,
            Self::Lz4 => MOST_BY_LZ4,
        };
        if size > (compressed.len() as u64).saturating_mul(most) {
            return Err(format!("there are {} compressed ones", compressed.len()));
        }
        match self {
            Self::Zlib => {
                ZlibDecoder::new(compressed).take(size).read_to_end(bytes).map_err(|error| error.to_string())?;
            }
            Self::Lz4 => {
                *bytes = lz4_flex::block::decompress(compressed, size as usize).map_err(|error| error.to_string())?;
            }
        }
        match bytes.len() as u64 {
            found if found == size => Ok(()),
            found => Err(format!("there are {found}")),
        }
    }
}
