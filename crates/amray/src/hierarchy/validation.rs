//! From what a file says of its levels to a hierarchy that the rest can rely on.

use super::error::{HierarchyError, HierarchyWarning};
use super::overlap::for_each_overlap;
use super::{Hierarchy, IndexBox, Level, LevelDescription};

/// Regions keep a level in one byte; real hierarchies stay below thirty.
const MAX_LEVELS: usize = 64;
/// Brick numbers are kept in 32 bits.
const MAX_BRICKS: usize = u32::MAX as usize;
/// Half cells of the finest level must be exact in f64.
const MAX_INDEX: u64 = 1 << 51;
/// Counts of cells, and of their bytes, stay within 64 bits.
const MAX_CELLS: u64 = 1 << 60;
/// Files may hold cell sizes in single precision.
const CELL_SIZE_TOLERANCE: f64 = 1e-4;

pub(super) fn validated(origin: [f64; 3], descriptions: Vec<LevelDescription>) -> Result<Hierarchy, HierarchyError> {
    check_counts(&descriptions)?;
    check_geometry(origin, &descriptions)?;
    for (level, description) in descriptions.iter().enumerate() {
        check_bricks(level, description)?;
    }
    let warnings = (1..descriptions.len())
        .filter_map(|level| improper_nesting(level, &descriptions[level - 1], &descriptions[level]))
        .collect();
    Ok(Hierarchy { origin, levels: levels(descriptions), warnings })
}

fn check_counts(levels: &[LevelDescription]) -> Result<(), HierarchyError> {
    let bricks = levels.iter().map(|level| level.bricks.len()).sum::<usize>();
    if bricks == 0 {
        return Err(HierarchyError::Empty);
    }
    let cells =
        levels.iter().flat_map(|level| &level.bricks).fold(0, |sum: u64, brick| sum.saturating_add(brick.cells()));
    let counts = [
        ("levels", levels.len() as u64, MAX_LEVELS as u64),
        ("bricks", bricks as u64, MAX_BRICKS as u64),
        ("cells", cells, MAX_CELLS),
    ];
    for (what, count, limit) in counts {
        if count > limit {
            return Err(HierarchyError::TooMany { what, count, limit });
        }
    }
    Ok(())
}

fn check_geometry(origin: [f64; 3], levels: &[LevelDescription]) -> Result<(), HierarchyError> {
    if origin.iter().any(|position| !position.is_finite()) {
        let expected = "finite numbers";
        return Err(HierarchyError::Geometry { level: 0, what: "the origin", found: origin, expected });
    }
    for (number, level) in levels.iter().enumerate() {
        let LevelDescription { ratio, cell_size, domain, .. } = level;
        if cell_size.iter().any(|width| !(width.is_normal() && *width > 0.0)) {
            let expected = "positive numbers";
            return Err(HierarchyError::Geometry { level: number, what: "the cell size", found: *cell_size, expected });
        }
        if domain.is_empty() {
            let expected = "at least one cell per axis".into();
            return Err(HierarchyError::Domain { level: number, found: *domain, expected });
        }
        let expected = match number {
            0 if *ratio != [1; 3] => "[1, 1, 1] on the coarsest level",
            0 => continue,
            _ if ratio.iter().any(|&cells| cells < 1) => "at least 1 on every axis",
            _ if *ratio == [1; 3] => "at least 2 on one axis",
            _ => {
                check_against_coarser(number, &levels[number - 1], level)?;
                continue;
            }
        };
        return Err(HierarchyError::Ratio { level: number, found: *ratio, expected });
    }
    check_range(origin, levels)
}

fn check_against_coarser(
    number: usize,
    coarser: &LevelDescription,
    level: &LevelDescription,
) -> Result<(), HierarchyError> {
    let expected: [f64; 3] = std::array::from_fn(|axis| coarser.cell_size[axis] / level.ratio[axis] as f64);
    let found = level.cell_size;
    if (0..3).any(|axis| (found[axis] - expected[axis]).abs() > CELL_SIZE_TOLERANCE * expected[axis]) {
        return Err(HierarchyError::CellSize { level: number, found, expected });
    }
    match coarser.domain.checked_refined(level.ratio) {
        None => Err(HierarchyError::Overflow { level: number - 1, domain: coarser.domain }),
        Some(refined) if refined != level.domain => {
            let expected = format!("{refined} (the next coarser domain refined by {:?})", level.ratio);
            Err(HierarchyError::Domain { level: number, found: level.domain, expected })
        }
        Some(_) => Ok(()),
    }
}

