//! FLASH's lists of named numbers: data sets of compounds of a name of 80 characters and a value.

use crate::FormatError;
use crate::hdf5::{Hdf5Group, Hdf5Set};

/// One list.
pub(super) struct Scalars {
    set: Hdf5Set,
    values: Vec<(String, f64)>,
}

impl Scalars {
    pub(super) fn integers(root: &Hdf5Group) -> Result<Self, FormatError> {
        Self::read(root, "integer scalars")
    }

    pub(super) fn reals(root: &Hdf5Group) -> Result<Self, FormatError> {
        Self::read(root, "real scalars")
    }

    fn read(root: &Hdf5Group, name: &str) -> Result<Self, FormatError> {
        let set = root.data_set(name)?;
        let values = set.named_numbers()?;
        Ok(Self { set, values })
    }

    /// The number with a name.
    pub(super) fn find(&self, name: &str) -> Result<f64, FormatError> {
        let found = self.values.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| *value).ok_or_else(|| self.set.malformed(&format!("no {name}, expected it in the list")))
    }
}
