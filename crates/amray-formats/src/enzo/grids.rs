//! The grids of an Enzo dump: which level each is on, and which cells it has.

use std::path::{Path, PathBuf};

use amray::hierarchy::IndexBox;
use amray_expressions::quoted;

use crate::FormatError;
use crate::key_values::{Entry, Text};
use crate::refined::Root;

/// Edges are written with this many digits, in cells of the grid's level.
const TOLERANCE: f64 = 0.01;
/// As many as a hierarchy may have.
const MOST_LEVELS: usize = 64;

/// One grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// As the files call it.
    pub(super) id: usize,
    pub(super) level: usize,
    pub(super) cells: IndexBox,
    /// The file of its values, inside the dump's directory.
    pub(super) file: PathBuf,
}

/// What the hierarchy file says of a grid.
#[derive(Default)]
struct Block {
    start: Option<[i64; 3]>,
    end: Option<[i64; 3]>,
    left: Option<[f64; 3]>,
    right: Option<[f64; 3]>,
    file: Option<PathBuf>,
    /// Its next sibling, and its first child; 0 for none.
    next_this_level: Option<usize>,
    next_next_level: Option<usize>,
}

/// What the parameter file says of the mesh.
///
/// # Errors
/// [`FormatError::Malformed`] where it does not say so, or the data have fewer than three dimensions.
pub(super) fn root(parameters: &Text) -> Result<Root, FormatError> {
    let rank = parameters.find("TopGridRank")?;
    if rank.number::<i64>()? != 3 {
        return Err(rank.malformed(&format!("{}, expected 3 dimensions", rank.value)));
    }
    let dimensions = parameters.find("TopGridDimensions")?;
    let cells = dimensions.numbers::<i64, 3>()?;
    if cells.iter().any(|&cells| !(1..=1 << 30).contains(&cells)) {
        return Err(dimensions.malformed(&format!("{cells:?}, expected counts of cells")));
    }
    let low = parameters.find("DomainLeftEdge")?.numbers::<f64, 3>()?;
    let high = parameters.find("DomainRightEdge")?.numbers::<f64, 3>()?;
    let refinement = parameters.find("RefineBy")?;
    let ratio = refinement.number()?;
    if !(2..=1 << 10).contains(&ratio) {
        return Err(refinement.malformed(&format!("{ratio}, expected 2 or more")));
    }
    let cell_size = std::array::from_fn(|axis| (high[axis] - low[axis]) / cells[axis] as f64);
    Ok(Root { low, cell_size, cells, ratio })
}

/// All grids by level, and in the order of the file on each.
pub(super) fn read(hierarchy: &Text, root: &Root) -> Result<Vec<Grid>, FormatError> {
    let blocks = blocks(hierarchy)?;
    let problem = |id: usize, problem: String| FormatError::malformed(&hierarchy.path, format!("grid {id}"), problem);
    let levels = levels(&blocks, &problem)?;
    let directory = hierarchy.path.parent().unwrap_or(Path::new(""));
    let mut grids = Vec::with_capacity(blocks.len());
    for (place, (block, level)) in blocks.iter().zip(levels).enumerate() {
        let id = place + 1;
        let level = level.ok_or_else(|| problem(id, "no Pointer leads to it".into()))?;
        let cells = block.cells(root, level).ok_or_else(|| {
            problem(id, "its edges and indices, expected whole cells of its level inside the domain".into())
        })?;
        let file = block.file.as_deref().and_then(Path::file_name);
        let file = file.ok_or_else(|| problem(id, "no BaryonFileName, expected a file of values".into()))?;
        let name = file.to_string_lossy();
        if name.contains(char::is_control) {
            let expected = "expected a name without control characters";
            return Err(problem(id, format!("BaryonFileName {}, {expected}", quoted(&name))));
        }
        grids.push(Grid { id, level, cells, file: directory.join(file) });
    }
    grids.sort_by_key(|grid| grid.level);
    Ok(grids)
}

