//! What can be wrong with a mesh file: which file, where in it, what was expected.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::MeshError;

/// A mesh file that cannot be read.
#[derive(Debug, Error)]
pub enum MeshFileError {
    /// The operating system refused.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: `open`, `read`.
        action: &'static str,
        /// Why it failed.
        source: io::Error,
    },
    /// No reader knows the content.
    #[error("{path}: {found}, expected {expected}", path = path.display())]
    Unrecognised {
        /// The file.
        path: PathBuf,
        /// What it is instead.
        found: String,
        /// The formats that can be read.
        expected: &'static str,
    },
    /// The content contradicts its format.
    #[error("{path}: {place}: {problem}", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file: a line, an element, an array.
        place: String,
        /// What was found and what was expected.
        problem: String,
    },
    /// The vertices and triangles are no mesh.
    #[error("{path}: {source}", path = path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        source: MeshError,
    },
}

/// What is wrong with the bytes of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Problem {
    place: String,
    problem: String,
}

impl Problem {
    pub(super) fn new(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { place: place.into(), problem: problem.into() }
    }

    /// At a line, counted from 1.
    pub(super) fn at_line(number: usize, problem: impl Into<String>) -> Self {
        Self::new(format!("line {number}"), problem)
    }

    /// The problem as one of a file.
    pub(super) fn of(self, path: &Path) -> MeshFileError {
        MeshFileError::Malformed { path: path.into(), place: self.place, problem: self.problem }
    }
}

#[cfg(test)]
impl std::fmt::Display for Problem {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}: {}", self.place, self.problem)
    }
}
