//! Outlines: the edges of boxes as lines of a width in pixels, which lie in the scene like any surface.

use amray_mesh::MeshDescription;
use glam::DVec3;

use super::{Camera, Projection};
use crate::hierarchy::Hierarchy;

/// The edges of a box: its low and high corner in world units, and their colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// The low and the high corner.
    pub corners: [[f64; 3]; 2],
    /// Red, green and blue.
    pub color: [f32; 3],
    /// Where lines of two outlines are at the same place, those of the higher rank are seen.
    pub rank: usize,
}

/// By how much of the way to the eye lines of one rank lie before those of the next lower one.
const RANK_STEP: f64 = 2e-6;
/// What is nearer to the eye than this, over the box's size, is left out.
const NEAREST: f64 = 1e-4;

impl Outline {
    /// The outline of the domain.
    pub fn of_domain(hierarchy: &Hierarchy, color: [f32; 3]) -> Self {
        Self { corners: hierarchy.bounds(), color, rank: hierarchy.levels().len() }
    }

    /// The outlines of all bricks, in the colours of their levels.
    pub fn of_bricks(hierarchy: &Hierarchy) -> Vec<Self> {
        let levels = hierarchy.levels().iter().enumerate();
        let outlines = levels.flat_map(|(rank, level)| {
            level.bricks().iter().map(move |brick| {
                let corner = |cells: [i64; 3]| hierarchy.to_world(rank, cells.map(|cell| cell as f64));
                Self { corners: [corner(brick.low), corner(brick.high)], color: level_color(rank), rank }
            })
        });
        outlines.collect()
    }

    /// The twelve edges.
    fn edges(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        (0..12).map(|edge| {
            let (axis, side) = (edge / 4, edge % 4);
            let end = |along: usize| {
                DVec3::from_array(std::array::from_fn(|number| {
                    let high = match (number + 3 - axis) % 3 {
                        0 => along,
                        other => side >> (other - 1) & 1,
                    };
                    self.corners[high][number]
                }))
            };
            [end(0), end(1)]
        })
    }
}

/// The colour of a level's outlines. All of them can be told apart, by colour-blind eyes too (the palette of Okabe and
/// Ito, 2008, in an order that begins with the calm ones); deep levels take them again.
pub fn level_color(level: usize) -> [f32; 3] {
    const COLORS: [[u8; 3]; 7] =
        [[120, 120, 120], [86, 180, 233], [0, 158, 115], [230, 159, 0], [213, 94, 0], [204, 121, 167], [0, 114, 178]];
    COLORS[level % COLORS.len()].map(|channel| f32::from(channel) / 255.0)
}

