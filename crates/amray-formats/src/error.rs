//! What can be wrong with a file: which file, where in it, what was expected.

use std::io;
use std::path::{Path, PathBuf};

use amray::hierarchy::{FieldError, HierarchyError};
use amray_expressions::{ExpressionError, quoted};
use thiserror::Error;

/// A data set that cannot be opened, read or written.
#[derive(Debug, Error)]
pub enum FormatError {
    /// The operating system refused.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// What was tried: `open`, `read`, `write`, ...
        action: &'static str,
        /// Why it failed.
        source: io::Error,
    },
    /// No reader knows the content.
    #[error("{path}: {found}, expected {expected}", path = path.display())]
    Unrecognised {
        /// The file or directory.
        path: PathBuf,
        /// What it is instead.
        found: String,
        /// The formats that can be read.
        expected: String,
    },
    /// The content contradicts its format.
    #[error("{path}: {place}: {problem}", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file: a line, a group, an attribute, a level and brick.
        place: String,
        /// What was found and what was expected.
        problem: String,
    },
    /// The levels and bricks contradict each other.
    #[error("{path}: {source}", path = path.display())]
    Hierarchy {
        /// The file or directory.
        path: PathBuf,
        /// What does not fit.
        source: HierarchyError,
    },
    /// The values do not fit the bricks.
    #[error("{path}: {source}", path = path.display())]
    Field {
        /// The file or directory.
        path: PathBuf,
        /// What does not fit.
        source: FieldError,
    },
    /// A field that the data set does not have.
    #[error(
        "{path}: no field {name:?}{}; the fields are {}",
        suggested(suggestion),
        known.join(", "),
        path = path.display()
    )]
    UnknownField {
        /// The file or directory.
        path: PathBuf,
        /// The name asked for.
        name: String,
        /// The nearest existing name, where one is near.
        suggestion: Option<String>,
        /// The names of all fields.
        known: Vec<String>,
    },
    /// An expression that cannot be read, or that means nothing over the fields there are.
    #[error(
        "{path}: expression {expression}: {source}{}; the fields are {}",
        suggested(suggestion),
        known.join(", "),
        path = path.display()
    )]
    Expression {
        /// The file or directory.
        path: PathBuf,
        /// The expression in quotes, shortened.
        expression: String,
        /// What is wrong with it.
        source: ExpressionError,
        /// The existing name that is nearest to an unknown one, where one is near.
        suggestion: Option<String>,
        /// The names of all fields.
        known: Vec<String>,
    },
    /// A level that the data set does not have.
    #[error("{path}: no level {asked}; the finest level is {finest}", path = path.display())]
    MaxLevel {
        /// The file or directory.
        path: PathBuf,
        /// The level asked for.
        asked: usize,
        /// The finest there is.
        finest: usize,
    },
}

impl FormatError {
    /// An [`FormatError::Io`], for `map_err`.
    pub fn io(path: &Path, action: &'static str) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Io { path: path.clone(), action, source }
    }

    /// A [`FormatError::Hierarchy`], for `map_err`.
    pub(crate) fn hierarchy(path: &Path) -> impl Fn(HierarchyError) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::Hierarchy { path: path.clone(), source }
    }

    /// A [`FormatError::Malformed`].
    pub fn malformed(path: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Malformed { path: path.into(), place: place.into(), problem: problem.into() }
    }

    /// A [`FormatError::Expression`]; where a name in it is not known, it suggests the nearest of `known`.
    pub(crate) fn expression(path: &Path, text: &str, source: ExpressionError, known: Vec<String>) -> Self {
        let suggestion = match &source {
            // Perhaps the whole is one name that was mistyped: `x-momentun`.
            ExpressionError::UnknownName { name, .. } => {
                nearest(text, &known, VERY_ALIKE).or_else(|| nearest(name, &known, ALIKE))
            }
            _ => None,
        };
        Self::Expression { path: path.into(), expression: quoted(text), source, suggestion, known }
    }

    /// A [`FormatError::UnknownField`] that suggests the nearest of `known`.
    pub fn unknown_field(path: &Path, name: &str, known: Vec<String>) -> Self {
        let suggestion = nearest(name, &known, ALIKE);
        Self::UnknownField { path: path.into(), name: name.into(), suggestion, known }
    }
}

fn suggested(suggestion: &Option<String>) -> String {
    suggestion.as_ref().map(|name| format!(", did you mean {name:?}?")).unwrap_or_default()
}

/// How like a name another one must be to be meant instead, from 0 to 1.
const ALIKE: f64 = 0.7;
const VERY_ALIKE: f64 = 0.9;

/// The candidate most like `name`, where one is at least so like it.
fn nearest(name: &str, candidates: &[String], alike: f64) -> Option<String> {
    let lower = name.to_lowercase();
    candidates
        .iter()
        .map(|candidate| (strsim::jaro_winkler(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(likeness, _)| *likeness > alike)
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, candidate)| candidate.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_field_suggests_the_nearest() {
        let known = vec!["density".to_owned(), "x-momentum".into(), "energy-density".into()];
        let error = FormatError::unknown_field(Path::new("a.hdf5"), "Densty", known.clone());
        assert_eq!(
            error.to_string(),
            "a.hdf5: no field \"Densty\", did you mean \"density\"?; the fields are density, x-momentum, energy-density"
        );
        let error = FormatError::unknown_field(Path::new("a.hdf5"), "qqq", known);
        assert!(!error.to_string().contains("did you mean"));
    }
}
