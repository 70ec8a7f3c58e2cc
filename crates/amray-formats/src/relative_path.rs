//! Paths that files name: followed below the file's own directory only.

use std::path::{Component, Path, PathBuf};

/// A relative path that stays below the directory it starts from; `None` for any other.
pub(crate) fn path_below(text: &str) -> Option<PathBuf> {
    let path = Path::new(text);
    let stays = path.components().all(|component| matches!(component, Component::Normal(_)));
    (stays && !text.is_empty() && !text.contains(char::is_control)).then(|| path.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_below() {
        assert_eq!(path_below("Level_0/Cell"), Some(PathBuf::from("Level_0/Cell")));
        for text in ["", "/etc/passwd", "../Cell", "Level_0/../../Cell", "Level_0/..", "a\tb"] {
            assert_eq!(path_below(text), None, "{text}");
        }
    }
}
