//! Cameras: from pixels to rays.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

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
    /// Rays leave the eye in all directions: the picture's width is a whole turn, of which the target is in the middle,
    /// and its height goes from straight up to straight down (an equirectangular projection, as viewers of panoramas
    /// expect it).
    Panorama,
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
    /// By how much rays go to the right over how much forward, in the middle of the picture.
    shear: f64,
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
    /// There is no pair of pictures that eyes could look at.
    #[error("camera: no stereo pair {0}")]
    Stereo(&'static str),
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
        let half_height = height_of(fovy) / 2.0 * FILLED;
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
        Self { projection: Projection::Orthographic { height: self.distance() * height_of(fovy) }, ..self }
    }

    /// From the eye to the target, in world units.
    fn distance(&self) -> f64 {
        DVec3::from_array(self.eye).distance(DVec3::from_array(self.target))
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
        Ok(Self { viewpoint, forward, right, up: right.cross(forward), shear: 0.0 })
    }

    /// Where the camera stands and looks.
    pub fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// A direction in world space, given as parts to the right, up and forward in the picture.
    pub fn direction(&self, [right, up, forward]: [f64; 3]) -> [f64; 3] {
        (self.right * right + self.up * up + self.forward * forward).to_array()
    }

    /// The cameras of a left and a right eye so far apart, in world units: they look in parallel, and what lies at the
    /// target's distance is at the same place in both pictures (an off-axis pair: nothing is shifted up or down).
    ///
    /// # Errors
    /// [`CameraError::Stereo`] for a panorama, and for distances that are not finite.
    pub fn stereo_pair(&self, separation: f64) -> Result<[Self; 2], CameraError> {
        if self.viewpoint.projection == Projection::Panorama {
            return Err(CameraError::Stereo(
                "of a panorama: an eye beside the other is behind it when one looks aside",
            ));
        }
        if !separation.is_finite() {
            return Err(CameraError::Stereo("of eyes that are not a finite distance apart"));
        }
        let [eye, target] = [self.viewpoint.eye, self.viewpoint.target].map(DVec3::from_array);
        let beside = |shift: f64| {
            let aside = self.right * shift;
            let [eye, target] = [eye, target].map(|point| (point + aside).to_array());
            let viewpoint = Viewpoint { eye, target, ..self.viewpoint };
            Self { viewpoint, shear: self.shear - shift / self.distance(), ..*self }
        };
        Ok([beside(-separation / 2.0), beside(separation / 2.0)])
    }

    /// From the eye to the target, in world units.
    pub fn distance(&self) -> f64 {
        self.viewpoint.distance()
    }

    /// Where a point in world units is in a picture of `size` pixels; none where it is not before the eye, or in a
    /// panorama.
    pub fn project(&self, size: [usize; 2], point: [f64; 3]) -> Option<[f64; 2]> {
        let from_eye = DVec3::from_array(point) - DVec3::from_array(self.viewpoint.eye);
        let depth = from_eye.dot(self.forward);
        let per_length = self.pixel_width(size, point).recip();
        let is_seen = match self.viewpoint.projection {
            Projection::Perspective { .. } => depth > 0.0,
            Projection::Orthographic { .. } => true,
            Projection::Panorama => false,
        };
        let right = from_eye.dot(self.right) - depth * self.shear;
        let [middle, half] = size.map(|pixels| pixels as f64 / 2.0);
        is_seen.then(|| [middle + right * per_length, half - from_eye.dot(self.up) * per_length])
    }

    /// How wide a pixel is at a point, in world units; not above 0 at the eye and behind it.
    pub(crate) fn pixel_width(&self, size: [usize; 2], point: [f64; 3]) -> f64 {
        let [width, height] = size.map(|pixels| pixels as f64);
        let from_eye = DVec3::from_array(point) - DVec3::from_array(self.viewpoint.eye);
        match self.viewpoint.projection {
            Projection::Perspective { fovy } => height_of(fovy) * from_eye.dot(self.forward) / height,
            Projection::Orthographic { height: picture } => picture / height,
            Projection::Panorama => from_eye.length() * TAU / width,
        }
    }

    /// The ray through a point of a picture of `size` pixels (width, height): (0, 0) is the top left corner, pixel
    /// (i, j) has its centre at (i + 1/2, j + 1/2).
    pub fn ray(&self, size: [usize; 2], pixel: [f64; 2]) -> CameraRay {
        let [start, direction] = self.picture_rays(size).at(pixel);
        CameraRay { start: start.to_array(), direction: direction.normalize().to_array() }
    }

    /// The rays of a picture of `size` pixels.
    pub(crate) fn picture_rays(&self, size: [usize; 2]) -> PictureRays {
        let [width, height] = size.map(|pixels| pixels as f64);
        let eye = DVec3::from_array(self.viewpoint.eye);
        // From -1/2 at the bottom to 1/2 on top; pixels are square.
        let over = |middle: DVec3, picture: f64| {
            let [right, down] = [self.right, -self.up].map(|axis| axis * (picture / height));
            [middle - right * (width / 2.0) - down * (height / 2.0), right, down]
        };
        let still = |vector| [vector, DVec3::ZERO, DVec3::ZERO];
        let forward = self.forward + self.right * self.shear;
        match self.viewpoint.projection {
            Projection::Perspective { fovy } => {
                PictureRays::Plane { start: still(eye), direction: over(forward, height_of(fovy)) }
            }
            Projection::Orthographic { height } => {
                PictureRays::Plane { start: over(eye, height), direction: still(forward) }
            }
            Projection::Panorama => {
                let axes = [self.right, self.up, self.forward];
                PictureRays::Panorama(Panorama { eye, axes, turn: [TAU / width, PI / height] })
            }
        }
    }
}

