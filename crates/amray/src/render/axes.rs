//! Axes around a picture of a domain: ticks and labels along edges that lie at its rim.

use crate::appearance::{Picture, Scale, TextSize, Tick, ink_on, ticks};
use crate::scene::Camera;

/// Lines of text from one tick to the next, at least.
const LINES_PER_TICK: f64 = 3.5;
/// Ticks of an axis at most.
const MOST_TICKS: usize = 9;

/// Where a point of the picture is, in pixels from the top left corner.
type Pixel = [f64; 2];

/// Draws the axes of a domain, given its low and high corner in world units, over a picture by `camera`: along one edge
/// each that is at the domain's rim there, with round values of the coordinate. Text and lines are black or white, whichever
/// is easier to read on `background`.
///
/// Nothing is drawn of an axis no edge of which is seen at the rim: that points to the eye, or lies behind it; and
/// nothing at all in a panorama, or from inside of the domain.
pub fn draw_axes(picture: &mut Picture, camera: &Camera, bounds: [[f64; 3]; 2], background: [u8; 4]) {
    let size = [picture.width(), picture.height()];
    let Some(corners) = (0..8).map(|corner| camera.project(size, place(bounds, corner))).collect::<Option<Vec<_>>>()
    else {
        return;
    };
    let middle = mean(&corners);
    let text = TextSize::of_picture(size[1]);
    let ink = ink_on(background);
    for axis in 0..3 {
        let Some([low, high]) = edge_at_rim(&corners, axis) else { continue };
        let [a, b] = [corners[low], corners[high]];
        let length = distance(a, b);
        let outward = away([a, b], middle);
        let most = (length / (LINES_PER_TICK * text.height() as f64)) as usize;
        let range = [bounds[0][axis], bounds[1][axis]];
        let (mark, width) = (text.height() as f64 / 3.0, (text.height() as f64 / 14.0).max(1.0));
        picture.line([a, b], width, ink);
        let mut widest: f64 = 0.0;
        for Tick { value, label } in ticks(Scale::Linear, range, most.min(MOST_TICKS)) {
            let mut point = place(bounds, low);
            point[axis] = value;
            let Some(at) = camera.project(size, point) else { continue };
            picture.line([at, beside(at, outward, mark)], width, ink);
            widest = widest.max(label_at(picture, beside(at, outward, 1.6 * mark), outward, (text, &label), ink));
        }
        let name = ["x", "y", "z"][axis];
        let out = widest + 2.6 * mark;
        label_at(picture, beside(mean(&[a, b]), outward, out), outward, (text, name), ink);
    }
}

/// A corner of a box: bit `axis` of its number tells whether it is on the high side.
fn place(bounds: [[f64; 3]; 2], corner: usize) -> [f64; 3] {
    std::array::from_fn(|axis| bounds[corner >> axis & 1][axis])
}

/// The corners at the ends of an edge along `axis` that all other corners lie on one side of: the lowest, or leftmost, in
/// the picture.
fn edge_at_rim(corners: &[Pixel], axis: usize) -> Option<[usize; 2]> {
    let edges = (0..8).filter(|low| low >> axis & 1 == 0).map(|low| [low, low | 1 << axis]);
    let at_rim = edges.filter(|[low, high]| {
        let (a, b) = (corners[*low], corners[*high]);
        let side = |c: Pixel| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let length = distance(a, b);
        let sides = (0..8).filter(|corner| corner != low && corner != high).map(|corner| side(corners[corner]));
        let [least, most] =
            sides.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], side| [least.min(side), most.max(side)]);
        // Edges behind one another may be both at the rim: to a pixel.
        length > 1.0 && (least >= -length || most <= length)
    });
    let lowness = |[low, high]: &[usize; 2]| {
        let middle = mean(&[corners[*low], corners[*high]]);
        middle[1] - 0.7 * middle[0]
    };
    at_rim.max_by(|one, other| lowness(one).total_cmp(&lowness(other)))
}