/// Outlines as lines `width` pixels wide in a picture of `size` pixels by `camera`: ribbons that face it. Seen from
/// elsewhere they are too thin.
pub fn outline_mesh(outlines: &[Outline], camera: &Camera, size: [usize; 2], width: f64) -> MeshDescription {
    let mut mesh = MeshDescription { colors: Some(Vec::new()), ..MeshDescription::default() };
    // In a panorama lines are bent, and the middle may be much nearer than both ends.
    let pieces = if camera.viewpoint().projection == Projection::Panorama { 32 } else { 1 };
    for outline in outlines {
        let pieces_of = |[from, to]: [DVec3; 2]| {
            let at = move |piece: i32| from.lerp(to, f64::from(piece) / f64::from(pieces));
            (0..pieces).map(move |piece| [at(piece), at(piece + 1)])
        };
        for edge in outline.edges().flat_map(pieces_of) {
            let shift = 1.0 - RANK_STEP * outline.rank as f64;
            let Some(corners) = ribbon(edge, camera, size, [width, shift]) else { continue };
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend(corners.map(|corner| corner.to_array()));
            let [red, green, blue] = outline.color;
            mesh.colors.get_or_insert_default().extend([[red, green, blue, 1.0]; 4]);
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    mesh
}

/// The corners, going round, of a ribbon along a line; `None` where the camera sees nothing of it.
fn ribbon(
    [mut from, mut to]: [DVec3; 2],
    camera: &Camera,
    size: [usize; 2],
    [width, shift]: [f64; 2],
) -> Option<[DVec3; 4]> {
    let eye = DVec3::from_array(camera.viewpoint().eye);
    let forward = DVec3::from_array(camera.direction([0.0, 0.0, 1.0]));
    let is_parallel = matches!(camera.viewpoint().projection, Projection::Orthographic { .. });
    let nearest = NEAREST * (to - from).length();
    if let Projection::Perspective { .. } = camera.viewpoint().projection {
        // What lies behind the eye is cut off: ribbons would turn over.
        let [a, b] = [from, to].map(|point| (point - eye).dot(forward) - nearest);
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let cut = from + (to - from) * (a / (a - b));
        if a < 0.0 {
            from = cut;
        } else if b < 0.0 {
            to = cut;
        }
    }
    let sight = if is_parallel { forward } else { from - eye };
    // The same all along the line. A line that points to the eye is not seen.
    let across = (to - from).cross(sight).try_normalize()?;
    let [a, b] = [from, to].map(|point| across * (camera.pixel_width(size, point.to_array()).max(0.0) * width / 2.0));
    let nearer = |point: DVec3| if is_parallel { point - forward * (1.0 - shift) } else { eye + (point - eye) * shift };
    Some([from - a, from + a, to + b, to - b].map(nearer))
}

#[cfg(test)]
mod tests {
    use super::super::Viewpoint;
    use super::*;

    #[test]
    fn a_box_has_twelve_edges() {
        let outline = Outline { corners: [[0.0; 3], [1.0, 2.0, 4.0]], color: [0.0; 3], rank: 0 };
        let mut lengths: Vec<f64> = outline.edges().map(|[from, to]| (to - from).length()).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths, [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 4.0, 4.0, 4.0, 4.0]);
        let mut middles: Vec<_> = outline.edges().map(|[from, to]| (from + to).to_array().map(f64::to_bits)).collect();
        middles.sort_unstable();
        middles.dedup();
        assert_eq!(middles.len(), 12);
    }

    #[test]
    fn lines_are_as_wide_as_pixels_everywhere() {
        let size = [300, 200];
        let corners = [[-1.0, -2.0, -3.0], [1.0, 2.0, 4.0]];
        let framing = Viewpoint::framing(corners, 40.0, 1.5);
        let projection = Projection::Perspective { fovy: 110.0 };
        let inside = Viewpoint { eye: [0.2, 0.1, 0.3], target: [1.0, 0.5, 0.7], projection, ..framing };
        for viewpoint in [framing, framing.orthographic(), inside] {
            let camera = Camera::new(viewpoint).unwrap();
            let mesh = outline_mesh(&[Outline { corners, color: [1.0; 3], rank: 1 }], &camera, size, 3.0);
            assert_eq!(mesh.triangles.len() * 2, mesh.vertices.len());
            assert!(mesh.triangles.len() == 24 || viewpoint == inside && mesh.triangles.len() > 8);
            let mut ends = 0;
            for pair in mesh.vertices.chunks_exact(2) {
                let [Some(a), Some(b)] = [0, 1].map(|number| camera.project(size, pair[number])) else { continue };
                let middle = [(a[0] + b[0]) / 2.0 / 300.0, (a[1] + b[1]) / 2.0 / 200.0];
                if middle.iter().all(|share| (0.0..1.0).contains(share)) {
                    // A ribbon faces the eye, not the picture: off the middle it may be wider.
                    let from_middle = ((middle[0] - 0.5) * 1.5).hypot(middle[1] - 0.5);
                    let tangent = match viewpoint.projection {
                        Projection::Perspective { fovy } => 2.0 * (fovy.to_radians() / 2.0).tan() * from_middle,
                        _ => 0.0,
                    };
                    let (width, most) = ((a[0] - b[0]).hypot(a[1] - b[1]), 3.01 * tangent.hypot(1.0));
                    assert!((2.99..most).contains(&width), "{width} and not up to {most} at {middle:?}");
                    ends += 1;
                }
            }
            assert!(ends > 0);
        }
    }
}
