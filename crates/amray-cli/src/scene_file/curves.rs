//! Transfer functions in scene files: all their points, so that nothing is lost.

use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A transfer function's curves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Curves {
    /// Linear in the value's logarithm.
    #[serde(default)]
    log: bool,
    /// Value, red, green and blue, by ascending value.
    colors: Vec<(f64, f32, f32, f32)>,
    /// Value and opacity, from 0 to 1 for the unit distance; without them and extinctions all is opaque.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    opacities: Option<Vec<[f64; 2]>>,
    /// Value and extinction, per world length, in place of opacities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    extinctions: Option<Vec<[f64; 2]>>,
}

impl From<&TransferFunction> for Curves {
    fn from(function: &TransferFunction) -> Self {
        let colors = function.colors().iter().map(|ColorPoint { value, color: [r, g, b] }| (*value, *r, *g, *b));
        let points = Some(function.opacity().points().iter().map(|point| [point.value, point.opacity]).collect());
        let (opacities, extinctions) = match function.opacity() {
            Opacity::PerUnitDistance(_) => (points, None),
            Opacity::Extinction(_) => (None, points),
        };
        Self { log: function.scale() == Scale::Log10, colors: colors.collect(), opacities, extinctions }
    }
}

impl Curves {
    /// The transfer function with these curves; opaque where they tell no opacities.
    pub(crate) fn function(&self) -> Result<TransferFunction, String> {
        let scale = if self.log { Scale::Log10 } else { Scale::Linear };
        let colors = self.colors.iter().map(|&(value, r, g, b)| ColorPoint { value, color: [r, g, b] }).collect();
        let points =
            |points: &[[f64; 2]]| points.iter().map(|&[value, opacity]| OpacityPoint { value, opacity }).collect();
        let opacity = match (&self.opacities, &self.extinctions) {
            (Some(_), Some(_)) => return Err("extinctions beside opacities, expected one of them".into()),
            (None, Some(extinctions)) => Opacity::Extinction(points(extinctions)),
            (Some(opacities), None) => Opacity::PerUnitDistance(points(opacities)),
            (None, None) => Opacity::PerUnitDistance(points(&[[1.0; 2]])),
        };
        TransferFunction::new(scale, colors, opacity).map_err(|error| error.to_string())
    }
}
