//! A mesh in memory: what is kept of its description, and how.

use crate::MeshError;
use crate::frame::Frame;
use crate::tree::{self, Bounds, Primitive, Tree};

/// A mesh as files and programs have it. It may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDescription {
    /// Positions in world units.
    pub vertices: Vec<[f64; 3]>,
    /// Three vertices each; from the front they go round anticlockwise.
    pub triangles: Vec<[u32; 3]>,
    /// RGBA of each vertex, not premultiplied; the alpha from 0 to 1.
    pub colors: Option<Vec<[f32; 4]>>,
    /// The surface's normal at each vertex, of any length. One that is zero or not finite counts as not given.
    pub normals: Option<Vec<[f64; 3]>>,
}

/// A triangle mesh that rays can be asked for.
///
/// Vertices are stored in single precision, relative to the middle of the mesh: they are off by at most 2^-25 of its
/// longest side, wherever it is in the world. Memory for a million triangles that share vertices is about 50 MB.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(crate) frame: Frame,
    /// The low and high corner in the frame, a little outside of all triangles.
    pub(crate) local_bounds: [[f64; 3]; 2],
    bounds: Option<[[f64; 3]; 2]>,
    /// The vertices of triangles, in the order in which these need them.
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) colors: Option<Vec<[f32; 4]>>,
    /// Of length 1, or zero where there is none.
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    /// In the tree's order.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Each triangle's place in the description.
    pub(crate) numbers: Vec<u32>,
    pub(crate) tree: Tree,
    left_out: usize,
    opaque: bool,
}

/// How far outside of the triangles the mesh's bounds are: far more than what rounding does to a ray that starts up to
/// a million times the mesh's size away, less than what boxes are widened by.
const BOUNDS_MARGIN: f64 = 1e-7;

impl Mesh {
    /// Checks a mesh and builds the tree over its triangles, in parallel. Triangles without area are left out.
    ///
    /// # Errors
    /// [`MeshError`] where indices, counts or numbers are not what they should be.
    pub fn new(description: MeshDescription) -> Result<Self, MeshError> {
        description.check()?;
        let MeshDescription { vertices, triangles, colors, normals } = description;
        let corners = |triangle: &[u32; 3]| triangle.map(|vertex| vertices[vertex as usize]);

        let distinct = |[a, b, c]: [[f64; 3]; 3]| a != b && b != c && c != a;
        let distinct_corners = triangles.iter().map(corners).filter(|corners| distinct(*corners));
        let frame = Frame::new(world_bounds(distinct_corners).unwrap_or([[0.0; 3]; 2]));
        let local = |vertex: u32| frame.position(vertices[vertex as usize]).map(|component| component as f32);
        let mut primitives = Vec::with_capacity(triangles.len());
        for (number, triangle) in triangles.iter().enumerate() {
            let local_corners = triangle.map(local);
            if distinct(corners(triangle)) && area_vector(local_corners) != [0.0; 3] {
                primitives.push(Primitive { bounds: Bounds::around(&local_corners), triangle: number as u32 });
            }
        }
        let tree = tree::build(&mut primitives);
        let numbers: Vec<u32> = primitives.iter().map(|primitive| primitive.triangle).collect();
        drop(primitives);

        let kept = || numbers.iter().map(|&number| triangles[number as usize]);
        let bounds = world_bounds(kept().map(|triangle| corners(&triangle)));
        let (used, in_order) = in_order_of_use(kept(), vertices.len());
        let vertices: Vec<_> = used.iter().map(|&vertex| local(vertex)).collect();
        let local_bounds = Bounds::around(&vertices);
        let colors = colors.map(|colors| used.iter().map(|&vertex| colors[vertex as usize]).collect::<Vec<_>>());
        let normals = normals.map(|normals| used.iter().map(|&vertex| unit(normals[vertex as usize])).collect());
        Ok(Self {
            frame,
            local_bounds: [
                local_bounds.low.map(|low| f64::from(low) - BOUNDS_MARGIN),
                local_bounds.high.map(|high| f64::from(high) + BOUNDS_MARGIN),
            ],
            bounds,
            vertices,
            opaque: colors.iter().flatten().all(|color| color[3] >= 1.0),
            colors,
            normals,
            left_out: triangles.len() - numbers.len(),
            triangles: in_order,
            numbers,
            tree,
        })
    }

    /// The low and high corner in world units; none where there are no triangles.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        self.bounds
    }

    /// How many triangles rays can hit.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// How many triangles of the description have no area, and so are not there.
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// Whether no vertex's colour lets light through.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// How far from the surface a ray that leaves it should start, in world units: off along the normal, to the side
    /// where it goes. It is eight times what rounding can move a hit by, and a millionth of the mesh's size at most,
    /// unless the mesh is very far from the world's origin.
    pub fn precision(&self) -> f64 {
        self.bounds.map_or(0.0, |bounds| 8.0 * self.frame.rounding(bounds))
    }

    /// Where the corners of a triangle of the tree are in the frame.
    #[inline(always)]
    pub(crate) fn corners(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }
}

impl MeshDescription {
    /// What [`Mesh::new`] checks.
    pub(crate) fn check(&self) -> Result<(), MeshError> {
        let vertices = self.vertices.len();
        if let Some(colors) = self.colors.as_ref().map(Vec::len).filter(|&colors| colors != vertices) {
            return Err(MeshError::ColorCount { colors, vertices });
        }
        if let Some(normals) = self.normals.as_ref().map(Vec::len).filter(|&normals| normals != vertices) {
            return Err(MeshError::NormalCount { normals, vertices });
        }
        let (triangles, most) = (self.triangles.len(), u32::MAX as usize);
        if triangles > most {
            return Err(MeshError::TooManyTriangles { triangles, most });
        }
        for (vertex, &position) in self.vertices.iter().enumerate() {
            if !position.iter().all(|component| component.is_finite()) {
                return Err(MeshError::VertexNotFinite { vertex, position });
            }
        }
        for (vertex, &color) in self.colors.iter().flatten().enumerate() {
            if !color.iter().all(|component| component.is_finite()) || !(0.0..=1.0).contains(&color[3]) {
                return Err(MeshError::Color { vertex, color });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle, index, vertices });
            }
        }
        Ok(())
    }
}

