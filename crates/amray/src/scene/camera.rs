//! Cameras: from pixels to rays.

use glam::DVec3;
use thiserror::Error;

/// How rays leave the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays leave the eye.
    Perspective {
        /// The picture's vertical opening angle in degrees, between 0 and 180.
        fovy: f64,
    },
    /// All rays are parallel.
    Orthographic {
        /// The picture's height in world units.
        height: f64,
    },
}

/// A camera, not yet checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Where the camera is.
    pub eye: [f64; 3],
    /// What it looks at: the middle of the picture.
    pub target: [f64; 3],
    /// The direction that is up in the picture.
    pub up: [f64; 3],
    /// How rays leave it.
    pub projection: Projection,
}

/// A camera that can see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    viewpoint: Viewpoint,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

/// A ray in world units; the direction has length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraRay {
    /// Where it starts.
    pub start: [f64; 3],
    /// Where it goes.
    pub direction: [f64; 3],
}

/// A camera that cannot see.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CameraError {
    /// A position, direction or size is not finite.
    #[error("camera: {what} {found:?} is not finite")]
    NotFinite {
        /// Which one.
        what: &'static str,
        /// Its value.
        found: [f64; 3],
    },
    /// Eye and target are the same point.
    #[error("camera: eye and target are both {0:?}, expected two different points")]
    NoDirection([f64; 3]),
    /// Up points along the view.
    #[error("camera: up {up:?} is parallel to the view direction {view:?}")]
    UpAlongView {
        /// The up direction.
        up: [f64; 3],
        /// From the eye to the target.
        view: [f64; 3],
    },
    /// An opening angle or height that no picture has.
    #[error("camera: {what} is {found}, expected {expected}")]
    Projection {
        /// The vertical opening angle or the height.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What it can be.
        expected: &'static str,
    },
}

/// The default view comes from the front right and a little from above, with z up.
const DEFAULT_DIRECTION: DVec3 = DVec3::new(0.55, -0.75, 0.4);
const DEFAULT_UP: DVec3 = DVec3::Z;
/// The domain fills this share of the picture's width or height.
const FILLED: f64 = 0.96;

impl Viewpoint {
    /// The default viewpoint: all of a box just fits into a picture of `aspect` (width / height) with the opening
    /// angle `fovy` in degrees.
    pub fn framing(bounds: [[f64; 3]; 2], fovy: f64, aspect: f64) -> Self {
        let [low, high] = bounds.map(DVec3::from_array);
        let center = (low + high) / 2.0;
        let back = DEFAULT_DIRECTION.normalize();
        let right = DEFAULT_UP.cross(back).normalize();
        let up = back.cross(right);
        let half_height = (fovy.to_radians() / 2.0).tan() * FILLED;
        let corners = (0..8).map(|corner| {
            let side = |axis: usize| if corner >> axis & 1 == 1 { high } else { low };
            DVec3::new(side(0).x, side(1).y, side(2).z) - center
        });
        // Each corner asks for a distance at which it is inside the opening angle, across and up.
        let distance = corners
            .map(|corner| {
                let across = corner.dot(right).abs() / (half_height * aspect);
                let upward = corner.dot(up).abs() / half_height;
                across.max(upward) + corner.dot(back)
            })
            .fold(0.0, f64::max);
        Self {
            eye: (center + back * distance).to_array(),
            target: center.to_array(),
            up: DEFAULT_UP.to_array(),
            projection: Projection::Perspective { fovy },
        }
    }

    /// The same view without perspective: what lies at the target's distance keeps its size.
    pub fn orthographic(self) -> Self {
        let Projection::Perspective { fovy } = self.projection else { return self };
        let distance = DVec3::from_array(self.eye).distance(DVec3::from_array(self.target));
        let height = 2.0 * distance * (fovy.to_radians() / 2.0).tan();
        Self { projection: Projection::Orthographic { height }, ..self }
    }
}

impl Camera {
    /// The camera at a viewpoint.
    ///
    /// # Errors
    /// [`CameraError`] where no picture can be taken from there.
    pub fn new(viewpoint: Viewpoint) -> Result<Self, CameraError> {
        let Viewpoint { eye, target, up, projection } = viewpoint;
        for (what, found) in [("eye", eye), ("target", target), ("up", up)] {
            if found.iter().any(|value| !value.is_finite()) {
                return Err(CameraError::NotFinite { what, found });
            }
        }
        let view = DVec3::from_array(target) - DVec3::from_array(eye);
        let forward = view.try_normalize().ok_or(CameraError::NoDirection(eye))?;
        let upward = DVec3::from_array(up).normalize_or_zero();
        let right = forward.cross(upward);
        if right.length() < 1e-9 {
            return Err(CameraError::UpAlongView { up, view: view.to_array() });
        }
        match projection {
            Projection::Perspective { fovy: found } if !(found > 0.0 && found < 180.0) => {
                let expected = "an angle between 0 and 180 degrees";
                return Err(CameraError::Projection { what: "the vertical opening angle", found, expected });
            }
            Projection::Orthographic { height: found } if !(found > 0.0 && found.is_finite()) => {
                let expected = "a positive length";
                return Err(CameraError::Projection { what: "the height", found, expected });
            }
            _ => {}
        }
        let right = right.normalize();
        Ok(Self { viewpoint, forward, right, up: right.cross(forward) })
    }

