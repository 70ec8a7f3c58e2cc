//! Text from files in messages.

/// How much of an unexpected text an error shows, in characters.
const SHOWN: usize = 60;

/// The beginning of a text, quoted and with its control characters escaped.
pub fn shown(text: &str) -> String {
    let text = text.trim();
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{:?}...", &text[..end]),
        None => format!("{text:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(shown(" a\u{1}b\r"), "\"a\\u{1}b\"");
        assert_eq!(shown(&"é".repeat(100)), format!("\"{}\"...", "é".repeat(60)));
    }
}
