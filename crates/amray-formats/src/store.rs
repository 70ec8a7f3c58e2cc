//! Values that had to be read: kept in memory or, where that is too little, in a scratch file that is mapped in place, so
//! that the operating system drops what was not used for long and reads it again.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use amray::hierarchy::{BrickValues, ValueBuffer, Voxel, bytes_of, contiguous_strides};

use crate::{FormatError, OpenOptions, mapped_file};

/// Where values of bricks go as they are read.
pub(crate) enum Store {
    /// Each brick into memory of its own.
    Memory,
    /// One after the other into a file.
    Scratch(Scratch),
}

/// A file without a name, gone with the last view of it.
pub(crate) struct Scratch {
    /// Where to write, and how far the file is used.
    file: Mutex<(File, usize)>,
    /// All of the file.
    buffer: ValueBuffer,
}

impl Store {
    /// A store for so many values.
    ///
    /// # Errors
    /// [`FormatError::Io`] where there is no room for a scratch file.
    pub(crate) fn new<T: Voxel>(values: u64, options: &OpenOptions) -> Result<Self, FormatError> {
        let bytes = values.saturating_mul(size_of::<T>() as u64);
        if options.memory.is_none_or(|most| bytes <= most) {
            return Ok(Self::Memory);
        }
        let directory = directory();
        let make = || {
            let file = tempfile::tempfile_in(&directory)?;
            file.set_len(bytes)?;
            Ok(file)
        };
        let file = make().map_err(FormatError::io(&directory, "make a scratch file in"))?;
        let buffer = ValueBuffer::mapped(mapped_file::map_open(&file, &directory)?);
        Ok(Self::Scratch(Scratch { file: Mutex::new((file, 0)), buffer }))
    }

    /// Keeps the values of a brick of `size` cells, x fastest.
    ///
    /// # Errors
    /// [`FormatError::Io`] where the scratch file cannot be written.
    ///
    /// # Panics
    /// Where `values` are fewer than the brick's, or more are kept than the store is for.
    pub(crate) fn keep<T: Voxel>(&self, values: Vec<T>, size: [usize; 3]) -> Result<BrickValues<T>, FormatError> {
        match self {
            Self::Memory => Ok(BrickValues::owned(values, size).expect("one value for each place")),
            Self::Scratch(Scratch { file, buffer }) => {
                let mut guard = file.lock().unwrap_or_else(PoisonError::into_inner);
                let (file, used) = &mut *guard;
                let (start, bytes) = (*used, bytes_of(&values));
                let written = file.seek(SeekFrom::Start(start as u64)).and_then(|_| file.write_all(bytes));
                written.map_err(FormatError::io(&directory(), "write a scratch file in"))?;
                *used += bytes.len();
                Ok(BrickValues::new(buffer.clone(), start, contiguous_strides(size), size)
                    .expect("the file has room for all values"))
            }
        }
    }
}

/// Where scratch files are.
fn directory() -> PathBuf {
    std::env::temp_dir()
}

#[cfg(test)]
mod tests {
    use super::*;
    use amray::hierarchy::Residence;

    #[test]
    fn values_are_the_same_in_memory_and_in_a_file() {
        for (memory, residence) in
            [(None, Residence::Owned), (Some(96), Residence::Owned), (Some(95), Residence::Mapped)]
        {
            let store = Store::new::<f64>(12, &OpenOptions { memory, ..OpenOptions::default() }).unwrap();
            let first = store.keep((0..4).map(f64::from).collect(), [4, 1, 1]).unwrap();
            let second = store.keep((4..12).map(f64::from).collect(), [2; 3]).unwrap();
            assert_eq!((first.residence(), second.residence()), (residence, residence));
            second.buffer().release();
            assert_eq!(
                (first.get([3, 0, 0]), second.corners([0; 3])),
                (3.0, [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0])
            );
        }
    }
}
