//! The numbers of a PLY file, one after the other.

use amray_encoding::{NumberType, shown};

use super::header::{Element, Encoding};

/// What is left to read.
#[derive(Debug)]
pub(super) struct Body<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl<'a> Body<'a> {
    pub(super) fn new(encoding: Encoding, rest: &'a [u8]) -> Self {
        Self { encoding, rest }
    }

    /// The fewest bytes that a number takes: in a text a digit and a blank.
    fn least_bytes(&self, number: NumberType) -> usize {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary(_) => number.bytes(),
        }
    }

    /// The bytes there are; a blank after the last number may be missing.
    fn available(&self) -> usize {
        self.rest.len() + usize::from(self.encoding == Encoding::Text)
    }

    /// Checks that the rest is long enough for an element, as far as can be known.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn holds(&self, element: &Element) -> Result<(), String> {
        let row: usize =
            element.properties.iter().map(|column| self.least_bytes(column.length.unwrap_or(column.number))).sum();
        let needed = u128::from(element.count) * row as u128;
        match needed > self.available() as u128 {
            true => Err(format!("{needed} bytes are needed at least, but the file has {} more", self.rest.len())),
            false => Ok(()),
        }
    }

    /// The next number.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn number(&mut self, number: NumberType) -> Result<f64, String> {
        match self.encoding {
            Encoding::Text => {
                let text = self.rest.trim_ascii_start();
                let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
                let (word, rest) = text.split_at(end);
                self.rest = rest;
                let word = String::from_utf8_lossy(word);
                word.parse().map_err(|_| format!("{}, expected a number", shown(&word)))
            }
            Encoding::Binary(order) => {
                let (stored, rest) = self.rest.split_at_checked(number.bytes()).ok_or("the file ends here")?;
                self.rest = rest;
                Ok(number.value(order, stored))
            }
        }
    }

    /// The next list, into `list`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn list(&mut self, length: NumberType, number: NumberType, list: &mut Vec<f64>) -> Result<(), String> {
        let stated = self.number(length)?;
        if stated < 0.0 || stated.fract() != 0.0 {
            return Err(format!("{stated}, expected the length of a list"));
        }
        let needed = stated * self.least_bytes(number) as f64;
        if needed > self.available() as f64 {
            let available = self.rest.len();
            return Err(format!(
                "a list of {stated} numbers needs {needed} bytes at least, but the file has {available} more"
            ));
        }
        for _ in 0..stated as usize {
            list.push(self.number(number)?);
        }
        Ok(())
    }
}
