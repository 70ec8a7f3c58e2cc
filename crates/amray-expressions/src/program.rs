//! From operations to programs: what is computed in which order, and where numbers are kept meanwhile.

use crate::bind::{Names, Value, bind};
use crate::error::ExpressionError;
use crate::graph::{Graph, Id, Operation};
use crate::numeric::{Binary, Unary};
use crate::parse::Expression;

/// An expression, bound to fields and ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Program {
    inputs: Vec<usize>,
    /// One for each derivative of more than a field, whose values in neighbouring cells are needed; the last one is the
    /// expression itself.
    stages: Vec<Stage>,
}

/// What is computed cell by cell. Numbers are kept in slots, a block of cells in each.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    pub(crate) steps: Vec<Step>,
    pub(crate) slots: usize,
    /// Slots that hold the same number in each cell.
    pub(crate) constants: Vec<(usize, f64)>,
    /// The slot of the result.
    pub(crate) result: usize,
    /// Of what slopes are taken, and along which axes.
    pub(crate) sloped: Vec<(Source, usize)>,
}

/// Something with a value in each cell of the hierarchy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// A place in [`Program::inputs`].
    Input(usize),
    /// The result of a stage.
    Stage(usize),
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) action: Action,
    /// A slot, none of those that the action reads.
    pub(crate) into: usize,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Action {
    Load(Source),
    /// A place in [`Stage::sloped`].
    Slope(usize),
    Coordinate(usize),
    Level,
    CellSize,
    CellVolume,
    Unary(Unary, usize),
    Binary(Binary, usize, usize),
    If([usize; 3]),
}

impl Program {
    /// Looks up what the names in an expression stand for.
    ///
    /// # Errors
    /// [`ExpressionError`] where a name is not known, a function's arguments do not fit, definitions run in a circle, or
    /// the expression is a vector.
    pub fn bind(expression: &Expression, names: &Names) -> Result<Self, ExpressionError> {
        match bind(expression, names)? {
            (graph, Value::Number(root)) => Ok(Self::compile(&graph, root)),
            (_, Value::Vector(_)) => {
                let expected = "expected a number: its magnitude, or a component [0], [1] or [2]";
                Err(ExpressionError::invalid(1, format!("a vector, {expected}")))
            }
        }
    }

    /// The numbers of the fields that are needed, each once.
    pub fn inputs(&self) -> &[usize] {
        &self.inputs
    }

    /// Whether the expression is the same number everywhere.
    pub fn is_constant(&self) -> bool {
        self.stages.iter().all(|stage| stage.steps.is_empty())
    }

    pub(crate) fn stages(&self) -> &[Stage] {
        &self.stages
    }

    fn compile(graph: &Graph, root: Id) -> Self {
        let mut needed = vec![false; root + 1];
        needed[root] = true;
        let mut inputs = Vec::new();
        let mut sloped = Vec::new();
        for id in (0..=root).rev() {
            if !needed[id] {
                continue;
            }
            match graph.operation(id) {
                Operation::Field(number) => inputs.push(number),
                Operation::Slope(of, _) => {
                    needed[of] = true;
                    if !matches!(graph.operation(of), Operation::Field(_)) {
                        sloped.push(of);
                    }
                }
                operation => operation.operands().for_each(|operand| needed[operand] = true),
            }
        }
        inputs.reverse();
        sloped.sort_unstable();
        sloped.dedup();
        let source = |id: Id| match graph.operation(id) {
            Operation::Field(number) => {
                Source::Input(inputs.iter().position(|input| *input == number).expect("all fields were collected"))
            }
            _ => Source::Stage(sloped.binary_search(&id).expect("all slopes were collected")),
        };
        let stages = sloped.iter().chain([&root]).map(|&root| Stage::compile(graph, root, &source)).collect();
        Self { inputs, stages }
    }
}

impl Stage {
    fn compile(graph: &Graph, root: Id, source: &impl Fn(Id) -> Source) -> Self {
        let mut stage = Self { steps: Vec::new(), slots: 0, constants: Vec::new(), result: 0, sloped: Vec::new() };
        let last_uses = last_uses(graph, root);
        let mut slots = vec![0; root + 1];
        let mut free = Vec::new();
        for id in 0..=root {
            if last_uses[id].is_none() {
                continue;
            }
            let operation = graph.operation(id);
            if let Some(value) = graph.as_constant(id) {
                slots[id] = stage.new_slot();
                stage.constants.push((slots[id], value));
                continue;
            }
            let action = stage.action(id, operation, &slots, source);
            slots[id] = free.pop().unwrap_or_else(|| stage.new_slot());
            stage.steps.push(Step { action, into: slots[id] });
            let mut done: Vec<usize> = operation
                .operands()
                .filter(|&operand| last_uses[operand] == Some(id) && graph.as_constant(operand).is_none())
                .map(|operand| slots[operand])
                .collect();
            done.sort_unstable();
            done.dedup();
            free.extend(done);
        }
        stage.result = slots[root];
        stage
    }

    fn action(&mut self, id: Id, operation: Operation, slots: &[usize], source: &impl Fn(Id) -> Source) -> Action {
        match operation {
            Operation::Constant(_) => unreachable!("constants have slots and no steps"),
            Operation::Field(_) => Action::Load(source(id)),
            Operation::Slope(of, axis) => {
                // The graph holds every slope once.
                self.sloped.push((source(of), axis));
                Action::Slope(self.sloped.len() - 1)
            }
            Operation::Coordinate(axis) => Action::Coordinate(axis),
            Operation::Level => Action::Level,
            Operation::CellSize => Action::CellSize,
            Operation::CellVolume => Action::CellVolume,
            Operation::Unary(function, operand) => Action::Unary(function, slots[operand]),
            Operation::Binary(function, left, right) => Action::Binary(function, slots[left], slots[right]),
            Operation::If(operands) => Action::If(operands.map(|operand| slots[operand])),
        }
    }

    /// The place in [`Program::inputs`] of the field that this stage only loads, if it does.
    pub(crate) fn as_input(&self) -> Option<usize> {
        match self.steps[..] {
            [Step { action: Action::Load(Source::Input(place)), .. }] => Some(place),
            _ => None,
        }
    }

    fn new_slot(&mut self) -> usize {
        self.slots += 1;
        self.slots - 1
    }
}

/// The last operation that needs each one in the same cell, on the way to `root`; none where none does.
fn last_uses(graph: &Graph, root: Id) -> Vec<Option<Id>> {
    let mut last_uses = vec![None; root + 1];
    last_uses[root] = Some(root);
    for id in (0..=root).rev() {
        if last_uses[id].is_some() {
            for operand in graph.operation(id).operands() {
                last_uses[operand].get_or_insert(id);
            }
        }
    }
    last_uses
}
