//! Base64 that is decoded as it is read.

use std::io::{self, BufRead, Read};

use super::storage::damaged;

/// The bytes that base64 stands for. Padding may be anywhere: VTK encodes some headers apart from their data, so that one
/// follows the other's end.
#[derive(Clone, Debug)]
pub(super) struct Base64<R> {
    text: R,
    /// The bytes of the last four characters, and which of them are still to be handed out.
    bytes: [u8; 3],
    next: usize,
    end: usize,
}

impl<R: BufRead> Base64<R> {
    pub(super) fn new(text: R) -> Self {
        Self { text, bytes: [0; 3], next: 0, end: 0 }
    }

    /// Decodes four characters; false where the text ends.
    fn decode(&mut self) -> io::Result<bool> {
        let (mut bits, mut characters, mut padding) = (0, 0, 0);
        while characters < 4 {
            let Some(&character) = self.text.fill_buf()?.first() else { return Ok(false) };
            self.text.consume(1);
            let value = match character {
                b'A'..=b'Z' => character - b'A',
                b'a'..=b'z' => character - b'a' + 26,
                b'0'..=b'9' => character - b'0' + 52,
                b'+' => 62,
                b'/' => 63,
                b'=' => {
                    padding += 1;
                    0
                }
                _ if character.is_ascii_whitespace() => continue,
                _ => return Err(damaged(format!("{:?}, expected a character of base64", char::from(character)))),
            };
            bits = bits << 6 | u32::from(value);
            characters += 1;
        }
        if padding > 2 {
            return Err(damaged("base64 of padding alone"));
        }
        let [_, bytes @ ..] = bits.to_be_bytes();
        (self.bytes, self.next, self.end) = (bytes, 0, 3 - padding);
        Ok(true)
    }
}

impl<R: BufRead> Read for Base64<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        for (place, byte) in bytes.iter_mut().enumerate() {
            if self.next == self.end && !self.decode()? {
                return Ok(place);
            }
            *byte = self.bytes[self.next];
            self.next += 1;
        }
        Ok(bytes.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_goes_on_after_padding() {
        // RFC 4648, section 10.
        let mut base64 = Base64::new(&b"Zg==Zm8=\n Zm9v YmFy<"[..]);
        let mut bytes = [0; 9];
        base64.read_exact(&mut bytes[..2]).unwrap();
        base64.read_exact(&mut bytes[2..]).unwrap();
        assert_eq!(bytes, *b"ffofoobar");
        assert_eq!(base64.read(&mut bytes).unwrap_err().to_string(), "'<', expected a character of base64");
    }

    #[test]
    fn what_is_not_there_is_not_read() {
        let read = |text: &str| {
            let mut bytes = Vec::new();
            Base64::new(text.as_bytes()).read_to_end(&mut bytes).map(|_| bytes).map_err(|error| error.to_string())
        };
        assert_eq!(read("Zm9v   Zm9"), Ok(b"foo".to_vec()));
        assert_eq!(read("Z==="), Err("base64 of padding alone".into()));
    }
}
