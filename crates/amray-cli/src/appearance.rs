//! How values look: from the flags, or from the data where a flag is not given.

use std::path::{Path, PathBuf};

use amray::Volume;
use amray::appearance::{ColorMap, RangeError, TransferFunction, UnknownColorMap};
use amray::scene::{Look, LookError};
use anyhow::bail;
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::data::DataArguments;
use crate::json_file;
use crate::number;
use crate::progress::with_spinner;
use crate::scene_file::{Curves, checked};

/// Colours and opacities.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct AppearanceArguments {
    /// A colour map, or a transfer function as JSON: ParaView's presets or amray's own points
    #[arg(long, value_name = "NAME|FILE.json", value_parser = source)]
    #[serde(skip_serializing_if = "Option::is_none")]
    tf: Option<Source>,
    /// The values that the colour map spans [default: what has structure]
    #[arg(long, value_name = "LOW,HIGH", value_parser = number::range, allow_hyphen_values = true)]
    #[serde(deserialize_with = "checked::range", skip_serializing_if = "Option::is_none")]
    range: Option<[f64; 2]>,
    /// Logarithmic colours and opacities
    #[arg(long)]
    log: bool,
}

/// What `--tf` names.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "serde_json::Value", into = "Kept")]
#[schemars(with = "Kept")]
enum Source {
    Map(ColorMap),
    File(PathBuf),
    Points(TransferFunction),
}

/// How scene files keep it.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Kept {
    /// A colour map's name, or the path of a file: relative to the scene file.
    Name(String),
    Curves(Curves),
    /// What a transfer function file has in it.
    #[expect(dead_code, reason = "read, and told by the schema, but written as curves")]
    File(serde_json::Map<String, serde_json::Value>),
}

impl From<Source> for Kept {
    fn from(source: Source) -> Self {
        match source {
            Source::Map(map) => Self::Name(map.to_string()),
            Source::File(path) => Self::Name(path.to_string_lossy().into_owned()),
            Source::Points(function) => Self::Curves((&function).into()),
        }
    }
}

impl TryFrom<serde_json::Value> for Source {
    type Error = String;

    fn try_from(value: serde_json::Value) -> Result<Self, String> {
        match value {
            serde_json::Value::String(name) => source(&name).map_err(|error| error.to_string()),
            value if value.get("colors").is_some() => {
                let curves: Curves = serde_json::from_value(value).map_err(|error| error.to_string())?;
                curves.function().map(Self::Points)
            }
            value => {
                let function = TransferFunction::from_json(&value.to_string(), None);
                function.map(Self::Points).map_err(|error| error.to_string())
            }
        }
    }
}

fn source(name: &str) -> Result<Source, UnknownColorMap> {
    match name.to_lowercase().ends_with(".json") {
        true => Ok(Source::File(name.into())),
        false => name.parse().map(Source::Map),
    }
}

impl AppearanceArguments {
    /// Exactly this function.
    pub(crate) fn of(function: TransferFunction) -> Self {
        Self { tf: Some(Source::Points(function)), range: None, log: false }
    }

    /// What `--tf` and `--range` would say.
    pub(crate) fn named(function: Option<&str>, range: Option<[f64; 2]>) -> Result<Self, String> {
        let tf = function.map(source).transpose().map_err(|error| error.to_string())?;
        Ok(Self { tf, range, log: false })
    }

    /// This appearance or, where nothing of it is given, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        if self.tf.is_some() || self.range.is_some() || self.log { self } else { others }
    }

    /// The transfer function's file.
    pub(crate) fn path_mut(&mut self) -> Option<&mut PathBuf> {
        match &mut self.tf {
            Some(Source::File(path)) => Some(path),
            Some(Source::Map(_) | Source::Points(_)) | None => None,
        }
    }

    /// The transfer function for `volume`, which is of `data`: the flags', the rest from its leaf cells.
    pub(crate) fn transfer_function(&self, data: &DataArguments, volume: &Volume) -> anyhow::Result<TransferFunction> {
        let choose = |look: Look| with_spinner("histogram", || look.transfer_function(volume));
        let field = volume.field().name();
        self.chosen(choose, |error| data.error(format!("field {field}: {error}")))
    }

    /// The colours alone, for pictures in which every value is opaque; `values` are those shown of `data`, `place` tells
    /// where they are.
    pub(crate) fn colors(&self, data: &DataArguments, place: &str, values: &[f64]) -> anyhow::Result<TransferFunction> {
        self.chosen(|look| look.colors(values), |error| data.error(format!("{place}: {error}")))
    }

    /// The function that `--tf` names, or that `choose` finds for the look that the flags describe.
    fn chosen(
        &self,
        choose: impl FnOnce(Look) -> Result<TransferFunction, LookError>,
        wrong: impl FnOnce(LookError) -> anyhow::Error,
    ) -> anyhow::Result<TransferFunction> {
        let color_map = match &self.tf {
            Some(Source::File(path)) => return self.of_file(path),
            Some(Source::Points(function)) => return Ok(self.stretched(function)?),
            Some(Source::Map(map)) => Some(*map),
            None => None,
        };
        choose(Look { color_map, range: self.range, log: self.log }).map_err(wrong)
    }

    /// A file's function says its own scale and values; `--range` stretches it.
    fn of_file(&self, path: &Path) -> anyhow::Result<TransferFunction> {
        if self.log {
            bail!("--log applies to colour maps; a transfer function file says its own scale (\"scale\": \"log10\")");
        }
        json_file::read(path, "the transfer function", |json| {
            let function = TransferFunction::from_json(json, None).map_err(|error| error.to_string())?;
            self.stretched(&function).map_err(|error| error.to_string())
        })
    }

    /// A function over the range that is asked for.
    fn stretched(&self, function: &TransferFunction) -> Result<TransferFunction, RangeError> {
        match self.range {
            Some(range) => function.rescaled(range),
            None => Ok(function.clone()),
        }
    }
}
