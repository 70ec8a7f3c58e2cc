//! The values of a coarser level while a volume is converted: in a temporary file, so that memory does not have to hold
//! them.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use amray::hierarchy::{Voxel, VoxelType};

use crate::number::{ByteOrder, NumberType};

/// Slices of values, written one after the other and read in any order. The file has no name and goes with the process.
pub(super) struct LevelFile {
    file: File,
    voxel_type: VoxelType,
    /// Values per slice.
    slice: usize,
    /// One slice as it is stored.
    bytes: Vec<u8>,
}

impl LevelFile {
    /// An empty file in `directory`.
    pub(super) fn new(directory: &Path, voxel_type: VoxelType, slice: usize) -> io::Result<Self> {
        let file = tempfile::tempfile_in(directory)?;
        Ok(Self { file, voxel_type, slice, bytes: Vec::new() })
    }

    /// Appends a slice.
    pub(super) fn push<T: Voxel>(&mut self, values: &[T]) -> io::Result<()> {
        self.bytes.clear();
        match self.voxel_type {
            VoxelType::F32 => {
                self.bytes.extend(values.iter().flat_map(|value| (value.to_f64() as f32).to_le_bytes()));
            }
            VoxelType::F64 => self.bytes.extend(values.iter().flat_map(|value| value.to_f64().to_le_bytes())),
        }
        self.file.write_all(&self.bytes)
    }

    /// Puts the values of some slices into `values`, instead of what is there.
    pub(super) fn read<T: Voxel>(&mut self, slices: Range<usize>, values: &mut Vec<T>) -> io::Result<()> {
        let number = match self.voxel_type {
            VoxelType::F32 => NumberType::F32,
            VoxelType::F64 => NumberType::F64,
        };
        values.clear();
        values.reserve_exact(slices.len() * self.slice);
        let length = self.slice * number.bytes();
        self.bytes.resize(length, 0);
        self.file.seek(SeekFrom::Start(slices.start as u64 * length as u64))?;
        for _ in slices {
            self.file.read_exact(&mut self.bytes)?;
            number.decode(ByteOrder::Little, &self.bytes, T::from_f64, values);
        }
        Ok(())
    }
}
