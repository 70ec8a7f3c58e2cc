//! `amray convert`: between formats, and from structured volumes to AMR data.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use amray::hierarchy::{BrickValues, Centering, Field, FieldValues, Hierarchy, Voxel, VoxelType};
use amray_formats::output::check_writable;
use amray_formats::structured::amr::{FIELD, Refined, Refinement};
use amray_formats::structured::{ByteOrder, NumberType, RawLayout, StructuredVolume};
use amray_formats::{AmrContent, AmrFormat, AmrWriter, FormatError};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use rayon::prelude::*;
use serde::Serialize;

use crate::data::{DataArguments, warnings};
use crate::memory::MemoryArguments;
use crate::number::{bytes, grouped, list};
use crate::progress::{with_progress, with_spinner};
use crate::{memory, note, number, print, print_json};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A structured volume (NRRD, NumPy, NIfTI, VTK ImageData, or raw with --dims), or AMR data of any format
    path: PathBuf,
    /// Where to write the AMR data: .hdf5 or .h5 (Chombo), .vthb or .vtkhdf (VTK)
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(output_path))]
    output: PathBuf,
    #[command(flatten)]
    memory: MemoryArguments,
    #[command(flatten)]
    volume: VolumeFlags,
    #[command(flatten)]
    data: DataFlags,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What a structured volume becomes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Structured volumes")]
struct VolumeFlags {
    /// Cells per side of a brick: an even number from 4 to 256 [default: 16]
    #[arg(long, value_name = "CELLS")]
    brick: Option<usize>,
    /// Drop bricks whose samples the coarser level is nearer to than this [default: 0, nothing is lost]
    #[arg(long, value_name = "DIFFERENCE", value_parser = number::finite)]
    threshold: Option<f64>,
    /// The number of levels [default: until the coarsest is one brick]
    #[arg(long, value_name = "N")]
    levels: Option<usize>,
    /// Samples of a raw volume along x (stored fastest), y and z
    #[arg(long, value_name = "X,Y,Z", value_parser = dims, requires = "number_type")]
    dims: Option<[u64; 3]>,
    /// The type of a raw volume's samples
    #[arg(long = "type", value_name = "TYPE", value_parser = number_type, requires = "dims")]
    number_type: Option<NumberType>,
    /// A raw volume's samples have their highest byte first
    #[arg(long, requires = "dims")]
    big_endian: bool,
    /// The distance between samples [default: as the file says, else 1]
    #[arg(long, value_name = "X,Y,Z", value_parser = list::<3>, allow_hyphen_values = true)]
    spacing: Option<[f64; 3]>,
    /// The position of the first sample [default: as the file says, else 0]
    #[arg(long, value_name = "X,Y,Z", value_parser = list::<3>, allow_hyphen_values = true)]
    origin: Option<[f64; 3]>,
}

/// What is taken of AMR data.
#[derive(Debug, Args)]
#[command(next_help_heading = "AMR data")]
struct DataFlags {
    /// Only this field, or an expression over fields; may be repeated [default: all fields; of a volume, the first]
    #[arg(long, value_name = "NAME")]
    field: Vec<String>,
    /// As if levels finer than K did not exist
    #[arg(long, value_name = "K")]
    max_level: Option<usize>,
    /// Let covered cells take the mean of the finer ones
    #[arg(long)]
    restrict: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    input: PathBuf,
    output: PathBuf,
    /// The input's.
    format: &'static str,
    fields: Vec<String>,
    levels: Vec<LevelReport>,
    cells: u64,
    /// The output file's length.
    bytes: u64,
    /// Where the input is a structured volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    original: Option<Original>,
    peak_resident_bytes: Option<u64>,
}

#[derive(Serialize)]
struct LevelReport {
    level: usize,
    bricks: usize,
    cells: u64,
}

/// A structured volume, and what became of it.
#[derive(Serialize)]
struct Original {
    size: [usize; 3],
    cells: u64,
    /// Of the samples, not compressed.
    bytes: u64,
    threshold: f64,
    /// The output's share.
    cells_share: f64,
    bytes_share: f64,
    /// At the samples.
    max_error: f64,
    mean_error: f64,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    refuse_overwriting(&arguments.path, &arguments.output)?;
    check_writable(&arguments.output)?;
    let report = match arguments.open_volume()? {
        Some(volume) => convert_volume(arguments, &volume)?,
        None => convert_data(arguments)?,
    };
    if arguments.json {
        return print_json(&report);
    }
    Ok(print(&text(&report))?)
}

