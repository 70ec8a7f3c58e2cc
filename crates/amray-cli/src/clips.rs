//! What is cut away, from the flags.

use amray::Volume;
use amray::scene::Clip;
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::number;
use crate::scene_file::{self, checked};
use crate::surfaces::{Place, plane};

/// To look inside.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ClipArguments {
    /// Leave only what is inside a box, in world units. Meshes stay whole
    #[arg(long = "clip-box", value_name = "X,Y,Z:X,Y,Z", value_parser = corners, allow_hyphen_values = true)]
    #[serde(rename = "clip_box", skip_serializing_if = "Vec::is_empty")]
    inside: Vec<[[f64; 3]; 2]>,
    /// Cut a box out, in world units. May be repeated
    #[arg(long = "cut-box", value_name = "X,Y,Z:X,Y,Z", value_parser = corners, allow_hyphen_values = true)]
    #[serde(rename = "cut_box", skip_serializing_if = "Vec::is_empty")]
    outside: Vec<[[f64; 3]; 2]>,
    /// Leave the side that NORMAL X,Y,Z (or AXIS x, y, z, -x, -y or -z) points to of a plane through a place on the axis
    /// or a point X,Y,Z [default: the middle of the domain]. May be repeated
    #[arg(long = "clip-plane", value_name = "AXIS|NORMAL[:PLACE]", value_parser = clip_plane, allow_hyphen_values = true)]
    #[serde(rename = "clip_plane", skip_serializing_if = "Vec::is_empty")]
    planes: Vec<Plane>,
}

/// A plane, and which side of it is left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Plane {
    /// Points to what is left.
    #[serde(deserialize_with = "checked::normal")]
    normal: [f64; 3],
    #[serde(default)]
    place: Place,
}

impl ClipArguments {
    /// These clips; of kinds that there are none of, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            inside: scene_file::or(self.inside, others.inside),
            outside: scene_file::or(self.outside, others.outside),
            planes: scene_file::or(self.planes, others.planes),
        }
    }

    /// The clips of a scene with this volume.
    pub(crate) fn clips(&self, volume: &Volume) -> Vec<Clip> {
        let planes = self.planes.iter().map(|Plane { normal, place }| {
            let point = place.point(volume.hierarchy().bounds());
            Clip::Plane { point, normal: *normal }
        });
        let inside = self.inside.iter().map(|corners| Clip::Inside(ordered(*corners)));
        let outside = self.outside.iter().map(|corners| Clip::Outside(ordered(*corners)));
        planes.chain(inside).chain(outside).collect()
    }
}

/// Two opposite corners, in any order.
fn corners(text: &str) -> Result<[[f64; 3]; 2], String> {
    let Some((one, other)) = text.split_once(':') else {
        return Err("expected two corners, X,Y,Z:X,Y,Z".into());
    };
    Ok([number::list(one)?, number::list(other)?])
}

/// The low and the high corner of a box.
fn ordered([one, other]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    let order = |pick: fn(f64, f64) -> f64| std::array::from_fn(|axis| pick(one[axis], other[axis]));
    [order(f64::min), order(f64::max)]
}

/// `AXIS|NORMAL[:PLACE]`, the axis with a sign.
fn clip_plane(text: &str) -> Result<Plane, String> {
    let (across, place) = text.split_once(':').map_or((text, None), |(across, place)| (across, Some(place)));
    match across.strip_prefix('-').filter(|axis| !axis.contains(',')) {
        Some(axis) => {
            let (normal, place) = plane(axis, place)?;
            Ok(Plane { normal: normal.map(|part| 0.0 - part), place })
        }
        None => plane(across, place).map(|(normal, place)| Plane { normal, place }),
    }
}

#[cfg(test)]
mod tests {
    use amray::render::Axis;

    use super::*;

    #[test]
    fn clips_are_read() {
        assert_eq!(corners("1,0,-2:0,1,3").map(ordered), Ok([[0.0, 0.0, -2.0], [1.0, 1.0, 3.0]]));
        assert_eq!(clip_plane("x"), Ok(Plane { normal: [1.0, 0.0, 0.0], place: Place::Middle }));
        let place = Place::OnAxis(Axis::Z, -3.0);
        assert_eq!(clip_plane("-z:-3"), Ok(Plane { normal: [0.0, 0.0, -1.0], place }));
        let place = Place::Through([1.0, 2.0, 3.0]);
        assert_eq!(clip_plane("-1,0,2:1,2,3"), Ok(Plane { normal: [-1.0, 0.0, 2.0], place }));
    }

    #[test]
    fn what_is_no_clip_is_explained() {
        assert!(corners("1,2,3").unwrap_err().contains("two corners"));
        assert!(corners("1,2,3:1,2").unwrap_err().contains("3 numbers"));
        assert!(clip_plane("w").unwrap_err().contains("no axis"));
        assert!(clip_plane("0,0,0").unwrap_err().contains("other than 0"));
    }
}
