//! From the command line to a volume: which data, which field, which reconstruction.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use amray::Volume;
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{DataSet, OpenOptions, find_field, open};
use clap::Args;

use crate::note;
use crate::progress::with_progress;

/// Which data to open.
#[derive(Debug, Args)]
pub(crate) struct DataArguments {
    /// A Chombo HDF5 file, or an AMReX plotfile (the directory or its Header)
    pub(crate) path: PathBuf,
    /// As if levels finer than K did not exist
    #[arg(long, value_name = "K")]
    pub(crate) max_level: Option<usize>,
}

/// Which field to look at, and how its cells become a continuous function.
#[derive(Debug, Args)]
pub(crate) struct VolumeArguments {
    #[command(flatten)]
    pub(crate) data: DataArguments,
    /// The field to show [default: the first]
    #[arg(long, value_name = "NAME")]
    pub(crate) field: Option<String>,
    /// Reconstruction: nearest, finest, current, blend, basis, octant or prolong
    #[arg(long, default_value_t)]
    pub(crate) method: Method,
    /// Let covered cells take the mean of the finer ones
    #[arg(long)]
    pub(crate) restrict: bool,
}

/// A volume, and how long it took to get it.
pub(crate) struct Opened {
    pub(crate) volume: Volume,
    /// Seconds to open the files and read or map the field.
    pub(crate) open_seconds: f64,
    /// Seconds to build the index and its value ranges.
    pub(crate) index_seconds: f64,
}

impl DataArguments {
    /// Opens the data set and says on standard error what is unusual about it.
    pub(crate) fn open(&self) -> anyhow::Result<Box<dyn DataSet>> {
        let data = open(&self.path, &OpenOptions { max_level: self.max_level })?;
        for warning in warnings(&*data) {
            note(&format!("amray: warning: {}: {warning}", self.path.display()));
        }
        Ok(data)
    }

    /// The name of the data set without its ending: what pictures of it are called.
    pub(crate) fn stem(&self) -> String {
        // A plotfile may be opened by its Header, but is called by its directory.
        let named = if self.path.file_name().is_some_and(|name| name == "Header") {
            self.path.parent().filter(|parent| parent.file_name().is_some())
        } else {
            None
        };
        let path: &Path = named.unwrap_or(&self.path);
        let name = path.file_name().map_or_else(|| "amray".into(), |name| name.to_string_lossy().into_owned());
        let without = [".hdf5", ".h5"].iter().find_map(|ending| name.strip_suffix(ending));
        without.map_or(name.clone(), str::to_owned)
    }
}

/// What is unusual about a data set, a line each.
pub(crate) fn warnings(data: &dyn DataSet) -> Vec<String> {
    let of_hierarchy = data.hierarchy().warnings().iter().map(ToString::to_string);
    data.warnings().iter().cloned().chain(of_hierarchy).collect()
}

impl VolumeArguments {
    /// Opens the data set, reads the field and builds the index.
    pub(crate) fn open(&self) -> anyhow::Result<Opened> {
        let start = Instant::now();
        let data = self.data.open()?;
        let number = match &self.field {
            Some(name) => find_field(&self.data.path, data.fields(), name)?,
            None if data.fields().is_empty() => anyhow::bail!("{}: there is no field", self.data.path.display()),
            None => 0,
        };
        let mut field = with_progress("reading", |progress| data.read_field(number, progress))?;
        if self.restrict {
            field = field.restricted(data.hierarchy());
        }
        let open_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let index = Arc::new(Index::build(data.hierarchy().clone()));
        let volume = Volume::new(index, field, self.method);
        Ok(Opened { volume, open_seconds, index_seconds: start.elapsed().as_secs_f64() })
    }
}
