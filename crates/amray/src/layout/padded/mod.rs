//! An owned copy of every brick with one more cell on each side, so that one brick
//! alone supplies all eight corners of any dual cell that has a corner in it.
//!
//! The copy is `f32` in units of the field's range, which keeps large offsets and magnitudes beyond `f32` exact enough.
//! The lowest bit of each value is a flag: whether the cell takes part as a cell of the brick's level ([`Padding`]).

mod evaluate;
mod fill;
mod numbers;
mod plan;
mod point;

use super::pieces::{self, PaddedPieces, PieceNode};
use crate::Volume;
use crate::hierarchy::{Centering, Hierarchy, Normalisation, with_voxels};
use crate::reconstruction::{Method, Sampler};

pub(crate) use evaluate::PaddedValues;
use numbers::Numbers;
pub(super) use plan::{PaddedBrick, Plan};
pub(crate) use point::PaddedPoints;

/// What padding holds, and which cells are flagged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Padding {
    /// Virtual cells hold their closest existing cell; actual cells are flagged.
    Closest,
    /// Virtual cells hold their closest existing cell; leaf cells inside the domain are flagged.
    Leaves,
    /// Virtual cells hold the coarser levels' continuous function at their centre; actual cells are flagged.
    Prolonged,
    /// Values belong to nodes; those of other bricks hold the field's function there; all are flagged.
    Nodes,
}

impl Padding {
    /// The padding from which a method is evaluated.
    pub(crate) fn of(method: Method) -> Self {
        match method {
            Method::Basis => Self::Leaves,
            Method::Prolong => Self::Prolonged,
            Method::Nodal => Self::Nodes,
            _ => Self::Closest,
        }
    }
}

/// A cell that does not exist at all: inside a hole. The flag of a number is never part of this one.
pub(crate) const HOLE: u32 = 0x7fc0_0000;

/// Whether a value stands for a cell that does not exist.
pub(super) fn is_hole(value: f32) -> bool {
    value.to_bits() == HOLE
}

/// A cell whose value is not finite.
pub(super) const NOT_FINITE: u32 = 0x7fc0_0002;
/// The flag.
pub(super) const FLAG: u32 = 1;

/// All bricks of a field, padded.
#[derive(Clone, Debug)]
pub(crate) struct PaddedField {
    pub(crate) normalisation: Normalisation,
    /// The bricks' values, x fastest, one brick after the other.
    values: Numbers,
    /// Where each brick's values start.
    starts: Vec<usize>,
    /// Whether all values are finite.
    pub(crate) is_finite: bool,
}

impl PaddedField {
    /// A padded copy of the volume's field, filled in parallel.
    pub(crate) fn build(volume: &Volume) -> Self {
        Self::with(volume, volume.normalisation())
    }

    /// [`build`](Self::build) with another normalisation than the volume's.
    pub(crate) fn with(volume: &Volume, normalisation: Normalisation) -> Self {
        let starts = starts(volume.hierarchy(), volume.field().centering());
        // Pairs of values are read at once: one more than there are.
        let count = starts[starts.len() - 1] + 1;
        let (values, is_finite) = Numbers::filled(count, |values| {
            with_voxels!(volume.field().values(), bricks => {
                let sampler = Sampler::new(volume.index(), bricks, volume.method());
                fill::fill(&sampler, normalisation, Padding::of(volume.method()), &starts, values)
            })
        });
        Self { normalisation, values, starts, is_finite }
    }

    /// The values of a brick.
    pub(super) fn brick(&self, brick: &PaddedBrick) -> &[f32] {
        let size: usize = brick.values.iter().map(|&values| values as usize + 2).product();
        &self.values[brick.start..brick.start + size]
    }

    pub(crate) fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// The number of values.
    pub(crate) fn len(&self) -> usize {
        self.values.len()
    }

    #[inline(always)]
    pub(crate) fn values(&self) -> *const f32 {
        self.values.as_ptr()
    }

    /// Bytes of memory that the copy takes.
    fn bytes(&self) -> u64 {
        (size_of_val(&*self.values) + size_of_val(&*self.starts)) as u64
    }
}

/// A volume's padded copy, and how to march through it.
#[derive(Clone, Debug)]
pub(crate) struct Padded {
    pub(crate) field: PaddedField,
    pub(crate) plan: Plan,
    pub(crate) pieces: Vec<PieceNode>,
}

impl Padded {
    pub(crate) fn build(volume: &Volume) -> Self {
        let field = PaddedField::build(volume);
        let plan = Plan::new(volume.index(), volume.method(), field.starts());
        let pieces =
            pieces::tree(volume.index(), &PaddedPieces { ranges: volume.ranges(), plan: &plan, field: &field });
        Self { field, plan, pieces }
    }

    /// Bytes of memory that all of it takes.
    pub(crate) fn bytes(&self) -> u64 {
        self.field.bytes() + self.plan.bytes() + size_of_val(&*self.pieces) as u64
    }
}

/// Bytes of memory that the padded copy of a field over `hierarchy` takes.
pub fn padded_bytes(hierarchy: &Hierarchy, centering: Centering) -> u64 {
    starts(hierarchy, centering).last().map_or(0, |&values| (values * size_of::<f32>()) as u64)
}

/// Where each padded brick starts, and where the last one ends.
fn starts(hierarchy: &Hierarchy, centering: Centering) -> Vec<usize> {
    let mut starts = vec![0];
    let mut end = 0;
    for brick in hierarchy.bricks() {
        end += centering.values_of(&brick.cells).size().iter().map(|&values| values as usize + 2).product::<usize>();
        starts.push(end);
    }
    starts
}
