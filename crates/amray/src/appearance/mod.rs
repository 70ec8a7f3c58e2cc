//! How values look: colour maps, transfer functions, and the colour bar that explains them.
//!
//! Colours are display colours (as in VTK), red, green and blue within 0 and 1, mixed as they are.

pub mod automatic;
mod color_bar;
mod color_map;
mod color_space;
mod curve;
mod histogram;
mod picture;
mod prepared;
mod preset;
mod scale;
mod segments;
mod text;
mod ticks;
mod transfer_function;

pub use color_bar::color_bar;
pub use color_map::{ColorMap, UnknownColorMap};
pub use histogram::Histogram;
pub(crate) use picture::ink_on;
pub use picture::{Picture, Rectangle};
pub use prepared::{PreparedTransferFunction, Sample};
pub use preset::PresetError;
pub use scale::{RangeError, Scale};
pub(crate) use segments::{Absorbed, Glow, Place, Radiance, Segments, Slopes, Window, attenuate};
pub use text::TextSize;
pub(crate) use ticks::{Tick, ticks};
pub use transfer_function::{ColorPoint, Opacity, OpacityPoint, TransferFunction, TransferFunctionError};
