//! Lights, and what they make of volumes and surfaces.

use thiserror::Error;

use super::Camera;

/// A source of light. Colours are linear factors on what is lit, 1 for as bright as its own colour; they may exceed 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case", deny_unknown_fields))]
pub enum Light {
    /// From everywhere alike. Ambient occlusion takes from it; to path tracing it is the environment.
    Ambient {
        /// Red, green and blue.
        color: [f32; 3],
    },
    /// From the eye: it throws no shadow that could be seen.
    Headlight {
        /// Red, green and blue.
        color: [f32; 3],
    },
    /// From very far away.
    Directional {
        /// Where the light goes: of any length but 0.
        direction: [f64; 3],
        /// Red, green and blue.
        color: [f32; 3],
    },
    /// From a point in world units, inside or outside the volume.
    Point {
        /// Where it is.
        position: [f64; 3],
        /// Red, green and blue, at `reach`.
        color: [f32; 3],
        /// The distance at which the light has its colour, and from which on it falls off by the square of the
        /// distance; the same everywhere where it is not given.
        reach: Option<f64>,
    },
}

/// How something reflects light (Blinn and Phong's model).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// How much of the ambient light it reflects.
    pub ambient: f32,
    /// How much of the other lights it reflects in all directions.
    pub diffuse: f32,
    /// How bright highlights are, which have the light's colour.
    pub specular: f32,
    /// How sharp highlights are: the exponent.
    pub specular_power: f32,
}

/// How a volume takes part in light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shading {
    /// It glows in its own colours: lights do not matter.
    #[default]
    Emissive,
    /// It reflects the light that arrives alike in all directions.
    Isotropic,
    /// It reflects like a surface across the gradient, on both sides; the more like [`Shading::Isotropic`], the
    /// smaller the gradient is.
    Gradient(Material),
}

/// Short rays that find how much of the ambient light arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Rays per point, at least 1.
    pub rays: usize,
    /// How far they go, in world units.
    pub distance: f64,
}

/// Everything about light in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// The sources.
    pub lights: Vec<Light>,
    /// How volumes take part.
    pub shading: Shading,
    /// Whether directional and point lights are dimmed by what lies between: volumes and surfaces.
    pub shadows: bool,
    /// Whether, and how, ambient light is dimmed by what is near.
    pub ambient_occlusion: Option<AmbientOcclusion>,
}

/// How many directional and point lights can cast shadows in one picture.
pub const SHADOW_LIGHTS: usize = 4;

/// A light, a material or occlusion that cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{what} is {found}, expected {expected}")]
pub struct LightingError {
    /// What is wrong, as in `light 2: direction`.
    pub what: String,
    /// What it is.
    pub found: String,
    /// What it can be.
    pub expected: &'static str,
}

impl Default for Material {
    fn default() -> Self {
        Self { ambient: 1.0, diffuse: 1.0, specular: 0.2, specular_power: 32.0 }
    }
}

impl Default for Lighting {
    /// A headlight and a little ambient light; together they leave colours facing the eye as they are.
    fn default() -> Self {
        Self {
            lights: vec![Light::Ambient { color: [0.2; 3] }, Light::Headlight { color: [0.8; 3] }],
            shading: Shading::Emissive,
            shadows: false,
            ambient_occlusion: None,
        }
    }
}

impl Light {
    /// The light's colour.
    pub fn color(&self) -> [f32; 3] {
        match *self {
            Self::Ambient { color }
            | Self::Headlight { color }
            | Self::Directional { color, .. }
            | Self::Point { color, .. } => color,
        }
    }

    /// Whether the light is directional or a point: comes from one place, which may lie in shadow.
    pub fn casts_shadows(&self) -> bool {
        matches!(self, Self::Directional { .. } | Self::Point { .. })
    }
}

impl Lighting {
    /// Lights for pictures with shadows: ambient light, and more from the upper left behind the camera.
    pub fn from_upper_left(camera: &Camera) -> Vec<Light> {
        vec![
            Light::Ambient { color: [0.3; 3] },
            Light::Directional { direction: camera.direction([0.6, -0.7, 1.0]), color: [0.8; 3] },
        ]
    }

