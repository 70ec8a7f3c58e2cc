//! Text files of lines `Key = values`, as Enzo and RAMSES write them.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::FormatError;
use crate::hdf5::one_line;
use crate::mapped_file::start_of;

/// Far more than the text of any dump: a million grids take half of it.
const LONGEST: u64 = 1 << 30;

/// A text file in memory.
pub(crate) struct Text {
    pub(crate) path: PathBuf,
    content: String,
}

/// A line with a key.
#[derive(Clone, Copy)]
pub(crate) struct Entry<'a> {
    path: &'a Path,
    /// From 1 on.
    line: usize,
    pub(crate) key: &'a str,
    pub(crate) value: &'a str,
}

impl Text {
    pub(crate) fn read(path: &Path) -> Result<Self, FormatError> {
        // Names in foreign bytes are no reason to give up.
        let content = String::from_utf8_lossy(&start_of(path, LONGEST)?).into_owned();
        Ok(Self { path: path.into(), content })
    }

    /// The lines with a key, one after the other.
    pub(crate) fn entries(&self) -> impl Iterator<Item = Entry<'_>> {
        self.content.lines().enumerate().filter_map(|(number, line)| {
            let (key, value) = line.split_once('=')?;
            Some(Entry { path: &self.path, line: number + 1, key: key.trim(), value: value.trim() })
        })
    }

    /// The first line with a key.
    pub(crate) fn find(&self, key: &str) -> Result<Entry<'_>, FormatError> {
        self.entries()
            .find(|entry| entry.key == key)
            .ok_or_else(|| FormatError::malformed(&self.path, "the file", format!("no line {key} = ...")))
    }
}

impl Entry<'_> {
    /// The value as so many numbers; more may follow.
    pub(crate) fn numbers<T: FromStr, const N: usize>(&self) -> Result<[T; N], FormatError> {
        let mut words = self.value.split_whitespace().map(str::parse::<T>);
        let numbers: Option<Vec<T>> = (0..N).map(|_| words.next()?.ok()).collect();
        let numbers = numbers.and_then(|numbers| <[T; N]>::try_from(numbers).ok());
        numbers.ok_or_else(|| {
            let what = if N == 1 { "a number".into() } else { format!("{N} numbers") };
            self.malformed(&format!("{:?}, expected {what}", shortened(self.value)))
        })
    }

    /// The value as one number.
    pub(crate) fn number<T: FromStr>(&self) -> Result<T, FormatError> {
        Ok(self.numbers::<T, 1>()?.into_iter().next().expect("there is one"))
    }

    /// An error in this line.
    pub(crate) fn malformed(&self, problem: &str) -> FormatError {
        FormatError::malformed(self.path, format!("line {}, {}", self.line, shortened(self.key)), one_line(problem))
    }
}

/// The beginning of a text, for messages.
fn shortened(text: &str) -> String {
    const SHOWN: usize = 60;
    text.chars().filter(|letter| !letter.is_control()).take(SHOWN).collect()
}
