//! Expressions over fields of hierarchies: values, derivatives, and what is no expression.

mod derivatives;
mod errors;
mod values;

use std::sync::Arc;

use amray::hierarchy::{Field, Hierarchy};
use amray_expressions::{Definition, Expression, ExpressionError, Names, Program};

/// The program of `text` over fields of these names.
fn program(text: &str, fields: &[&str], definitions: &[Definition]) -> Result<Program, ExpressionError> {
    Program::bind(&Expression::parse(text)?, &Names { fields, definitions })
}

/// The expression over `fields`.
fn evaluate(text: &str, hierarchy: &Arc<Hierarchy>, fields: &[Field]) -> Field {
    let names: Vec<&str> = fields.iter().map(Field::name).collect();
    let program = program(text, &names, &[]).unwrap_or_else(|error| panic!("{text}: {error}"));
    let inputs: Vec<Field> = program.inputs().iter().map(|&number| fields[number].clone()).collect();
    program.evaluate(text, hierarchy, &inputs, &|share| assert!((0.0..=1.0).contains(&share))).unwrap()
}

/// Calls `visit` with every cell of the hierarchy: its level, its index and the field's value.
fn for_each_cell(hierarchy: &Hierarchy, field: &Field, mut visit: impl FnMut(usize, [i64; 3], f64)) {
    for (place, brick) in hierarchy.bricks().enumerate() {
        for cell in brick.cells.iter() {
            let inside = std::array::from_fn(|axis| (cell[axis] - brick.cells.low[axis]) as usize);
            visit(brick.level, cell, field.value(place, inside));
        }
    }
}

/// The world position of a cell's centre.
fn center(hierarchy: &Hierarchy, level: usize, cell: [i64; 3]) -> [f64; 3] {
    hierarchy.to_world(level, cell.map(|index| index as f64 + 0.5))
}
