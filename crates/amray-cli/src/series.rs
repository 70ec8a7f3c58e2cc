//! Time series: several data sets, named one by one or by patterns, of which the next one is opened ahead.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use amray::index::Index;

use crate::scene_file::SceneDocument;
use crate::stage::Stage;

/// The data sets that arguments name: paths as they are, patterns (`plt*`, for programs and shells that leave them alone)
/// as all that they match, in the order of the numbers in their names.
///
/// # Errors
/// Where a data set is not there: each is opened when its turn comes, which is late to learn that.
pub(crate) fn paths(arguments: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for argument in arguments {
        let missing = |problem: String| anyhow::anyhow!("{}: {problem}", argument.display());
        match argument.metadata() {
            Ok(_) => paths.push(argument.clone()),
            Err(_) if argument.to_string_lossy().contains(['*', '?', '[']) => {
                let found = glob::glob(&argument.to_string_lossy()).map_err(|error| missing(error.to_string()))?;
                let mut found: Vec<PathBuf> = found.filter_map(Result::ok).collect();
                if found.is_empty() {
                    return Err(missing("no data set has such a name".into()));
                }
                found.sort_by(|a, b| by_number(&a.to_string_lossy(), &b.to_string_lossy()));
                paths.extend(found);
            }
            Err(error) => return Err(missing(format!("cannot open: {error}"))),
        }
    }
    Ok(paths)
}

/// The order of names in which runs of digits count as numbers.
fn by_number(a: &str, b: &str) -> Ordering {
    let parts = |name: &str| -> Vec<(u128, String)> {
        let mut parts = Vec::new();
        let mut rest = name;
        while !rest.is_empty() {
            let text = rest.find(|letter: char| letter.is_ascii_digit()).unwrap_or(rest.len());
            let digits = rest[text..].find(|letter: char| !letter.is_ascii_digit()).unwrap_or(rest.len() - text);
            let number = &rest[text..text + digits];
            // The text before a number decides first.
            parts.push((0, rest[..text].to_owned()));
            if !number.is_empty() {
                parts.push((number.parse().unwrap_or(u128::MAX), number.to_owned()));
            }
            rest = &rest[text + digits..];
        }
        parts
    };
    parts(a).cmp(&parts(b))
}

/// The steps of a series, opened one after the other.
pub(crate) struct Steps<'a> {
    document: &'a SceneDocument,
    paths: &'a [PathBuf],
    /// The mesh of the last step that was opened.
    index: Option<Arc<Index>>,
    /// A step that is being opened, and its number.
    next: Option<(usize, JoinHandle<anyhow::Result<Stage>>)>,
}

impl<'a> Steps<'a> {
    /// Steps as `document` shows them; `index` is that of a step that is open already.
    pub(crate) fn new(document: &'a SceneDocument, paths: &'a [PathBuf], index: Arc<Index>) -> Self {
        Self { document, paths, index: Some(index), next: None }
    }

    /// A step, for which it may have to be waited.
    pub(crate) fn open(&mut self, number: usize) -> anyhow::Result<Stage> {
        let ahead = self.next.take_if(|(ahead, _)| *ahead == number);
        let stage = match ahead {
            Some((_, opening)) => opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?,
            None => open(self.document.clone(), &self.paths[number], self.index.clone())?,
        };
        self.index = Some(stage.volume.index().clone());
        Ok(stage)
    }

    /// Begins to open a step that is needed next.
    pub(crate) fn prepare(&mut self, number: usize) {
        let (document, path, index) = (self.document.clone(), self.paths[number].clone(), self.index.clone());
        self.next = Some((number, thread::spawn(move || open(document, &path, index))));
    }
}

/// Opens a data set as a document shows it; it shares an `index` of the same mesh.
pub(crate) fn open(mut document: SceneDocument, path: &Path, index: Option<Arc<Index>>) -> anyhow::Result<Stage> {
    document.data.path = Some(path.into());
    let data = document.data.volume().expect("the path has just been set");
    let source = data.source()?;
    Stage::open(document, &data, source, index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let mut names = ["plt10", "plt9", "a2b10", "a2b9", "a10", "plt", "plt9.old", "1", "plt09"];
        names.sort_by(|a, b| by_number(a, b));
        assert_eq!(names, ["1", "a2b9", "a2b10", "a10", "plt", "plt09", "plt9", "plt9.old", "plt10"]);
    }

    #[test]
    fn patterns_are_what_they_match() {
        let directory = tempfile::tempdir().unwrap();
        for name in ["plt00010", "plt00009", "plt100000", "other"] {
            std::fs::create_dir(directory.path().join(name)).unwrap();
        }
        let at = |name: &str| directory.path().join(name);
        let found = paths(&[at("other"), at("plt*")]).unwrap();
        assert_eq!(found, ["other", "plt00009", "plt00010", "plt100000"].map(at));
        assert!(paths(&[at("chk*")]).unwrap_err().to_string().ends_with("no data set has such a name"));
        assert!(paths(&[at("plt1")]).unwrap_err().to_string().contains("cannot open"));
    }
}