impl Arguments {
    /// The structured volume that the input is, if it is one.
    fn open_volume(&self) -> anyhow::Result<Option<StructuredVolume>> {
        let VolumeFlags { dims, number_type, big_endian, spacing, origin, .. } = self.volume;
        let volume = match (dims, number_type) {
            (Some(size), Some(number_type)) => {
                let byte_order = if big_endian { ByteOrder::Big } else { ByteOrder::Little };
                StructuredVolume::open_raw(&self.path, &RawLayout { size, number_type, byte_order })?
            }
            _ if StructuredVolume::recognises(&self.path)? => {
                StructuredVolume::open(&self.path, self.data.field.first().map(String::as_str))?
            }
            _ => return Ok(None),
        };
        Ok(Some(volume.placed(spacing, origin)?))
    }
}

fn convert_volume(arguments: &Arguments, volume: &StructuredVolume) -> anyhow::Result<Report> {
    let Arguments { path, output, volume: flags, data, .. } = arguments;
    if data.restrict || data.max_level.is_some() {
        anyhow::bail!("{}: --max-level and --restrict are for AMR data, this is a volume", path.display());
    }
    if flags.dims.is_some() && !data.field.is_empty() {
        anyhow::bail!("{}: --field is for files that name their fields, a raw volume does not", path.display());
    }
    if data.field.len() > 1 {
        anyhow::bail!("{}: {} fields, expected one of a volume", path.display(), data.field.len());
    }
    refuse_overwriting(volume.sample_file(), output)?;
    for warning in volume.warnings() {
        note(&format!("amray: warning: {}: {warning}", path.display()));
    }
    let refinement = Refinement {
        brick: flags.brick.unwrap_or(16),
        threshold: flags.threshold.unwrap_or(0.0),
        levels: flags.levels,
        memory: arguments.memory.most(),
    };
    let refined = with_progress("converting", |progress| refinement.write(volume, output, progress))?;
    let Refined { hierarchy, max_error, mean_error } = refined;
    let bytes = volume.sample_count() * volume.number_type().bytes() as u64;
    let mut report = Report::new(arguments, volume.format(), vec![FIELD.to_owned()], &hierarchy)?;
    report.original = Some(Original {
        size: volume.size(),
        cells: volume.sample_count(),
        bytes,
        threshold: refinement.threshold,
        cells_share: report.cells as f64 / volume.sample_count() as f64,
        bytes_share: report.bytes as f64 / bytes as f64,
        max_error,
        mean_error,
    });
    Ok(report)
}

fn convert_data(arguments: &Arguments) -> anyhow::Result<Report> {
    let Arguments { path, output, data: flags, volume, .. } = arguments;
    let data_arguments = DataArguments { path: path.clone(), max_level: flags.max_level, memory: arguments.memory };
    let data = data_arguments.open().map_err(|error| match error.downcast::<FormatError>() {
        Ok(FormatError::Unrecognised { path, found, expected }) => {
            let expected =
                format!("{expected}, or a structured volume ({}; raw with --dims)", StructuredVolume::FORMATS);
            FormatError::Unrecognised { path, found, expected }.into()
        }
        Ok(error) => error.into(),
        Err(error) => error,
    })?;
    let VolumeFlags { brick, threshold, levels, spacing, origin, .. } = volume;
    let placed = spacing.is_some() || origin.is_some();
    if brick.is_some() || threshold.is_some() || levels.is_some() || placed {
        let flags = "--brick, --threshold, --levels, --spacing and --origin are for structured volumes";
        return Err(data_arguments.error(format!("{flags}, these are AMR data")));
    }
    for warning in warnings(&*data) {
        note(&format!("amray: warning: {}: {warning}", path.display()));
    }
    let fields: Vec<String> = match &flags.field[..] {
        [] => data.fields().iter().map(|field| field.name.clone()).collect(),
        names => names.to_vec(),
    };
    // An expression may be over any of them.
    let double = data.fields().iter().any(|field| field.voxel_type == VoxelType::F64);
    let voxel_type = if double { VoxelType::F64 } else { VoxelType::F32 };
    let names: Vec<&str> = fields.iter().map(String::as_str).collect();
    let hierarchy = data.hierarchy();
    let format = AmrFormat::of(output)?;
    // What values belong to is known with the first field.
    let mut writer: Option<(Centering, AmrWriter)> = None;
    for (component, name) in fields.iter().enumerate() {
        let prepare = |field: Field| if flags.restrict { field.restricted(hierarchy) } else { field };
        let field = data_arguments.read_field(&*data, Some(name), &prepare)?;
        let centering = field.centering();
        if writer.is_none() {
            let time = data.time().unwrap_or(0.0);
            let content = AmrContent { hierarchy, components: &names, centering, voxel_type, time };
            writer = Some((centering, format.create(output, &content)?));
        }
        if let Some((of_all, writer)) = &writer {
            if centering != *of_all {
                let problem = format!("{name} belongs to {}, {} to {}", values(centering), fields[0], values(*of_all));
                return Err(data_arguments.error(format!("{problem}: convert them one by one (--field)")));
            }
            with_spinner(name, || write_field(writer, hierarchy, component, &field))?;
        }
    }
    if let Some((_, writer)) = writer {
        writer.finish()?;
    }
    Report::new(arguments, data.format(), fields, hierarchy)
}

