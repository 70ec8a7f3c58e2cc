//! AMR data as VTK reads them.

mod images;
mod vthb;
mod vtkhdf;

pub use vthb::VthbWriter;
pub use vtkhdf::VtkhdfWriter;
