//! From a tree to operations: what its names stand for, and vectors as three numbers.

use std::collections::HashMap;

use crate::error::ExpressionError;
use crate::function::Function;
use crate::graph::{Graph, Id, Operation};
use crate::numeric::{Binary, Unary};
use crate::parse::{Expression, Node, NodeKind};

/// Definitions may refer to one another so many times in a row.
const LONGEST_CHAIN: usize = 32;

/// The most operations of one expression, with all definitions that it uses.
const MOST_OPERATIONS: usize = 4096;

/// What an expression's names can stand for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Names<'a> {
    /// The fields, by number. Of several with one name, the first counts.
    pub fields: &'a [&'a str],
    /// Expressions under names of their own, which may refer to one another. A field of the same name wins.
    pub definitions: &'a [Definition],
}

/// An expression under a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// The name.
    pub name: String,
    /// The expression.
    pub formula: String,
}

/// What a part of an expression is in each cell.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Value {
    Number(Id),
    Vector([Id; 3]),
}

/// The operations of an expression, and what it is in the end.
///
/// # Errors
/// [`ExpressionError`] where a name is not known, a function's arguments do not fit, or definitions run in a circle.
pub(crate) fn bind(expression: &Expression, names: &Names) -> Result<(Graph, Value), ExpressionError> {
    let mut binder = Binder { names, graph: Graph::default(), known: HashMap::new(), open: Vec::new() };
    let value = binder.expression(expression)?;
    Ok((binder.graph, value))
}

struct Binder<'a> {
    names: &'a Names<'a>,
    graph: Graph,
    /// Definitions that are bound, by number.
    known: HashMap<usize, Value>,
    /// Definitions that are being bound.
    open: Vec<usize>,
}