/// What has values of a centering, in words.
fn values(centering: Centering) -> &'static str {
    match centering {
        Centering::Cells => "cells",
        Centering::Nodes => "nodes",
    }
}

fn write_field(writer: &AmrWriter, hierarchy: &Hierarchy, component: usize, field: &Field) -> Result<(), FormatError> {
    match field.values() {
        FieldValues::F32(bricks) => write_bricks(writer, hierarchy, component, bricks),
        FieldValues::F64(bricks) => write_bricks(writer, hierarchy, component, bricks),
    }
}

fn write_bricks<T: Voxel>(
    writer: &AmrWriter,
    hierarchy: &Hierarchy,
    component: usize,
    bricks: &[BrickValues<T>],
) -> Result<(), FormatError> {
    let places: Vec<_> = hierarchy.bricks().collect();
    places
        .into_par_iter()
        .zip(bricks)
        .try_for_each(|(brick, cells)| writer.write(brick.level, brick.number, component, 0, &cells.to_vec()))
}

impl Report {
    /// What can be said of any output.
    fn new(
        arguments: &Arguments,
        format: &'static str,
        fields: Vec<String>,
        hierarchy: &Hierarchy,
    ) -> anyhow::Result<Self> {
        let Arguments { path, output, .. } = arguments;
        let levels = hierarchy.levels().iter().enumerate();
        let levels =
            levels.map(|(level, of)| LevelReport { level, bricks: of.bricks().len(), cells: of.cells() }).collect();
        Ok(Self {
            input: path.clone(),
            output: output.clone(),
            format,
            fields,
            levels,
            cells: hierarchy.cells(),
            bytes: AmrFormat::of(output)?.bytes_at(output)?,
            original: None,
            peak_resident_bytes: memory::peak_resident(),
        })
    }
}

fn text(report: &Report) -> String {
    let mut text = String::new();
    write_text(&mut text, report).expect("writing to a string cannot fail");
    text
}

fn write_text(out: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(out, "{}: {}, {}", report.output.display(), report.fields.join(", "), bytes(report.bytes))?;
    writeln!(out, "\nlevel  bricks          cells")?;
    for level in &report.levels {
        writeln!(out, "{:>5} {:>7} {:>14}", level.level, level.bricks, grouped(level.cells))?;
    }
    let bricks = report.levels.iter().map(|level| level.bricks).sum::<usize>();
    writeln!(out, "  all {bricks:>7} {:>14}", grouped(report.cells))?;
    if let Some(original) = &report.original {
        let [x, y, z] = original.size;
        writeln!(
            out,
            "\n{} {x} x {y} x {z}: {} samples, {}",
            report.format,
            grouped(original.cells),
            bytes(original.bytes)
        )?;
        let [cells, bytes] = [original.cells_share, original.bytes_share].map(|share| 100.0 * share);
        writeln!(out, "kept: {cells:.1} % of the cells, {bytes:.1} % of the bytes")?;
        let Original { max_error, mean_error, threshold, .. } = original;
        writeln!(
            out,
            "error at the samples: {max_error:.6e} at most, {mean_error:.6e} on average (threshold {threshold})"
        )?;
    }
    Ok(())
}

/// An output that is the input under whatever name would be gone when it is complete.
fn refuse_overwriting(input: &Path, output: &Path) -> anyhow::Result<()> {
    let same = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    // Images of VTK data lie in a directory of the index's name, whose place the output's would take.
    let [of_input, of_output] = [input, output].map(|path| path.with_extension(""));
    let images = AmrFormat::of(output)? == AmrFormat::Vthb && of_input.is_dir() && same(&of_input, &of_output);
    match same(input, output) || images {
        true => Err(anyhow::anyhow!("{}: this is the input, expected another name", output.display())),
        false => Ok(()),
    }
}

fn output_path(path: PathBuf) -> Result<PathBuf, String> {
    AmrFormat::of(&path).map(|_| path).map_err(|error| error.to_string())
}

fn dims(text: &str) -> Result<[u64; 3], String> {
    let counts: Option<Vec<u64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    let counts: Option<[u64; 3]> = counts.and_then(|counts| counts.try_into().ok());
    counts.filter(|counts| !counts.contains(&0)).ok_or_else(|| "expected three counts such as 512,512,256".into())
}

fn number_type(text: &str) -> Result<NumberType, String> {
    NumberType::ALL.into_iter().find(|number| number.name() == text).ok_or_else(|| {
        let names: Vec<&str> = NumberType::ALL.iter().map(|number| number.name()).collect();
        format!("expected one of {}", names.join(", "))
    })
}
