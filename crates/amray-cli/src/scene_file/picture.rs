//! Pixels, and how exact they are.

use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checked;
use crate::number;

/// The picture itself.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct PictureSection {
    /// Pixels [default: 1024x1024]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = number::size)]
    #[serde(deserialize_with = "checked::size", skip_serializing_if = "Option::is_none")]
    pub(crate) size: Option<[usize; 2]>,
    /// Multiply all opacities [default: 1]
    #[arg(long, value_name = "A", value_parser = number::positive)]
    #[serde(deserialize_with = "checked::positive", skip_serializing_if = "Option::is_none")]
    pub(crate) opacity: Option<f64>,
    /// The length that opacities refer to [default: a hundredth of the domain's longest side]
    #[arg(long, value_name = "D", value_parser = number::positive)]
    #[serde(deserialize_with = "checked::positive", skip_serializing_if = "Option::is_none")]
    pub(crate) unit_distance: Option<f64>,
    /// Samples per cell width along a ray [default: 1]
    #[arg(long, value_name = "R", value_parser = number::samples_per_cell)]
    #[serde(deserialize_with = "checked::samples_per_cell", skip_serializing_if = "Option::is_none")]
    pub(crate) samples_per_cell: Option<f64>,
    /// Rays per pixel [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    #[serde(deserialize_with = "checked::count::<{ u16::MAX }, _>", skip_serializing_if = "Option::is_none")]
    pub(crate) spp: Option<u16>,
    /// Seed of the noise that hides banding [default: 0]
    #[arg(long, value_name = "SEED")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) seed: Option<u64>,
    /// What is behind the volume in a .png, each 0 to 1 [default: 1,1,1]
    #[arg(long, value_name = "R,G,B[,A]", value_parser = number::color)]
    #[serde(deserialize_with = "checked::color", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<f32>>", length(min = 3, max = 4))]
    pub(crate) background: Option<[f32; 4]>,
}

impl PictureSection {
    /// These flags, and where they are not given, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            size: self.size.or(others.size),
            opacity: self.opacity.or(others.opacity),
            unit_distance: self.unit_distance.or(others.unit_distance),
            samples_per_cell: self.samples_per_cell.or(others.samples_per_cell),
            spp: self.spp.or(others.spp),
            seed: self.seed.or(others.seed),
            background: self.background.or(others.background),
        }
    }

    /// With nothing left to be chosen.
    pub(crate) fn resolved(&self, size: [usize; 2], unit_distance: f64) -> Self {
        Self {
            size: Some(size),
            opacity: Some(self.opacity.unwrap_or(1.0)),
            unit_distance: Some(unit_distance),
            samples_per_cell: Some(self.samples_per_cell.unwrap_or(1.0)),
            spp: Some(self.spp.unwrap_or(1)),
            seed: Some(self.seed.unwrap_or(0)),
            background: Some(self.background()),
        }
    }

    /// What is behind the volume.
    pub(crate) fn background(&self) -> [f32; 4] {
        self.background.unwrap_or([1.0; 4])
    }
}
