//! From where a picture is taken.

use std::array;

use amray::Volume;
use amray::scene::{Camera, CameraError, Projection, Viewpoint};
use clap::Args;

use crate::number;
use crate::view_file::View;

/// Degrees.
const FOVY: f64 = 30.0;

/// The camera; what is not given frames the domain.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ViewArguments {
    /// Where the camera is, in world units
    #[arg(long, value_name = "X,Y,Z", value_parser = number::list::<3>, allow_hyphen_values = true)]
    eye: Option<[f64; 3]>,
    /// What the camera looks at [default: the middle of the domain]
    #[arg(long, value_name = "X,Y,Z", value_parser = number::list::<3>, allow_hyphen_values = true)]
    target: Option<[f64; 3]>,
    /// The direction that is up in the picture [default: 0,0,1]
    #[arg(long, value_name = "X,Y,Z", value_parser = number::list::<3>, allow_hyphen_values = true)]
    up: Option<[f64; 3]>,
    /// Vertical opening angle of the picture in degrees [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = number::angle)]
    fovy: Option<f64>,
    /// Parallel rays instead of perspective; the target keeps its size
    #[arg(long)]
    orthographic: bool,
    /// All around the eye: a picture twice as wide as high, as viewers of panoramas expect it. Give it an --eye inside
    #[arg(long, conflicts_with_all = ["orthographic", "fovy"])]
    pub(crate) panorama: bool,
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
        }
    }
}

impl ViewArguments {
    /// These flags, and where they are not given, `others`.
    pub(crate) fn or(&self, others: &Self) -> Self {
        Self {
            eye: self.eye.or(others.eye),
            target: self.target.or(others.target),
            up: self.up.or(others.up),
            fovy: self.fovy.or(others.fovy),
            orthographic: self.orthographic || others.orthographic,
            panorama: self.panorama || others.panorama,
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
