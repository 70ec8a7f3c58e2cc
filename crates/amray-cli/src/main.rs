//! The program `amray`: pictures of AMR simulation data from the command line.

mod annotations;
mod appearance;
mod bench;
mod clips;
mod convert;
mod data;
mod demo;
mod fields;
mod info;
mod json_file;
mod lighting;
mod memory;
mod mode;
mod movie;
mod number;
mod progress;
mod project;
mod render;
mod sample;
mod sampling;
mod scene_file;
mod series;
mod slice;
mod stage;
mod surfaces;
mod value_picture;
mod view;
mod view_file;

use std::io::{self, Write};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use serde::Serialize;

/// Shows adaptive-mesh-refinement (AMR) simulation data directly, without resampling it.
#[derive(Debug, Parser)]
#[command(name = "amray", version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Threads to use [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a demo data set and a picture of it
    Demo(demo::Arguments),
    /// Levels, bricks, cells, fields and their ranges
    Info(info::Arguments),
    /// One picture of the volume
    Render(Box<render::Arguments>),
    /// A movie: a camera that moves, time steps, or both
    Movie(Box<movie::Arguments>),
    /// A slice across an axis, with a colour bar
    Slice(slice::Arguments),
    /// Values along rays: column densities, averages, maxima, minima
    Project(project::Arguments),
    /// The JSON schema of scene files
    Schema,
    /// Values at given points
    Sample(sample::Arguments),
    /// From any readable format to another, and from structured volumes to AMR data
    Convert(convert::Arguments),
    /// Frames per second of both engines, per method, level and number of threads
    Bench(bench::Arguments),
}

fn main() -> ExitCode {
    // Wrong usage ends here with exit code 2.
    let arguments = Arguments::parse();
    match run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // One line, whatever a library's message looks like.
            let message = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
            // Nothing is left to be done where standard error is closed.
            let _ = writeln!(io::stderr(), "amray: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> anyhow::Result<()> {
    if let Some(threads) = arguments.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    match arguments.command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Movie(arguments) => movie::run(&arguments),
        Command::Slice(arguments) => slice::run(&arguments),
        Command::Project(arguments) => project::run(&arguments),
        Command::Schema => Ok(print(&scene_file::schema())?),
        Command::Sample(arguments) => sample::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
    }
}

/// Prints to standard output; a reader that has gone away (`amray info | head`) is no failure.
fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}

/// Prints a value as one line of JSON.
fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    Ok(print(&(serde_json::to_string(value)? + "\n"))?)
}

/// Prints to standard error what does not belong to the output.
fn note(text: &str) {
    // A closed standard error must not end the work.
    let _ = writeln!(io::stderr(), "{text}");
}