    /// Where the camera stands and looks.
    pub fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// A direction in world space, given as parts to the right, up and forward in the picture.
    pub fn direction(&self, [right, up, forward]: [f64; 3]) -> [f64; 3] {
        (self.right * right + self.up * up + self.forward * forward).to_array()
    }

    /// The ray through a point of a picture of `size` pixels (width, height): (0, 0) is the top left corner, pixel
    /// (i, j) has its centre at (i + 1/2, j + 1/2).
    pub fn ray(&self, size: [usize; 2], pixel: [f64; 2]) -> CameraRay {
        let plane = self.picture_plane(size);
        let at = |[corner, right, down]: [DVec3; 3]| corner + right * pixel[0] + down * pixel[1];
        CameraRay { start: at(plane.start).to_array(), direction: at(plane.direction).normalize().to_array() }
    }

    /// How rays change over a picture of `size` pixels.
    pub(crate) fn picture_plane(&self, size: [usize; 2]) -> PicturePlane {
        let [width, height] = size.map(|pixels| pixels as f64);
        let eye = DVec3::from_array(self.viewpoint.eye);
        // From -1/2 at the bottom to 1/2 on top; pixels are square.
        let over = |middle: DVec3, picture: f64| {
            let [right, down] = [self.right, -self.up].map(|axis| axis * (picture / height));
            [middle - right * (width / 2.0) - down * (height / 2.0), right, down]
        };
        let still = |vector| [vector, DVec3::ZERO, DVec3::ZERO];
        match self.viewpoint.projection {
            Projection::Perspective { fovy } => {
                let picture = 2.0 * (fovy.to_radians() / 2.0).tan();
                PicturePlane { start: still(eye), direction: over(self.forward, picture) }
            }
            Projection::Orthographic { height } => {
                PicturePlane { start: over(eye, height), direction: still(self.forward) }
            }
        }
    }
}

/// Rays of a picture, linear in the pixel: at its corner (0, 0), and by how much they change per pixel to the right and
/// down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PicturePlane {
    pub(crate) start: [DVec3; 3],
    /// Not of length 1.
    pub(crate) direction: [DVec3; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking_down_z() -> Viewpoint {
        Viewpoint {
            eye: [0.0, 0.0, 10.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            projection: Projection::Perspective { fovy: 90.0 },
        }
    }

    #[test]
    fn row_zero_is_on_top_and_pixels_are_square() {
        let camera = Camera::new(looking_down_z()).unwrap();
        assert_eq!(camera.ray([200, 100], [100.0, 50.0]).direction, [0.0, 0.0, -1.0]);
        let top = camera.ray([200, 100], [100.0, 0.0]).direction;
        assert!((top[1] / -top[2] - 1.0).abs() < 1e-12 && top[0] == 0.0);
        let right = camera.ray([200, 100], [200.0, 50.0]).direction;
        assert!((right[0] / -right[2] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn orthographic_rays_are_parallel_and_keep_the_size_at_the_target() {
        let camera = Camera::new(looking_down_z().orthographic()).unwrap();
        assert!(
            matches!(camera.viewpoint().projection, Projection::Orthographic { height } if (height - 20.0).abs() < 1e-9)
        );
        let ray = camera.ray([100, 100], [0.0, 0.0]);
        assert!((ray.start[0] + 10.0).abs() < 1e-9 && (ray.start[1] - 10.0).abs() < 1e-9);
        assert_eq!(ray.direction, [0.0, 0.0, -1.0]);
    }

    #[test]
    fn framing_fits_the_box() {
        let bounds = [[-3.0, 1.0, 2.0], [5.0, 2.0, 9.0]];
        for aspect in [0.5, 1.0, 3.0] {
            let camera = Camera::new(Viewpoint::framing(bounds, 30.0, aspect)).unwrap();
            let size = [(600.0 * aspect) as usize, 600];
            let mut farthest: f64 = 0.0;
            for corner in 0..8 {
                let point = DVec3::from_array(std::array::from_fn(|axis| bounds[corner >> axis & 1][axis]));
                let seen = point - DVec3::from_array(camera.viewpoint.eye);
                let scale = 0.5 / (15f64.to_radians().tan() * seen.dot(camera.forward));
                let across = seen.dot(camera.right) * scale / (size[0] as f64 / size[1] as f64);
                farthest = farthest.max(2.0 * across.abs()).max(2.0 * seen.dot(camera.up).abs() * scale);
            }
            assert!((farthest - FILLED).abs() < 1e-6, "aspect {aspect}: {farthest}");
        }
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let error = |change: fn(&mut Viewpoint)| {
            let mut viewpoint = looking_down_z();
            change(&mut viewpoint);
            Camera::new(viewpoint).unwrap_err()
        };
        assert!(matches!(error(|view| view.target = view.eye), CameraError::NoDirection(_)));
        assert!(matches!(error(|view| view.up = [0.0, 0.0, 2.0]), CameraError::UpAlongView { .. }));
        assert!(matches!(error(|view| view.up = [0.0; 3]), CameraError::UpAlongView { .. }));
        assert!(matches!(error(|view| view.eye[0] = f64::NAN), CameraError::NotFinite { .. }));
        for fovy in [0.0, 180.0, f64::NAN] {
            let viewpoint = Viewpoint { projection: Projection::Perspective { fovy }, ..looking_down_z() };
            assert!(Camera::new(viewpoint).is_err());
        }
    }
}
