//! Where a ray meets a triangle: on a closed surface exactly once per sheet, never between two neighbours.
//!
//! The test is that of Woop, Benthin, Wald, *Watertight Ray/Triangle Intersection* (Journal of Computer Graphics
//! Techniques 2013): space is sheared so that the ray is an axis, and three edge functions say on which side of the
//! edges the ray passes. Two triangles that share an edge compute the same number for it, but for its sign.
//!
//! An edge function of zero needs more care: both neighbours would be hit, or at a vertex many. Here the sign is always
//! exact, and a ray that goes through an edge exactly counts as shifted by an infinitely small distance (Edelsbrunner,
//! Mücke, *Simulation of Simplicity*, ACM Transactions on Graphics 1990), the same for all triangles.

use crate::local_ray::LocalRay;

/// Where a ray meets a triangle, in the mesh's own units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// From the ray's origin.
    pub(crate) distance: f64,
    /// How much each corner counts.
    pub(crate) weights: [f64; 3],
}

/// A corner as the ray sees it: right, up, and along.
type Seen = [f64; 3];

/// The edge function of `a` and `b`: positive where the ray passes on the left of the way from `a` to `b`.
#[inline(always)]
fn edge(a: Seen, b: Seen) -> f64 {
    // Rounding keeps order, so the sign is right unless the result is zero; and swapping a and b only swaps the sign.
    a[0] * b[1] - a[1] * b[0]
}

/// [`edge`], and the side on which the ray passes where that is zero.
#[cold]
fn exact_edge(a: Seen, b: Seen) -> (f64, bool) {
    let [left, right] = [a[0] * b[1], a[1] * b[0]];
    let mut function = left - right;
    if function == 0.0 {
        // What the products lost by rounding.
        function = a[0].mul_add(b[1], -left) - a[1].mul_add(b[0], -right);
    }
    let on_left = if function != 0.0 {
        function > 0.0
    } else if a[1] != b[1] {
        a[1] > b[1]
    } else {
        a[0] < b[0]
    };
    (function, on_left)
}

impl LocalRay {
    /// Where the ray's whole line meets a triangle, seen from either side.
    #[inline]
    pub(crate) fn cross(&self, corners: [[f32; 3]; 3]) -> Option<Crossing> {
        let [x, y, z] = self.shear.axes;
        let seen = corners.map(|corner| {
            let along = f64::from(corner[z]) - self.origin[z];
            [
                f64::from(corner[x]) - self.origin[x] - self.shear.slope[0] * along,
                f64::from(corner[y]) - self.origin[y] - self.shear.slope[1] * along,
                along,
            ]
        });
        let [a, b, c] = seen;
        let mut functions = [edge(b, c), edge(c, a), edge(a, b)];
        let all = |side: fn(&f64) -> bool| functions.iter().all(side);
        if !all(|function| *function > 0.0) && !all(|function| *function < 0.0) {
            if functions.iter().any(|function| *function > 0.0) && functions.iter().any(|function| *function < 0.0) {
                return None;
            }
            functions = through_edge(seen)?;
        }
        let sum = functions[0] + functions[1] + functions[2];
        let weights = functions.map(|function| function / sum);
        let along = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        Some(Crossing { distance: along * self.shear.distance, weights })
    }
}

/// The exact edge functions, where the ray passes on the same side of all edges.
#[cold]
fn through_edge([a, b, c]: [Seen; 3]) -> Option<[f64; 3]> {
    let edges = [exact_edge(b, c), exact_edge(c, a), exact_edge(a, b)];
    let inside = edges[0].1 == edges[1].1 && edges[1].1 == edges[2].1;
    inside.then(|| edges.map(|(function, _)| function))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;
    use crate::frame::Frame;

    /// Along z through a point of the plane z = 0.
    fn ray(x: f64, y: f64) -> LocalRay {
        let frame = Frame::new([[-0.9; 3], [0.9; 3]]);
        let ray = Ray { origin: [x, y, -0.5], direction: [0.0, 0.0, 1.0], from: 0.0, to: f64::INFINITY };
        LocalRay::new(&ray, &frame, [[-1.0; 3], [1.0; 3]]).unwrap()
    }

    #[test]
    fn weights_are_those_of_the_corners() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for [first, second, third] in [[0, 1, 2], [1, 2, 0], [0, 2, 1]] {
            let crossing = ray(0.25, 0.5).cross([corners[first], corners[second], corners[third]]).unwrap();
            let expected = [0.25, 0.25, 0.5];
            assert_eq!(crossing.weights, [expected[first], expected[second], expected[third]]);
            assert_eq!(crossing.distance, 0.5);
        }
        assert_eq!(ray(0.75, 0.75).cross(corners), None);
        assert_eq!(ray(-0.25, 0.5).cross(corners), None);
    }

    #[test]
    fn a_ray_through_edges_and_vertices_of_a_fan_meets_one_triangle() {
        let rim: Vec<[f32; 3]> =
            [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [-0.7, 0.3], [-0.5, -0.5], [0.0, -1.0], [0.9, -0.9]]
                .map(|[x, y]| [x, y, 0.0])
                .into();
        let count = |x: f64, y: f64| {
            let meets = |next: usize| {
                let corners = [[0.0; 3], rim[next], rim[(next + 1) % rim.len()]];
                ray(x, y).cross(corners).is_some()
            };
            (0..rim.len()).filter(|&next| meets(next)).count()
        };
        assert_eq!(count(0.0, 0.0), 1);
        for corner in &rim {
            for share in [0.125, 0.25, 0.5] {
                assert_eq!(count(share * f64::from(corner[0]), share * f64::from(corner[1])), 1, "{corner:?} {share}");
            }
        }
    }

    #[test]
    fn edge_functions_that_round_to_zero_have_their_exact_sign() {
        // The products differ by the square of one rounding.
        let [a, b] = [[1.0 + f64::EPSILON, 1.0, 0.0], [1.0, 1.0 - f64::EPSILON, 0.0]];
        assert_eq!(edge(a, b), 0.0);
        assert_eq!(exact_edge(a, b), (-f64::EPSILON * f64::EPSILON, false));
        assert_eq!(exact_edge(b, a), (f64::EPSILON * f64::EPSILON, true));
    }

    #[test]
    fn a_triangle_seen_from_its_edge_is_not_met() {
        for corners in [
            [[0.0, -0.5, -0.5], [0.0, 0.5, -0.25], [0.0, 0.25, 0.5]],
            [[-0.5, 0.0, -0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]],
            [[0.0, 0.0, -0.5], [0.0, 0.0, 0.5], [0.5, 0.0, 0.0]],
        ] {
            assert_eq!(ray(0.0, 0.0).cross(corners), None, "{corners:?}");
        }
    }
}
