//! Cameras that move: around what they look at, or from key to key.

use glam::{DQuat, DVec3};
use thiserror::Error;

use super::{Camera, CameraError, Projection, Viewpoint};

/// A viewpoint as it turns around its target: the eye goes around the axis that is up in the picture, the distance stays.
///
/// At 0 degrees it is the viewpoint itself, and at 360 again; seen from above, it goes round anticlockwise.
///
/// # Errors
/// [`CameraError`] where no picture can be taken from the viewpoint.
pub fn orbit(viewpoint: Viewpoint, degrees: f64) -> Result<Viewpoint, CameraError> {
    let axis = Camera::new(viewpoint)?.viewpoint().up;
    let axis = DVec3::from_array(axis).normalize();
    let [eye, target] = [viewpoint.eye, viewpoint.target].map(DVec3::from_array);
    let turned = target + DQuat::from_axis_angle(axis, degrees.to_radians()) * (eye - target);
    Ok(Viewpoint { eye: turned.to_array(), ..viewpoint })
}

/// Where a camera is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraKey {
    /// In any unit.
    pub time: f64,
    /// Where it is then, and what it sees.
    pub viewpoint: Viewpoint,
}

/// A smooth way of a camera through viewpoints at given times.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    keys: Vec<CameraKey>,
}

/// Keys that make no way.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CameraPathError {
    /// No key at all.
    #[error("there is no key, expected at least one")]
    Empty,
    /// A time that is not after the one before, or no number.
    #[error("key {index}: time {found} after {previous}, expected ascending times")]
    Order {
        /// The key, from 0 on.
        index: usize,
        /// Its time.
        found: f64,
        /// The time of the key before.
        previous: f64,
    },
    /// A viewpoint from which there is no picture.
    #[error("key {index}: {source}")]
    Camera {
        /// The key, from 0 on.
        index: usize,
        /// What is wrong with it.
        source: CameraError,
    },
    /// One way cannot have cameras of two kinds.
    #[error("key {index}: its projection is of another kind than that of key 0")]
    Projection {
        /// The key, from 0 on.
        index: usize,
    },
}

/// What of a viewpoint changes along the way: eye, target, up, and the opening angle or height.
type Parts = [f64; 10];

impl CameraPath {
    /// The way through keys in the order of their times.
    ///
    /// # Errors
    /// [`CameraPathError`] names the first key that is wrong.
    pub fn new(keys: Vec<CameraKey>) -> Result<Self, CameraPathError> {
        let Some(first) = keys.first() else { return Err(CameraPathError::Empty) };
        let kind = |key: &CameraKey| std::mem::discriminant(&key.viewpoint.projection);
        let mut previous = f64::NEG_INFINITY;
        for (index, key) in keys.iter().enumerate() {
            let found = key.time;
            if !(found > previous && found.is_finite()) {
                return Err(CameraPathError::Order { index, found, previous });
            }
            Camera::new(key.viewpoint).map_err(|source| CameraPathError::Camera { index, source })?;
            if kind(key) != kind(first) {
                return Err(CameraPathError::Projection { index });
            }
            previous = found;
        }
        Ok(Self { keys })
    }

    /// The first and the last key's time.
    pub fn times(&self) -> [f64; 2] {
        [self.keys[0].time, self.keys[self.keys.len() - 1].time]
    }

    /// Where the camera is at a time; before the first key and after the last one, where it is then.
    ///
    /// Eye, target and the direction that is up go through keys with no jump of speed (Catmull and Rom's splines, 1974, for
    /// times that need not be even); the opening angle never leaves the range of the two keys around (Fritsch and
    /// Carlson, 1980). Between keys it may happen that no picture can be taken: eye and target may meet.
    pub fn at(&self, time: f64) -> Viewpoint {
        let [first, last] = self.times();
        let time = time.clamp(first, last);
        let after = self.keys.partition_point(|key| key.time <= time);
        let (low, high) = (after.saturating_sub(1), after.min(self.keys.len() - 1));
        let before = self.keys[low];
        if low == high {
            return before.viewpoint;
        }
        let length = self.keys[high].time - before.time;
        let share = (time - before.time) / length;
        let [from, to] = [low, high].map(|key| parts(&self.keys[key].viewpoint));
        let [leaving, arriving] = [self.speeds(low), self.speeds(high)];
        // Hermite's cubic polynomials.
        let (s2, s3) = (share * share, share * share * share);
        let weights = [2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + share, 3.0 * s2 - 2.0 * s3, s3 - s2];
        let mixed: Parts = std::array::from_fn(|part| {
            let ends = [from[part], length * leaving[part], to[part], length * arriving[part]];
            (0..4).map(|term| weights[term] * ends[term]).sum()
        });
        let triple = |start: usize| [mixed[start], mixed[start + 1], mixed[start + 2]];
        Viewpoint {
            eye: triple(0),
            target: triple(3),
            up: triple(6),
            projection: match before.viewpoint.projection {
                Projection::Perspective { .. } => Projection::Perspective { fovy: mixed[9] },
                Projection::Orthographic { .. } => Projection::Orthographic { height: mixed[9] },
                Projection::Panorama => Projection::Panorama,
            },
        }
    }

