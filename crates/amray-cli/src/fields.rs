//! Fields that are seen together with the volume's own, from the flags.

use std::path::PathBuf;

use amray::Volume;
use amray::appearance::TransferFunction;
use amray::render::Layout;
use amray::scene::{MOST_FIELDS, ShownField};
use clap::Args;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::appearance::AppearanceArguments;
use crate::data::{Opened, VolumeArguments};
use crate::number;
use crate::progress::with_spinner;
use crate::scene_file::{self, checked};

/// Which other fields are seen.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FieldArguments {
    /// Colour the volume by another field; its own one says how opaque it is. TF is a colour map or a file as with --tf,
    /// LOW,HIGH are the values that it spans [default: as without --tf and --range]
    #[arg(long, value_name = "FIELD[:TF[:LOW,HIGH]]", value_parser = coloring)]
    #[serde(skip_serializing_if = "Option::is_none")]
    color_by: Option<OtherField>,
    /// Another field that is seen in the same place; OPACITY multiplies its opacities. May be repeated: a picture shows
    /// four fields at most, that of --color-by included
    #[arg(long = "overlay", value_name = "FIELD[:TF[:LOW,HIGH[:OPACITY]]]", value_parser = overlay)]
    #[serde(rename = "overlay", skip_serializing_if = "Vec::is_empty")]
    overlays: Vec<OtherField>,
}

/// A field beside the volume's.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OtherField {
    /// The field's name, or an expression over fields.
    field: String,
    /// How it looks.
    #[serde(default)]
    appearance: AppearanceArguments,
    /// By what its opacities are multiplied.
    #[serde(default, deserialize_with = "checked::positive", skip_serializing_if = "Option::is_none")]
    opacity: Option<f64>,
}

/// Fields with their values.
pub(crate) struct OtherFields {
    colors: Option<(Volume, TransferFunction)>,
    overlays: Vec<(Volume, TransferFunction)>,
}

impl FieldArguments {
    /// These fields; of kinds that there are none of, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self { color_by: self.color_by.or(others.color_by), overlays: scene_file::or(self.overlays, others.overlays) }
    }

    /// The files of transfer functions.
    pub(crate) fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        self.color_by.iter_mut().chain(&mut self.overlays).filter_map(|field| field.appearance.path_mut())
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        usize::from(self.color_by.is_some()) + self.overlays.len()
    }

    /// Reads them.
    pub(crate) fn open(&self, data: &VolumeArguments, opened: &Opened) -> anyhow::Result<OtherFields> {
        let most = MOST_FIELDS - 1;
        if self.count() > most {
            anyhow::bail!(
                "{} fields beside the volume's own, expected at most {most}: drop some --overlay",
                self.count()
            );
        }
        let open = |other: &OtherField| {
            let volume = data.other_field(opened, &other.field)?;
            with_spinner("value ranges", || volume.ranges());
            let function = other.appearance.transfer_function(&data.data(), &volume)?;
            anyhow::Ok((volume, function.scaled_opacity(other.opacity.unwrap_or(1.0))))
        };
        Ok(OtherFields {
            colors: self.color_by.as_ref().map(open).transpose()?,
            overlays: self.overlays.iter().map(open).collect::<anyhow::Result<_>>()?,
        })
    }

    /// These flags with the transfer functions that were chosen.
    pub(crate) fn resolved(&self, fields: &OtherFields) -> Self {
        let resolved = |other: &OtherField, (_, function): &(Volume, TransferFunction)| OtherField {
            appearance: AppearanceArguments::of(function.clone()),
            opacity: None,
            field: other.field.clone(),
        };
        let overlays = self.overlays.iter().zip(&fields.overlays);
        Self {
            color_by: self.color_by.as_ref().zip(fields.colors.as_ref()).map(|(other, field)| resolved(other, field)),
            overlays: overlays.map(|(other, field)| resolved(other, field)).collect(),
        }
    }
}

impl OtherFields {
    /// What gives the volume its colours.
    pub(crate) fn colors(&self) -> Option<ShownField<'_>> {
        self.colors.as_ref().map(|field| shown(field, 1.0))
    }

    /// What is seen together with the volume, with opacities times `opacity`.
    pub(crate) fn overlays(&self, opacity: f64) -> Vec<ShownField<'_>> {
        self.overlays.iter().map(|field| shown(field, opacity)).collect()
    }

    /// Lays values out for marching.
    pub(crate) fn prepare(&self, layout: Layout) {
        self.volumes().for_each(|volume| volume.prepare(layout));
    }

    /// Bytes of memory that a layout takes.
    pub(crate) fn layout_bytes(&self, layout: Layout) -> u64 {
        self.volumes().map(|volume| volume.layout_bytes(layout)).sum()
    }

    fn volumes(&self) -> impl Iterator<Item = &Volume> {
        self.colors.iter().chain(&self.overlays).map(|(volume, _)| volume)
    }
}

fn shown((volume, function): &(Volume, TransferFunction), opacity: f64) -> ShownField<'_> {
    ShownField { volume, transfer_function: function.scaled_opacity(opacity) }
}

/// `FIELD[:TF[:LOW,HIGH]]`.
fn coloring(text: &str) -> Result<OtherField, String> {
    match overlay(text)? {
        OtherField { opacity: Some(_), .. } => Err("expected FIELD[:TF[:LOW,HIGH]]".into()),
        field => Ok(field),
    }
}

/// `FIELD[:TF[:LOW,HIGH[:OPACITY]]]`; what is empty is as if it were not there.
fn overlay(text: &str) -> Result<OtherField, String> {
    let mut parts = text.split(':');
    let field = parts.next().unwrap_or_default().to_owned();
    let mut next = || parts.next().filter(|part| !part.is_empty());
    let (function, range, opacity) = (next(), next(), next());
    if field.is_empty() || parts.next().is_some() {
        return Err("expected FIELD[:TF[:LOW,HIGH[:OPACITY]]]".into());
    }
    let appearance = AppearanceArguments::named(function, range.map(number::range).transpose()?)?;
    Ok(OtherField { field, appearance, opacity: opacity.map(number::positive).transpose()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_read() {
        let read = |text: &str| serde_json::to_value(overlay(text).unwrap()).unwrap();
        assert_eq!(read("density"), serde_json::json!({"field": "density", "appearance": {"log": false}}));
        let appearance = serde_json::json!({"tf": "plasma", "range": [-1.0, 2.0], "log": false});
        let whole = serde_json::json!({"field": "density", "appearance": appearance, "opacity": 0.5});
        assert_eq!(read("density:plasma:-1,2:0.5"), whole);
        let far = serde_json::json!({"field": "density", "appearance": {"log": false}, "opacity": 2.0});
        assert_eq!(read("density:::2"), far);
    }

    #[test]
    fn what_is_no_field_is_explained() {
        for (text, part) in [
            ("", "FIELD[:TF"),
            (":plasma", "FIELD[:TF"),
            ("a:nosuch", "nosuch"),
            ("a::2,1", "2,1"),
            ("a:::0", "0"),
            ("a:::1:1", "FIELD[:TF"),
        ] {
            let message = overlay(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        assert!(coloring("a:::1").unwrap_err().contains("FIELD[:TF[:LOW,HIGH]]"));
    }
}
