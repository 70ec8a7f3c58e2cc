//! From where a picture is taken.

use std::array;

use amray::Volume;
use amray::scene::{Camera, CameraError, Projection, Viewpoint};
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::number;
use crate::scene_file::checked;
use crate::view_file::View;

/// The opening angle where nothing says so, in degrees.
pub(crate) const FOVY: f64 = 30.0;

/// The camera; what is not given frames the domain.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ViewArguments {
    /// Where the camera is, in world units
    #[arg(long, value_name = "X,Y,Z", value_parser = number::list::<3>, allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    eye: Option<[f64; 3]>,
    /// What the camera looks at [default: the middle of the domain]
    #[arg(long, value_name = "X,Y,Z", value_parser = number::list::<3>, allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<[f64; 3]>,
    /// The direction that is up in the picture [default: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = number::list::<3>, allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<[f64; 3]>,
    /// Vertical opening angle of the picture in degrees [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = number::angle)]
    #[serde(deserialize_with = "checked::angle", skip_serializing_if = "Option::is_none")]
    fovy: Option<f64>,
    /// Parallel rays instead of perspective; the target keeps its size
    #[arg(long)]
    pub(crate) orthographic: bool,
    /// All around the eye: a picture twice as wide as high, as viewers of panoramas expect it. Give it an --eye inside
    #[arg(long, conflicts_with_all = ["orthographic", "fovy"])]
    pub(crate) panorama: bool,
    /// A pair of pictures for the left and the right eye, side by side, each of --size; SEPARATION is in world units
    /// [default: a thirtieth of the way to the target]
    #[arg(long, value_name = "SEPARATION", num_args = 0..=1, default_missing_value = "", value_parser = stereo)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) stereo: Option<Stereo>,
}

/// How far apart a pair of eyes is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Stereo {
    /// So that the target can be looked at comfortably.
    Comfortable,
    /// In world units.
    Apart(f64),
}

/// How many times as far as its eyes are apart a target is that is looked at comfortably.
const COMFORTABLE: f64 = 30.0;

/// A distance, or nothing.
fn stereo(text: &str) -> Result<Stereo, String> {
    match text {
        "" => Ok(Stereo::Comfortable),
        text => number::positive(text).map(Stereo::Apart),
    }
}

impl Stereo {
    /// The left and the right eye.
    pub(crate) fn pair(self, camera: &Camera) -> Result<[Camera; 2], CameraError> {
        camera.stereo_pair(match self {
            Self::Comfortable => camera.distance() / COMFORTABLE,
            Self::Apart(separation) => separation,
        })
    }
}

impl From<&View> for ViewArguments {
    fn from(view: &View) -> Self {
        Self {
            eye: Some(view.eye),
            target: Some(view.target),
            up: Some(view.up),
            fovy: Some(view.fovy),
            orthographic: false,
            panorama: false,
            stereo: None,
        }
    }
}

impl ViewArguments {
    /// A camera as it was found.
    pub(crate) fn resolved(&self, camera: &Camera) -> Self {
        let Viewpoint { eye, target, up, .. } = *camera.viewpoint();
        let fovy = if self.panorama { None } else { Some(self.fovy.unwrap_or(FOVY)) };
        Self { eye: Some(eye), target: Some(target), up: Some(up), fovy, ..self.clone() }
    }

    /// These flags, and where they are not given, `others`.
    pub(crate) fn or(&self, others: &Self) -> Self {
        let projection = if self.orthographic || self.panorama { self } else { others };
        Self {
            eye: self.eye.or(others.eye),
            target: self.target.or(others.target),
            up: self.up.or(others.up),
            fovy: self.fovy.or(others.fovy),
            orthographic: projection.orthographic,
            panorama: projection.panorama,
            stereo: self.stereo.or(others.stereo),
        }
    }

    /// The camera that looks at `volume` for a picture of `size` pixels; without an eye given, it is `room` times as far
    /// away as the domain needs.
    pub(crate) fn camera(&self, volume: &Volume, size: [usize; 2], room: f64) -> Result<Camera, CameraError> {
        let aspect = size[0] as f64 / size[1] as f64;
        let fovy = self.fovy.unwrap_or(FOVY);
        let framing = Viewpoint::framing(volume.hierarchy().bounds(), fovy, aspect);
        let viewpoint = Viewpoint {
            eye: self.eye.unwrap_or(array::from_fn(|axis| {
                framing.target[axis] + room * (framing.eye[axis] - framing.target[axis])
            })),
            target: self.target.unwrap_or(framing.target),
            up: self.up.unwrap_or(framing.up),
            projection: Projection::Perspective { fovy },
        };
        Camera::new(match self {
            Self { panorama: true, .. } => Viewpoint { projection: Projection::Panorama, ..viewpoint },
            Self { orthographic: true, .. } => viewpoint.orthographic(),
            _ => viewpoint,
        })
    }
}
