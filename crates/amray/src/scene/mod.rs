//! What a picture is made of: the volume, how it looks, and from where it is seen.

mod camera;
mod camera_path;
mod clip;
mod lighting;
mod look;
mod outline;
mod surface;

use crate::Volume;
use crate::appearance::TransferFunction;

pub(crate) use camera::PictureRays;
pub use camera::{Camera, CameraError, CameraRay, Projection, Viewpoint};
pub use camera_path::{CameraKey, CameraPath, CameraPathError, orbit};
pub use clip::Clip;
pub use lighting::{AmbientOcclusion, Light, Lighting, LightingError, Material, SHADOW_LIGHTS, Shading};
pub use look::{Look, LookError};
pub use outline::{Outline, level_color, outline_mesh};
pub use surface::{Paint, Shape, Surface};

/// The most fields that a scene shows, its volume's and those that it is coloured by included.
pub const MOST_FIELDS: usize = 4;

/// A field that a scene shows besides its volume, of the same index and with the same method.
#[derive(Clone, Debug)]
pub struct ShownField<'a> {
    /// The data.
    pub volume: &'a Volume,
    /// Value to colour and opacity.
    pub transfer_function: TransferFunction,
}

/// Everything that decides what a picture shows.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The data.
    pub volume: &'a Volume,
    /// Value to colour and opacity.
    pub transfer_function: TransferFunction,
    /// What gives the volume its colours, if not its own transfer function: the colours of another field's values.
    /// Where these are not a number, the volume is not seen.
    /// [`Engine::Query`](crate::render::Engine::Query) leaves it out, and overlays.
    pub colors: Option<ShownField<'a>>,
    /// Fields that are seen together with the volume: at each place extinctions add up, and so does what they give off.
    pub overlays: Vec<ShownField<'a>>,
    /// The length, in world units, that the transfer functions' opacities refer to: positive and finite.
    pub unit_distance: f64,
    /// From where it is seen.
    pub camera: Camera,
    /// What lights it.
    pub lighting: Lighting,
    /// What else is there. [`Engine::Query`](crate::render::Engine::Query) leaves it out.
    pub surfaces: Vec<Surface<'a>>,
    /// What of the volume is cut away.
    pub clips: Vec<Clip>,
}

impl<'a> Scene<'a> {
    /// A volume alone that glows in its own colours.
    pub fn new(volume: &'a Volume, transfer_function: TransferFunction, unit_distance: f64, camera: Camera) -> Self {
        Self {
            volume,
            transfer_function,
            colors: None,
            overlays: Vec::new(),
            unit_distance,
            camera,
            lighting: Lighting::default(),
            surfaces: Vec::new(),
            clips: Vec::new(),
        }
    }
}