/// Across a triangle, and twice as long as it is large.
pub(crate) fn area_vector([a, b, c]: [[f32; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|corner| [0, 1, 2].map(|axis| f64::from(corner[axis]) - f64::from(a[axis])));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// A vector made 1 long; zero where it has no direction.
pub(crate) fn unit(vector: [f64; 3]) -> [f32; 3] {
    let longest = vector.iter().fold(0.0, |longest: f64, component| longest.max(component.abs()));
    let vector = vector.map(|component| component / longest);
    let length = vector.iter().map(|component| component * component).sum::<f64>().sqrt();
    if length.is_finite() { vector.map(|component| (component / length) as f32) } else { [0.0; 3] }
}

fn world_bounds(triangles: impl Iterator<Item = [[f64; 3]; 3]>) -> Option<[[f64; 3]; 2]> {
    triangles.flatten().fold(None, |bounds, point| {
        let [mut low, mut high] = bounds.unwrap_or([point; 2]);
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
        Some([low, high])
    })
}

/// The vertices of `vertices` that triangles use, in the order in which these come, and the triangles over them. What
/// rays need together is close together then.
fn in_order_of_use(triangles: impl Iterator<Item = [u32; 3]>, vertices: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    const UNUSED: u32 = u32::MAX;
    let mut places = vec![UNUSED; vertices];
    let mut used = Vec::new();
    let triangles = triangles
        .map(|triangle| {
            triangle.map(|vertex| {
                let place = &mut places[vertex as usize];
                if *place == UNUSED {
                    *place = used.len() as u32;
                    used.push(vertex);
                }
                *place
            })
        })
        .collect();
    (used, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad() -> MeshDescription {
        MeshDescription {
            vertices: vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshDescription::default()
        }
    }

    fn error(change: impl FnOnce(&mut MeshDescription)) -> String {
        let mut description = quad();
        change(&mut description);
        Mesh::new(description).unwrap_err().to_string()
    }

    #[test]
    fn what_is_wrong_is_named() {
        let expected = "vertex 1 is at (2, NaN, 0), expected finite numbers";
        assert_eq!(error(|quad| quad.vertices[1][1] = f64::NAN), expected);
        let expected = "vertex 3 is at (0, 1, -inf), expected finite numbers";
        assert_eq!(error(|quad| quad.vertices[3][2] = f64::NEG_INFINITY), expected);
        let expected = "triangle 1 refers to vertex 4, but there are 4 vertices";
        assert_eq!(error(|quad| quad.triangles[1][1] = 4), expected);
        let expected = "there are 3 colours for 4 vertices, expected one per vertex";
        assert_eq!(error(|quad| quad.colors = Some(vec![[1.0; 4]; 3])), expected);
        let expected = "there are 5 normals for 4 vertices, expected one per vertex";
        assert_eq!(error(|quad| quad.normals = Some(vec![[1.0; 3]; 5])), expected);
        let expected =
            "the colour of vertex 0 is [1.0, 1.0, 1.0, 2.0], expected finite numbers and an alpha from 0 to 1";
        assert_eq!(error(|quad| quad.colors = Some(vec![[1.0, 1.0, 1.0, 2.0]; 4])), expected);
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        let mut description = quad();
        description.vertices.push([4.0, 4.0, 0.0]);
        description.vertices.push([2.0, 2.0, 0.0]);
        description.triangles.extend([[0, 0, 1], [4, 1, 4], [2, 2, 2], [0, 4, 5]]);
        let mesh = Mesh::new(description).unwrap();
        assert_eq!((mesh.triangle_count(), mesh.left_out()), (2, 4));
        assert_eq!(mesh.bounds(), Some([[0.0; 3], [2.0, 1.0, 0.0]]));
    }

    #[test]
    fn a_mesh_may_be_empty() {
        for vertices in [vec![], vec![[1.0; 3]; 3]] {
            let mesh = Mesh::new(MeshDescription { vertices, ..MeshDescription::default() }).unwrap();
            assert_eq!((mesh.triangle_count(), mesh.left_out(), mesh.bounds()), (0, 0, None));
            assert!(mesh.is_opaque());
            assert_eq!(mesh.precision(), 0.0);
        }
    }

    #[test]
    fn one_translucent_vertex_makes_a_mesh_translucent() {
        let mut description = quad();
        description.colors = Some(vec![[0.5, 0.5, 0.5, 1.0]; 4]);
        assert!(Mesh::new(description.clone()).unwrap().is_opaque());
        description.colors.as_mut().unwrap()[2][3] = 0.9;
        assert!(!Mesh::new(description).unwrap().is_opaque());
    }

    #[test]
    fn normals_are_made_one_long() {
        assert_eq!(unit([0.0, -3e200, 4e200]), [0.0, -0.6, 0.8]);
        assert_eq!(unit([1e-320, 0.0, 0.0]), [1.0, 0.0, 0.0]);
        for none in [[0.0; 3], [f64::NAN, 1.0, 0.0], [1.0, f64::INFINITY, 0.0]] {
            assert_eq!(unit(none), [0.0; 3], "{none:?}");
        }
    }
}
