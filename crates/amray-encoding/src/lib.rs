//! Numbers and arrays as files encode them: number types in either byte order, base64, compressed blocks, and the XML
//! files of VTK that are made of them.
//!
//! Nothing here believes a count before there are bytes for it: damaged input is an error, whatever it says.

mod number;
mod text;
pub mod vtk;

pub use number::{ByteOrder, NumberType};
pub use text::shown;
