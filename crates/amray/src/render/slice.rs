//! Slices: the reconstruction on an axis-aligned plane, one value per pixel.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::value_image::ValueImage;
use crate::Volume;

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// A name that no axis has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no axis {0:?}; the axes are x, y and z")]
pub struct UnknownAxis(pub String);

impl FromStr for Axis {
    type Err = UnknownAxis;

    fn from_str(name: &str) -> Result<Self, UnknownAxis> {
        match name {
            "x" => Ok(Self::X),
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            _ => Err(UnknownAxis(name.into())),
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(["x", "y", "z"][*self as usize])
    }
}

impl Axis {
    /// The axes that run to the right and up in a slice across this one, in the order x, y, z.
    pub fn across(self) -> [Self; 2] {
        match self {
            Self::X => [Self::Y, Self::Z],
            Self::Y => [Self::X, Self::Z],
            Self::Z => [Self::X, Self::Y],
        }
    }
}

/// A plane across the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// The axis that the plane is perpendicular to.
    pub axis: Axis,
    /// Where on that axis, in world units.
    pub at: f64,
}

impl Slice {
    /// The size in pixels of a picture of the whole slice whose longer side has `longest` pixels; pixels are square.
    pub fn fitting_size(&self, volume: &Volume, longest: usize) -> [usize; 2] {
        let [low, high] = volume.hierarchy().bounds();
        let sides = self.axis.across().map(|axis| high[axis as usize] - low[axis as usize]);
        let scale = longest as f64 / sides[0].max(sides[1]);
        sides.map(|side| ((side * scale).round() as usize).max(1))
    }

    /// Samples the volume on the whole slice, at the centres of `size` pixels (width, height). Row 0 is on top, where the
    /// second of [`Axis::across`] is highest.
    pub fn sample(&self, volume: &Volume, size: [usize; 2]) -> ValueImage {
        let [low, high] = volume.hierarchy().bounds();
        let [right, up] = self.axis.across().map(|axis| axis as usize);
        let mut point = [0.0; 3];
        point[self.axis as usize] = self.at;
        let mut values = vec![0.0; size[0] * size[1]];
        volume.sample_at(&mut values, |pixel| {
            let (column, row) = (pixel % size[0], pixel / size[0]);
            let mut point = point;
            let share = |pixel: usize, count: usize| (pixel as f64 + 0.5) / count as f64;
            point[right] = low[right] + (high[right] - low[right]) * share(column, size[0]);
            point[up] = high[up] - (high[up] - low[up]) * share(row, size[1]);
            point
        });
        ValueImage { size, values }
    }
}