impl Binder<'_> {
    fn expression(&mut self, expression: &Expression) -> Result<Value, ExpressionError> {
        let mut values: Vec<Value> = Vec::with_capacity(expression.nodes().len());
        for node in expression.nodes() {
            let value = self.node(node, &values)?;
            if self.graph.len() > MOST_OPERATIONS {
                let problem = format!("more than {MOST_OPERATIONS} operations, with all that the names stand for");
                return Err(ExpressionError::invalid(node.column, problem));
            }
            values.push(value);
        }
        Ok(*values.last().expect("an expression that was read has parts"))
    }

    fn node(&mut self, node: &Node, values: &[Value]) -> Result<Value, ExpressionError> {
        let invalid = |problem: String| ExpressionError::invalid(node.column, problem);
        match &node.kind {
            NodeKind::Number(number) => Ok(Value::Number(self.graph.constant(*number))),
            NodeKind::Name(name) => {
                self.name(name)?.ok_or_else(|| ExpressionError::UnknownName { column: node.column, name: name.clone() })
            }
            NodeKind::Call(function, name, arguments) => {
                let arguments: Vec<Value> = arguments.iter().map(|&place| values[place]).collect();
                self.call(*function, &arguments).ok_or_else(|| invalid(misfit(*function, name, &arguments)))
            }
            NodeKind::Vector(parts) => match parts.map(|place| values[place]) {
                [Value::Number(x), Value::Number(y), Value::Number(z)] => Ok(Value::Vector([x, y, z])),
                _ => Err(invalid("a vector of vectors, expected one of numbers".into())),
            },
            NodeKind::Component(vector, component) => match values[*vector] {
                Value::Vector(components) => Ok(Value::Number(components[*component])),
                Value::Number(_) => Err(invalid("a number has no components, expected a vector before [".into())),
            },
        }
    }

    /// Fields first, then definitions, then what there is everywhere.
    fn name(&mut self, name: &str) -> Result<Option<Value>, ExpressionError> {
        if let Some(field) = self.field(name) {
            return Ok(Some(Value::Number(field)));
        }
        if let Some(value) = self.definition(name)? {
            return Ok(Some(value));
        }
        let everywhere = match name {
            "x" => Operation::Coordinate(0),
            "y" => Operation::Coordinate(1),
            "z" => Operation::Coordinate(2),
            "level" => Operation::Level,
            "cell_size" => Operation::CellSize,
            "cell_volume" => Operation::CellVolume,
            "pi" => Operation::Constant(std::f64::consts::PI.to_bits()),
            "e" => Operation::Constant(std::f64::consts::E.to_bits()),
            _ => return self.vector_or_component(name),
        };
        Ok(Some(Value::Number(self.graph.add(everywhere))))
    }

    fn field(&mut self, name: &str) -> Option<Id> {
        let number = self.names.fields.iter().position(|field| *field == name)?;
        Some(self.graph.add(Operation::Field(number)))
    }

    /// The vector whose components are fields of their own, `x-NAME` or `NAME_x`; or `NAME_x` of a defined vector.
    fn vector_or_component(&mut self, name: &str) -> Result<Option<Value>, ExpressionError> {
        let components: [fn(&str, &str) -> String; 2] =
            [|name, axis| format!("{axis}-{name}"), |name, axis| format!("{name}_{axis}")];
        for component in components {
            if let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(|axis| self.field(&component(name, axis))) {
                return Ok(Some(Value::Vector([x, y, z])));
            }
        }
        for (axis, ending) in ["_x", "_y", "_z"].into_iter().enumerate() {
            if let Some(vector) = name.strip_suffix(ending)
                && let Some(Value::Vector(components)) = self.definition(vector)?
            {
                return Ok(Some(Value::Number(components[axis])));
            }
        }
        Ok(None)
    }

    fn definition(&mut self, name: &str) -> Result<Option<Value>, ExpressionError> {
        let definitions = self.names.definitions;
        let Some(number) = definitions.iter().position(|definition| definition.name == name) else { return Ok(None) };
        if let Some(value) = self.known.get(&number) {
            return Ok(Some(*value));
        }
        let Definition { name, formula } = &definitions[number];
        let circle = self.open.contains(&number);
        if circle || self.open.len() == LONGEST_CHAIN {
            let problem = if circle { "refers to itself" } else { "refers to too many others in a row" };
            return Err(ExpressionError::invalid(1, problem).in_definition(name, formula));
        }
        self.open.push(number);
        let value = Expression::parse(formula).and_then(|expression| self.expression(&expression));
        let value = value.map_err(|error| error.in_definition(name, formula))?;
        self.open.pop();
        self.known.insert(number, value);
        Ok(Some(value))
    }

    /// `None` where the arguments do not fit the function.
    fn call(&mut self, function: Function, arguments: &[Value]) -> Option<Value> {
        use Value::{Number, Vector};
        match (function, arguments) {
            (Function::Unary(function), &[Number(operand)]) => Some(Number(self.graph.unary(function, operand))),
            (Function::Unary(Unary::Negate), &[Vector(operand)]) => {
                Some(Vector(operand.map(|operand| self.graph.unary(Unary::Negate, operand))))
            }
            (Function::Binary(function), &[left, right]) => self.binary(function, left, right),
            (Function::Fold(function), &[Number(first), ref rest @ ..]) if !rest.is_empty() => {
                rest.iter().try_fold(Number(first), |all, next| match (all, *next) {
                    (Number(all), Number(next)) => Some(Number(self.graph.binary(function, all, next))),
                    _ => None,
                })
            }
            (Function::If, &[Number(condition), Number(then), Number(otherwise)]) => {
                Some(Number(self.graph.choice([condition, then, otherwise])))
            }
            (Function::If, &[Number(condition), Vector(then), Vector(otherwise)]) => {
                Some(Vector(each_axis(|axis| self.graph.choice([condition, then[axis], otherwise[axis]]))))
            }
            (Function::Dot, &[Vector(left), Vector(right)]) => Some(Number(self.dot(left, right))),
            (Function::Cross, &[Vector(left), Vector(right)]) => {
                Some(Vector(each_axis(|axis| self.cross(axis, |this, a, b| this.product(left[a], right[b])))))
            }
            (Function::Magnitude, &[Vector(vector)]) => Some(Number(self.magnitude(vector))),
            (Function::Slope(axis), &[Number(of)]) => Some(Number(self.graph.slope(of, axis))),
            (Function::Gradient, &[Number(of)]) => Some(Vector(self.gradient(of))),
            (Function::GradientMagnitude, &[Number(of)]) => {
                let gradient = self.gradient(of);
                Some(Number(self.magnitude(gradient)))
            }
            (Function::Divergence, arguments) => {
                let vector = vector(arguments)?;
                let slopes = each_axis(|axis| self.graph.slope(vector[axis], axis));
                Some(Number(self.sum(slopes)))
            }
            (Function::VorticityAlong(axis), arguments) => {
                let vector = vector(arguments)?;
                Some(Number(self.vorticity(vector, axis)))
            }
            (Function::Vorticity, arguments) => {
                let vector = vector(arguments)?;
                Some(Vector(each_axis(|axis| self.vorticity(vector, axis))))
            }
            (Function::VorticityMagnitude, arguments) => {
                let vector = vector(arguments)?;
                let vorticity = each_axis(|axis| self.vorticity(vector, axis));
                Some(Number(self.magnitude(vorticity)))
            }
            _ => None,
        }
    }

    fn binary(&mut self, function: Binary, left: Value, right: Value) -> Option<Value> {
        use Value::{Number, Vector};
        match (function, left, right) {
            (_, Number(left), Number(right)) => Some(Number(self.graph.binary(function, left, right))),
            (Binary::Add | Binary::Subtract, Vector(left), Vector(right)) => {
                Some(Vector(each_axis(|axis| self.graph.binary(function, left[axis], right[axis]))))
            }
            (Binary::Multiply | Binary::Divide, Vector(left), Number(right)) => {
                Some(Vector(left.map(|left| self.graph.binary(function, left, right))))
            }
            (Binary::Multiply, Number(left), Vector(right)) => {
                Some(Vector(right.map(|right| self.product(left, right))))
            }
            _ => None,
        }
    }

    fn product(&mut self, left: Id, right: Id) -> Id {
        self.graph.binary(Binary::Multiply, left, right)
    }

    fn sum(&mut self, [x, y, z]: [Id; 3]) -> Id {
        let two = self.graph.binary(Binary::Add, x, y);
        self.graph.binary(Binary::Add, two, z)
    }

    fn dot(&mut self, left: [Id; 3], right: [Id; 3]) -> Id {
        let products = each_axis(|axis| self.product(left[axis], right[axis]));
        self.sum(products)
    }

    fn magnitude(&mut self, vector: [Id; 3]) -> Id {
        let square = self.dot(vector, vector);
        self.graph.unary(Unary::SquareRoot, square)
    }

    fn gradient(&mut self, of: Id) -> [Id; 3] {
        each_axis(|axis| self.graph.slope(of, axis))
    }

    fn vorticity(&mut self, vector: [Id; 3], axis: usize) -> Id {
        self.cross(axis, |this, along, of| this.graph.slope(vector[of], along))
    }

    /// A component of a cross product; `product` is given the axes of its two factors.
    fn cross(&mut self, axis: usize, mut product: impl FnMut(&mut Self, usize, usize) -> Id) -> Id {
        let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        let [plus, minus] = [product(self, next, last), product(self, last, next)];
        self.graph.binary(Binary::Subtract, plus, minus)
    }
}

