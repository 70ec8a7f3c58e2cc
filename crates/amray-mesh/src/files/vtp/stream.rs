//! Bytes one after the other, stored as they are or as base64.

/// Where bytes come from.
#[derive(Clone, Debug)]
pub(super) enum Stream<'a> {
    Raw(&'a [u8]),
    Base64(Base64<'a>),
}

/// Base64 that is decoded as it is needed. Padding may be anywhere: VTK encodes some headers apart from their data, so
/// that one follows the other's end.
#[derive(Clone, Debug)]
pub(super) struct Base64<'a> {
    text: &'a [u8],
    /// The bytes of the last four characters that are not taken yet, in the order of taking from the end.
    pending: Vec<u8>,
}

impl<'a> Stream<'a> {
    pub(super) fn base64(text: &'a [u8]) -> Self {
        Self::Base64(Base64 { text, pending: Vec::with_capacity(3) })
    }

    /// The next bytes.
    ///
    /// # Errors
    /// What is wrong, in words; in particular where there are not as many.
    pub(super) fn take(&mut self, count: u64) -> Result<Vec<u8>, String> {
        let available = match self {
            Self::Raw(bytes) => bytes.len(),
            Self::Base64(base64) => base64.pending.len() + base64.text.len() / 4 * 3,
        };
        let too_few = || format!("{count} bytes are needed, but the file ends before");
        let count = usize::try_from(count).ok().filter(|&count| count <= available).ok_or_else(too_few)?;
        match self {
            Self::Raw(bytes) => {
                let (taken, rest) = bytes.split_at(count);
                *bytes = rest;
                Ok(taken.to_vec())
            }
            Self::Base64(base64) => {
                let mut taken = Vec::with_capacity(count);
                while taken.len() < count {
                    if base64.pending.is_empty() && !base64.decode()? {
                        return Err(too_few());
                    }
                    taken.extend(base64.pending.pop());
                }
                Ok(taken)
            }
        }
    }
}

impl Base64<'_> {
    /// Decodes four characters; false where the text ends.
    fn decode(&mut self) -> Result<bool, String> {
        let mut bits = 0;
        let mut characters = 0;
        let mut padding = 0;
        while characters < 4 {
            let Some((&character, rest)) = self.text.split_first() else { break };
            self.text = rest;
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
                _ => return Err(format!("{:?}, expected a character of base64", char::from(character))),
            };
            bits = bits << 6 | u32::from(value);
            characters += 1;
        }
        if characters < 4 || padding > 2 {
            return Ok(false);
        }
        let [_, first, second, third] = bits.to_be_bytes();
        self.pending.extend(&[third, second, first][padding..]);
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_goes_on_after_padding() {
        // RFC 4648, section 10.
        let mut stream = Stream::base64(b"Zg==Zm8=\n Zm9v YmFy<");
        assert_eq!(stream.take(2).unwrap(), b"ff");
        assert_eq!(stream.take(0).unwrap(), b"");
        assert_eq!(stream.take(7).unwrap(), b"ofoobar");
        assert!(stream.take(1).is_err());
    }

    #[test]
    fn what_is_not_there_cannot_be_taken() {
        let too_few = "18446744073709551615 bytes are needed, but the file ends before";
        assert_eq!(Stream::Raw(b"abc").take(u64::MAX).unwrap_err(), too_few);
        assert_eq!(Stream::base64(b"Zm9v").take(u64::MAX).unwrap_err(), too_few);
        assert_eq!(Stream::base64(b"Zm9v   =").take(5).unwrap_err(), "5 bytes are needed, but the file ends before");
        assert_eq!(Stream::base64(b"Zm<v").take(1).unwrap_err(), "'<', expected a character of base64");
    }
}
