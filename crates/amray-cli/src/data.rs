//! From the command line to a volume: which data, which field, which reconstruction.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use amray::Volume;
use amray::hierarchy::Field;
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{DataSet, OpenOptions, open, read_named};
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::{MemoryArguments, Watch};
use crate::note;
use crate::progress::{with_progress, with_spinner};
use crate::scene_file::checked;

/// Which data to open.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct DataArguments {
    /// A data set: a file or a directory, of any format that amray reads
    pub(crate) path: PathBuf,
    /// As if levels finer than K did not exist
    #[arg(long, value_name = "K")]
    pub(crate) max_level: Option<usize>,
    #[command(flatten)]
    pub(crate) memory: MemoryArguments,
}

/// A volume of a data set.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct VolumeArguments {
    /// A data set: a file or a directory, of any format that amray reads
    path: PathBuf,
    #[command(flatten)]
    section: DataSection,
}

/// Which field to look at, and how its cells become a continuous function.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct DataSection {
    /// A data set: a file or a directory, of any format that amray reads; relative to the scene file.
    #[arg(skip)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) path: Option<PathBuf>,
    /// The field to show, or an expression over fields [default: the first]
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) field: Option<String>,
    /// As if levels finer than K did not exist
    #[arg(long, value_name = "K")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) max_level: Option<usize>,
    /// Reconstruction: nearest, finest, current, blend, basis, octant or prolong [default: basis]
    #[arg(long)]
    #[serde(with = "checked::name", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub(crate) method: Option<Method>,
    /// Let covered cells take the mean of the finer ones
    #[arg(long)]
    pub(crate) restrict: bool,
    #[command(flatten)]
    #[serde(skip)]
    pub(crate) memory: MemoryArguments,
}

impl DataSection {
    /// This section, and where it leaves something open, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            path: self.path.or(others.path),
            field: self.field.or(others.field),
            max_level: self.max_level.or(others.max_level),
            method: self.method.or(others.method),
            restrict: self.restrict || others.restrict,
            memory: self.memory.or(others.memory),
        }
    }

    /// The volume that is asked for; none where no data are named.
    pub(crate) fn volume(&self) -> Option<VolumeArguments> {
        Some(VolumeArguments { path: self.path.clone()?, section: self.clone() })
    }
}

/// A data set without its values, and how long it took to open it.
pub(crate) struct Source {
    data: Box<dyn DataSet>,
    seconds: f64,
}

/// A volume, and how long it took to get it.
pub(crate) struct Opened {
    pub(crate) volume: Volume,
    /// The field's name with its unit.
    pub(crate) title: String,
    data: Box<dyn DataSet>,
    /// Seconds to open the files and read or map the field.
    pub(crate) open_seconds: f64,
    /// Seconds to build the index.
    pub(crate) index_seconds: f64,
    /// Keeps what values take within what was asked for.
    pub(crate) watch: Option<Watch>,
}

impl DataArguments {
    /// Opens the data set.
    pub(crate) fn open(&self) -> anyhow::Result<Box<dyn DataSet>> {
        Ok(open(&self.path, &OpenOptions { max_level: self.max_level, memory: Some(self.memory.most()) })?)
    }

    /// Reads the field called `name`, which may be an expression, or the first one. `prepare` is given each field that is
    /// read, and then what follows from them.
    pub(crate) fn read_field(
        &self,
        data: &dyn DataSet,
        name: Option<&str>,
        prepare: &dyn Fn(Field) -> Field,
    ) -> anyhow::Result<Field> {
        let first = data.fields().first().map(|field| field.name.as_str());
        let name = name.or(first).ok_or_else(|| self.error("there is no field"))?;
        Ok(with_progress("reading", |progress| read_named(&self.path, data, name, prepare, progress))?)
    }

    /// An error that says which data it is about.
    pub(crate) fn error(&self, problem: impl Display) -> anyhow::Error {
        anyhow::anyhow!("{}: {problem}", self.path.display())
    }

    /// The name of the data set without its ending: what pictures of it are called.
    pub(crate) fn stem(&self) -> String {
        let path = absolute(&self.path);
        // A plotfile may be opened by its Header, but is called by its directory.
        let name = match path.parent() {
            Some(parent) if path.file_name().is_some_and(|name| name == "Header") => last_name(parent),
            _ => last_name(&path),
        };
        let name = name.unwrap_or_else(|| "amray".into());
        let without = [".hdf5", ".h5"].iter().find_map(|ending| name.strip_suffix(ending));
        without.map_or(name.clone(), str::to_owned)
    }
}

/// The path as it can be opened from anywhere.
pub(crate) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.into())
}

/// The last name of an absolute path, even if it ends in `..`.
fn last_name(path: &Path) -> Option<String> {
    let path = if path.file_name().is_some() { path.into() } else { path.canonicalize().ok()? };
    Some(path.file_name()?.to_string_lossy().into_owned())
}

/// The unit of a field, where the data set states one.
pub(crate) fn unit_of<'a>(data: &'a dyn DataSet, name: &str) -> Option<&'a str> {
    data.fields().iter().find(|field| field.name == name)?.unit.as_deref()
}