fn each_axis(component: impl FnMut(usize) -> Id) -> [Id; 3] {
    [0, 1, 2].map(component)
}

/// A vector, or three numbers that are one.
fn vector(arguments: &[Value]) -> Option<[Id; 3]> {
    match *arguments {
        [Value::Vector(vector)] => Some(vector),
        [Value::Number(x), Value::Number(y), Value::Number(z)] => Some([x, y, z]),
        _ => None,
    }
}

/// Why arguments do not fit a function.
fn misfit(function: Function, name: &str, arguments: &[Value]) -> String {
    let found: Vec<&str> = arguments
        .iter()
        .map(|argument| match argument {
            Value::Number(_) => "a number",
            Value::Vector(_) => "a vector",
        })
        .collect();
    let found = if found.is_empty() { "nothing".into() } else { found.join(" and ") };
    let expected = match function {
        Function::Binary(Binary::Multiply) => "numbers, or a number and a vector (dot and cross multiply vectors)",
        Function::Binary(Binary::Add | Binary::Subtract) => "two numbers or two vectors",
        Function::Binary(Binary::Divide) => "numbers, or a vector and a number",
        Function::Unary(_) | Function::Slope(_) | Function::Gradient | Function::GradientMagnitude => "a number",
        Function::Binary(_) => "two numbers",
        Function::Fold(_) => "two or more numbers",
        Function::If => "a condition and two numbers or two vectors",
        Function::Dot | Function::Cross => "two vectors",
        Function::Magnitude => "a vector",
        Function::Divergence | Function::Vorticity | Function::VorticityAlong(_) | Function::VorticityMagnitude => {
            "a vector or its three components"
        }
    };
    format!("{name} of {found}, expected {expected}")
}
