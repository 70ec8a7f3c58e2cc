//! A hierarchy in the numbers of a Chombo file: 32-bit indices, inclusive corners, no origin but in whole cells.

use std::path::Path;

use amray::hierarchy::{Hierarchy, IndexBox, Level};

use crate::{AmrContent, FormatError};

/// What codes write where it has no meaning: for the finest level.
const FINEST_RATIO: [i64; 3] = [2; 3];
/// Origins and cell widths carry the rounding of whatever they were computed from.
const ROUNDING: f64 = 1e-9;
/// A file's length in bytes is a signed 64-bit number.
const MAX_VALUES: u64 = i64::MAX as u64 / size_of::<f64>() as u64;

/// One level.
pub(super) struct LevelTable {
    pub(super) cell_size: CellSize,
    /// To the next finer level.
    pub(super) ratio: [i32; 3],
    pub(super) domain: Corners,
    pub(super) boxes: Vec<Corners>,
    /// Where each brick's values start, and where the last one's end.
    pub(super) offsets: Vec<i64>,
}

/// A box's first and last cell.
pub(super) type Corners = [i32; 6];

/// A cell's width: one number if all levels have cubes for cells and the same ratio on all axes.
pub(super) enum CellSize {
    Cubic(f64),
    PerAxis([f64; 3]),
}

/// The tables of all levels, and the origin where indices do not tell it.
pub(super) fn of(path: &Path, content: &AmrContent) -> Result<(Option<[f64; 3]>, Vec<LevelTable>), FormatError> {
    let hierarchy = content.hierarchy;
    let levels = hierarchy.levels();
    let in_cells = origin_in_cells(hierarchy);
    let origin = in_cells.unwrap_or_default();
    let isotropic = levels.iter().all(is_isotropic);
    let table = |(number, level): (usize, &Level)| {
        let refinement = [0, 1, 2].map(|axis| levels[0].finest_cells()[axis] / level.finest_cells()[axis]);
        let shift = [0, 1, 2].map(|axis| i128::from(origin[axis]) * i128::from(refinement[axis]));
        let finer_ratio = levels.get(number + 1).map_or(FINEST_RATIO, Level::ratio);
        let refused = |problem| FormatError::malformed(path, format!("level {number}"), problem);
        LevelTable::new(level, finer_ratio, shift, isotropic, content).map_err(refused)
    };
    let tables = levels.iter().enumerate().map(table).collect::<Result<_, _>>()?;
    Ok((in_cells.is_none().then(|| hierarchy.origin()), tables))
}

impl LevelTable {
    fn new(
        level: &Level,
        finer_ratio: [i64; 3],
        shift: [i128; 3],
        isotropic: bool,
        content: &AmrContent,
    ) -> Result<Self, String> {
        let domain = corners(&level.domain(), shift)
            .ok_or_else(|| format!("domain {} does not fit Chombo's 32-bit indices", level.domain()))?;
        let [Ok(x), Ok(y), Ok(z)] = finer_ratio.map(i32::try_from) else {
            return Err(format!("refinement ratio {finer_ratio:?} does not fit Chombo's 32-bit numbers"));
        };
        // Bricks lie in the domain, so their indices fit too.
        let boxes = level.bricks().iter().filter_map(|brick| corners(brick, shift)).collect();
        let components = content.components.len();
        let places = level.bricks().iter().map(|brick| content.centering.values_of(brick));
        let offsets = offsets(places, components as u64).ok_or_else(|| {
            format!("{} bricks of {components} components hold too many values", level.bricks().len())
        })?;
        let width = level.cell_size();
        let cell_size = if isotropic { CellSize::Cubic(width[0]) } else { CellSize::PerAxis(width) };
        Ok(Self { cell_size, ratio: [x, y, z], domain, boxes, offsets })
    }
}

/// The origin in cells of level 0, where that is a whole number.
fn origin_in_cells(hierarchy: &Hierarchy) -> Option<[i64; 3]> {
    let (origin, width) = (hierarchy.origin(), hierarchy.levels()[0].cell_size());
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let cells = origin[axis] / width[axis];
        let off = (cells - cells.round()).abs();
        (off <= ROUNDING * cells.abs().max(1.0)).then_some(cells.round() as i64)
    });
    Some([x?, y?, z?])
}

fn is_isotropic(level: &Level) -> bool {
    let (width, ratio) = (level.cell_size(), level.ratio());
    let cubic = width.iter().all(|other| (other - width[0]).abs() <= ROUNDING * width[0]);
    cubic && ratio == [ratio[0]; 3]
}

fn corners(cells: &IndexBox, shift: [i128; 3]) -> Option<Corners> {
    let index =
        |corner: [i64; 3], last: i128, axis: usize| i32::try_from(i128::from(corner[axis]) + shift[axis] - last).ok();
    let [first_x, first_y, first_z] = [0, 1, 2].map(|axis| index(cells.low, 0, axis));
    let [last_x, last_y, last_z] = [0, 1, 2].map(|axis| index(cells.high, 1, axis));
    Some([first_x?, first_y?, first_z?, last_x?, last_y?, last_z?])
}

fn offsets(places: impl Iterator<Item = IndexBox>, components: u64) -> Option<Vec<i64>> {
    let mut end = 0u64;
    let mut offsets = vec![0];
    for places in places {
        let values = places.cells().checked_mul(components)?;
        end = end.checked_add(values).filter(|&end| end <= MAX_VALUES)?;
        offsets.push(end as i64);
    }
    Some(offsets)
}
