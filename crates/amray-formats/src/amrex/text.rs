//! The text of a plotfile: lines of numbers, and index boxes in parentheses.

use std::fmt::Display;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use amray::hierarchy::IndexBox;

use crate::FormatError;
use crate::mapped_file::open_regular;

/// No line of a plotfile comes near this; a damaged file must not fill the memory.
const LONGEST_LINE: u64 = 1 << 20;
/// How much of an unexpected line an error shows, in characters.
const SHOWN: usize = 60;

/// The next thing to expect of an index box, as the codes print it.
pub(super) const INDEX_BOX: &str = "a cell-centred box such as ((0,0,0) (15,15,15) (0,0,0))";

/// A text file, read line by line; it knows the line it is at.
#[derive(Debug)]
pub(super) struct LineReader {
    path: PathBuf,
    reader: BufReader<File>,
    number: usize,
    /// The line read last with its line feed; empty at the file's end.
    line: Vec<u8>,
}

impl LineReader {
    pub(super) fn open(path: &Path) -> Result<Self, FormatError> {
        let reader = BufReader::new(open_regular(path)?);
        Ok(Self { path: path.into(), reader, number: 0, line: Vec::new() })
    }

    /// What `parse` makes of the next line. It may leave a rest of the line, as the codes' own readers do.
    pub(super) fn parse<T>(
        &mut self,
        expected: impl Display,
        parse: impl FnOnce(&mut Scanner<'_>) -> Option<T>,
    ) -> Result<T, FormatError> {
        self.line.clear();
        self.number += 1;
        let mut limited = (&mut self.reader).take(LONGEST_LINE);
        limited.read_until(b'\n', &mut self.line).map_err(FormatError::io(&self.path, "read"))?;
        let value = match self.line.is_empty() {
            true => None,
            false => parse(&mut Scanner(String::from_utf8_lossy(&self.line).trim())),
        };
        value.ok_or_else(|| self.malformed(expected))
    }

    /// The next line as one number.
    pub(super) fn number<T: FromStr>(&mut self, expected: impl Display) -> Result<T, FormatError> {
        self.parse(expected, |line| line.number())
    }

    /// The error that the line read last is not what was expected there.
    pub(super) fn malformed(&self, expected: impl Display) -> FormatError {
        let problem = match self.line.is_empty() {
            true => format!("the file ends here, expected {expected}"),
            false => format!("{}, expected {expected}", shown(&self.line)),
        };
        FormatError::malformed(&self.path, format!("line {}", self.number), problem)
    }
}

/// The beginning of a line, quoted and with its control characters escaped.
pub(super) fn shown(line: &[u8]) -> String {
    let line = String::from_utf8_lossy(line);
    let line = line.trim();
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{:?}...", &line[..end]),
        None => format!("{line:?}"),
    }
}

/// What is left of a line.
#[derive(Debug)]
pub(super) struct Scanner<'a>(pub(super) &'a str);

impl<'a> Scanner<'a> {
    /// The whole rest.
    pub(super) fn rest(&self) -> &'a str {
        self.0.trim()
    }

    /// Steps over `symbol`.
    pub(super) fn symbol(&mut self, symbol: &str) -> Option<()> {
        self.0 = self.0.trim_start().strip_prefix(symbol)?;
        Some(())
    }

    /// A word, up to the next blank, comma or parenthesis; not empty.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        let text = self.0.trim_start();
        let end = text.find(|c: char| c.is_whitespace() || "(),".contains(c)).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.0 = rest;
        (!word.is_empty()).then_some(word)
    }

    /// A number.
    pub(super) fn number<T: FromStr>(&mut self) -> Option<T> {
        self.word()?.parse().ok()
    }

    /// A finite number.
    pub(super) fn finite(&mut self) -> Option<f64> {
        self.number().filter(|number: &f64| number.is_finite())
    }

    /// Three finite numbers.
    pub(super) fn finite_triple(&mut self) -> Option<[f64; 3]> {
        Some([self.finite()?, self.finite()?, self.finite()?])
    }

    /// Three indices, `(i,j,k)`. The codes' indices have 32 bits, so that no arithmetic with boxes overflows.
    pub(super) fn index(&mut self) -> Option<[i64; 3]> {
        let mut index = [0; 3];
        for (axis, opening) in ["(", ",", ","].into_iter().enumerate() {
            self.symbol(opening)?;
            index[axis] = i64::from(self.number::<i32>()?);
        }
        self.symbol(")")?;
        Some(index)
    }

    /// First cell, last cell, centring: `((0,0,0) (15,15,15) (0,0,0))`, where the last 0 says cell-centred per axis.
    pub(super) fn index_box(&mut self) -> Option<IndexBox> {
        self.symbol("(")?;
        let [first, last, centring] = [self.index()?, self.index()?, self.index()?];
        self.symbol(")")?;
        if centring != [0; 3] {
            return None;
        }
        IndexBox::from_corners(first, last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index_box(text: &str) -> Option<IndexBox> {
        Scanner(text).index_box()
    }

    #[test]
    fn boxes_are_cell_centred_and_have_three_axes() {
        let cells = IndexBox::new([-8, 0, 3], [1, 16, 4]);
        assert_eq!(index_box("((-8,0,3) (0,15,3) (0,0,0))"), Some(cells));
        assert_eq!(index_box(" ( (-8, 0,3)(0,15,3) (0,0,0) ) rest"), Some(cells));
        assert_eq!(index_box("((-8,0,3) (0,15,3) (0,0,1))"), None);
        assert_eq!(index_box("((0,0) (15,15) (0,0))"), None);
        assert_eq!(index_box("((0,0,0) (15,15,15)"), None);
        assert_eq!(index_box("((0,0,0) (15,15,3000000000) (0,0,0))"), None);
        assert_eq!(index_box("((0,0,0) (2147483647,0,0) (0,0,0))"), Some(IndexBox::new([0; 3], [1 << 31, 1, 1])));
    }

    #[test]
    fn numbers_are_finite_and_whole_words() {
        assert_eq!(Scanner(" 0.5 -1e3  7 ").finite_triple(), Some([0.5, -1000.0, 7.0]));
        for text in ["nan", "1e400", "-inf", "", "1x", "(1)"] {
            assert_eq!(Scanner(text).finite(), None, "{text}");
        }
        assert_eq!(Scanner("-1").number::<u32>(), None);
    }

    #[test]
    fn errors_show_the_line_in_one_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("Header");
        std::fs::write(&path, format!("3\r\n\x01{}\n", "x".repeat(100))).unwrap();
        let mut lines = LineReader::open(&path).unwrap();
        assert_eq!(lines.number::<u32>("a count").unwrap(), 3);
        let error = lines.number::<u32>("a count").unwrap_err().to_string();
        assert_eq!(error, format!("{}: line 2: \"\\u{{1}}{}\"..., expected a count", path.display(), "x".repeat(59)));
        let error = lines.number::<u32>("a count").unwrap_err().to_string();
        assert_eq!(error, format!("{}: line 3: the file ends here, expected a count", path.display()));
        let error = LineReader::open(directory.path()).unwrap_err().to_string();
        assert!(error.ends_with(": cannot open: not a regular file"), "{error}");
    }
}
