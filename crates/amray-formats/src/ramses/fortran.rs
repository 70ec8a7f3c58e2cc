//! Fortran's unformatted files: records, each between two marks that tell its length in bytes.

use std::path::Path;

use crate::FormatError;
use crate::number::{ByteOrder, NumberType};

/// Bytes of a mark.
pub(super) const MARK: usize = 4;

/// The records of a file, one after the other.
pub(super) struct Records<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// Where the next record begins.
    at: usize,
    order: ByteOrder,
}

impl<'a> Records<'a> {
    /// A file whose first record is one integer: its mark tells the byte order.
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Result<Self, FormatError> {
        let order = match bytes.first_chunk::<MARK>() {
            Some([4, 0, 0, 0]) => ByteOrder::Little,
            Some([0, 0, 0, 4]) => ByteOrder::Big,
            found => {
                let problem = format!("starts with the bytes {found:?}, expected a record of one integer");
                return Err(FormatError::malformed(path, "the file", problem));
            }
        };
        Ok(Self { path, bytes, at: 0, order })
    }

    pub(super) fn order(&self) -> ByteOrder {
        self.order
    }

    /// The next record; `what` it should be is for errors.
    pub(super) fn record(&mut self, what: &str) -> Result<&'a [u8], FormatError> {
        let length = self.next_length(what)?;
        let start = self.alike(1, length, what)?;
        Ok(&self.bytes[start + MARK..start + MARK + length])
    }

    /// The length of the next record, if what is left of the file is as long.
    pub(super) fn next_length(&self, what: &str) -> Result<usize, FormatError> {
        let left = self.bytes.len() - self.at;
        match mark(self.bytes, self.at, self.order) {
            Some(length) if length.saturating_add(2 * MARK) <= left => Ok(length),
            Some(length) => Err(self.malformed(what, &format!("a record of {length} bytes, {left} bytes are left"))),
            None => Err(self.malformed(what, &format!("{left} bytes are left, expected a record"))),
        }
    }

    /// Passes over so many records of one length, of which the first and the last mark are looked at, and tells where
    /// they begin.
    pub(super) fn alike(&mut self, count: usize, length: usize, what: &str) -> Result<usize, FormatError> {
        let (start, left) = (self.at, self.bytes.len() - self.at);
        let total = length.checked_add(2 * MARK).and_then(|bytes| bytes.checked_mul(count));
        let Some(end) = total.filter(|total| *total <= left).map(|total| start + total) else {
            let expected = format!("expected {count} records of {length} bytes");
            return Err(self.malformed(what, &format!("{left} bytes are left, {expected}")));
        };
        if count > 0 {
            let marks = [start, end - MARK].map(|at| mark(self.bytes, at, self.order));
            if let Some(found) = marks.into_iter().flatten().find(|found| *found != length) {
                return Err(self.malformed(what, &format!("a record of {found} bytes, expected {length} bytes")));
            }
        }
        self.at = end;
        Ok(start)
    }

    /// A record of so many integers.
    pub(super) fn integers(&mut self, count: usize, what: &str) -> Result<Vec<i32>, FormatError> {
        let start = self.at;
        let record = self.record(what)?;
        if Some(record.len()) != count.checked_mul(4) {
            let problem = format!("a record of {} bytes, expected {count} integers of 4 bytes", record.len());
            self.at = start;
            return Err(self.malformed(what, &problem));
        }
        let mut integers = Vec::new();
        NumberType::I32.decode(self.order, record, |value| value as i32, &mut integers);
        Ok(integers)
    }

    /// A record of one integer.
    pub(super) fn integer(&mut self, what: &str) -> Result<i32, FormatError> {
        Ok(self.integers(1, what)?[0])
    }

    /// A record of so many reals, in single or double precision.
    pub(super) fn reals(&mut self, count: usize, what: &str) -> Result<Vec<f64>, FormatError> {
        let length = self.next_length(what)?;
        let wrong = || self.malformed(what, &format!("a record of {length} bytes, expected {count} reals"));
        let number = real_of(length, count).ok_or_else(wrong)?;
        let mut values = Vec::new();
        number.decode(self.order, self.record(what)?, |value| value, &mut values);
        Ok(values)
    }

    /// An error in what comes next.
    pub(super) fn malformed(&self, what: &str, problem: &str) -> FormatError {
        FormatError::malformed(self.path, format!("{what} at byte {}", self.at), problem)
    }
}

/// The precision of so many reals in a record of `length` bytes.
pub(super) fn real_of(length: usize, count: usize) -> Option<NumberType> {
    [NumberType::F32, NumberType::F64].into_iter().find(|number| count.checked_mul(number.bytes()) == Some(length))
}

/// The length that the mark at a place tells.
pub(super) fn mark(bytes: &[u8], at: usize, order: ByteOrder) -> Option<usize> {
    let mark = bytes.get(at..)?.first_chunk::<MARK>()?;
    Some(NumberType::U32.value(order, mark) as usize)
}