    /// Whether light can be kept from arriving, by shadows or occlusion.
    pub(crate) fn may_be_missing(&self) -> bool {
        let shadows = self.shadows && self.lights.iter().any(Light::casts_shadows);
        shadows || self.ambient_occlusion.is_some()
    }

    /// Whether volumes take part in that: those that glow do not.
    pub(crate) fn dims_volumes(&self) -> bool {
        self.shading != Shading::Emissive && self.may_be_missing()
    }

    /// # Errors
    /// [`LightingError`] names the first number that cannot be.
    pub fn check(&self) -> Result<(), LightingError> {
        let wrong = |what: String, found: String, expected| Err(LightingError { what, found, expected });
        let casting = self.lights.iter().filter(|light| light.casts_shadows()).count();
        if self.shadows && casting > SHADOW_LIGHTS {
            return wrong("the number of lights that cast shadows".into(), casting.to_string(), "at most 4");
        }
        for (number, light) in self.lights.iter().enumerate() {
            let name = |part: &str| format!("light {number}: {part}");
            if light.color().iter().any(|channel| !(*channel >= 0.0 && channel.is_finite())) {
                let found = format!("{:?}", light.color());
                return wrong(name("color"), found, "finite numbers of at least 0");
            }
            match *light {
                Light::Directional { direction, .. } => {
                    let length = direction.map(|part| part * part).iter().sum::<f64>();
                    if !(length > 0.0 && length.is_finite()) {
                        return wrong(name("direction"), format!("{direction:?}"), "a vector other than 0");
                    }
                }
                Light::Point { position, reach, .. } => {
                    if position.iter().any(|part| !part.is_finite()) {
                        return wrong(name("position"), format!("{position:?}"), "finite numbers");
                    }
                    if let Some(reach) = reach.filter(|reach| !(*reach > 0.0 && reach.is_finite())) {
                        return wrong(name("reach"), reach.to_string(), "a positive length");
                    }
                }
                Light::Ambient { .. } | Light::Headlight { .. } => {}
            }
        }
        if let Shading::Gradient(Material { ambient, diffuse, specular, specular_power }) = self.shading {
            let parts = [ambient, diffuse, specular, specular_power];
            if parts.iter().any(|part| !(*part >= 0.0 && part.is_finite())) {
                return wrong("material".into(), format!("{parts:?}"), "finite numbers of at least 0");
            }
        }
        match self.ambient_occlusion {
            Some(AmbientOcclusion { rays: 0, .. }) => wrong("ambient occlusion: rays".into(), "0".into(), "at least 1"),
            Some(AmbientOcclusion { distance, .. }) if !(distance > 0.0 && distance.is_finite()) => {
                wrong("ambient occlusion: distance".into(), distance.to_string(), "a positive length")
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_leaves_colours_that_face_the_eye_as_they_are() {
        let sum: f32 = Lighting::default().lights.iter().map(|light| light.color()[0]).sum();
        assert_eq!(sum, 1.0);
        assert_eq!(Lighting::default().check(), Ok(()));
    }

    #[test]
    fn what_cannot_be_is_named() {
        let message = |change: fn(&mut Lighting)| {
            let mut lighting = Lighting::default();
            change(&mut lighting);
            lighting.check().unwrap_err().to_string()
        };
        let color = [1.0; 3];
        assert_eq!(
            message(|lighting| lighting.lights[1] = Light::Ambient { color: [0.0, f32::NAN, 0.0] }),
            "light 1: color is [0.0, NaN, 0.0], expected finite numbers of at least 0"
        );
        assert_eq!(
            message(|lighting| lighting.lights.push(Light::Directional { direction: [0.0; 3], color: [1.0; 3] })),
            "light 2: direction is [0.0, 0.0, 0.0], expected a vector other than 0"
        );
        let reach = Light::Point { position: [0.0; 3], color, reach: Some(0.0) };
        let lighting = Lighting { lights: vec![reach], ..Lighting::default() };
        assert_eq!(lighting.check().unwrap_err().to_string(), "light 0: reach is 0, expected a positive length");
        assert_eq!(
            message(|lighting| lighting.ambient_occlusion = Some(AmbientOcclusion { rays: 4, distance: -1.0 })),
            "ambient occlusion: distance is -1, expected a positive length"
        );
    }
}