/// A field's name with its unit, such as `density [g/cm^3]`.
pub(crate) fn with_unit(name: &str, unit: Option<&str>) -> String {
    unit.map_or_else(|| name.to_owned(), |unit| format!("{name} [{unit}]"))
}

/// What is unusual about a data set, a line each.
pub(crate) fn warnings(data: &dyn DataSet) -> Vec<String> {
    let of_hierarchy = data.hierarchy().warnings().iter().map(ToString::to_string);
    data.warnings().iter().cloned().chain(of_hierarchy).collect()
}

impl VolumeArguments {
    /// The data set.
    pub(crate) fn data(&self) -> DataArguments {
        DataArguments { path: self.path.clone(), max_level: self.section.max_level, memory: self.section.memory }
    }

    /// The coarse levels, to be looked at while the finer ones are read, where all of them take more memory than they
    /// may: those that take a small part of it.
    pub(crate) fn coarse_part(&self, Source { data, .. }: &Source) -> Option<Self> {
        /// What is small.
        const SHARE: u64 = 16;
        let voxel = data.fields().iter().map(|field| field.voxel_type.bytes() as u64).max().unwrap_or(0);
        let mut bytes = 0;
        let up_to = data.hierarchy().levels().iter().map(|level| {
            bytes += level.cells() * voxel;
            bytes
        });
        let up_to: Vec<u64> = up_to.collect();
        let most = self.section.memory.most();
        if bytes <= most {
            return None;
        }
        let finest = up_to.iter().rposition(|&bytes| bytes <= most / SHARE)?;
        Some(Self { section: DataSection { max_level: Some(finest), ..self.section.clone() }, ..self.clone() })
    }

    /// How much memory values may take.
    pub(crate) fn memory(&self) -> MemoryArguments {
        self.section.memory
    }

    /// Opens the data set without its values.
    pub(crate) fn source(&self) -> anyhow::Result<Source> {
        let start = Instant::now();
        Ok(Source { data: self.data().open()?, seconds: start.elapsed().as_secs_f64() })
    }

    /// Opens the data set, says on standard error what is unusual about it, reads the field and builds the index.
    pub(crate) fn open(&self) -> anyhow::Result<Opened> {
        self.read_from(self.source()?, None)
    }

    /// [`open`](Self::open) of what has been opened without its values. It shares an `index` of the same mesh.
    pub(crate) fn read_from(&self, source: Source, index: Option<Arc<Index>>) -> anyhow::Result<Opened> {
        let start = Instant::now();
        let Source { data, seconds } = source;
        for warning in warnings(&*data) {
            note(&format!("amray: warning: {}: {warning}", self.path.display()));
        }
        let field = self.read(&*data, self.section.field.as_deref())?;
        let watch = self.section.memory.watch(&field);
        let open_seconds = seconds + start.elapsed().as_secs_f64();
        let start = Instant::now();
        let shared = index.filter(|index| index.hierarchy() == data.hierarchy());
        let build = || with_spinner("indexing", || Arc::new(Index::build(data.hierarchy().clone())));
        let index = shared.unwrap_or_else(build);
        let volume = Volume::new(index, field, self.method());
        if volume.method() == Method::Nodal && self.section.method.is_some() {
            let name = volume.field().name();
            note(&format!("amray: warning: {}: {name} is node-centred: --method is left alone", self.path.display()));
        }
        let title = with_unit(volume.field().name(), unit_of(&*data, volume.field().name()));
        Ok(Opened { volume, title, data, open_seconds, index_seconds: start.elapsed().as_secs_f64(), watch })
    }

    /// Another field of a data set that is open.
    pub(crate) fn other_field(&self, opened: &Opened, name: &str) -> anyhow::Result<Volume> {
        let field = self.read(&*opened.data, Some(name))?;
        Ok(Volume::new(opened.volume.index().clone(), field, self.method()))
    }

    fn method(&self) -> Method {
        self.section.method.unwrap_or_default()
    }

    fn read(&self, data: &dyn DataSet, name: Option<&str>) -> anyhow::Result<Field> {
        let prepare = |field: Field| match self.section.restrict {
            true => field.restricted(data.hierarchy()),
            false => field,
        };
        self.data().read_field(data, name, &prepare)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_are_called_by_their_file_or_directory() {
        let stem = |path: &str| DataArguments { path: path.into(), ..DataArguments::default() }.stem();
        assert_eq!(stem("runs/a.hdf5"), "a");
        assert_eq!(stem("a.3d.h5"), "a.3d");
        assert_eq!(stem("plt00100"), "plt00100");
        assert_eq!(stem("runs/plt00100/"), "plt00100");
        assert_eq!(stem("runs/plt00100/Header"), "plt00100");
        // Tests run in the crate's directory.
        for here in [".", "./", "Header", "./Header", "src/..", "src/../Header"] {
            assert_eq!(stem(here), "amray-cli", "{here}");
        }
        assert_eq!(stem("/"), "amray");
    }
}
