//! What of the volumes is cut away, to look inside.

/// Cuts volumes, isosurfaces and slices; several clips leave what all of them leave. Meshes stay whole. What is cut away
/// throws no shadows either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clip {
    /// Leaves the side of a plane that its normal points to.
    Plane {
        /// A point on it, in world units.
        point: [f64; 3],
        /// Across it: of any length but 0.
        normal: [f64; 3],
    },
    /// Leaves what is inside a box: its low and high corner, in world units.
    Inside([[f64; 3]; 2]),
    /// Leaves what is outside of a box.
    Outside([[f64; 3]; 2]),
}
