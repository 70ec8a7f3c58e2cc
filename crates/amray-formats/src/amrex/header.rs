//! The file `Header` of a plotfile: fields, time, and the geometry of every level.
//!
//! Line by line: version, number of components, their names, dimension, time, finest level, low corner, high corner,
//! ratios, domain boxes, steps, a cell size per level, coordinate system, 0; then per level its number, grids and
//! time, its step, bounds per grid and axis, and the path of its values.

use std::path::{Path, PathBuf};

use amray::hierarchy::IndexBox;

use super::text::{INDEX_BOX, LineReader, Scanner};
use crate::relative_path::path_below;
use crate::{FormatError, OpenOptions};

/// What `Header` says.
#[derive(Debug, PartialEq)]
pub(super) struct Header {
    /// The names of the components.
    pub(super) fields: Vec<String>,
    /// The simulation time.
    pub(super) time: f64,
    /// World position of the low corner of cell (0, 0, 0).
    pub(super) origin: [f64; 3],
    /// What the axes are.
    pub(super) coordinates: Coordinates,
    /// The levels that are to be read, coarsest first.
    pub(super) levels: Vec<HeaderLevel>,
}

/// What `Header` says of one level.
#[derive(Debug, PartialEq)]
pub(super) struct HeaderLevel {
    /// Cells per cell of the next coarser level, per axis; `[1, 1, 1]` on level 0.
    pub(super) ratio: [i64; 3],
    /// A cell's width per axis.
    pub(super) cell_size: [f64; 3],
    /// The domain in this level's cells.
    pub(super) domain: IndexBox,
    /// The number of bricks.
    pub(super) grids: usize,
    /// The file that lists the bricks (`Level_0/Cell_H`), from the plotfile's directory on.
    pub(super) multifab: PathBuf,
}

/// AMReX's coordinate systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coordinates {
    Cartesian,
    Cylindrical,
    Spherical,
}

/// Whether the file starts as the `Header` of a plotfile of any dimension.
pub(super) fn recognises(path: &Path) -> bool {
    let start = || -> Result<(), FormatError> {
        let mut lines = LineReader::open(path)?;
        fields_and_dimension(&mut lines)?;
        lines.number::<f64>("a time")?;
        lines.number::<usize>("a level")?;
        Ok(())
    };
    start().is_ok()
}

impl Header {
    pub(super) fn read(path: &Path, options: &OpenOptions) -> Result<Self, FormatError> {
        let mut lines = LineReader::open(path)?;
        let (fields, dimension) = fields_and_dimension(&mut lines)?;
        if dimension != 3 {
            return Err(lines.malformed("3 dimensions (others cannot be shown)"));
        }
        let time = lines.parse("the time, a finite number", |line| line.finite())?;
        let levels = lines.parse("the number of the finest level", |line| line.number::<usize>()?.checked_add(1))?;
        let count = options.level_count(path, levels)?;
        let low = lines.parse("the domain's low corner, three finite numbers", |line| line.finite_triple())?;
        lines.parse("the domain's high corner, three finite numbers", |line| line.finite_triple())?;
        // Only the first component of a ratio is written; the cell sizes tell it per axis.
        lines.parse("refinement ratios", |_| Some(()))?;
        let domains: Vec<IndexBox> = lines.parse(format_args!("{INDEX_BOX} for each of {levels} levels"), |line| {
            (0..levels).map(|_| line.index_box()).collect()
        })?;
        lines.parse("the steps of the levels", |_| Some(()))?;
        let mut cell_sizes = Vec::new();
        for level in 0..levels {
            let expected = format_args!("the cell size of level {level}, three finite numbers");
            cell_sizes.push(lines.parse(expected, |line| line.finite_triple())?);
        }
        let coordinates = lines.parse("a coordinate system, 0, 1 or 2", Coordinates::scan)?;
        lines.parse("0", |_| Some(()))?;

        let mut described = Vec::new();
        for level in 0..count {
            let (grids, multifab) = level_section(&mut lines, level)?;
            let cell_size: [f64; 3] = cell_sizes[level];
            let ratio = match level {
                0 => [1; 3],
                _ => std::array::from_fn(|axis| (cell_sizes[level - 1][axis] / cell_size[axis]).round() as i64),
            };
            described.push(HeaderLevel { ratio, cell_size, domain: domains[level], grids, multifab });
        }
        // The low corner is that of the domain, wherever its indices start.
        let origin = std::array::from_fn(|axis| low[axis] - domains[0].low[axis] as f64 * cell_sizes[0][axis]);
        Ok(Self { fields, time, origin, coordinates, levels: described })
    }
}

impl Coordinates {
    fn scan(line: &mut Scanner<'_>) -> Option<Self> {
        match line.number()? {
            0 => Some(Self::Cartesian),
            1 => Some(Self::Cylindrical),
            2 => Some(Self::Spherical),
            _ => None,
        }
    }
}

/// The names of the components and the dimension (1 to 3), with which every `Header` starts after its version.
fn fields_and_dimension(lines: &mut LineReader) -> Result<(Vec<String>, usize), FormatError> {
    lines.parse("a version such as HyperCLaw-V1.1", |line| {
        line.word().filter(|word| word.parse::<f64>().is_err()).map(|_| ())
    })?;
    let components = lines.parse("the number of components, at least 1", |line| {
        line.number::<usize>().filter(|&components| components > 0)
    })?;
    let mut fields = Vec::new();
    for component in 0..components {
        let name = lines.parse(format_args!("the name of component {component}"), |line| {
            (!line.rest().is_empty()).then(|| line.rest().to_owned())
        })?;
        fields.push(name);
    }
    let dimension =
        lines.parse("the dimension, 1 to 3", |line| line.number().filter(|dimension| (1..=3).contains(dimension)))?;
    Ok((fields, dimension))
}

/// The number of a level's grids and the path of the file that lists them.
fn level_section(lines: &mut LineReader, level: usize) -> Result<(usize, PathBuf), FormatError> {
    let expected = format_args!("level {level}, its number of grids and its time");
    let grids = lines.parse(expected, |line| {
        let number: usize = line.number()?;
        line.number().filter(|_| number == level)
    })?;
    if grids == 0 {
        let expected = match level {
            0 => "level 0 to hold at least one grid".to_owned(),
            _ => format!("level {level} to hold at least one grid (--max-level {} leaves it out)", level - 1),
        };
        return Err(lines.malformed(expected));
    }
    lines.parse(format_args!("the step of level {level}"), |_| Some(()))?;
    for grid in 0..grids {
        for axis in ["x", "y", "z"] {
            // The boxes in cells, which the values' own file lists, say the same exactly.
            let bounds = |line: &mut Scanner<'_>| Some((line.number::<f64>()?, line.number::<f64>()?));
            lines.parse(format_args!("the bounds of level {level}, grid {grid}, in {axis}"), bounds)?;
        }
    }
    let expected = format_args!("the path of level {level}'s values below the plotfile, such as Level_{level}/Cell");
    let multifab = lines.parse(expected, |line| {
        path_below(line.rest()).and_then(|path| path_below(&format!("{}_H", path.display())))
    })?;
    Ok((grids, multifab))
}
