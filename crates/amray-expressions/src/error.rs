//! What can be wrong with an expression, and where in it.

use thiserror::Error;

/// Of longer texts, messages show this many characters.
const SHOWN: usize = 60;

/// An expression that cannot be read, or that means nothing over the fields there are.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ExpressionError {
    /// What stands in a place makes no sense there.
    #[error("column {column}: {problem}")]
    Invalid {
        /// The place, in characters from 1 on.
        column: usize,
        /// What was found and what was expected.
        problem: String,
    },
    /// A name that is no field's and no definition's.
    #[error("column {column}: no field {name:?}")]
    UnknownName {
        /// The place, in characters from 1 on.
        column: usize,
        /// The name.
        name: String,
    },
    /// A definition that the expression uses is wrong itself.
    #[error("in {name} = {formula}: {source}")]
    InDefinition {
        /// The definition's name.
        name: String,
        /// Its formula, shortened.
        formula: String,
        /// What is wrong with it.
        source: Box<ExpressionError>,
    },
}

impl ExpressionError {
    pub(crate) fn invalid(column: usize, problem: impl Into<String>) -> Self {
        Self::Invalid { column, problem: problem.into() }
    }

    /// This error inside a definition. The innermost definition is what a user must look at; it is kept alone.
    pub(crate) fn in_definition(self, name: &str, formula: &str) -> Self {
        match self {
            Self::InDefinition { .. } => self,
            source => Self::InDefinition { name: name.into(), formula: quoted(formula), source: Box::new(source) },
        }
    }
}

/// An expression as messages show it: in quotes, its start where it is long.
pub fn quoted(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{:?}...", &text[..end]),
        None => format!("{text:?}"),
    }
}