/// The direction across a line, of length 1, that leads away from a point.
fn away([a, b]: [Pixel; 2], from: Pixel) -> Pixel {
    let length = distance(a, b);
    let across = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
    let outward = across[0] * (a[0] - from[0]) + across[1] * (a[1] - from[1]);
    if outward < 0.0 { [-across[0], -across[1]] } else { across }
}

/// Writes text beside a point, on the side that `outward` leads to; how far it reaches that way.
fn label_at(picture: &mut Picture, at: Pixel, outward: Pixel, (size, text): (TextSize, &str), ink: [u8; 4]) -> f64 {
    let [width, height] = [size.width(text), size.height()].map(|pixels| pixels as f64);
    let [left, top] = [at[0] + (outward[0] - 1.0) * width / 2.0, at[1] + (outward[1] - 1.0) * height / 2.0];
    if left >= 0.0 && top >= 0.0 {
        picture.text(left.round() as usize, top.round() as usize, size, text, ink);
    }
    outward[0].abs() * width + outward[1].abs() * height
}

fn beside(at: Pixel, outward: Pixel, by: f64) -> Pixel {
    [at[0] + by * outward[0], at[1] + by * outward[1]]
}

fn distance(a: Pixel, b: Pixel) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn mean(points: &[Pixel]) -> Pixel {
    [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Viewpoint;

    const WHITE: [u8; 4] = [255; 4];
    const BOUNDS: [[f64; 3]; 2] = [[-1.0, 0.0, 5.0], [1.0, 1.0, 6.0]];

    fn drawn(viewpoint: Viewpoint) -> (Picture, Camera) {
        let camera = Camera::new(viewpoint).unwrap();
        let mut picture = Picture::new(400, 300, WHITE);
        draw_axes(&mut picture, &camera, BOUNDS, WHITE);
        (picture, camera)
    }

    #[test]
    fn axes_lie_around_the_domain() {
        let viewpoint = Viewpoint::framing(BOUNDS, 60.0, 4.0 / 3.0);
        // Room for labels.
        let eye =
            std::array::from_fn(|axis| viewpoint.target[axis] + 1.5 * (viewpoint.eye[axis] - viewpoint.target[axis]));
        for viewpoint in [Viewpoint { eye, ..viewpoint }, Viewpoint { eye, ..viewpoint }.orthographic()] {
            let (picture, camera) = drawn(viewpoint);
            let inked = |x: usize, y: usize| picture.pixels()[y * 400 + x] != WHITE;
            let count = (0..300).flat_map(|y| (0..400).map(move |x| (x, y))).filter(|&(x, y)| inked(x, y)).count();
            assert!((500..8000).contains(&count), "{count}");
            let center = camera.project([400, 300], [0.0, 0.5, 5.5]).unwrap().map(|pixel| pixel as usize);
            assert!(!inked(center[0], center[1]));
        }
    }

    #[test]
    fn an_axis_that_points_to_the_eye_is_left_out() {
        let eye = [0.0, 0.5, 20.0];
        let viewpoint =
            Viewpoint { eye, target: [0.0, 0.5, 5.5], up: [0.0, 1.0, 0.0], ..Viewpoint::framing(BOUNDS, 20.0, 1.0) };
        let camera = Camera::new(viewpoint.orthographic()).unwrap();
        let corners: Vec<_> = (0..8).map(|corner| camera.project([400, 300], place(BOUNDS, corner)).unwrap()).collect();
        assert_eq!(edge_at_rim(&corners, 2), None);
        let [low, high] = edge_at_rim(&corners, 0).unwrap();
        assert!(corners[low][1] > 150.0 && corners[low][0] < corners[high][0], "{corners:?}");
    }

    #[test]
    fn nothing_is_drawn_from_inside() {
        let inside =
            Viewpoint { eye: [0.0, 0.5, 5.5], target: [1.0, 0.5, 5.5], ..Viewpoint::framing(BOUNDS, 60.0, 1.0) };
        assert_eq!(drawn(inside).0, Picture::new(400, 300, WHITE));
    }
}
