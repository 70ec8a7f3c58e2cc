//! How values look: from the flags, or from the data where a flag is not given.

use std::path::PathBuf;

use amray::Volume;
use amray::appearance::{ColorMap, Histogram, Opacity, OpacityPoint, Scale, TransferFunction, automatic};
use anyhow::{Context, bail};
use clap::Args;

use crate::number;

/// Colours and opacities.
#[derive(Debug, Args)]
pub(crate) struct AppearanceArguments {
    /// A colour map, or a transfer function as JSON: ParaView's presets or amray's own points
    #[arg(long, value_name = "NAME|FILE.json")]
    tf: Option<String>,
    /// The values that the colour map spans [default: what has structure]
    #[arg(long, value_name = "LOW,HIGH", value_parser = number::range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// Logarithmic colours and opacities
    #[arg(long)]
    log: bool,
}

/// What `--tf` says.
enum Look {
    Map(Option<ColorMap>),
    Function(TransferFunction),
}

impl AppearanceArguments {
    /// The transfer function for `volume`: the flags', the rest from the histogram of its leaf cells.
    pub(crate) fn transfer_function(&self, volume: &Volume) -> anyhow::Result<TransferFunction> {
        match self.look()? {
            Look::Function(function) => self.fitted(function),
            Look::Map(map) => {
                let Some(whole) = volume.leaf_range() else {
                    bail!("field {}: no finite value to choose colours for", volume.field().name());
                };
                let scale = if self.log { Scale::Log10 } else { self.default_scale(whole) };
                let histogram = histogram(volume, self.histogram_range(volume, whole, scale)?, scale)?;
                let range = self.range.unwrap_or_else(|| automatic::range(&histogram));
                let opacity = automatic::opacity(&histogram, range);
                let map = map.unwrap_or_else(|| automatic::color_map(range));
                Ok(TransferFunction::from_color_map(map, range, scale, opacity)?)
            }
        }
    }

    /// The colours alone, for pictures in which every value is opaque; `values` are those shown.
    pub(crate) fn colors(&self, values: &[f64]) -> anyhow::Result<TransferFunction> {
        let map = match self.look()? {
            Look::Function(function) => return self.fitted(function),
            Look::Map(map) => map,
        };
        let usable = |value: &f64| value.is_finite() && !(self.log && *value <= 0.0);
        let shown = values.iter().copied().filter(usable);
        let whole = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        if whole[0] > whole[1] {
            bail!("no finite{} value on the slice", if self.log { " positive" } else { "" });
        }
        let range = self.range.unwrap_or_else(|| widened(whole));
        let map = map.unwrap_or_else(|| automatic::color_map(range));
        let scale = if self.log { Scale::Log10 } else { self.default_scale(whole) };
        let opacity = Opacity::PerUnitDistance(vec![OpacityPoint { value: range[0], opacity: 1.0 }]);
        Ok(TransferFunction::from_color_map(map, range, scale, opacity)?)
    }

    fn look(&self) -> anyhow::Result<Look> {
        let Some(name) = &self.tf else { return Ok(Look::Map(None)) };
        if !name.to_lowercase().ends_with(".json") {
            return Ok(Look::Map(Some(name.parse()?)));
        }
        let path = PathBuf::from(name);
        let json = std::fs::read_to_string(&path).with_context(|| format!("{name}: cannot read the transfer function"));
        // The context alone would hide why.
        let json = json.map_err(|error| anyhow::anyhow!("{error}: {}", error.root_cause()))?;
        let function = TransferFunction::from_json(&json, None).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
        Ok(Look::Function(function))
    }

    /// A file's function says its own scale and values; `--range` stretches it.
    fn fitted(&self, function: TransferFunction) -> anyhow::Result<TransferFunction> {
        if self.log {
            bail!("--log applies to colour maps; a transfer function file says its own scale (\"scale\": \"log10\")");
        }
        Ok(match self.range {
            Some(range) => function.rescaled(range)?,
            None => function,
        })
    }

    /// A range that was asked for is shown as it was asked for: linear.
    fn default_scale(&self, [low, high]: [f64; 2]) -> Scale {
        if self.range.is_some() { Scale::Linear } else { automatic::scale(low, high) }
    }

    fn histogram_range(&self, volume: &Volume, whole: [f64; 2], scale: Scale) -> anyhow::Result<[f64; 2]> {
        if let Some(range) = self.range {
            return Ok(range);
        }
        let [mut low, high] = whole;
        if scale == Scale::Log10 && low <= 0.0 {
            if high <= 0.0 {
                bail!("--log needs positive values; field {} reaches {high} at most", volume.field().name());
            }
            low = smallest_positive(volume);
        }
        Ok(widened([low, high]))
    }
}

/// The volume-weighted histogram of the leaf cells.
fn histogram(volume: &Volume, range: [f64; 2], scale: Scale) -> anyhow::Result<Histogram> {
    let empty = Histogram::new(range[0], range[1], scale, automatic::HISTOGRAM_BINS)?;
    Ok(volume.fold_leaf_cells(
        || empty.clone(),
        |histogram, cell| histogram.add(cell.value, cell.volume),
        |mut sum, part| {
            sum.merge(&part);
            sum
        },
    ))
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
