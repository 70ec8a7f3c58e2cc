//! What `amray bench --json` prints.

use std::fs;
use std::path::{Path, PathBuf};

use amray::hierarchy::Field;
use amray::index::Index;
use amray::simd::InstructionSet;
use amray_formats::DataSet;
use serde::Serialize;

use crate::sampling::LayoutName;

#[derive(Serialize)]
pub(super) struct Report {
    pub(super) data: DataReport,
    pub(super) machine: MachineReport,
    pub(super) size: [usize; 2],
    /// Frames that a median is of.
    pub(super) repeat: u16,
    pub(super) rows: Vec<Row>,
    /// Of all levels.
    pub(super) index: IndexReport,
}

#[derive(Serialize)]
pub(super) struct DataReport {
    pub(super) path: PathBuf,
    pub(super) format: &'static str,
    pub(super) field: String,
    pub(super) levels: usize,
    pub(super) bricks: usize,
    pub(super) cells: u64,
    pub(super) leaf_cells: u64,
    /// Of all cells' values.
    pub(super) bytes: u64,
}

#[derive(Serialize)]
pub(super) struct MachineReport {
    /// Null where the system does not tell.
    pub(super) processor: Option<String>,
    pub(super) instructions: &'static str,
    /// That the program may use.
    pub(super) threads: usize,
    /// Of amray.
    pub(super) version: &'static str,
}

/// One transfer function, method, finest level and number of threads.
#[derive(Serialize)]
pub(super) struct Row {
    pub(super) transfer_function: String,
    pub(super) method: &'static str,
    pub(super) max_level: usize,
    pub(super) threads: usize,
    /// What was marched through.
    pub(super) layout: LayoutName,
    /// To lay values out for marching.
    pub(super) prepare_seconds: f64,
    /// Medians.
    pub(super) march_fps: f64,
    pub(super) query_fps: f64,
    /// How many times faster marching is.
    pub(super) ratio: f64,
    /// The same where marching, too, samples every cell.
    pub(super) ratio_same_samples: f64,
    /// Against converged pictures of the same method; null where there is no difference.
    pub(super) march_psnr: Option<f64>,
    pub(super) query_psnr: Option<f64>,
    /// Of marching, like the shares.
    pub(super) samples_per_ray: f64,
    /// Of the samples, those that came from one brick alone.
    pub(super) interior_share: f64,
    /// Of the rays' length inside the domain, what was passed over.
    pub(super) skipped_share: f64,
    pub(super) march_msamples_per_s: f64,
    pub(super) query_msamples_per_s: f64,
}

#[derive(Serialize)]
pub(super) struct IndexReport {
    pub(super) bytes: u64,
    /// To build it.
    pub(super) seconds: f64,
    pub(super) regions: usize,
}

impl DataReport {
    pub(super) fn new(path: &Path, data: &dyn DataSet, field: &Field, index: &Index) -> Self {
        let hierarchy = data.hierarchy();
        Self {
            path: path.into(),
            format: data.format(),
            field: field.name().into(),
            levels: hierarchy.levels().len(),
            bricks: hierarchy.brick_count(),
            cells: hierarchy.cells(),
            leaf_cells: index.leaf_cells().iter().sum(),
            bytes: hierarchy.cells() * field.voxel_type().bytes() as u64,
        }
    }
}

impl MachineReport {
    pub(super) fn of_this() -> Self {
        Self {
            processor: processor(),
            instructions: InstructionSet::best().name(),
            threads: rayon::current_num_threads(),
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// The processor's name, as Linux has it (proc(5)).
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