/// How high a picture with a vertical opening angle in degrees is at a distance of 1.
fn height_of(fovy: f64) -> f64 {
    2.0 * (fovy.to_radians() / 2.0).tan()
}

/// The rays of a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PictureRays {
    /// Rays are linear in the pixel: at the picture's corner (0, 0), and by how much they change per pixel to the right
    /// and down. Directions are not of length 1.
    Plane { start: [DVec3; 3], direction: [DVec3; 3] },
    /// Rays go all around.
    Panorama(Panorama),
}

/// All around one point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panorama {
    pub(crate) eye: DVec3,
    /// To the right, up and forward.
    axes: [DVec3; 3],
    /// The angle of a pixel across and down.
    turn: [f64; 2],
}

impl PictureRays {
    /// Where the ray through a point of the picture starts, and where it goes: not of length 1.
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> [DVec3; 2] {
        match self {
            Self::Plane { start, direction } => {
                [start, direction].map(|[corner, right, down]| *corner + *right * x + *down * y)
            }
            Self::Panorama(panorama) => [panorama.eye, panorama.direction([x, y])],
        }
    }
}

impl Panorama {
    /// The direction of a point of the picture, of length 1.
    fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        let (across, across_cosine) = (x * self.turn[0] - PI).sin_cos();
        let (up, up_cosine) = (FRAC_PI_2 - y * self.turn[1]).sin_cos();
        let [to_right, upward, forward] = self.axes;
        to_right * (across * up_cosine) + upward * up + forward * (across_cosine * up_cosine)
    }

    /// The directions of points of the picture, by axis.
    pub(crate) fn directions<const COUNT: usize>(&self, x: &[f64; COUNT], y: &[f64; COUNT]) -> [[f64; COUNT]; 3] {
        let mut directions = [[0.0; COUNT]; 3];
        for number in 0..COUNT {
            let direction = self.direction([x[number], y[number]]);
            for axis in 0..3 {
                directions[axis][number] = direction[axis];
            }
        }
        directions
    }

    /// The angle of a pixel in the middle of the picture, the larger way.
    pub(crate) fn pixel_angle(&self) -> f64 {
        self.turn[0].max(self.turn[1])
    }
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
    fn points_are_where_rays_through_them_are() {
        let size = [90, 60];
        for viewpoint in [looking_down_z(), looking_down_z().orthographic()] {
            let camera = Camera::new(viewpoint).unwrap();
            for camera in camera.stereo_pair(0.7).unwrap().into_iter().chain([camera]) {
                let CameraRay { start, direction } = camera.ray(size, [70.0, 20.0]);
                let point = std::array::from_fn(|axis| start[axis] + 7.0 * direction[axis]);
                let [x, y] = camera.project(size, point).unwrap();
                assert!((x - 70.0).abs() < 1e-9 && (y - 20.0).abs() < 1e-9, "{x}, {y}");
            }
        }
        assert_eq!(Camera::new(looking_down_z()).unwrap().project(size, [0.0, 0.0, 11.0]), None);
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

    #[test]
    fn a_panorama_goes_all_around() {
        let viewpoint = Viewpoint { projection: Projection::Panorama, ..looking_down_z() };
        let camera = Camera::new(viewpoint).unwrap();
        for (pixel, expected) in [
            ([200.0, 100.0], [0.0, 0.0, -1.0]),
            ([300.0, 100.0], [1.0, 0.0, 0.0]),
            ([0.0, 100.0], [0.0, 0.0, 1.0]),
            ([100.0, 100.0], [-1.0, 0.0, 0.0]),
            ([17.0, 0.0], [0.0, 1.0, 0.0]),
            ([200.0, 150.0], [0.0, -0.5f64.sqrt(), -0.5f64.sqrt()]),
        ] {
            let ray = camera.ray([400, 200], pixel);
            assert_eq!(ray.start, [0.0, 0.0, 10.0]);
            let off = (0..3).map(|axis| (ray.direction[axis] - expected[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{pixel:?}: {ray:?}");
        }
        assert!(matches!(camera.stereo_pair(0.1), Err(CameraError::Stereo(_))));
    }

    #[test]
    fn two_eyes_see_the_target_at_the_same_place() {
        for viewpoint in [looking_down_z(), looking_down_z().orthographic()] {
            let camera = Camera::new(viewpoint).unwrap();
            let [left, right] = camera.stereo_pair(0.5).unwrap();
            assert_eq!((left.viewpoint().eye[0], right.viewpoint().eye[0]), (-0.25, 0.25));
            // Where rays are at the target's distance, and behind it.
            let at = |camera: &Camera, z: f64| {
                let CameraRay { start, direction } = camera.ray([90, 60], [70.0, 20.0]);
                let t = (z - start[2]) / direction[2];
                [start[0] + t * direction[0], start[1] + t * direction[1]]
            };
            let (seen, behind) = ([&left, &right].map(|eye| at(eye, 0.0)), [&left, &right].map(|eye| at(eye, -5.0)));
            assert!((seen[0][0] - seen[1][0]).abs() < 1e-12 && (seen[0][1] - seen[1][1]).abs() < 1e-12);
            assert!((behind[0][0] - behind[1][0] - 0.25).abs() < 1e-12 && (behind[0][1] - behind[1][1]).abs() < 1e-12);
        }
    }
}
