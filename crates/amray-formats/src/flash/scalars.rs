//! FLASH's lists of named values: data sets of compounds of a name of 80 characters and a value.

use crate::FormatError;
use crate::hdf5::{Hdf5Group, Hdf5Set};

/// One list of numbers.
pub(super) struct Numbers {
    set: Hdf5Set,
    values: Vec<(String, f64)>,
}

impl Numbers {
    pub(super) fn read(root: &Hdf5Group, name: &str) -> Result<Self, FormatError> {
        let set = root.data_set(name)?;
        let values = set.named_numbers()?;
        Ok(Self { set, values })
    }

    /// A list that older or smaller files do not have.
    pub(super) fn read_if_there(root: &Hdf5Group, name: &str) -> Result<Option<Self>, FormatError> {
        root.has_data_set(name)?.then(|| Self::read(root, name)).transpose()
    }

    /// The number with a name.
    pub(super) fn find(&self, name: &str) -> Result<f64, FormatError> {
        self.get(name).ok_or_else(|| self.set.malformed(&format!("no {name}, expected it in the list")))
    }

    /// The number with a name, if there is one.
    pub(super) fn get(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Checks that the number with a name is as expected, if there is one.
    pub(super) fn expect(&self, name: &str, expected: f64, why: &str) -> Result<(), FormatError> {
        match self.get(name).filter(|&found| found != expected) {
            Some(found) => Err(self.set.malformed(&format!("{name} is {found}, expected {expected}{why}"))),
            None => Ok(()),
        }
    }

    /// An error in this list.
    pub(super) fn malformed(&self, problem: &str) -> FormatError {
        self.set.malformed(problem)
    }
}

/// The name of the coordinates, if a list of texts tells.
pub(super) fn geometry(root: &Hdf5Group) -> Result<Option<String>, FormatError> {
    for list in ["string scalars", "string runtime parameters"] {
        if root.has_data_set(list)?
            && let Some((_, geometry)) =
                root.data_set(list)?.named_texts()?.into_iter().find(|(name, _)| name == "geometry")
        {
            return Ok(Some(geometry.trim().to_lowercase()));
        }
    }
    Ok(None)
}
