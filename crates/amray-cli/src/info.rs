//! `amray info`: what a data set holds.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use amray::Volume;
use amray::hierarchy::{Centering, Field, Hierarchy, Residence};
use amray::index::Index;
use amray::reconstruction::Method;
use amray::render::padded_bytes;
use amray_formats::{DataSet, derived_fields};
use clap::Args;
use serde::Serialize;
use serde_json::json;

use crate::data::{self, DataArguments, unit_of, with_unit};
use crate::memory::MemoryArguments;
use crate::number::{bytes, grouped};
use crate::progress::{with_progress, with_spinner};
use crate::{print, print_json, series};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A data set, or several: the steps of a time series, or patterns in quotes ('plt*')
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// As if levels finer than K did not exist
    #[arg(long, value_name = "K")]
    max_level: Option<usize>,
    #[command(flatten)]
    memory: MemoryArguments,
    /// Only the range of this field, or of an expression over fields [default: of every field in the files]
    #[arg(long, value_name = "NAME")]
    field: Option<String>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Description {
    format: &'static str,
    time: Option<f64>,
    bounds: [[f64; 3]; 2],
    levels: Vec<LevelDescription>,
    fields: Vec<FieldDescription>,
    /// Fields that follow from those by expressions in the files.
    derived: Vec<DerivedDescription>,
    /// What the padded copy of one field takes, which marching is fastest in.
    padded_bytes: u64,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct LevelDescription {
    level: usize,
    /// To the next coarser level; 1 on level 0.
    ratio: [i64; 3],
    cell_size: [f64; 3],
    /// First and last cell.
    domain: [[i64; 3]; 2],
    bricks: usize,
    cells: u64,
    leaf_cells: u64,
}

#[derive(Serialize)]
struct FieldDescription {
    name: String,
    /// As the file states it.
    unit: Option<String>,
    /// Over leaf cells, without ghosts; null where no value is finite.
    min: Option<f64>,
    max: Option<f64>,
    /// Of all cells' values, without ghosts.
    bytes: u64,
    /// How many of them are in memory, rather than in a mapped file.
    #[serde(skip)]
    owned_bytes: u64,
}

#[derive(Serialize)]
struct DerivedDescription {
    name: String,
    formula: String,
}

/// What the index takes; only the text says it.
struct IndexDescription {
    regions: usize,
    bytes: u64,
    seconds: f64,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let paths = series::paths(&arguments.paths)?;
    match &paths[..] {
        [path] => one(arguments, &arguments.data(path)),
        paths => several(arguments, paths),
    }
}

impl Arguments {
    fn data(&self, path: &Path) -> DataArguments {
        DataArguments { path: path.into(), max_level: self.max_level, memory: self.memory }
    }
}

/// A step of a time series.
#[derive(Serialize)]
struct Step {
    path: PathBuf,
    format: &'static str,
    time: Option<f64>,
    levels: usize,
    bricks: usize,
    cells: u64,
    /// Whether the mesh is that of the step before.
    same_mesh: bool,
}

/// Describes a time series, a line each.
fn several(arguments: &Arguments, paths: &[PathBuf]) -> anyhow::Result<()> {
    let mut last: Option<Arc<Hierarchy>> = None;
    let mut steps = Vec::with_capacity(paths.len());
    for path in paths {
        let data = arguments.data(path).open()?;
        let hierarchy = data.hierarchy();
        steps.push(Step {
            path: path.clone(),
            format: data.format(),
            time: data.time(),
            levels: hierarchy.levels().len(),
            bricks: hierarchy.brick_count(),
            cells: hierarchy.cells(),
            same_mesh: last.replace(hierarchy.clone()).is_some_and(|last| last == *hierarchy),
        });
    }
    if arguments.json {
        return print_json(&json!({ "steps": steps }));
    }
    let mut text = format!("{:>14} {:>7} {:>8} {:>14}  mesh    data\n", "time", "levels", "bricks", "cells");
    for Step { path, time, levels, bricks, cells, same_mesh, .. } in &steps {
        let time = time.map_or_else(|| "unknown".into(), |time| format!("{time:.6e}"));
        let mesh = if *same_mesh { "same" } else { "new" };
        let cells = grouped(*cells);
        text += &format!("{time:>14} {levels:>7} {bricks:>8} {cells:>14}  {mesh:<6}  {}\n", path.display());
    }
    Ok(print(&text)?)
}

fn one(arguments: &Arguments, source: &DataArguments) -> anyhow::Result<()> {
    let data = source.open()?;
    let start = Instant::now();
    let index = Arc::new(with_spinner("indexing", || Index::build(data.hierarchy().clone())));
    let seconds = start.elapsed().as_secs_f64();
    let of_index = IndexDescription { regions: index.regions().len(), bytes: index.bytes(), seconds };
    let description = describe((arguments, source), &*data, &index)?;
    if arguments.json {
        return print_json(&description);
    }
    Ok(print(&text(&description, &of_index))?)
}

fn describe(
    (arguments, source): (&Arguments, &DataArguments),
    data: &dyn DataSet,
    index: &Arc<Index>,
) -> anyhow::Result<Description> {
    let hierarchy = data.hierarchy();
    let leaf_cells = index.leaf_cells();
    let levels = hierarchy.levels().iter().enumerate().map(|(number, level)| LevelDescription {
        level: number,
        ratio: level.ratio(),
        cell_size: level.cell_size(),
        domain: [level.domain().low, level.domain().high.map(|index| index - 1)],
        bricks: level.bricks().len(),
        cells: level.cells(),
        leaf_cells: leaf_cells[number],
    });
    let fields = match &arguments.field {
        Some(name) => vec![describe_field(data, index, source.read_field(data, Some(name), &|field| field)?)],
        None => (0..data.fields().len())
            .map(|number| {
                let name = &data.fields()[number].name;
                let field = with_progress(name, |progress| data.read_field(number, progress))?;
                Ok(describe_field(data, index, field))
            })
            .collect::<anyhow::Result<_>>()?,
    };
    let derived = derived_fields(data).into_iter();
    let derived = derived.map(|derived| DerivedDescription { name: derived.name, formula: derived.formula }).collect();
    Ok(Description {
        format: data.format(),
        time: data.time(),
        bounds: hierarchy.bounds(),
        levels: levels.collect(),
        fields,
        derived,
        padded_bytes: padded_bytes(hierarchy, Centering::Cells),
        warnings: data::warnings(data),
    })
}

fn describe_field(data: &dyn DataSet, index: &Arc<Index>, field: Field) -> FieldDescription {
    let name = field.name().to_owned();
    let unit = unit_of(data, &name).map(str::to_owned);
    let bytes = index.hierarchy().cells() * field.voxel_type().bytes() as u64;
    let owned_bytes = field.bytes(Residence::Owned);
    let range = with_spinner(&name, || Volume::new(index.clone(), field, Method::Nearest).leaf_range());
    FieldDescription {
        name,
        unit,
        min: range.map(|range| range[0]),
        max: range.map(|range| range[1]),
        bytes,
        owned_bytes,
    }
}

fn text(description: &Description, index: &IndexDescription) -> String {
    let mut text = String::new();
    write_text(&mut text, description, index).expect("writing to a string cannot fail");
    text
}

fn write_text(out: &mut String, description: &Description, index: &IndexDescription) -> std::fmt::Result {
    let Description { format, time, bounds: [low, high], levels, fields, derived, padded_bytes, warnings } =
        description;
    write!(out, "{format}")?;
    if let Some(time) = time {
        write!(out, ", time {time}")?;
    }
    writeln!(out, "\nbounds {} to {}\n", triple(low), triple(high))?;
    writeln!(out, "level  ratio  bricks         cells    leaf cells  cell size")?;
    for level in levels {
        let [i, j, k] = level.ratio;
        let ratio = if i == j && j == k { i.to_string() } else { format!("{i},{j},{k}") };
        writeln!(
            out,
            "{:>5} {ratio:>6} {:>7} {:>13} {:>13}  {}",
            level.level,
            level.bricks,
            grouped(level.cells),
            grouped(level.leaf_cells),
            triple(&level.cell_size)
        )?;
    }
    let total = |count: fn(&LevelDescription) -> u64| grouped(levels.iter().map(count).sum());
    let bricks = levels.iter().map(|level| level.bricks).sum::<usize>();
    writeln!(out, "  all {:>14} {:>13} {:>13}\n", bricks, total(|l| l.cells), total(|l| l.leaf_cells))?;
    let names: Vec<String> = fields.iter().map(|field| with_unit(&field.name, field.unit.as_deref())).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(5);
    writeln!(out, "{:width$}  {:>13}  {:>13}  memory", "field", "min", "max")?;
    for (field, name) in fields.iter().zip(&names) {
        let value = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.6e}"));
        let residence = if field.owned_bytes > 0 { "read" } else { "mapped" };
        writeln!(
            out,
            "{name:width$}  {:>13}  {:>13}  {} {residence}",
            value(field.min),
            value(field.max),
            bytes(field.bytes)
        )?;
    }
    if !derived.is_empty() {
        let width = derived.iter().map(|field| field.name.chars().count()).max().unwrap_or(0).max(7);
        writeln!(out, "\n{:width$}  formula", "derived")?;
        for DerivedDescription { name, formula } in derived {
            writeln!(out, "{name:width$}  {formula}")?;
        }
    }
    let IndexDescription { regions, bytes: index_bytes, seconds } = index;
    writeln!(out, "\nindex: {} regions, {}, built in {seconds:.4} s", grouped(*regions as u64), bytes(*index_bytes))?;
    writeln!(out, "to march: {} for the padded copy of a field, or nothing in place", bytes(*padded_bytes))?;
    for warning in warnings {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(())
}

fn triple([x, y, z]: &[f64; 3]) -> String {
    format!("({x}, {y}, {z})")
}
