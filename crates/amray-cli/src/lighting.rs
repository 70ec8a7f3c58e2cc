//! What lights a picture, from the flags.

use std::str::FromStr;

use amray::scene::{AmbientOcclusion, Camera, Light, Lighting, LightingError, Material, Shading};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use crate::number;
use crate::scene_file::{self, checked};

/// Rays around a point go this share of the domain's longest side.
const OCCLUSION_DISTANCE: f64 = 0.1;

/// Lights, and what they do.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct LightingArguments {
    /// How volumes reflect light: across their gradient, like surfaces, or alike in all directions [default: they glow,
    /// or reflect alike in all directions where there are shadows or occlusion]
    #[arg(long, value_name = "KIND", num_args = 0..=1, default_missing_value = "gradient")]
    #[serde(skip_serializing_if = "Option::is_none")]
    shading: Option<ShadingName>,
    /// A light: ambient:COLOR, headlight:COLOR, directional:X,Y,Z:COLOR (where it goes) or point:X,Y,Z:COLOR[:REACH]
    /// (from REACH on it falls off by the square of the distance); COLOR is a number or R,G,B. May be repeated
    /// [default: a little ambient light and a headlight or, with shadows, a light from the upper left]
    #[arg(long, value_name = "LIGHT", value_parser = light, allow_hyphen_values = true)]
    #[serde(deserialize_with = "lights", skip_serializing_if = "Vec::is_empty")]
    light: Vec<Light>,
    /// Directional and point lights throw shadows
    #[arg(long)]
    shadows: bool,
    /// Ambient occlusion with N rays per point
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    #[serde(deserialize_with = "checked::count::<1024, _>", skip_serializing_if = "Option::is_none")]
    ao: Option<u16>,
    /// How far rays of ambient occlusion go, in world units [default: a tenth of the domain's longest side]
    #[arg(long, value_name = "LENGTH", value_parser = number::positive, requires = "ao")]
    #[serde(deserialize_with = "checked::positive", skip_serializing_if = "Option::is_none")]
    ao_distance: Option<f64>,
}

/// How volumes reflect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum ShadingName {
    Gradient,
    Isotropic,
}

impl LightingArguments {
    /// These flags, and where they are not given, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            shading: self.shading.or(others.shading),
            light: scene_file::or(self.light, others.light),
            shadows: self.shadows || others.shadows,
            ao: self.ao.or(others.ao),
            ao_distance: self.ao_distance.or(others.ao_distance),
        }
    }

    /// With the lights that were found.
    pub(crate) fn resolved(&self, lighting: &Lighting) -> Self {
        let shading = match lighting.shading {
            // Lights do not matter.
            Shading::Emissive => return self.clone(),
            Shading::Isotropic => ShadingName::Isotropic,
            Shading::Gradient(_) => ShadingName::Gradient,
        };
        let ao_distance = lighting.ambient_occlusion.map(|occlusion| occlusion.distance);
        Self { shading: Some(shading), light: lighting.lights.clone(), ao_distance, ..self.clone() }
    }

    /// The lighting of a picture by `camera` of a domain with the longest side `longest`, in which volumes may be known to
    /// scatter light.
    ///
    /// # Errors
    /// Where there are more lights with shadows than can be.
    pub(crate) fn lighting(&self, camera: &Camera, longest: f64, scatters: bool) -> Result<Lighting, LightingError> {
        let occlusion = |rays: u16| AmbientOcclusion {
            rays: rays.into(),
            distance: self.ao_distance.unwrap_or(OCCLUSION_DISTANCE * longest),
        };
        let shading = match self.shading {
            Some(ShadingName::Gradient) => Shading::Gradient(Material::default()),
            Some(ShadingName::Isotropic) => Shading::Isotropic,
            None if scatters || self.shadows || self.ao.is_some() || !self.light.is_empty() => Shading::Isotropic,
            None => Shading::Emissive,
        };
        let lights = match self.light.is_empty() {
            true if scatters || self.shadows => Lighting::from_upper_left(camera),
            true => Lighting::default().lights,
            false => self.light.clone(),
        };
        let ambient_occlusion = self.ao.map(occlusion);
        let lighting = Lighting { lights, shading, shadows: self.shadows, ambient_occlusion };
        lighting.check().map(|()| lighting)
    }
}

/// Lights of a scene file that can be.
fn lights<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Light>, D::Error> {
    let lights = Vec::<Light>::deserialize(deserializer)?;
    let lighting = Lighting { lights, ..Lighting::default() };
    lighting.check().map_err(D::Error::custom)?;
    Ok(lighting.lights)
}

/// `KIND:...` as in the help of `--light`.
fn light(text: &str) -> Result<Light, String> {
    let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
    let parts: Vec<&str> = rest.split(':').collect();
    let light = match (kind, &parts[..]) {
        ("ambient", [shade]) => Light::Ambient { color: color(shade)? },
        ("headlight", [shade]) => Light::Headlight { color: color(shade)? },
        ("directional", [direction, shade]) => {
            Light::Directional { direction: number::list(direction)?, color: color(shade)? }
        }
        ("point", [position, shade]) => {
            Light::Point { position: number::list(position)?, color: color(shade)?, reach: None }
        }
        ("point", [position, shade, reach]) => {
            let reach = Some(number::positive(reach)?);
            Light::Point { position: number::list(position)?, color: color(shade)?, reach }
        }
        _ => {
            let kinds = "ambient:COLOR, headlight:COLOR, directional:X,Y,Z:COLOR or point:X,Y,Z:COLOR[:REACH]";
            return Err(format!("expected {kinds}"));
        }
    };
    let lighting = Lighting { lights: vec![light], ..Lighting::default() };
    lighting.check().map(|()| light).map_err(|LightingError { what, found, expected }| {
        let what = what.rsplit(' ').next().unwrap_or_default().to_owned();
        format!("{what} is {found}, expected {expected}")
    })
}

/// One number for a grey, or red, green and blue.
fn color(text: &str) -> Result<[f32; 3], String> {
    let channels = match f64::from_str(text) {
        Ok(grey) => [grey; 3],
        Err(_) => number::list(text).map_err(|_| format!("{text:?} is no colour: expected a number or r,g,b"))?,
    };
    Ok(channels.map(|channel| channel as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_read() {
        assert_eq!(light("ambient:0.25"), Ok(Light::Ambient { color: [0.25; 3] }));
        assert_eq!(light("headlight:1,0.5,0"), Ok(Light::Headlight { color: [1.0, 0.5, 0.0] }));
        let direction = [-1.0, 0.0, -2.5];
        assert_eq!(light("directional:-1,0,-2.5:2"), Ok(Light::Directional { direction, color: [2.0; 3] }));
        let position = [1.0, 2.0, 3.0];
        assert_eq!(light("point:1,2,3:1"), Ok(Light::Point { position, color: [1.0; 3], reach: None }));
        assert_eq!(light("point:1,2,3:1:0.5"), Ok(Light::Point { position, color: [1.0; 3], reach: Some(0.5) }));
    }

    #[test]
    fn what_is_no_light_is_explained() {
        for (text, part) in [
            ("sun", "expected ambient:COLOR"),
            ("point:1,2:1", "expected 3 numbers"),
            ("ambient:red", "no colour"),
            ("ambient:-1", "color is [-1.0, -1.0, -1.0], expected finite numbers of at least 0"),
            ("directional:0,0,0:1", "expected a vector other than 0"),
            ("point:1,2,3:1:0", "expected a number above 0"),
        ] {
            let message = light(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
