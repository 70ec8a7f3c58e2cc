//! Slices of samples that are stored z fastest: each pass over the file gathers as many as memory allows.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

use amray::hierarchy::Voxel;

use super::samples::Samples;
use crate::number::ByteOrder;

/// Gathers slices ahead of those that are asked for.
pub(super) struct Transposed {
    /// Slices per pass over the file.
    batch: usize,
    /// The next slice to hand out.
    next: usize,
    /// The slices that are there, in their stored numbers, x fastest: from `first` on.
    first: usize,
    slices: Vec<u8>,
}

impl Transposed {
    /// A reader that keeps about `memory` bytes; one slice at the least.
    pub(super) fn new(samples: &Samples, memory: u64) -> Self {
        let slice = (samples.slice() * samples.number.bytes()) as u64;
        let batch = (memory / slice).clamp(1, samples.size[2] as u64) as usize;
        Self { batch, next: 0, first: 0, slices: Vec::new() }
    }

    /// Appends the values of the next `count` slices.
    pub(super) fn read<T: Voxel>(&mut self, samples: &Samples, count: usize, values: &mut Vec<T>) -> io::Result<()> {
        let slice = samples.slice() * samples.number.bytes();
        for number in self.next..self.next + count {
            if number >= self.first + self.slices.len() / slice {
                self.gather(samples, number)?;
            }
            let bytes = &self.slices[(number - self.first) * slice..][..slice];
            samples.number.decode(ByteOrder::Little, bytes, T::from_f64, values);
        }
        self.next += count;
        Ok(())
    }

    /// Goes through the file once for the slices from `first` on.
    fn gather(&mut self, samples: &Samples, first: usize) -> io::Result<()> {
        let [width, height, depth] = samples.size;
        let bytes = samples.number.bytes();
        let count = self.batch.min(depth - first);
        self.first = first;
        self.slices.clear();
        self.slices.resize(count * samples.slice() * bytes, 0);
        let mut file = BufReader::new(File::open(&samples.path)?);
        file.seek(SeekFrom::Start(samples.offset))?;
        let mut column = vec![0; depth * bytes];
        for x in 0..width {
            for y in 0..height {
                file.read_exact(&mut column)?;
                for (slice, number) in column[first * bytes..][..count * bytes].chunks_exact_mut(bytes).enumerate() {
                    if samples.order == ByteOrder::Big {
                        number.reverse();
                    }
                    let place = x + width * (y + height * slice);
                    self.slices[place * bytes..][..bytes].copy_from_slice(number);
                }
            }
        }
        Ok(())
    }
}
