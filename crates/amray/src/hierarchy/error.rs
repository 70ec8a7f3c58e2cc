//! What can be wrong with a hierarchy.

use thiserror::Error;

use super::IndexBox;

/// A hierarchy that contradicts itself. Bricks are numbered per level, from 0, in the order of the file.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum HierarchyError {
    /// Nothing to show.
    #[error("no level holds any brick")]
    Empty,
    /// More levels, bricks or cells than the index can number.
    #[error("{count} {what}, expected at most {limit}")]
    TooMany {
        /// Levels, bricks or cells.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
    /// An origin or a cell size that is no usable number.
    #[error("level {level}: {what} is {found:?}, expected {expected}")]
    Geometry {
        /// The level.
        level: usize,
        /// Which number.
        what: &'static str,
        /// Its value per axis.
        found: [f64; 3],
        /// What it should be.
        expected: &'static str,
    },
    /// A refinement ratio below 1, or one that refines nothing.
    #[error("level {level}: refinement ratio {found:?}, expected {expected}")]
    Ratio {
        /// The level.
        level: usize,
        /// The ratio to the next coarser level.
        found: [i64; 3],
        /// What it should be.
        expected: &'static str,
    },
    /// A cell size that is not the coarser one divided by the ratio.
    #[error("level {level}: cell size {found:?}, expected {expected:?} (the next coarser cell divided by the ratio)")]
    CellSize {
        /// The level.
        level: usize,
        /// The level's cell size.
        found: [f64; 3],
        /// What the ratio makes of the coarser one.
        expected: [f64; 3],
    },
    /// A domain without cells, or one that is not the coarser one refined.
    #[error("level {level}: domain {found}, expected {expected}")]
    Domain {
        /// The level.
        level: usize,
        /// The level's domain.
        found: IndexBox,
        /// What it should be.
        expected: String,
    },
    /// Cell indices that leave the range in which positions are exact.
    #[error(
        "level {level}: domain {domain} is too large, or too far from the origin, in cells of the finest level: \
         expected indices within 2^51"
    )]
    Overflow {
        /// The level.
        level: usize,
        /// Its domain.
        domain: IndexBox,
    },
    /// A brick without cells.
    #[error("level {level}, brick {brick}: box {found} holds no cell")]
    EmptyBrick {
        /// The level.
        level: usize,
        /// The brick.
        brick: usize,
        /// Its box.
        found: IndexBox,
    },
    /// A brick that leaves the domain.
    #[error("level {level}, brick {brick}: box {found} leaves the domain {domain}")]
    OutsideDomain {
        /// The level.
        level: usize,
        /// The brick.
        brick: usize,
        /// Its box.
        found: IndexBox,
        /// The level's domain.
        domain: IndexBox,
    },
    /// A brick that cuts through a cell of the next coarser level.
    #[error("level {level}, brick {brick}: box {found} cuts coarser cells, expected corners at multiples of {ratio:?}")]
    Misaligned {
        /// The level.
        level: usize,
        /// The brick.
        brick: usize,
        /// Its box.
        found: IndexBox,
        /// The ratio to the next coarser level.
        ratio: [i64; 3],
    },
    /// Two bricks of a level that share cells.
    #[error("level {level}: bricks {first} and {second} overlap in {shared}, expected disjoint bricks")]
    Overlap {
        /// The level.
        level: usize,
        /// One brick.
        first: usize,
        /// The other.
        second: usize,
        /// The cells they share.
        shared: IndexBox,
    },
}

/// Something unusual about a hierarchy that does not keep it from being rendered.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum HierarchyWarning {
    /// Fine bricks that stick out of the next coarser level.
    #[error(
        "level {level}: {bricks} of {of} bricks are not wholly covered by level {coarser} (the first is brick {first})",
        coarser = level - 1
    )]
    ImproperNesting {
        /// The finer level.
        level: usize,
        /// How many of its bricks stick out.
        bricks: usize,
        /// How many bricks it has.
        of: usize,
        /// The first brick that does.
        first: usize,
    },
}

impl HierarchyWarning {
    /// The level that the warning is about.
    pub(super) fn level(&self) -> usize {
        match *self {
            Self::ImproperNesting { level, .. } => level,
        }
    }
}
