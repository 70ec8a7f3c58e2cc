//! Groups: their members by name, and their attributes as numbers, strings and compounds.

use std::sync::Arc;

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Datatype};

use super::number::{describe, float, integer};
use super::{Hdf5Set, Source, listing};
use crate::FormatError;

/// A group, with its attributes read.
pub(crate) struct Hdf5Group {
    source: Arc<Source>,
    /// The path from the root, without a slash in front; empty for the root.
    place: String,
    group: Group,
    attributes: Vec<Attribute>,
}

impl Hdf5Group {
    pub(super) fn new(source: Arc<Source>, place: String, group: Group) -> Result<Self, FormatError> {
        let attributes = group.attributes().map_err(|error| source.failed(&place, &error))?;
        Ok(Self { source, place, group, attributes })
    }

    /// The path from the root, for messages.
    pub(crate) fn place(&self) -> &str {
        if self.place.is_empty() { "/" } else { &self.place }
    }

    /// An error at this group.
    pub(crate) fn malformed(&self, problem: &str) -> FormatError {
        self.source.malformed(self.place(), problem)
    }

    /// The names of the groups and data sets in it.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the list is damaged.
    pub(crate) fn member_names(&self) -> Result<Vec<String>, FormatError> {
        let (groups, sets) = self.group.member_names().map_err(|error| self.source.failed(self.place(), &error))?;
        Ok(groups.into_iter().chain(sets).collect())
    }

    /// The names of the data sets in it.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the list is damaged.
    pub(crate) fn data_set_names(&self) -> Result<Vec<String>, FormatError> {
        let (_, sets) = self.group.member_names().map_err(|error| self.source.failed(self.place(), &error))?;
        Ok(sets)
    }

    /// Whether there is a data set `name` in this group.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where the list of what is in it is damaged.
    pub(crate) fn has_data_set(&self, name: &str) -> Result<bool, FormatError> {
        Ok(self.data_set_names()?.iter().any(|set| set == name))
    }

    /// The group `name` in this one, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is damaged.
    pub(crate) fn group(&self, name: &str) -> Result<Option<Self>, FormatError> {
        let place = self.child_place(name);
        match self.group.group(name) {
            Ok(group) => Self::new(Arc::clone(&self.source), place, group).map(Some),
            Err(Error::GroupNotFound(_)) => Ok(None),
            Err(error) => Err(self.source.failed(&place, &error)),
        }
    }

    /// The data set `name` in this group.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where there is none or it is damaged.
    pub(crate) fn data_set(&self, name: &str) -> Result<Hdf5Set, FormatError> {
        let place = self.child_place(name);
        match self.group.dataset(name) {
            Ok(set) => Ok(Hdf5Set::new(Arc::clone(&self.source), place, set)),
            Err(Error::DatasetNotFound(_)) => Err(self.malformed(&format!("no data set {name}"))),
            Err(error) => Err(self.source.failed(&place, &error)),
        }
    }

    /// The names of the attributes.
    pub(crate) fn attribute_names(&self) -> impl Iterator<Item = &str> {
        self.attributes.iter().map(|attribute| attribute.name.as_str())
    }

    /// Whether there is an attribute `name`.
    pub(crate) fn has_attribute(&self, name: &str) -> bool {
        self.attribute(name).is_some()
    }

    /// The attribute `name` as one integer, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is something else.
    pub(crate) fn integer(&self, name: &str) -> Result<Option<i64>, FormatError> {
        self.single(name, "an integer", |attribute| integer(&attribute.datatype, &attribute.raw_data))
    }

    /// The attribute `name` as one number, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is something else.
    pub(crate) fn float(&self, name: &str) -> Result<Option<f64>, FormatError> {
        self.single(name, "a number", |attribute| float(&attribute.datatype, &attribute.raw_data))
    }

    /// The attribute `name` as so many integers, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is something else.
    pub(crate) fn integer_list(&self, name: &str) -> Result<Option<Vec<i64>>, FormatError> {
        self.list(name, "integers", integer)
    }

    /// The attribute `name` as so many numbers, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is something else.
    pub(crate) fn float_list(&self, name: &str) -> Result<Option<Vec<f64>>, FormatError> {
        self.list(name, "numbers", float)
    }

