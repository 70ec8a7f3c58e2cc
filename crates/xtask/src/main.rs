//! Tasks around the project: `cargo xtask gallery`.

mod figures;
mod gallery;

use clap::{Parser, Subcommand};

/// Tasks around amray.
#[derive(Parser)]
#[command(name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Render figures after the paper's and of what else there is, with their commands, into a folder
    Gallery(gallery::Arguments),
}

fn main() -> anyhow::Result<()> {
    match Arguments::parse().task {
        Task::Gallery(arguments) => gallery::run(&arguments),
    }
}
