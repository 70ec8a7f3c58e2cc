//! Keys of scene files that hold what flags hold: read by the flags' parsers, with their limits and messages.

use std::fmt::Display;
use std::str::FromStr;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};

use crate::number;

/// What a flag's parser makes of numbers.
fn by<'de, D: Deserializer<'de>, V: Deserialize<'de>, T>(
    deserializer: D,
    text: impl Fn(V) -> String,
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Option<T>, D::Error> {
    let value = Option::<V>::deserialize(deserializer)?;
    value.map(|value| parse(&text(value)).map_err(D::Error::custom)).transpose()
}

/// Numbers as flags have them.
fn listed<T: ToString>(numbers: Vec<T>, between: &str) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(between)
}

pub(crate) fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    by(deserializer, |value: f64| value.to_string(), number::positive)
}

pub(crate) fn angle<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    by(deserializer, |value: f64| value.to_string(), number::angle)
}

pub(crate) fn samples_per_cell<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    by(deserializer, |value: f64| value.to_string(), number::samples_per_cell)
}

pub(crate) fn range<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    by(deserializer, |range: Vec<f64>| listed(range, ","), number::range)
}

pub(crate) fn color<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f32; 4]>, D::Error> {
    by(deserializer, |color: Vec<f32>| listed(color, ","), number::color)
}

pub(crate) fn size<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[usize; 2]>, D::Error> {
    by(deserializer, |size: [usize; 2]| listed(size.to_vec(), "x"), number::size)
}

pub(crate) fn count<'de, const MOST: u16, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u16>, D::Error> {
    match Option::<u16>::deserialize(deserializer)? {
        Some(count) if !(1..=MOST).contains(&count) => {
            Err(D::Error::custom(format!("{count}, expected a whole number from 1 to {MOST}")))
        }
        count => Ok(count),
    }
}

/// An opacity.
pub(crate) fn share<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f32, D::Error> {
    let found = f64::deserialize(deserializer)?;
    number::share(found).map_err(D::Error::custom)
}

/// A vector other than 0.
pub(crate) fn normal<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    number::normal(<[f64; 3]>::deserialize(deserializer)?).map_err(D::Error::custom)
}

/// What has a name.
pub(crate) mod name {
    use super::*;

    pub(crate) fn serialize<S: Serializer, T: Display>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        match value {
            Some(value) => serializer.collect_str(value),
            None => serializer.serialize_none(),
        }
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, T: FromStr<Err: Display>>(
        deserializer: D,
    ) -> Result<Option<T>, D::Error> {
        by(deserializer, |name: String| name, |name| name.parse::<T>().map_err(|error| error.to_string()))
    }
}
