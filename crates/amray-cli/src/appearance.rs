//! How values look: from the flags, or from the data where a flag is not given.

use std::path::{Path, PathBuf};

use amray::Volume;
use amray::appearance::{ColorMap, TransferFunction, UnknownColorMap};
use amray::scene::{Look, LookError};
use anyhow::bail;
use clap::Args;

use crate::data::DataArguments;
use crate::number;
use crate::progress::with_spinner;

/// Colours and opacities.
#[derive(Debug, Default, Args)]
pub(crate) struct AppearanceArguments {
    /// A colour map, or a transfer function as JSON: ParaView's presets or amray's own points
    #[arg(long, value_name = "NAME|FILE.json", value_parser = source)]
    tf: Option<Source>,
    /// The values that the colour map spans [default: what has structure]
    #[arg(long, value_name = "LOW,HIGH", value_parser = number::range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// Logarithmic colours and opacities
    #[arg(long)]
    log: bool,
}

/// What `--tf` names.
#[derive(Clone, Debug)]
enum Source {
    Map(ColorMap),
    File(PathBuf),
}

fn source(name: &str) -> Result<Source, UnknownColorMap> {
    match name.to_lowercase().ends_with(".json") {
        true => Ok(Source::File(name.into())),
        false => name.parse().map(Source::Map),
    }
}

impl AppearanceArguments {
    /// Whether any flag says how values look.
    pub(crate) fn is_given(&self) -> bool {
        self.tf.is_some() || self.range.is_some() || self.log
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
        let name = path.display();
        let json = std::fs::read_to_string(path)
            .map_err(|error| anyhow::anyhow!("{name}: cannot read the transfer function: {error}"))?;
        let function = TransferFunction::from_json(&json, None).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
        match self.range {
            Some(range) => function.rescaled(range).map_err(|error| anyhow::anyhow!("{name}: {error}")),
            None => Ok(function),
        }
    }
}
