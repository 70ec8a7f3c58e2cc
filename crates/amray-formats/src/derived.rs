//! What a name stands for in a data set: a field, an expression that it keeps, or an expression over both.

use std::path::Path;

use amray::hierarchy::Field;
use amray_expressions::{Definition, Expression, ExpressionError, Names, Program};

use crate::{DataSet, FormatError, find_field};

/// Reads the field called `name` or, where there is none, evaluates `name` as an expression over fields and over what the
/// data set keeps as [`DataSet::expressions`]. The field that results is called `name`. `prepare` is given each field
/// that is read, before anything follows from its values, and then what follows. `progress` is told the share that is
/// done, 0 to 1, possibly from several threads.
///
/// # Errors
/// [`FormatError::UnknownField`] and [`FormatError::Expression`] list the fields there are and suggest the nearest; others
/// where the file is damaged or cannot be read.
pub fn read_named(
    path: &Path,
    data: &dyn DataSet,
    name: &str,
    prepare: &dyn Fn(Field) -> Field,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Field, FormatError> {
    if let Ok(number) = find_field(path, data.fields(), name) {
        return data.read_field(number, progress).map(prepare);
    }
    let program = program(data, name).map_err(|problem| misunderstood(path, data, name, problem))?;
    let steps = (program.inputs().len() + 1) as f64;
    let mut fields = Vec::with_capacity(program.inputs().len());
    for &number in program.inputs() {
        let done = fields.len() as f64;
        let field = data.read_field(number, &|share| progress((done + share) / steps))?;
        fields.push(prepare(field));
    }
    let done = fields.len() as f64;
    let derived = program.evaluate(name, data.hierarchy(), &fields, &|share| progress((done + share) / steps));
    derived.map(prepare).map_err(|problem| misunderstood(path, data, name, problem))
}

/// The fields that follow from a data set's own by [`DataSet::expressions`], in their order: those that can be evaluated,
/// are not called like a field, and are not the same number everywhere. Of vectors, the three components.
pub fn derived_fields(data: &dyn DataSet) -> Vec<Definition> {
    let known = |name: &str| data.fields().iter().any(|field| field.name == name);
    let varies = |name: &str| !known(name) && program(data, name).is_ok_and(|program| !program.is_constant());
    let derived = |Definition { name, formula }: &Definition| {
        if varies(name) {
            return vec![Definition { name: name.clone(), formula: formula.clone() }];
        }
        let component = |(number, axis)| {
            let name = format!("{name}_{axis}");
            varies(&name).then(|| Definition { name, formula: format!("({formula})[{number}]") })
        };
        [(0, 'x'), (1, 'y'), (2, 'z')].into_iter().filter_map(component).collect()
    };
    data.expressions().iter().flat_map(derived).collect()
}

/// What `name` stands for as a whole, else as an expression.
fn program(data: &dyn DataSet, name: &str) -> Result<Program, ExpressionError> {
    let fields: Vec<&str> = data.fields().iter().map(|field| field.name.as_str()).collect();
    let names = Names { fields: &fields, definitions: data.expressions() };
    match Program::bind(&Expression::name(name), &names) {
        Err(ExpressionError::UnknownName { .. }) => Program::bind(&Expression::parse(name)?, &names),
        bound => bound,
    }
}

fn misunderstood(path: &Path, data: &dyn DataSet, text: &str, problem: ExpressionError) -> FormatError {
    let stored = data.fields().iter().map(|field| field.name.clone());
    let known = stored.chain(derived_fields(data).into_iter().map(|derived| derived.name)).collect();
    match problem {
        ExpressionError::UnknownName { name, .. } if name == text => FormatError::unknown_field(path, text, known),
        problem => FormatError::expression(path, text, problem, known),
    }
}
