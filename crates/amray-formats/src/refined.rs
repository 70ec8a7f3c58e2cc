//! Hierarchies with one ratio throughout, as octree codes and Enzo have them.

use amray::hierarchy::{Hierarchy, HierarchyError, IndexBox, LevelDescription};

/// Level 0 of a hierarchy and how each level is refined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    /// The domain's low corner, where cell 0 of every level begins.
    pub(crate) low: [f64; 3],
    /// Of level 0.
    pub(crate) cell_size: [f64; 3],
    /// Of level 0, from 0 on.
    pub(crate) cells: [i64; 3],
    /// Cells of a level per cell of the one below, along each axis.
    pub(crate) ratio: i64,
}

impl Root {
    /// The width of a level's cells.
    pub(crate) fn cell_size(&self, level: usize) -> [f64; 3] {
        self.cell_size.map(|width| width / (self.ratio as f64).powi(level as i32))
    }

    /// The hierarchy of so many levels of bricks, each told with its level.
    pub(crate) fn hierarchy(
        &self,
        levels: usize,
        bricks: impl IntoIterator<Item = (usize, IndexBox)>,
    ) -> Result<Hierarchy, HierarchyError> {
        let mut of_levels = vec![Vec::new(); levels];
        for (level, cells) in bricks {
            of_levels[level].push(cells);
        }
        let root = IndexBox::new([0; 3], self.cells);
        let describe = |(level, bricks): (usize, Vec<IndexBox>)| {
            let refined = self.ratio.checked_pow(level as u32).and_then(|cells| root.checked_refined([cells; 3]));
            Ok(LevelDescription {
                ratio: [if level == 0 { 1 } else { self.ratio }; 3],
                cell_size: self.cell_size(level),
                domain: refined.ok_or(HierarchyError::Overflow { level: level.saturating_sub(1), domain: root })?,
                bricks,
            })
        };
        Hierarchy::new(self.low, of_levels.into_iter().enumerate().map(describe).collect::<Result<_, _>>()?)
    }
}
