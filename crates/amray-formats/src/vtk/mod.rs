//! VTK's files: AMR data as an XML index of images (`.vthb`) or as one HDF5 file (`.vtkhdf`), and images alone (`.vti`).
//!
//! The formats are described in VTK's documentation, chapter *VTK File Formats*. Boxes of AMR data are in cells of their
//! level, with the last cell included; cell (0, 0, 0) of every level begins at the origin.

mod arrays;
mod geometry;
mod image;
mod overlapping;
mod vtkhdf;
mod writer;

pub(crate) use image::{Image, ImageArray};
pub use overlapping::VthbFile;
pub use vtkhdf::VtkhdfFile;
pub use writer::{VthbWriter, VtkhdfWriter};
