//! How rays find their samples: from the flags, or by what fits into memory.

use amray::Volume;
use amray::render::{Engine, Integration, Layout};
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::memory::MemoryArguments;

/// How rays are sampled.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct SamplingArguments {
    /// How rays find their samples: march through regions, or query the tree for every sample (as the paper has it)
    /// [default: march]
    #[arg(long, value_name = "ENGINE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    engine: Option<EngineName>,
    /// Where marching has its values.
    #[command(flatten)]
    layout: LayoutArguments,
    /// Integrate the transfer function between samples, or take it at samples [default: on]
    #[arg(long, value_name = "ON|OFF")]
    #[serde(skip_serializing_if = "Option::is_none")]
    preintegrate: Option<Switch>,
    /// Sample every cell, also where nothing is seen or nothing changes
    #[arg(long)]
    pub(crate) every_cell: bool,
}

/// Where marching has its values.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct LayoutArguments {
    /// Where marching has its values: in a padded copy (fastest), in place, or padded if that fits --memory
    /// [default: auto]
    #[arg(long, value_name = "LAYOUT")]
    #[serde(skip_serializing_if = "Option::is_none")]
    layout: Option<LayoutChoice>,
}

/// A way for rays to find their samples.
#[derive(Clone, Copy, Debug, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum EngineName {
    #[default]
    March,
    Query,
}

/// A wish for where values are.
#[derive(Clone, Copy, Debug, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum LayoutChoice {
    #[default]
    Auto,
    Padded,
    InPlace,
}

/// On or off.
#[derive(Clone, Copy, Debug, Default, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Switch {
    #[default]
    On,
    Off,
}

impl From<Switch> for Integration {
    fn from(preintegrate: Switch) -> Self {
        match preintegrate {
            Switch::On => Self::Preintegrated,
            Switch::Off => Self::AtSamples,
        }
    }
}

/// Where samples come from, as `--json` says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum LayoutName {
    Padded,
    InPlace,
    Query,
}

impl From<Engine> for LayoutName {
    fn from(engine: Engine) -> Self {
        match engine {
            Engine::March(Layout::Padded) => Self::Padded,
            Engine::March(Layout::InPlace) => Self::InPlace,
            Engine::Query => Self::Query,
        }
    }
}

impl SamplingArguments {
    /// These flags, and where they are not given, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            engine: self.engine.or(others.engine),
            layout: LayoutArguments { layout: self.layout.layout.or(others.layout.layout) },
            preintegrate: self.preintegrate.or(others.preintegrate),
            every_cell: self.every_cell || others.every_cell,
        }
    }

    /// With the engine that was chosen.
    pub(crate) fn resolved(&self, engine: Engine) -> Self {
        let (engine, layout) = match engine {
            Engine::March(Layout::Padded) => (EngineName::March, Some(LayoutChoice::Padded)),
            Engine::March(Layout::InPlace) => (EngineName::March, Some(LayoutChoice::InPlace)),
            Engine::Query => (EngineName::Query, None),
        };
        let layout = LayoutArguments { layout };
        Self { engine: Some(engine), layout, preintegrate: Some(self.preintegrate.unwrap_or_default()), ..self.clone() }
    }

    /// How light follows from samples.
    pub(crate) fn integration(&self) -> Integration {
        self.preintegrate.unwrap_or_default().into()
    }

    /// The engine for so many fields, of which `volume` is one.
    pub(crate) fn engine(&self, volume: &Volume, fields: usize, memory: MemoryArguments) -> Engine {
        match self.engine.unwrap_or_default() {
            EngineName::March => Engine::March(self.layout.layout(volume, fields, memory)),
            EngineName::Query => Engine::Query,
        }
    }
}

impl LayoutArguments {
    /// The layout for so many fields, of which `volume` is one: without a wish, padded copies if they fit the budget.
    pub(crate) fn layout(&self, volume: &Volume, fields: usize, memory: MemoryArguments) -> Layout {
        match self.layout.unwrap_or_default() {
            LayoutChoice::Padded => return Layout::Padded,
            LayoutChoice::InPlace => return Layout::InPlace,
            LayoutChoice::Auto => {}
        }
        if volume.layout_bytes(Layout::Padded).saturating_mul(fields as u64) <= memory.most() {
            Layout::Padded
        } else {
            Layout::InPlace
        }
    }
}
