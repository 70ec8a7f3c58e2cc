//! What goes in and what comes out: rays and their hits, in world units.

/// A piece of a straight line: `origin + t * direction` for `t` between `from` and `to`, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is 0, in world units.
    pub origin: [f64; 3],
    /// How far one unit of `t` goes, in world units. It may have any length but zero.
    pub direction: [f64; 3],
    /// The smallest `t`; may be negative, and infinite.
    pub from: f64,
    /// The largest `t`; may be infinite.
    pub to: f64,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// How far along the ray, in units of its direction.
    pub t: f64,
    /// The triangle's place in the description of the mesh.
    pub triangle: u32,
    /// How much each of the triangle's vertices counts, in its order; together 1.
    pub weights: [f32; 3],
    /// The normal for shading, of length 1: interpolated between those of the vertices, or where there are none
    /// [`Hit::geometric_normal`]. It points where the mesh says, not towards the ray.
    pub normal: [f32; 3],
    /// The normal of the triangle's plane, of length 1: from where it points, the vertices go round anticlockwise.
    pub geometric_normal: [f32; 3],
    /// RGBA, interpolated between the colours of the vertices and not premultiplied; white where there are none.
    pub color: [f32; 4],
}
