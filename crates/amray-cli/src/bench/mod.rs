//! `amray bench`: both engines on the user's data, as in the paper's Table 1.

mod arguments;
mod frames;
mod looks;
mod quality;
mod report;
mod table;
mod transfer_functions;

use std::sync::Arc;
use std::time::Instant;

use amray::Volume;
use amray::hierarchy::Field;
use amray::index::Index;
use amray::reconstruction::Method;
use amray::render::{Engine, RenderOptions, RenderStatistics};
use amray::scene::Scene;
use amray_formats::DataSet;

use crate::data::warnings;
use crate::progress::{with_progress, with_spinner};
use crate::sampling::LayoutName;
use crate::stage::SIZE;
use crate::{note, print, print_json};
pub(crate) use arguments::Arguments;
use frames::{Frames, Pool};
use looks::{Look, Views};
use report::{DataReport, IndexReport, MachineReport, Report, Row};

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let report = measure(arguments)?;
    match arguments.json {
        true => print_json(&report),
        false => Ok(print(&table::text(&report))?),
    }
}

/// A data set with its index, as if finer levels than some did not exist.
struct Truncated {
    data: Box<dyn DataSet>,
    index: Arc<Index>,
    index_seconds: f64,
    field: Field,
}

impl Truncated {
    fn open(arguments: &Arguments, views: &Views, max_level: Option<usize>) -> anyhow::Result<Self> {
        let source = arguments.data(max_level);
        let data = source.open()?;
        let field = source.read_field(&*data, arguments.field.as_deref().or(views.field()), &|field| field)?;
        let start = Instant::now();
        let index = with_spinner("indexing", || Arc::new(Index::build(data.hierarchy().clone())));
        Ok(Self { data, index, index_seconds: start.elapsed().as_secs_f64(), field })
    }

    fn volume(&self, method: Method) -> Volume {
        Volume::new(self.index.clone(), self.field.clone(), method)
    }
}

fn measure(arguments: &Arguments) -> anyhow::Result<Report> {
    let views = Views::read(&arguments.views)?;
    let whole = Truncated::open(arguments, &views, None)?;
    for warning in warnings(&*whole.data) {
        note(&format!("amray: warning: {}: {warning}", arguments.path.display()));
    }
    let size = arguments.size.or(views.size()).unwrap_or(SIZE);
    let looks = with_spinner("histogram", || views.looks(&whole.volume(Method::Nearest), size))
        .map_err(|error| arguments.data(None).error(format!("field {}: {error}", whole.field.name())))?;
    let finest = whole.data.hierarchy().finest_level();
    let levels = arguments.levels(finest)?;
    let pools = arguments.threads().into_iter().map(Pool::new).collect::<anyhow::Result<Vec<Pool>>>()?;
    let methods = arguments.methods();
    let mut rows = Vec::new();
    let count = levels.len() * methods.len() * looks.len() * pools.len();
    with_progress("measuring", |progress| -> anyhow::Result<()> {
        for &level in &levels {
            let opened;
            let truncated = if level == finest {
                &whole
            } else {
                opened = Truncated::open(arguments, &views, Some(level))?;
                &opened
            };
            for &method in &methods {
                let volume = truncated.volume(method);
                let layout = arguments.layout.layout(&volume, 1, arguments.memory);
                let start = Instant::now();
                volume.prepare(layout);
                let prepare_seconds = start.elapsed().as_secs_f64();
                for look in &looks {
                    let options = RenderOptions { size, engine: Engine::March(layout), ..RenderOptions::default() };
                    let measured = Measured { volume: &volume, look, options, level, prepare_seconds };
                    rows.extend(measured.rows(&pools, arguments.repeat.into()));
                    progress(rows.len() as f64 / count as f64);
                }
            }
        }
        Ok(())
    })?;
    // A table is about a transfer function; its rows are methods, its columns levels.
    let look = |row: &Row| looks.iter().position(|look| look.name == row.transfer_function);
    let method = |row: &Row| methods.iter().position(|method| method.name() == row.method);
    rows.sort_by_key(|row| (look(row), method(row), row.max_level));
    Ok(Report {
        data: DataReport::new(&arguments.path, &*whole.data, &whole.field, &whole.index),
        machine: MachineReport::of_this(),
        size,
        repeat: arguments.repeat,
        rows,
        index: IndexReport {
            bytes: whole.index.bytes(),
            seconds: whole.index_seconds,
            regions: whole.index.regions().len(),
        },
    })
}

/// One volume as it looks under one transfer function.
struct Measured<'a> {
    volume: &'a Volume,
    look: &'a Look,
    /// Those of marching.
    options: RenderOptions,
    level: usize,
    prepare_seconds: f64,
}

impl Measured<'_> {
    /// A row for each number of threads.
    fn rows(&self, pools: &[Pool], repeat: usize) -> Vec<Row> {
        let march = self.options;
        let query = RenderOptions { engine: Engine::Query, ..march };
        let every_cell = RenderOptions { adaptive: false, ..march };
        let function = self.look.transfer_function.clone();
        let scene = Scene::new(self.volume, function, self.look.unit_distance, self.look.camera);
        let [march_psnr, query_psnr] = quality::psnr(&scene, [march, query]);
        let row = |pool: &Pool| {
            let [march, query, every_cell] = pool.alternate(&scene, [march, query, every_cell], repeat);
            let RenderStatistics { rays, samples, interior_samples, ray_length, skipped_length, .. } = march.statistics;
            Row {
                transfer_function: self.look.name.clone(),
                method: self.volume.method().name(),
                max_level: self.level,
                threads: pool.threads(),
                layout: LayoutName::from(self.options.engine),
                prepare_seconds: self.prepare_seconds,
                march_fps: march.per_second(1),
                query_fps: query.per_second(1),
                ratio: query.seconds / march.seconds,
                ratio_same_samples: query.seconds / every_cell.seconds,
                march_psnr,
                query_psnr,
                samples_per_ray: share(samples as f64, rays as f64),
                interior_share: share(interior_samples as f64, samples as f64),
                skipped_share: share(skipped_length, ray_length),
                march_msamples_per_s: megasamples(&march),
                query_msamples_per_s: megasamples(&query),
            }
        };
        pools.iter().map(row).collect()
    }
}

fn megasamples(frames: &Frames) -> f64 {
    frames.per_second(frames.statistics.samples) / 1e6
}

/// A part of a whole; nothing of nothing.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}
