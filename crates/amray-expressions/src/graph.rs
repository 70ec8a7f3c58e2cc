//! What is to be computed for each cell: a graph of operations on numbers, in which nothing is computed twice.

use std::collections::HashMap;

use crate::numeric::{Binary, Unary, choose};

/// The place of an operation in its [`Graph`].
pub(crate) type Id = usize;

/// One number for each cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    /// The bits of a double.
    Constant(u64),
    /// The cell's centre along an axis, in world units.
    Coordinate(usize),
    Level,
    /// The cell's width along x.
    CellSize,
    CellVolume,
    /// A field's value, by the field's number.
    Field(usize),
    /// The slope of another operation's values along an axis.
    Slope(Id, usize),
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    /// Condition, then, otherwise.
    If([Id; 3]),
}

impl Operation {
    /// The operations that this one needs in the same cell.
    pub(crate) fn operands(self) -> impl Iterator<Item = Id> {
        let (operands, count) = match self {
            Self::Unary(_, operand) => ([operand; 3], 1),
            Self::Binary(_, left, right) => ([left, right, right], 2),
            Self::If(operands) => (operands, 3),
            _ => ([0; 3], 0),
        };
        operands.into_iter().take(count)
    }
}

/// Operations; each follows those that it needs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    operations: Vec<Operation>,
    known: HashMap<Operation, Id>,
}

impl Graph {
    /// How many operations there are.
    pub(crate) fn len(&self) -> usize {
        self.operations.len()
    }

    pub(crate) fn operation(&self, id: Id) -> Operation {
        self.operations[id]
    }

    pub(crate) fn constant(&mut self, value: f64) -> Id {
        self.add(Operation::Constant(value.to_bits()))
    }

    /// The number that an operation is in every cell, if it is one.
    pub(crate) fn as_constant(&self, id: Id) -> Option<f64> {
        match self.operations[id] {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    pub(crate) fn unary(&mut self, function: Unary, operand: Id) -> Id {
        match self.as_constant(operand) {
            Some(value) => self.constant(function.of(value)),
            None => self.add(Operation::Unary(function, operand)),
        }
    }

    pub(crate) fn binary(&mut self, function: Binary, left: Id, right: Id) -> Id {
        match (self.as_constant(left), self.as_constant(right)) {
            (Some(left), Some(right)) => self.constant(function.of(left, right)),
            (None, Some(exponent)) if function == Binary::Power => self.power(left, exponent),
            _ => self.add(Operation::Binary(function, left, right)),
        }
    }

    /// Small powers are products and roots: as exact, and many times faster.
    fn power(&mut self, base: Id, exponent: f64) -> Id {
        if exponent == 2.0 {
            self.binary(Binary::Multiply, base, base)
        } else if exponent == 3.0 {
            let square = self.binary(Binary::Multiply, base, base);
            self.binary(Binary::Multiply, square, base)
        } else if exponent == 0.5 {
            self.unary(Unary::SquareRoot, base)
        } else {
            let exponent = self.constant(exponent);
            self.add(Operation::Binary(Binary::Power, base, exponent))
        }
    }

    pub(crate) fn choice(&mut self, [condition, then, otherwise]: [Id; 3]) -> Id {
        let values = [condition, then, otherwise].map(|id| self.as_constant(id));
        match values {
            [Some(condition), Some(then), Some(otherwise)] => self.constant(choose(condition, then, otherwise)),
            _ => self.add(Operation::If([condition, then, otherwise])),
        }
    }

    pub(crate) fn slope(&mut self, of: Id, axis: usize) -> Id {
        match self.as_constant(of) {
            Some(_) => self.constant(0.0),
            None => self.add(Operation::Slope(of, axis)),
        }
    }

    /// Adds an operation, or finds it.
    pub(crate) fn add(&mut self, operation: Operation) -> Id {
        *self.known.entry(operation).or_insert_with(|| {
            self.operations.push(operation);
            self.operations.len() - 1
        })
    }
}
