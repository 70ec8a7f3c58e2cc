//! One element of a VTK file, with what is in it.

use std::ops::Range;
use std::str::FromStr;

use super::VtkError;
use crate::shown;

/// An element: its name, attributes and children, and where its text is in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Element {
    pub(super) name: String,
    /// Where in the file it begins.
    pub(super) position: u64,
    pub(super) attributes: Vec<(String, String)>,
    pub(super) children: Vec<Element>,
    /// The element's own text, in as many parts as its children leave; blank parts are left out.
    pub(super) text: Vec<Range<usize>>,
}

impl Element {
    /// The element's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The value of an attribute, if there is one.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
    }

    /// An attribute as one number, if there is one.
    ///
    /// # Errors
    /// [`VtkError`] where it is something else.
    pub fn number<T: FromStr>(&self, name: &str) -> Result<Option<T>, VtkError> {
        let number = |text: &str| text.trim().parse().map_err(|_| self.unlike(name, text, "a number"));
        self.attribute(name).map(number).transpose()
    }

    /// An attribute as `N` numbers between blanks, if there is one.
    ///
    /// # Errors
    /// [`VtkError`] where it is something else.
    pub fn numbers<T: FromStr, const N: usize>(&self, name: &str) -> Result<Option<[T; N]>, VtkError> {
        let numbers = |text: &str| {
            let numbers: Option<Vec<T>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
            let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
            numbers.ok_or_else(|| self.unlike(name, text, &format!("{N} numbers")))
        };
        self.attribute(name).map(numbers).transpose()
    }

    /// All children.
    pub fn children(&self) -> &[Self] {
        &self.children
    }

    /// The children of a name.
    pub fn children_named(&self, name: &str) -> impl Iterator<Item = &Self> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The first child of a name.
    ///
    /// # Errors
    /// [`VtkError`] where there is none.
    pub fn child(&self, name: &str) -> Result<&Self, VtkError> {
        self.children_named(name).next().ok_or_else(|| self.error(format!("there is no element {name} in it")))
    }

    /// An error at this element.
    pub fn error(&self, problem: impl Into<String>) -> VtkError {
        VtkError::new(format!("byte {}, element {}", self.position, shown(&self.name)), problem)
    }

    fn unlike(&self, name: &str, text: &str, expected: &str) -> VtkError {
        self.error(format!("{name} is {}, expected {expected}", shown(text)))
    }
}