    /// How fast all parts change at a key.
    fn speeds(&self, key: usize) -> Parts {
        let slope = |low: usize| -> Parts {
            let [from, to] = [low, low + 1].map(|key| parts(&self.keys[key].viewpoint));
            let length = self.keys[low + 1].time - self.keys[low].time;
            std::array::from_fn(|part| (to[part] - from[part]) / length)
        };
        // The way ends as straight as it began.
        let last = self.keys.len() - 1;
        let [before, behind] = [key.saturating_sub(1).min(last - 1), key.min(last - 1)].map(slope);
        let time = |key: usize| self.keys[key].time;
        let share = match (key, last) {
            (key, last) if key == 0 || key == last => 0.5,
            (key, _) => (time(key) - time(key - 1)) / (time(key + 1) - time(key - 1)),
        };
        let mut speeds: Parts = std::array::from_fn(|part| before[part] + share * (behind[part] - before[part]));
        // What has its highest or lowest value here does not go beyond, and elsewhere it is not overtaken.
        let [before, behind] = [before[9], behind[9]];
        let steepest = 3.0 * before.abs().min(behind.abs());
        speeds[9] = if before * behind <= 0.0 { 0.0 } else { speeds[9].clamp(-steepest, steepest) };
        speeds
    }
}

fn parts(viewpoint: &Viewpoint) -> Parts {
    let up = DVec3::from_array(viewpoint.up).normalize().to_array();
    let size = match viewpoint.projection {
        Projection::Perspective { fovy } => fovy,
        Projection::Orthographic { height } => height,
        Projection::Panorama => 0.0,
    };
    let [[a, b, c], [d, e, f], [g, h, i]] = [viewpoint.eye, viewpoint.target, up];
    [a, b, c, d, e, f, g, h, i, size]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, eye: [f64; 3], fovy: f64) -> CameraKey {
        let projection = Projection::Perspective { fovy };
        CameraKey { time, viewpoint: Viewpoint { eye, target: [0.0; 3], up: [0.0, 0.0, 2.0], projection } }
    }

    fn path() -> CameraPath {
        let keys =
            [([4.0, 0.0, 1.0], 30.0), ([0.0, 5.0, 1.0], 50.0), ([-3.0, 0.0, 2.0], 50.0), ([0.0, -4.0, 0.0], 20.0)];
        let times = [-1.0, 0.0, 2.5, 3.0];
        let keys = keys.into_iter().zip(times).map(|((eye, fovy), time)| key(time, eye, fovy)).collect();
        CameraPath::new(keys).unwrap()
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_comes_back() {
        let viewpoint = Viewpoint { target: [1.0, 2.0, 3.0], ..key(0.0, [4.0, 1.0, 5.0], 30.0).viewpoint };
        let distance = |viewpoint: &Viewpoint| Camera::new(*viewpoint).unwrap().distance();
        for degrees in [0.0, 17.0, 180.0, -90.0, 360.0] {
            let turned = orbit(viewpoint, degrees).unwrap();
            assert!((distance(&turned) - distance(&viewpoint)).abs() < 1e-12);
            assert!((turned.eye[2] - 5.0).abs() < 1e-12);
            let is_back = (0..3).all(|axis| (turned.eye[axis] - viewpoint.eye[axis]).abs() < 1e-12);
            assert_eq!(is_back, degrees % 360.0 == 0.0, "{degrees}");
        }
        // Anticlockwise, seen from above.
        let quarter = orbit(viewpoint, 90.0).unwrap().eye;
        assert!((quarter[0] - 2.0).abs() < 1e-12 && (quarter[1] - 5.0).abs() < 1e-12, "{quarter:?}");
    }

    #[test]
    fn ways_go_through_their_keys_without_a_jerk() {
        let path = path();
        for key in &path.keys {
            let (found, expected) = (parts(&path.at(key.time)), parts(&key.viewpoint));
            assert!((0..10).all(|part| (found[part] - expected[part]).abs() < 1e-12), "{found:?}, not {expected:?}");
            // The speed right before and right behind.
            const STEP: f64 = 1e-6;
            let speed = |from: f64, to: f64| -> Parts {
                let [from, to] = [from, to].map(|time| parts(&path.at(time)));
                std::array::from_fn(|part| (to[part] - from[part]) / STEP)
            };
            if key.time > -1.0 && key.time < 3.0 {
                let (before, behind) = (speed(key.time - STEP, key.time), speed(key.time, key.time + STEP));
                assert!((0..9).all(|part| (before[part] - behind[part]).abs() < 1e-3), "{before:?}, {behind:?}");
            }
        }
        assert_eq!(path.at(-9.0), path.at(-1.0));
        assert_eq!(path.at(9.0), path.keys[3].viewpoint);
    }

    #[test]
    fn opening_angles_stay_between_those_of_keys() {
        let path = path();
        for step in 0..=400 {
            let time = -1.0 + f64::from(step) * 0.01;
            let Projection::Perspective { fovy } = path.at(time).projection else { panic!() };
            assert!((20.0 - 1e-9..=50.0 + 1e-9).contains(&fovy), "{fovy} at {time}");
            assert!(!(0.0..=2.5).contains(&time) || (fovy - 50.0).abs() < 1e-9, "{fovy} at {time}");
        }
    }

    #[test]
    fn wrong_keys_are_named() {
        assert_eq!(CameraPath::new(vec![]), Err(CameraPathError::Empty));
        let good = key(0.0, [1.0; 3], 30.0);
        assert!(CameraPath::new(vec![good]).is_ok_and(|path| path.at(5.0) == good.viewpoint));
        let error = |second| CameraPath::new(vec![good, second]).unwrap_err();
        assert!(matches!(error(good), CameraPathError::Order { index: 1, .. }));
        assert!(matches!(error(key(f64::NAN, [1.0; 3], 30.0)), CameraPathError::Order { index: 1, .. }));
        assert!(matches!(error(key(1.0, [0.0; 3], 30.0)), CameraPathError::Camera { index: 1, .. }));
        let around = Viewpoint { projection: Projection::Panorama, ..good.viewpoint };
        assert!(matches!(error(CameraKey { time: 1.0, viewpoint: around }), CameraPathError::Projection { index: 1 }));
    }
}
