//! From an array as it is stored to its numbers.

use std::io::Read;

use flate2::bufread::ZlibDecoder;

use super::document::{Appended, Compressor, DataArray, Document, Format, Storage};
use super::stream::Stream;
use crate::files::text::shown;

/// Zlib makes at most so many bytes of one.
const MOST_BY_ZLIB: u64 = 1032;
/// LZ4 makes less than so many bytes of one.
const MOST_BY_LZ4: u64 = 256;

impl DataArray {
    /// The numbers of the array, of which there are `expected`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn values(&self, document: &Document<'_>, expected: u128) -> Result<Vec<f64>, String> {
        let stream = match (self.format, document.appended) {
            (Format::Text, _) => None,
            (Format::Base64, _) => Some(Stream::base64(self.text.as_bytes())),
            (Format::Appended(offset), Appended::Raw(bytes)) => Some(Stream::Raw(from(bytes, offset)?)),
            (Format::Appended(offset), Appended::Base64(text)) => Some(Stream::base64(from(text, offset)?)),
            (Format::Appended(_), Appended::None) => return Err("there is no AppendedData".into()),
        };
        let values: Vec<f64> = match stream {
            None => {
                let number = |word: &str| word.parse().map_err(|_| format!("{}, expected a number", shown(word)));
                self.text.split_ascii_whitespace().map(number).collect::<Result<_, _>>()?
            }
            Some(stream) => {
                let bytes = document.storage.bytes(stream, expected.saturating_mul(self.number.bytes() as u128))?;
                let value = |stored: &[u8]| self.number.value(stored, document.storage.byte_order);
                bytes.chunks_exact(self.number.bytes()).map(value).collect()
            }
        };
        match values.len() as u128 == expected {
            true => Ok(values),
            false => Err(format!("there are {} numbers, expected {expected}", values.len())),
        }
    }
}

/// What begins at an offset.
fn from(bytes: &[u8], offset: u64) -> Result<&[u8], String> {
    let rest = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
    rest.ok_or_else(|| format!("the array is at byte {offset} of {} appended ones", bytes.len()))
}

impl Storage {
    /// The bytes of an array: after their number, or in compressed blocks after the number of blocks, the size of all
    /// blocks but the last, that of the last (0 if it is like the others), and the compressed size of each. Nothing is
    /// decompressed where there are not as many as `expected`.
    fn bytes(&self, mut stream: Stream<'_>, expected: u128) -> Result<Vec<u8>, String> {
        let check = |found: u128| match found == expected {
            true => Ok(()),
            false => Err(format!("there are {found} bytes, expected {expected}")),
        };
        let Some(compressor) = self.compressor else {
            let [count] = self.lengths(&mut stream)?;
            check(count.into())?;
            return stream.take(count);
        };
        let [blocks, block_size, last_size] = self.lengths(&mut stream)?;
        let lacking = if last_size > 0 { u128::from(block_size) - u128::from(last_size.min(block_size)) } else { 0 };
        check((u128::from(blocks) * u128::from(block_size)).saturating_sub(lacking))?;
        let sizes = stream.take(blocks.saturating_mul(self.length.bytes() as u64))?;
        let mut bytes = Vec::new();
        for (block, compressed_size) in sizes.chunks_exact(self.length.bytes()).enumerate() {
            let is_last = block as u64 + 1 == blocks;
            let size = if is_last && last_size > 0 { last_size } else { block_size };
            let compressed = stream.take(self.length_of(compressed_size))?;
            compressor.decompress(&compressed, size, &mut bytes).map_err(|problem| {
                format!("block {} of {blocks} does not decompress to {size} bytes: {problem}", block + 1)
            })?;
        }
        Ok(bytes)
    }

    fn lengths<const N: usize>(&self, stream: &mut Stream<'_>) -> Result<[u64; N], String> {
        let mut lengths = [0; N];
        for length in &mut lengths {
            *length = self.length_of(&stream.take(self.length.bytes() as u64)?);
        }
        Ok(lengths)
    }

    /// A length; those that are too large to be exact are too large for any file.
    fn length_of(&self, stored: &[u8]) -> u64 {
        self.length.value(stored, self.byte_order) as u64
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
        let start = bytes.len();
        match self {
            Self::Zlib => {
                ZlibDecoder::new(compressed).take(size).read_to_end(bytes).map_err(|error| error.to_string())?;
            }
            Self::Lz4 => {
                let block = lz4_flex::block::decompress(compressed, size as usize);
                bytes.extend(block.map_err(|error| error.to_string())?);
            }
        }
        match (bytes.len() - start) as u64 {
            found if found == size => Ok(()),
            found => Err(format!("there are {found}")),
        }
    }
}
