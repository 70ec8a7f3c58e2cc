//! Pictures of values that are not coloured yet.

/// A value per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueImage {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The values, row by row from the top; NaN where there is none.
    pub values: Vec<f64>,
}
