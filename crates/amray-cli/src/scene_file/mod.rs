//! Scene files: all that makes a picture, as one JSON document.
//!
//! A document has the flags' words as its keys. Flags, named views and files all become documents; one fills what
//! another one leaves open, and the picture is made from the result alone.

pub(crate) mod checked;
mod curves;
mod picture;

use std::path::{Path, PathBuf};

use amray_formats::output::OutputFile;
use clap::Args;
use schemars::{JsonSchema, schema_for};
use serde::{Deserialize, Serialize};

use crate::annotations::AnnotationArguments;
use crate::appearance::AppearanceArguments;
use crate::clips::ClipArguments;
use crate::data::{DataSection, absolute};
use crate::fields::FieldArguments;
use crate::json_file;
use crate::lighting::LightingArguments;
use crate::mode::ModeArguments;
use crate::sampling::SamplingArguments;
use crate::surfaces::SurfaceArguments;
use crate::view::ViewArguments;

pub(crate) use curves::Curves;
pub(crate) use picture::PictureSection;

/// What documents of this program are.
const VERSION: u32 = 1;

/// Everything that makes a picture. Keys have the meaning of the flags of `amray render` of the same name; what is left
/// out is chosen as without the flag.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "amray scene")]
pub(crate) struct SceneDocument {
    /// Of the document: 1.
    #[arg(skip)]
    #[schemars(required, range(min = 1, max = 1))]
    pub(crate) version: u32,
    /// Which data.
    #[command(flatten)]
    pub(crate) data: DataSection,
    /// From where it is seen.
    #[command(flatten)]
    pub(crate) camera: ViewArguments,
    /// Colours and opacities of values.
    #[command(flatten)]
    pub(crate) appearance: AppearanceArguments,
    /// Which other fields are seen.
    #[command(flatten)]
    pub(crate) fields: FieldArguments,
    /// What lights it.
    #[command(flatten)]
    pub(crate) lighting: LightingArguments,
    /// What is drawn besides the volume.
    #[command(flatten)]
    pub(crate) surfaces: SurfaceArguments,
    /// What is cut away.
    #[command(flatten)]
    pub(crate) clips: ClipArguments,
    /// What explains it.
    #[command(flatten)]
    pub(crate) annotations: AnnotationArguments,
    /// How light goes.
    #[command(flatten)]
    pub(crate) light_paths: ModeArguments,
    /// Pixels, and how exact they are.
    #[command(flatten)]
    pub(crate) picture: PictureSection,
    /// How rays find their samples.
    #[command(flatten)]
    pub(crate) sampling: SamplingArguments,
}

impl SceneDocument {
    /// Reads a scene file. Its paths are relative to it.
    ///
    /// # Errors
    /// Which key of which file is wrong, and what it should be.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let mut document = json_file::read(path, "the scene", Self::of_json)?;
        let directory = absolute(path).parent().map(PathBuf::from).unwrap_or_default();
        document.for_each_path(|path| *path = directory.join(&path));
        Ok(document)
    }

    /// The document of a JSON text.
    fn of_json(text: &str) -> Result<Self, String> {
        let value = json_file::value(text)?;
        let Some(object) = value.as_object() else { return Err("expected an object".into()) };
        // Other versions may have other keys.
        match object.get("version") {
            None => return Err(format!("\"version\" is missing, expected {VERSION}")),
            Some(found) if *found != VERSION => {
                return Err(format!("version: {found} is not known, expected {VERSION}"));
            }
            Some(_) => {}
        }
        let document: Self = json_file::typed(value)?;
        if document.camera.orthographic && document.camera.panorama {
            return Err("camera.panorama: true beside \"orthographic\", expected one of them".into());
        }
        Ok(document)
    }

    /// Writes a scene file. Paths below its directory are relative to it, others absolute.
    pub(crate) fn write(&self, path: &Path) -> anyhow::Result<()> {
        let mut document = Self { version: VERSION, ..self.clone() };
        let directory = absolute(path).parent().map(PathBuf::from).unwrap_or_default();
        document.for_each_path(|path| {
            let whole = absolute(path);
            *path = whole.strip_prefix(&directory).map(PathBuf::from).unwrap_or(whole);
        });
        let json = serde_json::to_string_pretty(&document)? + "\n";
        Ok(OutputFile::write(path, |file| std::io::Write::write_all(file, json.as_bytes()))?)
    }

    fn for_each_path(&mut self, mut change: impl FnMut(&mut PathBuf)) {
        self.data.path.iter_mut().for_each(&mut change);
        self.appearance.path_mut().into_iter().for_each(&mut change);
        self.fields.paths_mut().for_each(&mut change);
        self.surfaces.paths_mut().for_each(change);
    }

    /// This document; what it leaves open is as in `others`. Other fields, surfaces, lights and clips of one kind are not mixed: those of
    /// this document, if it has any.
    pub(crate) fn or(self, others: Self) -> Self {
        Self {
            version: VERSION,
            data: self.data.or(others.data),
            camera: self.camera.or(&others.camera),
            appearance: self.appearance.or(others.appearance),
            fields: self.fields.or(others.fields),
            lighting: self.lighting.or(others.lighting),
            surfaces: self.surfaces.or(others.surfaces),
            clips: self.clips.or(others.clips),
            annotations: self.annotations.or(others.annotations),
            light_paths: self.light_paths.or(others.light_paths),
            picture: self.picture.or(others.picture),
            sampling: self.sampling.or(others.sampling),
        }
    }
}

