//! The geometry in a Chombo file: levels, boxes, cell sizes, refinement ratios.

use std::path::Path;

use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};

use crate::FormatError;
use crate::hdf5::Hdf5Group;

/// A box: its first and last cell. In files the type has 28 bytes, not 24, so members go by name.
const BOX: [&str; 6] = ["lo_i", "lo_j", "lo_k", "hi_i", "hi_j", "hi_k"];
/// An integer per axis.
pub(super) const INTEGER_VECTOR: [&str; 3] = ["intvecti", "intvectj", "intvectk"];
/// A number per axis.
const REAL_VECTOR: [&str; 3] = ["x", "y", "z"];

/// The group of a level, by its number.
pub(super) fn level_group(root: &Hdf5Group, number: usize) -> Result<Hdf5Group, FormatError> {
    let name = format!("level_{number}");
    let missing = || root.malformed(&format!("no group {name}, expected it by the attribute num_levels"));
    root.group(&name)?.ok_or_else(missing)
}

/// The validated hierarchy of the levels that are to be read.
pub(super) fn hierarchy(
    path: &Path,
    root: &Hdf5Group,
    levels: &[Hdf5Group],
    warnings: &mut Vec<String>,
) -> Result<Hierarchy, FormatError> {
    let origin = root.floats("origin", REAL_VECTOR)?.unwrap_or_default();
    let mut descriptions: Vec<LevelDescription> = Vec::with_capacity(levels.len());
    for (number, level) in levels.iter().enumerate() {
        let coarser = match number {
            0 => None,
            _ => Some((&descriptions[number - 1], ratio_to_finer(&levels[number - 1])?)),
        };
        let cell_size = match (cell_size(level)?, &coarser) {
            (Some(cell_size), _) => cell_size,
            (None, Some((coarser, ratio))) => std::array::from_fn(|axis| coarser.cell_size[axis] / ratio[axis] as f64),
            (None, None) => {
                warnings.push(format!("{} has no dx: cells are taken to be 1 wide", level.place()));
                [1.0; 3]
            }
        };
        let bricks = bricks(number, level)?;
        let ratio = coarser.map_or([1; 3], |(_, ratio)| ratio);
        descriptions.push(LevelDescription { ratio, cell_size, domain: domain(level)?, bricks });
    }
    Hierarchy::new(origin, descriptions).map_err(FormatError::hierarchy(path))
}

/// The ratio between a level and the next finer one, which is where Chombo keeps it.
fn ratio_to_finer(level: &Hdf5Group) -> Result<[i64; 3], FormatError> {
    if let Some(ratio) = level.integers("vec_ref_ratio", INTEGER_VECTOR)? {
        return Ok(ratio);
    }
    let ratio =
        level.integer("ref_ratio")?.ok_or_else(|| level.malformed("no attribute ref_ratio or vec_ref_ratio"))?;
    Ok([ratio; 3])
}

fn cell_size(level: &Hdf5Group) -> Result<Option<[f64; 3]>, FormatError> {
    match level.floats("vec_dx", REAL_VECTOR)? {
        Some(cell_size) => Ok(Some(cell_size)),
        None => Ok(level.float("dx")?.map(|width| [width; 3])),
    }
}

fn domain(level: &Hdf5Group) -> Result<IndexBox, FormatError> {
    let corners = level.integers("prob_domain", BOX)?.ok_or_else(|| level.malformed("no attribute prob_domain"))?;
    index_box(corners).ok_or_else(|| level.malformed(&format!("prob_domain {corners:?} leaves the range of integers")))
}

fn bricks(number: usize, level: &Hdf5Group) -> Result<Vec<IndexBox>, FormatError> {
    let set = level.data_set("boxes")?;
    let boxes = set.compounds(BOX)?;
    if boxes.is_empty() {
        let advice = match number.checked_sub(1) {
            Some(coarser) => format!("; --max-level {coarser} leaves the level out"),
            None => String::new(),
        };
        return Err(set.malformed(&format!("no boxes, expected at least one{advice}")));
    }
    let wrong = |brick, corners| set.malformed(&format!("box {brick}: {corners:?} leaves the range of integers"));
    let checked = |(brick, corners)| index_box(corners).ok_or_else(|| wrong(brick, corners));
    boxes.into_iter().enumerate().map(checked).collect()
}

fn index_box([i, j, k, last_i, last_j, last_k]: [i64; 6]) -> Option<IndexBox> {
    IndexBox::from_corners([i, j, k], [last_i, last_j, last_k])
}
