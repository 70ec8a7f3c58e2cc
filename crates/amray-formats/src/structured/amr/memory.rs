//! How many slices of a volume memory holds while it is converted.

use super::shape::LevelShape;

/// Buffers of readers and of the output.
const BUFFERS: u128 = 4 << 20;

/// The most slices that are read at a time within `memory` bytes, for values of `voxel` bytes: an even number, and no
/// more than `brick`, for more would not make anything faster.
///
/// # Errors
/// How many bytes would be enough.
pub(super) fn slab(levels: &[LevelShape], brick: usize, voxel: usize, memory: u64) -> Result<usize, u64> {
    let needed = |slab: usize| needed(levels, brick, voxel, slab).try_into().unwrap_or(u64::MAX);
    (1..=brick / 2).rev().map(|pairs| 2 * pairs).find(|&slab| needed(slab) <= memory).ok_or_else(|| needed(2))
}

fn needed(levels: &[LevelShape], brick: usize, voxel: usize, slab: usize) -> u128 {
    /// A slice that waits and one that is made, each with means, lows and highs, and the bytes of one.
    const LAYERS: u128 = 7;
    let slice = |level: &LevelShape| level.slice() as u128 * voxel as u128;
    let (finest, coarser) = levels.split_last().expect("there is at least one level");
    let first_pass: u128 = coarser.iter().map(|level| LAYERS * slice(level)).sum();
    let second_pass: u128 = coarser.iter().map(|level| (slab / level.samples[2] + 3) as u128 * slice(level)).sum();
    // Their values, as they are, as the output's number type and as bytes.
    let bricks = 3 * (rayon::current_num_threads() * voxel) as u128 * (brick as u128).pow(3);
    let kept: u128 = levels.iter().map(|level| level.grid.iter().map(|&bricks| bricks as u128).product::<u128>()).sum();
    BUFFERS + bricks + kept + slab as u128 * slice(finest) + first_pass.max(second_pass)
}
