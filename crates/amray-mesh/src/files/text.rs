//! Lines and numbers of text files.

use std::borrow::Cow;

/// The lines of a text with their numbers, from 1. `joined` says whether a line that ends with a backslash goes on in
/// the next one.
pub(super) fn lines(bytes: &[u8], joined: bool) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = bytes.split(|&byte| byte == b'\n').enumerate();
    std::iter::from_fn(move || {
        let (index, line) = lines.next()?;
        let mut line = String::from_utf8_lossy(line);
        while joined && let Some(part) = line.trim_end().strip_suffix('\\') {
            let part = part.to_owned();
            let Some((_, next)) = lines.next() else { break };
            line = Cow::Owned(part + " " + &String::from_utf8_lossy(next));
        }
        Some((index + 1, line))
    })
}

/// The next three words as numbers.
pub(super) fn triple<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f64; 3]> {
    let mut number = || words.next()?.parse().ok();
    Some([number()?, number()?, number()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_may_go_on() {
        let text = b"f 1 \\\r\n2 \\\n3\nv\n\\";
        let joined: Vec<_> = lines(text, true).map(|(number, line)| (number, line.trim().to_owned())).collect();
        assert_eq!(joined, [(1, "f 1  2  3".into()), (4, "v".into()), (5, "\\".into())]);
        assert_eq!(lines(text, false).count(), 5);
    }
}
