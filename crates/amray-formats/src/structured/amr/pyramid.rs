//! The first pass over a volume: all coarser levels at once, and which bricks must be kept.

use std::io;

use amray::hierarchy::Voxel;

use super::layer::{Between, Layer, LayerView};
use super::level_file::LevelFile;
use super::shape::LevelShape;
use super::{Plan, Refinement};
use crate::FormatError;
use crate::structured::StructuredVolume;

/// What the first pass finds.
pub(super) struct Pyramid {
    /// The values of all levels but the finest, coarsest first.
    pub(super) files: Vec<LevelFile>,
    /// Per level, which bricks are kept, in the order of [`LevelShape::places`].
    pub(super) kept: Vec<Vec<bool>>,
    /// How many levels hold bricks: level 0 alone or all.
    pub(super) used: usize,
}

/// What goes on between two levels: slices of the finer one come, one of the coarser goes whenever there are two.
struct Stage<T> {
    /// A slice that waits for its neighbour.
    waiting: Option<Layer<T>>,
    /// Coarse slices so far.
    done: usize,
    file: LevelFile,
    /// Which fine bricks deviate from the coarse level.
    kept: Vec<bool>,
}

impl Pyramid {
    /// Reads the volume once. `progress` is told the share that is done, 0 to 1.
    pub(super) fn build<T: Voxel>(
        volume: &StructuredVolume,
        plan: &Plan<'_>,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, FormatError> {
        let failed = FormatError::io(plan.directory, "keep a temporary file in");
        let stages = plan.levels.windows(2).map(|pair| {
            let file = LevelFile::new(plan.directory, volume.voxel_type(), pair[0].slice())?;
            let kept = vec![false; pair[1].grid.iter().product()];
            Ok(Stage { waiting: None, done: 0, file, kept })
        });
        let mut stages: Vec<Stage<T>> = stages.collect::<io::Result<_>>().map_err(&failed)?;

        let (finest, depth) = (plan.finest(), volume.size()[2]);
        let mut reader = volume.slices(plan.reader_memory)?;
        let mut slab: Vec<T> = Vec::new();
        for first in (0..depth).step_by(plan.slab) {
            let count = plan.slab.min(depth - first);
            reader.read(count, &mut slab)?;
            let slices: Vec<_> = slab.chunks_exact(finest.slice()).map(LayerView::of_samples).collect();
            for group in slices.chunks(finest.ratio[2]) {
                coarsen(plan, &mut stages, group).map_err(&failed)?;
            }
            progress((first + count) as f64 / depth as f64);
        }
        for stage in (0..stages.len()).rev() {
            // What waits for a neighbour that does not come.
            if let Some(last) = stages[stage].waiting.take() {
                coarsen(plan, &mut stages[..=stage], &[last.view()]).map_err(&failed)?;
            }
        }
        let (files, deviating): (Vec<_>, Vec<_>) = stages.into_iter().map(|stage| (stage.file, stage.kept)).unzip();
        let kept = kept(&plan.levels, deviating);
        let mut pyramid = Self { files, kept, used: plan.levels.len() };
        pyramid.anchor::<T>(&plan.levels).map_err(failed)?;
        Ok(pyramid)
    }

    /// Keeps the first brick of the finest level where none is kept: what is interpolated on the finest level there is
    /// must be so on the samples' own grid. Only where level 0 stands for all samples and is one value, it is all that is
    /// used.
    fn anchor<T: Voxel>(&mut self, levels: &[LevelShape]) -> io::Result<()> {
        let [_, finer @ ..] = &self.kept[..] else { return Ok(()) };
        let any = |level: &Vec<bool>| level.contains(&true);
        if finer.last().is_none_or(any) {
            return Ok(());
        }
        if !finer.iter().any(any) && is_one_value::<T>(&mut self.files[0], &levels[0])? {
            self.used = 1;
        } else {
            self.kept.iter_mut().for_each(|level| level[0] = true);
        }
        Ok(())
    }
}

/// Makes one coarse slice of one or two fine ones, and what follows from it on all coarser levels. The last of `stages` is
/// the one that the slices are for.
fn coarsen<T: Voxel>(plan: &Plan<'_>, stages: &mut [Stage<T>], slices: &[LayerView<'_, T>]) -> io::Result<()> {
    let Some((stage, coarser)) = stages.split_last_mut() else { return Ok(()) };
    let (fine, coarse) = (&plan.levels[coarser.len() + 1], &plan.levels[coarser.len()]);
    let Refinement { brick, threshold, .. } = *plan.refinement;
    let bricks = fine.grid[0] * fine.grid[1];
    let kept = &mut stage.kept[stage.done * fine.ratio[2] / brick * bricks..][..bricks];
    let layer = Layer::coarsened(Between { fine, coarse, brick, threshold }, slices, kept);
    stage.file.push(&layer.means)?;
    stage.done += 1;
    let Some(next) = coarser.last_mut() else { return Ok(()) };
    match next.waiting.take() {
        Some(first) => coarsen(plan, coarser, &[first.view(), layer.view()]),
        None if coarse.ratio[2] == 1 => coarsen(plan, coarser, &[layer.view()]),
        None => {
            next.waiting = Some(layer);
            Ok(())
        }
    }
}

/// Whether all cells of a level have the same value, or none is a number.
fn is_one_value<T: Voxel>(file: &mut LevelFile, level: &LevelShape) -> io::Result<bool> {
    let mut first = None;
    let mut values: Vec<T> = Vec::new();
    for slice in 0..level.cells[2] {
        file.read(slice..slice + 1, &mut values)?;
        for value in values.iter().map(|value| value.to_f64()) {
            let first = *first.get_or_insert(value);
            if value != first && !(value.is_nan() && first.is_nan()) {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// The bricks that are kept on each level: all of level 0, those that deviate from the coarser level, the rim of a volume
/// that is padded, and the parents of all these.
fn kept(levels: &[LevelShape], deviating: Vec<Vec<bool>>) -> Vec<Vec<bool>> {
    let everything = vec![true; levels[0].grid.iter().product()];
    let mut kept: Vec<Vec<bool>> = std::iter::once(everything).chain(deviating).collect();
    for (number, level) in levels.iter().enumerate().skip(1).rev() {
        for place in level.places() {
            let keep = &mut kept[number][level.number(place)];
            *keep |= level.is_rim(place);
            if *keep {
                kept[number - 1][levels[number - 1].number(level.parent(place))] = true;
            }
        }
    }
    kept
}
