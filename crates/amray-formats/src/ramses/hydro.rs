//! The files of values: for each list of grids a record per cell of a grid and variable, with a value of every grid.
//!
//! The layout is that of RAMSES' own `backup_hydro`. Values stay in the file until a field is asked for.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use memmap2::Mmap;

use super::amr::{Header, Mesh};
use super::fortran::{MARK, Records, mark, real_of};
use crate::FormatError;
use crate::mapped_file::map;
use crate::number::{ByteOrder, NumberType};

/// Cells of a grid: x fastest.
pub(super) const CELLS: usize = 8;

/// The values of a process.
pub(super) struct HydroFile {
    path: PathBuf,
    map: Arc<Mmap>,
    order: ByteOrder,
    pub(super) variables: usize,
    /// What the values are; `None` where there are none.
    pub(super) number: Option<NumberType>,
    /// Of the process's own grids on each level.
    blocks: Vec<Block>,
}

/// The values of the grids of a list.
#[derive(Clone, Copy, Default)]
struct Block {
    /// Where its records begin.
    start: usize,
    /// Of grids.
    count: usize,
}

impl HydroFile {
    /// Finds the values of the grids that the process `cpu` (from 0 on) has.
    pub(super) fn open(path: &Path, cpu: usize, mesh: &Mesh) -> Result<Self, FormatError> {
        let map = map(path)?;
        let mut records = Records::new(path, &map)?;
        let variables = variables(&mut records, &mesh.header)?;
        let mut number = None;
        let mut blocks = Vec::with_capacity(mesh.header.levels);
        for (level, grids) in mesh.levels.iter().enumerate() {
            let mut own = Block::default();
            for list in 0..mesh.header.cpus + mesh.header.boundaries {
                let block = block(&mut records, level, variables, &mut number)?;
                if list == cpu {
                    own = block;
                }
            }
            if own.count != grids.len() {
                let problem = format!("{} grids, expected {} by the mesh", own.count, grids.len());
                return Err(FormatError::malformed(path, format!("level {}", level + 1), problem));
            }
            blocks.push(own);
        }
        let order = records.order();
        Ok(Self { path: path.into(), map, order, variables, number, blocks })
    }

    /// Whether the records of a variable are where they should be; else [`HydroFile::value`] makes no sense.
    pub(super) fn check(&self, variable: usize) -> Result<(), FormatError> {
        let length = |block: &Block| block.count * self.width();
        for (level, block) in self.blocks.iter().enumerate().filter(|(_, block)| block.count > 0) {
            for cell in 0..CELLS {
                let start = self.record(block, variable, cell);
                let marks = [start - MARK, start + length(block)].map(|at| mark(&self.map, at, self.order));
                if marks != [Some(length(block)); 2] {
                    let expected = format!("expected a record of {} bytes between its marks", length(block));
                    let problem = format!("the marks {marks:?}, {expected}");
                    let place = format!("level {}, variable {}, cell {cell} at byte {start}", level + 1, variable + 1);
                    return Err(FormatError::malformed(&self.path, place, problem));
                }
            }
        }
        Ok(())
    }

    /// The value of a variable in a cell of the process's own grid number `grid` on a level.
    ///
    /// # Panics
    /// Where there is no such grid.
    #[inline]
    pub(super) fn value(&self, level: usize, grid: usize, variable: usize, cell: usize) -> f64 {
        let at = self.record(&self.blocks[level], variable, cell) + grid * self.width();
        let (bytes, little) = (&self.map[at..], self.order == ByteOrder::Little);
        match self.number {
            Some(NumberType::F32) => {
                let bytes = bytes.first_chunk().copied().unwrap_or_default();
                f64::from(if little { f32::from_le_bytes(bytes) } else { f32::from_be_bytes(bytes) })
            }
            _ => {
                let bytes = bytes.first_chunk().copied().unwrap_or_default();
                if little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) }
            }
        }
    }

    /// Where the content of a record begins.
    #[inline]
    fn record(&self, block: &Block, variable: usize, cell: usize) -> usize {
        let length = block.count * self.width() + 2 * MARK;
        block.start + (cell * self.variables + variable) * length + MARK
    }

    fn width(&self) -> usize {
        self.number.map_or(0, NumberType::bytes)
    }
}

/// Reads the beginning of a file of values: the number of variables.
fn variables(records: &mut Records, header: &Header) -> Result<usize, FormatError> {
    let mut counts = [0; 5];
    let names = ["ncpu", "nvar", "ndim", "nlevelmax", "nboundary"];
    for (count, name) in counts.iter_mut().zip(names) {
        *count = records.integer(name)?;
    }
    records.record("gamma")?;
    let [cpus, variables, dimensions, levels, boundaries] = counts;
    let found = [cpus, dimensions, levels, boundaries].map(i64::from);
    let expected = [header.cpus as i64, 3, header.levels as i64, header.boundaries as i64];
    if found != expected {
        let problem = format!("ncpu, ndim, nlevelmax and nboundary {found:?}, expected {expected:?} by the mesh");
        return Err(records.malformed("counts before", &problem));
    }
    match usize::try_from(variables) {
        Ok(variables @ 1..) => Ok(variables),
        _ => Err(records.malformed("nvar before", &format!("{variables}, expected 1 or more"))),
    }
}

/// The next list's values. `number` is what values are, once that is known.
fn block(
    records: &mut Records,
    level: usize,
    variables: usize,
    number: &mut Option<NumberType>,
) -> Result<Block, FormatError> {
    let found = records.integer("level")?;
    if usize::try_from(found) != Ok(level + 1) {
        return Err(records.malformed("level before", &format!("{found}, expected {}", level + 1)));
    }
    let count = records.integer("number of grids")?;
    let Ok(count) = usize::try_from(count) else {
        return Err(records.malformed("number of grids before", &format!("{count}, expected 0 or more")));
    };
    if count == 0 {
        return Ok(Block::default());
    }
    let length = records.next_length("values")?;
    let Some(values) = real_of(length, count).filter(|found| number.is_none_or(|number| number == *found)) else {
        let expected = format!("expected {count} reals of one precision throughout");
        return Err(records.malformed("values", &format!("a record of {length} bytes, {expected}")));
    };
    *number = Some(values);
    let start = records.alike(variables.saturating_mul(CELLS), length, "values")?;
    Ok(Block { start, count })
}
