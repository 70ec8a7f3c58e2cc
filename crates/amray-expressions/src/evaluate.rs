//! Running programs: a block of cells at a time, operation after operation.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use amray::hierarchy::{Brick, BrickValues, Centering, Field, FieldValues, Hierarchy, Voxel, VoxelType};
use amray::index::Index;
use rayon::prelude::*;

use crate::differences::Sloped;
use crate::error::ExpressionError;
use crate::numeric::choose;
use crate::program::{Action, Program, Source, Stage};
use crate::source::read_row;

/// Cells per block, in whole rows: so few that all slots stay in the cache.
const BLOCK: usize = 1024;

impl Program {
    /// Evaluates the expression in every cell, in parallel. `fields` are those that [`Program::inputs`] lists, in its
    /// order. All is computed in double precision; the result is kept in single precision where all of the fields are, and
    /// there is one. An expression that is only a field's name gives that field's values in place. `progress` is told the
    /// share that is done, 0 to 1, from several threads.
    ///
    /// # Errors
    /// [`ExpressionError`] where some fields are cell-centred and others node-centred, or a slope of a node-centred one is
    /// asked for.
    ///
    /// # Panics
    /// Where a field is missing, or belongs to another hierarchy with a different number of bricks.
    pub fn evaluate(
        &self,
        name: &str,
        hierarchy: &Arc<Hierarchy>,
        fields: &[Field],
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Field, ExpressionError> {
        assert_eq!(fields.len(), self.inputs().len(), "fields and inputs of the program");
        let bricks = hierarchy.brick_count();
        assert!(fields.iter().all(|field| field.brick_count() == bricks), "bricks of the fields and of the hierarchy");
        let (last, derivatives) = self.stages().split_last().expect("a program has a stage");
        let slopes = self.stages().iter().any(|stage| !stage.sloped.is_empty());
        let centering = centering_of(fields)?;
        if slopes && centering == Centering::Nodes {
            return Err(ExpressionError::invalid(1, "node-centred fields, expected cell-centred ones for derivatives"));
        }
        let index = slopes.then(|| Index::build(hierarchy.clone()));
        let single = !fields.is_empty() && fields.iter().all(|field| field.voxel_type() == VoxelType::F32);

        let mut run =
            Run { hierarchy, centering, index, fields, results: Vec::new(), stages: self.stages().len(), progress };
        for stage in derivatives {
            let values = run.stage::<f64>(stage);
            run.results.push(run.field("", values));
        }
        if let Some(input) = last.as_input() {
            return Ok(run.field(name, fields[input].values().clone()));
        }
        let values = if single { run.stage::<f32>(last) } else { run.stage::<f64>(last) };
        Ok(run.field(name, values))
    }
}

/// What all fields' values belong to.
fn centering_of(fields: &[Field]) -> Result<Centering, ExpressionError> {
    let first = fields.first().map_or(Centering::Cells, Field::centering);
    match fields.iter().all(|field| field.centering() == first) {
        true => Ok(first),
        false => Err(ExpressionError::invalid(1, "cell-centred and node-centred fields, expected one or the other")),
    }
}

/// What all stages of one evaluation share.
struct Run<'a> {
    hierarchy: &'a Hierarchy,
    centering: Centering,
    /// Where slopes are taken.
    index: Option<Index>,
    fields: &'a [Field],
    /// Of the stages that are done.
    results: Vec<Field>,
    stages: usize,
    progress: &'a (dyn Fn(f64) + Sync),
}

/// Rows of a brick, and their results.
struct Block<'a, T> {
    /// Its cells are nodes where values belong to nodes.
    brick: Brick,
    /// The brick's place in [`Hierarchy::bricks`].
    place: usize,
    /// Rows along x are counted along y first.
    rows: Range<usize>,
    results: &'a mut [T],
}

/// The memory that one thread computes in.
struct Slots {
    slots: Vec<Vec<f64>>,
    /// For slopes.
    row: Vec<f64>,
}

