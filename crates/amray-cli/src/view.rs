//! From where a picture is taken.

use amray::Volume;
use amray::scene::{Camera, CameraError, Projection, Viewpoint};
use clap::Args;

use crate::number;

/// The camera; what is not given frames the domain.
#[derive(Debug, Args)]
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
    /// Vertical opening angle of the picture in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = Self::default().fovy, value_parser = number::angle)]
    fovy: f64,
    /// Parallel rays instead of perspective; the target keeps its size
    #[arg(long)]
    orthographic: bool,
}

/// What the flags are where they are not given.
impl Default for ViewArguments {
    fn default() -> Self {
        Self { eye: None, target: None, up: None, fovy: 30.0, orthographic: false }
    }
}

impl ViewArguments {
    /// The camera that looks at `volume` for a picture of `size` pixels.
    pub(crate) fn camera(&self, volume: &Volume, size: [usize; 2]) -> Result<Camera, CameraError> {
        let aspect = size[0] as f64 / size[1] as f64;
        let framing = Viewpoint::framing(volume.hierarchy().bounds(), self.fovy, aspect);
        let viewpoint = Viewpoint {
            eye: self.eye.unwrap_or(framing.eye),
            target: self.target.unwrap_or(framing.target),
            up: self.up.unwrap_or(framing.up),
            projection: Projection::Perspective { fovy: self.fovy },
        };
        Camera::new(if self.orthographic { viewpoint.orthographic() } else { viewpoint })
    }
}