/// The grids, the first one first.
fn blocks(hierarchy: &Text) -> Result<Vec<Block>, FormatError> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut pointers = Vec::new();
    for entry in hierarchy.entries() {
        if entry.key == "Grid" {
            let id: usize = entry.number()?;
            if id != blocks.len() + 1 {
                return Err(entry.malformed(&format!("{id}, expected {}", blocks.len() + 1)));
            }
            blocks.push(Block::default());
        } else if let Some(pointer) = entry.key.strip_prefix("Pointer: Grid[") {
            pointers.push((entry, pointer));
        } else if let Some(block) = blocks.last_mut() {
            block.set(&entry)?;
        }
    }
    if blocks.is_empty() {
        return Err(FormatError::malformed(&hierarchy.path, "the file", "no grid, expected lines Grid = 1 and so on"));
    }
    let count = blocks.len();
    for (entry, pointer) in pointers {
        // `Pointer: Grid[2]->NextGridThisLevel = 3` is cut at its `=`.
        let (id, kind) = pointer.split_once("]->").ok_or_else(|| entry.malformed("expected Grid[N]->NextGrid..."))?;
        let block = id.parse::<usize>().ok().and_then(|id| blocks.get_mut(id.checked_sub(1)?));
        let block = block.ok_or_else(|| entry.malformed(&format!("grid {id}, expected 1 to {count}")))?;
        let next: usize = entry.number()?;
        if next > count {
            return Err(entry.malformed(&format!("grid {next}, expected at most {count}")));
        }
        match kind.trim() {
            "NextGridThisLevel" => block.next_this_level = Some(next),
            "NextGridNextLevel" => block.next_next_level = Some(next),
            _ => {}
        }
    }
    Ok(blocks)
}

/// The level of each grid, by the pointers from the first one on.
fn levels(
    blocks: &[Block],
    problem: &impl Fn(usize, String) -> FormatError,
) -> Result<Vec<Option<usize>>, FormatError> {
    let mut levels = vec![None; blocks.len()];
    let mut left = vec![(1, 0)];
    while let Some((id, level)) = left.pop() {
        if level >= MOST_LEVELS {
            return Err(problem(id, format!("on level {level}, expected at most {}", MOST_LEVELS - 1)));
        }
        if levels[id - 1].replace(level).is_some() {
            return Err(problem(id, "several Pointers lead to it".into()));
        }
        let Block { next_this_level, next_next_level, .. } = blocks[id - 1];
        let (Some(sibling), Some(child)) = (next_this_level, next_next_level) else {
            return Err(problem(id, "a Pointer is missing, expected two: the file may have been cut short".into()));
        };
        left.extend([(sibling, level), (child, level + 1)].into_iter().filter(|(id, _)| *id > 0));
    }
    Ok(levels)
}

impl Block {
    fn set(&mut self, entry: &Entry) -> Result<(), FormatError> {
        match entry.key {
            "GridStartIndex" => self.start = Some(entry.numbers()?),
            "GridEndIndex" => self.end = Some(entry.numbers()?),
            "GridLeftEdge" => self.left = Some(entry.numbers()?),
            "GridRightEdge" => self.right = Some(entry.numbers()?),
            "BaryonFileName" => self.file = Some(entry.value.into()),
            _ => {}
        }
        Ok(())
    }

    /// The active cells, in indices of the level; `None` where edges and indices contradict each other.
    fn cells(&self, root: &Root, level: usize) -> Option<IndexBox> {
        let (start, end, left, right) = (self.start?, self.end?, self.left?, self.right?);
        let cell_size = root.cell_size(level);
        let index = |position: f64, axis: usize| {
            let cells = (position - root.low[axis]) / cell_size[axis];
            let near = cells.is_finite() && cells.abs() < 1e15 && (cells - cells.round()).abs() <= TOLERANCE;
            near.then_some(cells.round() as i64)
        };
        let mut cells = IndexBox::new([0; 3], [0; 3]);
        for axis in 0..3 {
            cells.low[axis] = index(left[axis], axis)?;
            cells.high[axis] = index(right[axis], axis)?;
            let active = end[axis].checked_sub(start[axis])?.checked_add(1)?;
            if active < 1 || cells.size()[axis] != active {
                return None;
            }
        }
        Some(cells)
    }
}
