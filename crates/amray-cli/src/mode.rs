//! How light goes through the scene: along straight rays, or on paths with any number of turns.

use amray::render::{Film, PathError, PathOptions, PathTracer, RenderOptions, RenderStatistics, render};
use amray::scene::Scene;
use clap::{Args, ValueEnum};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::number;
use crate::progress::with_progress;

/// How light goes through the scene.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct ModeArguments {
    /// March along rays, or trace paths of light that is scattered any number of times, --spp of them per pixel
    /// [default: march]
    #[arg(long, value_name = "MODE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    mode: Option<Mode>,
    /// With --mode path, the mean cosine of the angle by which light is turned: between -1, back, and 1, straight on
    /// [default: 0]
    #[arg(long, value_name = "G", value_parser = number::finite, allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    anisotropy: Option<f64>,
    /// With --mode path, the share of light that is scattered and not absorbed, 0 to 1, times the colour [default: 1]
    #[arg(long, value_name = "A", value_parser = number::finite)]
    #[serde(skip_serializing_if = "Option::is_none")]
    albedo: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Mode {
    #[default]
    March,
    Path,
}

impl ModeArguments {
    /// These flags, and where they are not given, `others`.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            mode: self.mode.or(others.mode),
            anisotropy: self.anisotropy.or(others.anisotropy),
            albedo: self.albedo.or(others.albedo),
        }
    }

    /// Whether paths are traced.
    pub(crate) fn is_path(&self) -> bool {
        self.mode == Some(Mode::Path)
    }

    /// What paths do.
    ///
    /// # Errors
    /// Where a flag says it of rays that march.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        let given = [("--anisotropy", self.anisotropy), ("--albedo", self.albedo)];
        match given.iter().find(|(_, value)| value.is_some()) {
            Some((flag, _)) if !self.is_path() => anyhow::bail!("{flag} is about paths of light: add --mode path"),
            _ => Ok(()),
        }
    }

    /// Renders a scene; `what` is on the progress bar.
    pub(crate) fn film(
        &self,
        scene: &Scene,
        options: &RenderOptions,
        what: &str,
    ) -> Result<(Film, RenderStatistics), PathError> {
        match self.mode.unwrap_or_default() {
            Mode::March => Ok(with_progress(what, |progress| render(scene, options, progress))),
            Mode::Path => {
                let usual = PathOptions::default();
                let path = PathOptions {
                    anisotropy: self.anisotropy.unwrap_or(usual.anisotropy),
                    albedo: self.albedo.unwrap_or(usual.albedo),
                    ..usual
                };
                let mut tracer = PathTracer::new(scene, options, &path)?;
                with_progress(what, |progress| tracer.accumulate(options.samples_per_pixel, progress));
                Ok((tracer.film(), tracer.statistics().into()))
            }
        }
    }
}