/// Every position must be exact to half a cell of the finest level, in integers and in f64.
fn check_range(origin: [f64; 3], levels: &[LevelDescription]) -> Result<(), HierarchyError> {
    let Some(finest) = levels.last() else { return Ok(()) };
    for axis in 0..3 {
        let IndexBox { low, high } = finest.domain;
        let farthest = low[axis].unsigned_abs().max(high[axis].unsigned_abs());
        let origin = (origin[axis] / finest.cell_size[axis]).abs();
        let reach = farthest as f64 * finest.cell_size[axis];
        if farthest > MAX_INDEX || origin > MAX_INDEX as f64 || !reach.is_finite() {
            return Err(HierarchyError::Overflow { level: levels.len() - 1, domain: finest.domain });
        }
    }
    Ok(())
}

fn check_bricks(level: usize, description: &LevelDescription) -> Result<(), HierarchyError> {
    let LevelDescription { ratio, domain, bricks, .. } = description;
    for (brick, &found) in bricks.iter().enumerate() {
        if found.is_empty() {
            return Err(HierarchyError::EmptyBrick { level, brick, found });
        }
        if !domain.contains_box(&found) {
            return Err(HierarchyError::OutsideDomain { level, brick, found, domain: *domain });
        }
        let cuts = |corner: [i64; 3]| (0..3).any(|axis| corner[axis] % ratio[axis] != 0);
        if cuts(found.low) || cuts(found.high) {
            return Err(HierarchyError::Misaligned { level, brick, found, ratio: *ratio });
        }
    }
    let mut overlap = None;
    for_each_overlap(bricks, bricks, |first, second, shared| {
        if first != second {
            overlap =
                Some(HierarchyError::Overlap { level, first: first.min(second), second: first.max(second), shared });
        }
        overlap.is_none()
    });
    overlap.map_or(Ok(()), Err)
}

/// Bricks are disjoint by now, so a brick is covered where the shared cells add up to its own.
fn improper_nesting(
    level: usize,
    coarser: &LevelDescription,
    description: &LevelDescription,
) -> Option<HierarchyWarning> {
    let needed: Vec<IndexBox> = description.bricks.iter().map(|brick| brick.coarsened(description.ratio)).collect();
    let mut missing: Vec<u64> = needed.iter().map(IndexBox::cells).collect();
    for_each_overlap(&needed, &coarser.bricks, |brick, _, shared| {
        missing[brick] -= shared.cells();
        true
    });
    let first = missing.iter().position(|&cells| cells > 0)?;
    let bricks = missing.iter().filter(|&&cells| cells > 0).count();
    Some(HierarchyWarning::ImproperNesting { level, bricks, of: missing.len(), first })
}

/// Cell sizes are derived from level 0's, so that levels agree to the last digit whatever the file rounds to.
fn levels(descriptions: Vec<LevelDescription>) -> Vec<Level> {
    let coarsest = descriptions[0].cell_size;
    let mut refinement = [1i64; 3];
    let mut first_brick = 0;
    let mut levels: Vec<Level> = Vec::with_capacity(descriptions.len());
    for LevelDescription { ratio, domain, bricks, .. } in descriptions {
        refinement = std::array::from_fn(|axis| refinement[axis] * ratio[axis]);
        let cell_size = std::array::from_fn(|axis| coarsest[axis] / refinement[axis] as f64);
        let count = bricks.len();
        // `finest_cells` holds the refinement of level 0 until that of the finest level is known.
        levels.push(Level { ratio, cell_size, domain, bricks, first_brick, finest_cells: refinement });
        first_brick += count;
    }
    for level in &mut levels {
        level.finest_cells = std::array::from_fn(|axis| refinement[axis] / level.finest_cells[axis]);
    }
    levels
}
