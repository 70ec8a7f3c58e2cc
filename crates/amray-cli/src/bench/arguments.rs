//! What is measured, and how often.

use std::path::PathBuf;

use amray::reconstruction::Method;
use clap::Args;

use super::frames::Threads;
use crate::data::DataArguments;
use crate::memory::MemoryArguments;
use crate::number;
use crate::sampling::LayoutArguments;
use crate::view_file::ViewName;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A data set: a file or a directory, of any format that amray reads
    pub(super) path: PathBuf,
    /// The field to show [default: that of the view, or the first]
    #[arg(long, value_name = "NAME")]
    pub(super) field: Option<String>,
    /// Reconstructions, separated by commas [default: all]
    #[arg(long = "method", value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<Method>,
    /// As if levels finer than K did not exist, for each K, separated by commas [default: each level]
    #[arg(long = "max-level", value_name = "K,...", value_delimiter = ',')]
    max_levels: Vec<usize>,
    /// Numbers of threads, separated by commas; all is what --threads says
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_value = "1,all")]
    thread_counts: Vec<Threads>,
    /// A camera and a transfer function from a file of views, in place of those that follow from the data; repeatable
    #[arg(long = "view", value_name = "FILE:NAME:TF")]
    pub(super) views: Vec<ViewName>,
    /// Pixels [default: those of the first view, or 1024x1024]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = number::size)]
    pub(super) size: Option<[usize; 2]>,
    /// Frames of each engine, after a warm-up; the median counts
    #[arg(long, value_name = "N", default_value = "5", value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) repeat: u16,
    #[command(flatten)]
    pub(super) layout: LayoutArguments,
    #[command(flatten)]
    pub(super) memory: MemoryArguments,
    /// Print one JSON object
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    pub(super) fn data(&self, max_level: Option<usize>) -> DataArguments {
        DataArguments { path: self.path.clone(), max_level, memory: self.memory }
    }

    pub(super) fn methods(&self) -> Vec<Method> {
        if self.methods.is_empty() { Method::ALL.to_vec() } else { distinct(&self.methods) }
    }

    /// Numbers of threads.
    pub(super) fn threads(&self) -> Vec<usize> {
        distinct(&self.thread_counts.iter().map(|threads| threads.count()).collect::<Vec<usize>>())
    }

    /// The finest levels to measure of data whose finest one is `finest`.
    pub(super) fn levels(&self, finest: usize) -> anyhow::Result<Vec<usize>> {
        if let Some(level) = self.max_levels.iter().find(|level| **level > finest) {
            return Err(self.data(None).error(format!("--max-level {level}: the finest level is {finest}")));
        }
        Ok(if self.max_levels.is_empty() { (0..=finest).collect() } else { distinct(&self.max_levels) })
    }
}

/// The first of each of some equal things.
fn distinct<T: Clone + PartialEq>(things: &[T]) -> Vec<T> {
    let first = |(place, thing): &(usize, &T)| !things[..*place].contains(thing);
    things.iter().enumerate().filter(first).map(|(_, thing)| thing.clone()).collect()
}
