//! From boxes and spacings to a hierarchy: VTK states neither a domain nor ratios.

use std::path::Path;

use amray::hierarchy::{Hierarchy, HierarchyError, IndexBox, LevelDescription};

use crate::FormatError;

/// A level as VTK states it.
#[derive(Clone, Debug)]
pub(super) struct StatedLevel {
    pub(super) spacing: [f64; 3],
    pub(super) bricks: Vec<IndexBox>,
}

/// The hierarchy of levels, the coarsest first. Its domain is the smallest box of coarsest cells around all bricks.
///
/// # Errors
/// [`FormatError::Malformed`] where a level's spacing is no whole part of the coarser one's, [`FormatError::Hierarchy`]
/// where bricks do not fit.
pub(super) fn hierarchy(path: &Path, origin: [f64; 3], levels: Vec<StatedLevel>) -> Result<Hierarchy, FormatError> {
    let mut ratios = vec![[1; 3]];
    for (number, pair) in levels.windows(2).enumerate() {
        let ratio = [0, 1, 2].map(|axis| (pair[0].spacing[axis] / pair[1].spacing[axis]).round());
        if !ratio.iter().all(|ratio| (1.0..=1e6).contains(ratio)) {
            let (coarse, fine) = (pair[0].spacing, pair[1].spacing);
            let problem = format!("the spacing is {fine:?}, expected whole parts of the coarser level's {coarse:?}");
            return Err(FormatError::malformed(path, format!("level {}", number + 1), problem));
        }
        ratios.push(ratio.map(|ratio| ratio as i64));
    }
    let wrong = FormatError::hierarchy(path);
    let mut domain = domain(&levels, &ratios);
    let mut described = Vec::with_capacity(levels.len());
    for (number, (level, ratio)) in levels.into_iter().zip(ratios).enumerate() {
        let coarser = domain;
        domain = domain
            .checked_refined(ratio)
            .ok_or_else(|| wrong(HierarchyError::Overflow { level: number.saturating_sub(1), domain: coarser }))?;
        described.push(LevelDescription { ratio, cell_size: level.spacing, domain, bricks: level.bricks });
    }
    Hierarchy::new(origin, described).map_err(wrong)
}

/// The cells of level 0 that all bricks lie in.
fn domain(levels: &[StatedLevel], ratios: &[[i64; 3]]) -> IndexBox {
    let mut around: Option<IndexBox> = None;
    for (level, ratio) in levels.iter().zip(ratios).rev() {
        let bricks = around.into_iter().chain(level.bricks.iter().copied()).reduce(|all, brick| IndexBox {
            low: [0, 1, 2].map(|axis| all.low[axis].min(brick.low[axis])),
            high: [0, 1, 2].map(|axis| all.high[axis].max(brick.high[axis])),
        });
        around = bricks.map(|bricks| bricks.coarsened(*ratio));
    }
    around.unwrap_or(IndexBox::new([0; 3], [1; 3]))
}

/// The box of VTK's six numbers: the first and the last cell along x, y and z.
pub(super) fn index_box([x, right, y, back, z, top]: [i64; 6]) -> Option<IndexBox> {
    IndexBox::from_corners([x, y, z], [right, back, top])
}

/// VTK's six numbers of a box.
pub(super) fn extent(cells: &IndexBox) -> [i64; 6] {
    let (low, last) = (cells.low, cells.high.map(|index| index - 1));
    [low[0], last[0], low[1], last[1], low[2], last[2]]
}