/// The JSON schema of scene files.
pub(crate) fn schema() -> String {
    serde_json::to_string_pretty(&schema_for!(SceneDocument)).expect("a schema is JSON") + "\n"
}

/// `these`, or if there are none `others`.
pub(crate) fn or<T>(these: Vec<T>, others: Vec<T>) -> Vec<T> {
    if these.is_empty() { others } else { these }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_in_the_documentation_is_that_of_the_types() {
        let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene.schema.json");
        let kept = std::fs::read_to_string(kept).unwrap_or_default();
        assert!(kept == schema(), "docs/scene.schema.json is old: cargo run -- schema > docs/scene.schema.json");
    }

    #[test]
    fn the_example_in_the_documentation_is_a_scene() {
        let page = include_str!("../../../../docs/scene-files.md");
        let example = page.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
        let document = SceneDocument::of_json(example).unwrap();
        assert_eq!((document.picture.spp, document.annotations.axes), (Some(4), true));
    }

    #[test]
    fn wrong_keys_are_named() {
        for (json, expected) in [
            ("[]", "expected an object"),
            ("{", "no JSON: "),
            ("{}", "\"version\" is missing, expected 1"),
            (r#"{"version": 2, "new": 1}"#, "version: 2 is not known, expected 1"),
            (r#"{"version": 1, "camera": {"orthographic": true, "panorama": true}}"#, "camera.panorama: true beside"),
            (
                r#"{"version": 1, "lighting": {"light": [{"directional": {"direction": [0, 0, 0], "color": [1, 1, 1]}}]}}"#,
                "lighting.light: light 0: direction is [0.0, 0.0, 0.0], expected a vector other than 0",
            ),
            (
                r#"{"version": 1, "lighting": {"ao": 1025}}"#,
                "lighting.ao: 1025, expected a whole number from 1 to 1024",
            ),
            (
                r#"{"version": 1, "appearance": {"tf": {"colors": [], "opacities": [], "extinctions": []}}}"#,
                "appearance.tf: extinctions beside opacities, expected one of them",
            ),
            (
                r#"{"version": 1, "fields": {"overlay": [{"appearance": {}}]}}"#,
                "fields.overlay[0]: missing field `field`",
            ),
            (r#"{"version": 1, "fields": {"color_by": {"field": "a", "opacity": -1}}}"#, "fields.color_by.opacity: "),
            (r#"{"version": 1, "colour": 3}"#, "colour: unknown field `colour`, expected one of"),
            (r#"{"version": 1, "camera": {"eye": [1, 2]}}"#, "camera.eye: invalid length 2"),
            (r#"{"version": 1, "camera": {"fovy": 200}}"#, "camera.fovy: expected an angle above 0 and below 180"),
            (r#"{"version": 1, "data": {"method": "cubic"}}"#, "data.method: "),
            (r#"{"version": 1, "lighting": {"light": [{"sun": {}}]}}"#, "lighting.light[0]: unknown variant `sun`"),
            (
                r#"{"version": 1, "lighting": {"light": [{"ambient": {"color": [1, 2]}}]}}"#,
                "lighting.light[0].ambient.color: invalid length 2",
            ),
            (r#"{"version": 1, "surfaces": {"iso": [{"opacity": 1}]}}"#, "surfaces.iso[0]: missing field `value`"),
            (
                r#"{"version": 1, "surfaces": {"iso": [{"value": 1, "opacity": 2}]}}"#,
                "surfaces.iso[0].opacity: the opacity is 2, expected a number from 0 to 1",
            ),
            (r#"{"version": 1, "picture": {"size": [0, 4]}}"#, "picture.size: expected WIDTHxHEIGHT or one number"),
            (r#"{"version": 1, "appearance": {"tf": "nosuch"}}"#, "appearance.tf: "),
            (
                r#"{"version": 1, "appearance": {"tf": {"points": [[1, 2]]}}}"#,
                "appearance.tf: \"points\", point 0: [1,2], expected five numbers",
            ),
        ] {
            let problem = SceneDocument::of_json(json).unwrap_err();
            assert!(problem.starts_with(expected), "{json}: {problem}");
        }
    }
}