impl Run<'_> {
    fn stage<T: Voxel>(&self, stage: &Stage) -> FieldValues
    where
        FieldValues: From<Vec<BrickValues<T>>>,
    {
        let sloped: Vec<Sloped> = match &self.index {
            Some(index) => {
                let sloped = stage.sloped.iter();
                sloped.map(|&(source, axis)| Sloped::new(self.source(source), axis, index)).collect()
            }
            None => Vec::new(),
        };
        let places = |brick: Brick| Brick { cells: self.centering.values_of(&brick.cells), ..brick };
        let bricks: Vec<Brick> = self.hierarchy.bricks().map(places).collect();
        let zero = T::from_f64(0.0);
        let mut results: Vec<Vec<T>> = bricks.iter().map(|brick| vec![zero; brick.cells.cells() as usize]).collect();
        let blocks: Vec<Block<T>> = bricks
            .iter()
            .zip(&mut results)
            .enumerate()
            .flat_map(|(place, (brick, results))| blocks(*brick, place, results))
            .collect();

        let longest = blocks.iter().map(|block| block.results.len()).max().unwrap_or(0);
        let (count, done) = (blocks.len(), AtomicUsize::new(0));
        blocks.into_par_iter().for_each_init(
            || Slots::new(stage, longest),
            |slots, block| {
                self.block(stage, &sloped, slots, block);
                let share = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count as f64;
                (self.progress)((self.results.len() as f64 + share) / self.stages as f64);
            },
        );
        let values = bricks.iter().zip(results).map(|(brick, results)| {
            let size = brick.cells.size().map(|cells| cells as usize);
            BrickValues::owned(results, size).expect("a result for each cell")
        });
        values.collect::<Vec<BrickValues<T>>>().into()
    }

    fn field(&self, name: &str, values: FieldValues) -> Field {
        Field::centered(name, self.centering, values, self.hierarchy).expect("the values are those of the bricks")
    }

    fn source(&self, source: Source) -> &Field {
        match source {
            Source::Input(place) => &self.fields[place],
            Source::Stage(place) => &self.results[place],
        }
    }

    fn block<T: Voxel>(&self, stage: &Stage, sloped: &[Sloped], memory: &mut Slots, block: Block<T>) {
        let count = block.results.len();
        for step in &stage.steps {
            // Taken out, so that it can be written while others are read: it is none of those.
            let mut into = std::mem::take(&mut memory.slots[step.into]);
            let results = &mut into[..count];
            let slot = |slot: usize| &memory.slots[slot][..count];
            match step.action {
                Action::Unary(function, operand) => function.apply(results, slot(operand)),
                Action::Binary(function, left, right) => function.apply(results, slot(left), slot(right)),
                Action::If([condition, then, otherwise]) => {
                    for (cell, result) in results.iter_mut().enumerate() {
                        *result = choose(slot(condition)[cell], slot(then)[cell], slot(otherwise)[cell]);
                    }
                }
                Action::Load(source) => {
                    let field = self.source(source);
                    block.each_row(results, |jk, row| read_row(field, block.place, jk, row));
                }
                Action::Slope(of) => block.each_row(results, |jk, row| {
                    let below = &mut memory.row[..row.len()];
                    sloped[of].slopes(block.place, jk, below, row);
                }),
                Action::Coordinate(axis) => {
                    let (origin, low) = (self.hierarchy.origin()[axis], block.brick.cells.low);
                    let cell_size = self.cell_size(&block)[axis];
                    let center = |index: i64| origin + (index as f64 + self.centering.place()) * cell_size;
                    block.each_row(results, |[j, k], row| match axis {
                        0 => row.iter_mut().zip(low[0]..).for_each(|(x, index)| *x = center(index)),
                        1 => row.fill(center(low[1] + j as i64)),
                        _ => row.fill(center(low[2] + k as i64)),
                    });
                }
                Action::Level => results.fill(block.brick.level as f64),
                Action::CellSize => results.fill(self.cell_size(&block)[0]),
                Action::CellVolume => results.fill(self.cell_size(&block).iter().product()),
            }
            memory.slots[step.into] = into;
        }
        for (result, value) in block.results.iter_mut().zip(&memory.slots[stage.result]) {
            *result = T::from_f64(*value);
        }
    }

    fn cell_size<T>(&self, block: &Block<T>) -> [f64; 3] {
        self.hierarchy.levels()[block.brick.level].cell_size()
    }
}

impl<T> Block<'_, T> {
    /// Calls `visit` with each row's place along y and z, and its part of `cells`.
    fn each_row(&self, cells: &mut [f64], mut visit: impl FnMut([usize; 2], &mut [f64])) {
        let [length, width, _] = self.brick.cells.size().map(|cells| cells as usize);
        for (row, cells) in self.rows.clone().zip(cells.chunks_exact_mut(length)) {
            visit([row % width, row / width], cells);
        }
    }
}

/// A brick's rows, shared out.
fn blocks<T>(brick: Brick, place: usize, results: &mut [T]) -> impl Iterator<Item = Block<'_, T>> {
    let length = brick.cells.size()[0] as usize;
    let rows = (BLOCK / length).max(1);
    results.chunks_mut(rows * length).enumerate().map(move |(number, results)| {
        let first = number * rows;
        Block { brick, place, rows: first..first + results.len() / length, results }
    })
}

impl Slots {
    fn new(stage: &Stage, cells: usize) -> Self {
        let mut slots = vec![vec![0.0; cells]; stage.slots];
        for (slot, value) in &stage.constants {
            slots[*slot].fill(*value);
        }
        Self { slots, row: vec![0.0; cells] }
    }
}
