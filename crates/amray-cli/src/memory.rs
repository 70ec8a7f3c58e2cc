//! How much memory the process takes, where the system tells, and how much of it data may take.

use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use amray::hierarchy::{Field, ValueBuffer};
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::number;

/// How much memory data may take. No part of a scene: machines differ.
#[derive(Clone, Copy, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
pub(crate) struct MemoryArguments {
    /// The most memory that values may take, such as 4G or 500M: larger ones stay in their files, or, where they must be
    /// read, go into a scratch file (in TMPDIR) [default: half of what is available]
    #[arg(long, value_name = "SIZE", value_parser = number::memory)]
    #[serde(skip)]
    memory: Option<u64>,
}

impl MemoryArguments {
    /// The most bytes of values.
    pub(crate) fn most(self) -> u64 {
        // Where the system does not tell, what every computer has to spare.
        self.memory.unwrap_or_else(|| available().map_or(1 << 30, |bytes| bytes / 2))
    }

    /// Half of it.
    pub(crate) fn half(self) -> Self {
        Self { memory: self.memory.map(|bytes| bytes / 2) }
    }

    /// Whatever is said here, else by `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self { memory: self.memory.or(others.memory) }
    }

    /// Sees to it, as long as the result lives, that a field's mapped files take no more memory than was asked for.
    pub(crate) fn watch(self, field: &Field) -> Option<Watch> {
        self.memory.map(|most| Watch::start(field, most))
    }
}

/// Gives pages of mapped files back when they take too much memory. The system does the same, but only when there is
/// none left for anybody.
pub(crate) struct Watch {
    /// Dropped first, which ends the thread.
    ended: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    /// Between two looks.
    const PAUSE: Duration = Duration::from_millis(2);
    /// Less is never asked for: what is being worked on would come and go.
    const LEAST: u64 = 32 << 20;

    fn start(field: &Field, most: u64) -> Self {
        let buffers = field.buffers();
        let (running, ended) = mpsc::channel::<()>();
        let thread = thread::spawn(move || {
            while ended.recv_timeout(Self::PAUSE) == Err(RecvTimeoutError::Timeout) {
                let (Some(mapped), Some(private)) = (mapped(), private()) else { return };
                if mapped > most.saturating_sub(private).max(Self::LEAST) {
                    buffers.iter().for_each(ValueBuffer::release);
                }
            }
        });
        Self { ended: Some(running), thread: Some(thread) }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.ended = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to do.
            let _ = thread.join();
        }
    }
}

/// Bytes in physical memory now.
pub(crate) fn resident() -> Option<u64> {
    of_status("VmRSS:")
}

/// The most bytes that were in physical memory at once.
pub(crate) fn peak_resident() -> Option<u64> {
    of_status("VmHWM:")
}

/// Bytes in physical memory that are the process's own now: mapped files, which the system can drop at any time, are
/// left out.
pub(crate) fn private() -> Option<u64> {
    of_status("RssAnon:")
}

/// Bytes of mapped files that are in physical memory now.
fn mapped() -> Option<u64> {
    of_status("RssFile:")
}

/// Bytes that programs can still get without making the system swap.
pub(crate) fn available() -> Option<u64> {
    line_of("/proc/meminfo", "MemAvailable:")
}

/// A line of Linux's process status (proc(5)), which counts in units of 1024 bytes.
fn of_status(key: &str) -> Option<u64> {
    line_of("/proc/self/status", key)
}

fn line_of(path: &str, key: &str) -> Option<u64> {
    let status = std::fs::read_to_string(path).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|count| count * 1024)
}
