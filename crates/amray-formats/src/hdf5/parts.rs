//! Many parts of a data set, so that each of its chunks is decompressed about once.

use std::ops::Range;

use rayon::prelude::*;

use super::{H5Type, Hdf5Set, Storage};
use crate::FormatError;

/// A run of parts that share chunks is read by one thread and spans about this many chunks, so that few are decompressed
/// by two threads.
const CHUNKS_PER_RUN: u64 = 16;
/// A thread keeps about so many elements at once, or those of a chunk if that is more.
const LARGEST_WINDOW: u64 = 1 << 24;

/// Parts that differ in their range along one axis alone.
pub(crate) struct Parts {
    /// The indices along the axes before it.
    pub(crate) leading: Vec<u64>,
    /// Each part's range along it.
    pub(crate) along: Vec<Range<u64>>,
    /// The ranges along the axes behind it.
    pub(crate) inner: Vec<Range<u64>>,
}

impl Hdf5Set {
    /// Reads all parts, in parallel. `keep` is told which part it is, and its elements, last axis fastest; what it makes of
    /// them comes back in the order of the parts. `N` must be the stored type, in either byte order; `storage` is that of
    /// the data set.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where a part leaves the data set or cannot be read, and what `keep` fails with.
    pub(crate) fn read_parts<N: H5Type + Copy, R: Send>(
        &self,
        storage: &Storage,
        parts: &Parts,
        keep: impl Fn(usize, &[N]) -> Result<R, FormatError> + Sync,
    ) -> Result<Vec<R>, FormatError> {
        let depth = parts.depth(storage);
        let mut order: Vec<usize> = (0..parts.along.len()).collect();
        order.sort_by_key(|&part| parts.along[part].start);
        let read = |run: &[usize]| {
            let mut window = Window { set: self, parts, depth, held: 0..0, values: Vec::new() };
            run.iter().map(|&part| Ok((part, keep(part, window.read(&parts.along[part])?)?))).collect()
        };
        let runs: Vec<&[usize]> = parts.runs(&order, depth);
        let found: Vec<Vec<(usize, R)>> = runs.into_par_iter().map(read).collect::<Result<_, FormatError>>()?;
        let mut found: Vec<(usize, R)> = found.into_iter().flatten().collect();
        found.sort_unstable_by_key(|&(part, _)| part);
        Ok(found.into_iter().map(|(_, kept)| kept).collect())
    }
}

impl Parts {
    /// The ranges along all axes of the part at some indices.
    pub(super) fn ranges(&self, along: Range<u64>) -> Vec<Range<u64>> {
        let leading = self.leading.iter().map(|&index| index..index.saturating_add(1));
        leading.chain([along]).chain(self.inner.iter().cloned()).collect()
    }

    /// Elements per index along the axis.
    fn row(&self) -> u64 {
        self.inner.iter().fold(1, |row, range| row.saturating_mul(range.end.saturating_sub(range.start)))
    }

    /// So many indices along the axis are read together: those of a chunk, unless the parts fill far more than one.
    fn depth(&self, storage: &Storage) -> u64 {
        let Storage::Chunked(chunk) = storage else { return 1 };
        let elements = chunk.iter().fold(1, |elements: u64, &length| elements.saturating_mul(length));
        let most = LARGEST_WINDOW.max(elements) / self.row().max(1);
        chunk.get(self.leading.len()).map_or(1, |&length| length.min(most).max(1))
    }

    /// Cuts ascending parts into runs: where no chunk is shared, or else where a run is long.
    fn runs<'a>(&self, order: &'a [usize], depth: u64) -> Vec<&'a [usize]> {
        let chunk_at = |index: u64| index / depth;
        let mut runs = Vec::new();
        let mut start = 0;
        for end in 1..=order.len() {
            let ends = order.get(end).is_none_or(|&next| {
                let first = chunk_at(self.along[order[start]].start);
                let last = chunk_at(self.along[order[end - 1]].end.saturating_sub(1));
                chunk_at(self.along[next].start) > last || last - first.min(last) >= CHUNKS_PER_RUN
            });
            if ends {
                runs.push(&order[start..end]);
                start = end;
            }
        }
        runs
    }
}

/// Reads ascending parts in whole chunks and keeps the last ones.
struct Window<'a, N> {
    set: &'a Hdf5Set,
    parts: &'a Parts,
    depth: u64,
    /// The indices along the axis whose elements are in `values`.
    held: Range<u64>,
    values: Vec<N>,
}

impl<N: H5Type + Copy> Window<'_, N> {
    fn read(&mut self, part: &Range<u64>) -> Result<&[N], FormatError> {
        if part.start < self.held.start || part.end > self.held.end {
            self.advance(part)?;
        }
        let row = self.parts.row() as usize;
        let [first, end] = [part.start, part.end].map(|index| (index - self.held.start) as usize * row);
        Ok(&self.values[first..end])
    }

    /// Reads on to the end of the last chunk of `part`, and lets go of what lies before it.
    fn advance(&mut self, part: &Range<u64>) -> Result<(), FormatError> {
        let length = self.set.shape().get(self.parts.leading.len()).copied().unwrap_or(0);
        // A part outside the data set is left to fail as it is read.
        let end = part.end.div_ceil(self.depth).saturating_mul(self.depth).min(length).max(part.end);
        let begin = part.start - part.start % self.depth;
        if self.held.contains(&part.start) {
            let passed = (part.start - self.held.start) as usize * self.parts.row() as usize;
            self.values.drain(..passed);
            let more = self.elements(self.held.end..end)?;
            self.values.extend_from_slice(&more);
            self.held = part.start..end;
        } else {
            self.values = Vec::new();
            self.values = self.elements(begin..end)?;
            self.held = begin..end;
        }
        Ok(())
    }

    fn elements(&self, indices: Range<u64>) -> Result<Vec<N>, FormatError> {
        self.set.read_box(&self.parts.ranges(indices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(along: &[Range<u64>], inner: &[u64]) -> Parts {
        Parts { leading: Vec::new(), along: along.to_vec(), inner: inner.iter().map(|&length| 0..length).collect() }
    }

    #[test]
    fn runs_share_no_chunks_or_are_long() {
        let along: Vec<Range<u64>> = (0..6).map(|part| part..part + 1).collect();
        let runs = |along: &[Range<u64>], depth| {
            let order: Vec<usize> = (0..along.len()).collect();
            parts(along, &[]).runs(&order, depth).iter().map(|run| run.len()).collect::<Vec<_>>()
        };
        assert_eq!(runs(&along, 4), [4, 2]);
        assert_eq!(runs(&along, 1), [1; 6]);
        assert_eq!(runs(&[], 4), [0; 0]);
        // Each reaches into the next one's first chunk.
        let chained: Vec<Range<u64>> = (0..40).map(|part| part * 999..part * 999 + 999).collect();
        assert_eq!(runs(&chained, 1000), [17, 16, 7]);
    }

    #[test]
    fn windows_are_bounded() {
        let chunked = Storage::Chunked(vec![1000, 8, 8, 8]);
        let depth = |side: u64| parts(&[], &[side; 3]).depth(&chunked);
        assert_eq!((depth(8), depth(64), depth(1024)), (1000, 64, 1));
        assert_eq!(parts(&[], &[]).depth(&Storage::Chunked(vec![u64::MAX])), u64::MAX);
        assert_eq!(parts(&[], &[]).depth(&Storage::Compact(Vec::new())), 1);
    }
}
