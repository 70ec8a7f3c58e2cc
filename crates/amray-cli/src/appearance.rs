//! How values look: from the flags, or from the data where a flag is not given.

use std::path::{Path, PathBuf};

use amray::Volume;
use amray::appearance::{
    ColorMap, Histogram, Opacity, OpacityPoint, Scale, TransferFunction, UnknownColorMap, automatic,
};
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
    /// The transfer function for `volume`, which is of `data`: the flags', the rest from the histogram of its leaf
    /// cells.
    pub(crate) fn transfer_function(&self, data: &DataArguments, volume: &Volume) -> anyhow::Result<TransferFunction> {
        let map = match &self.tf {
            Some(Source::File(path)) => return self.of_file(path),
            Some(Source::Map(map)) => Some(*map),
            None => None,
        };
        let Some(whole) = with_spinner("value range", || volume.leaf_range()) else {
            let problem = format!("field {}: no finite value to choose colours for", volume.field().name());
            return Err(data.error(problem));
        };
        let scale = if self.log { Scale::Log10 } else { self.default_scale(whole) };
        let span = self.histogram_range(volume, whole, scale).map_err(|problem| data.error(problem))?;
        let empty = Histogram::new(span[0], span[1], scale, automatic::HISTOGRAM_BINS);
        let empty = empty.map_err(|error| data.error(error))?;
        let histogram = with_spinner("histogram", || histogram(volume, &empty));
        let range = self.range.unwrap_or_else(|| automatic::range(&histogram));
        let opacity = automatic::opacity(&histogram, range);
        let map = map.unwrap_or_else(|| automatic::color_map(range));
        TransferFunction::from_color_map(map, range, scale, opacity).map_err(|error| data.error(error))
    }

    /// The colours alone, for pictures in which every value is opaque; `values` are those shown of `data`.
    pub(crate) fn colors(&self, data: &DataArguments, values: &[f64]) -> anyhow::Result<TransferFunction> {
        let map = match &self.tf {
            Some(Source::File(path)) => return self.of_file(path),
            Some(Source::Map(map)) => Some(*map),
            None => None,
        };
        let usable = |value: &f64| value.is_finite() && !(self.log && *value <= 0.0);
        let shown = values.iter().copied().filter(usable);
        let whole = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        if whole[0] > whole[1] {
            let positive = if self.log { " positive" } else { "" };
            return Err(data.error(format!("no finite{positive} value on the slice")));
        }
        let range = self.range.unwrap_or_else(|| widened(whole));
        let map = map.unwrap_or_else(|| automatic::color_map(range));
        let scale = if self.log { Scale::Log10 } else { self.default_scale(whole) };
        let opacity = Opacity::PerUnitDistance(vec![OpacityPoint { value: range[0], opacity: 1.0 }]);
        TransferFunction::from_color_map(map, range, scale, opacity).map_err(|error| data.error(error))
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

    /// A range that was asked for is shown as it was asked for: linear.
    fn default_scale(&self, [low, high]: [f64; 2]) -> Scale {
        if self.range.is_some() { Scale::Linear } else { automatic::scale(low, high) }
    }

    fn histogram_range(&self, volume: &Volume, whole: [f64; 2], scale: Scale) -> Result<[f64; 2], String> {
        if let Some(range) = self.range {
            return Ok(range);
        }
        let [mut low, high] = whole;
        if scale == Scale::Log10 && low <= 0.0 {
            if high <= 0.0 {
                let name = volume.field().name();
                return Err(format!("--log needs positive values; field {name} reaches {high} at most"));
            }
            low = with_spinner("value range", || smallest_positive(volume));
        }
        Ok(widened([low, high]))
    }
}

/// The volume-weighted histogram of the leaf cells.
fn histogram(volume: &Volume, empty: &Histogram) -> Histogram {
    volume.fold_leaf_cells(
        || empty.clone(),
        |histogram, cell| histogram.add(cell.value, cell.volume),
        |mut sum, part| {
            sum.merge(&part);
            sum
        },
    )
}

fn smallest_positive(volume: &Volume) -> f64 {
    volume.fold_leaf_cells(
        || f64::INFINITY,
        |smallest, cell| {
            if cell.value > 0.0 {
                *smallest = smallest.min(cell.value);
            }
        },
        f64::min,
    )
}

/// A range that is one value gets some width, so that it has a place in it.
fn widened([low, high]: [f64; 2]) -> [f64; 2] {
    if low < high {
        return [low, high];
    }
    let width = if low == 0.0 { 1.0 } else { low.abs() * 1e-3 };
    [low - width, high + width]
}
