//! Plotfiles written by AMReX, plotfiles written here, and damaged ones.

mod damaged;
mod real;
mod round_trip;
mod synthetic;

use std::path::Path;

use amray::hierarchy::{Field, VoxelType};

use super::*;

fn open(path: &Path) -> Result<AmrexPlotfile, FormatError> {
    AmrexPlotfile::open(path, &OpenOptions::default())
}

fn read(plotfile: &AmrexPlotfile, field: usize) -> Field {
    plotfile.read_field(field, &|_| ()).unwrap()
}