    /// The attribute `name` as strings without padding, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is something else.
    pub(crate) fn text_list(&self, name: &str) -> Result<Option<Vec<String>>, FormatError> {
        let Some(attribute) = self.attribute(name) else { return Ok(None) };
        let texts = attribute.read_strings().map_err(|_| self.unlike(name, attribute, "strings"))?;
        Ok(Some(texts.iter().map(|text| trimmed(text)).collect()))
    }

    /// The attribute `name` as one string without padding, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is something else.
    pub(crate) fn text(&self, name: &str) -> Result<Option<String>, FormatError> {
        self.single(name, "a string", |attribute| Some(trimmed(&attribute.read_string().ok()?)))
    }

    /// The integer members `members` of the compound attribute `name`, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is no such compound.
    pub(crate) fn integers<const N: usize>(
        &self,
        name: &str,
        members: [&str; N],
    ) -> Result<Option<[i64; N]>, FormatError> {
        self.compound(name, members, "integers", integer)
    }

    /// The numeric members `members` of the compound attribute `name`, if there is one.
    ///
    /// # Errors
    /// [`FormatError::Malformed`] where it is no such compound.
    pub(crate) fn floats<const N: usize>(
        &self,
        name: &str,
        members: [&str; N],
    ) -> Result<Option<[f64; N]>, FormatError> {
        self.compound(name, members, "numbers", float)
    }

    fn compound<T: Copy + Default, const N: usize>(
        &self,
        name: &str,
        members: [&str; N],
        kind: &str,
        decode: impl Fn(&Datatype, &[u8]) -> Option<T>,
    ) -> Result<Option<[T; N]>, FormatError> {
        let expected = format!("a compound of the {kind} {}", members.join(", "));
        self.single(name, &expected, |attribute| {
            let Datatype::Compound { fields, .. } = &attribute.datatype else { return None };
            let mut values = [T::default(); N];
            for (value, member) in values.iter_mut().zip(members) {
                let field = fields.iter().find(|field| field.name == member)?;
                *value = decode(&field.datatype, attribute.raw_data.get(field.byte_offset as usize..)?)?;
            }
            Some(values)
        })
    }

    /// The one value of the attribute `name`, decoded.
    fn single<T>(
        &self,
        name: &str,
        expected: &str,
        decode: impl Fn(&Attribute) -> Option<T>,
    ) -> Result<Option<T>, FormatError> {
        let Some(attribute) = self.attribute(name) else { return Ok(None) };
        let value = match attribute.num_elements() {
            Ok(1) => decode(attribute),
            _ => None,
        };
        value.map(Some).ok_or_else(|| self.unlike(name, attribute, expected))
    }

    /// All values of the attribute `name`, decoded.
    fn list<T>(
        &self,
        name: &str,
        expected: &str,
        decode: impl Fn(&Datatype, &[u8]) -> Option<T>,
    ) -> Result<Option<Vec<T>>, FormatError> {
        let Some(attribute) = self.attribute(name) else { return Ok(None) };
        let datatype = &attribute.datatype;
        let element = match datatype {
            Datatype::FixedPoint { size, .. } | Datatype::FloatingPoint { size, .. } if *size > 0 => *size as usize,
            _ => return Err(self.unlike(name, attribute, expected)),
        };
        let values: Option<Vec<T>> =
            attribute.raw_data.chunks_exact(element).map(|bytes| decode(datatype, bytes)).collect();
        values.map(Some).ok_or_else(|| self.unlike(name, attribute, expected))
    }

    /// The error for an attribute that holds something else.
    fn unlike(&self, name: &str, attribute: &Attribute, expected: &str) -> FormatError {
        let found = match &attribute.datatype {
            Datatype::Compound { fields, .. } => {
                format!("a compound of {}", listing(fields.iter().map(|field| field.name.as_str())))
            }
            other => describe(other),
        };
        self.malformed(&format!("attribute {name} holds {found}, expected {expected}"))
    }

    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    fn child_place(&self, name: &str) -> String {
        if self.place.is_empty() { name.into() } else { format!("{}/{name}", self.place) }
    }
}

/// A string without padding.
fn trimmed(text: &str) -> String {
    text.trim_end_matches(|end: char| end == '\0' || end.is_whitespace()).to_owned()
}
