//! `amray render`: one picture of the volume.

use std::path::{Path, PathBuf};
use std::time::Instant;

use amray::render::{Film, PathError, RenderStatistics};
use amray::scene::Scene;
use amray_formats::FormatError;
use amray_formats::output::check_writable;
use amray_formats::picture::{PictureFormat, write_exr, write_npy, write_png};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;

use crate::sampling::LayoutName;
use crate::scene_file::SceneDocument;
use crate::stage::Stage;
use crate::view_file::ViewName;
use crate::{memory, note, print, print_json};

#[derive(Debug, Default, Args)]
pub(crate) struct Arguments {
    /// A data set: a file or a directory, of any format that amray reads
    #[arg(required_unless_present = "scene")]
    path: Option<PathBuf>,
    /// A scene file: all that makes a picture, as --save-scene writes it; flags that are given win
    #[arg(long, value_name = "FILE.json")]
    scene: Option<PathBuf>,
    /// Write all that makes the picture into a scene file
    #[arg(long, value_name = "FILE.json")]
    save_scene: Option<PathBuf>,
    /// Where to write the picture: .png, .exr or .npy [default: the data's name with .png]
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(picture_path))]
    output: Option<PathBuf>,
    /// Field, camera, size and transfer function from a file of views; flags that are given win
    #[arg(long = "view", value_name = "FILE:NAME:TF")]
    view_name: Option<ViewName>,
    #[command(flatten)]
    document: SceneDocument,
    /// Render N frames after a warm-up and report the best and the median
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    repeat: Option<u16>,
    /// Print one JSON object: seconds, samples, memory
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
pub(crate) struct Report {
    pub(crate) output: PathBuf,
    size: [usize; 2],
    open_seconds: f64,
    /// To build the index and its value ranges.
    index_seconds: f64,
    /// To lay values out for marching.
    prepare_seconds: f64,
    /// Where samples come from.
    layout: LayoutName,
    /// What that takes besides the field.
    layout_bytes: u64,
    /// The last frame's.
    frame_seconds: f64,
    frame_best_seconds: f64,
    frame_median_seconds: f64,
    frames: usize,
    rays: u64,
    /// To lights, and around points.
    secondary_rays: u64,
    samples: u64,
    /// How many of them came from one brick alone.
    interior_samples: u64,
    /// The share of the rays' length inside the domain that was passed over.
    skipped_share: f64,
    /// Null where the system does not tell.
    resident_bytes: Option<u64>,
    peak_resident_bytes: Option<u64>,
    /// Resident without the pages of mapped files.
    private_bytes: Option<u64>,
}

impl Arguments {
    /// What `amray render DATA -o PICTURE` says.
    pub(crate) fn new(data: PathBuf, picture: PathBuf) -> Self {
        Self { path: Some(data), output: Some(picture), ..Self::default() }
    }

    /// What the flags say, then the view, then the scene file.
    fn document(&self) -> anyhow::Result<SceneDocument> {
        let mut document = self.document.clone();
        document.data.path = self.path.clone();
        if let Some(view) = &self.view_name {
            document = document.or(view.read()?.into());
        }
        if let Some(scene) = &self.scene {
            document = document.or(SceneDocument::read(scene)?);
            if let (None, Some(path)) = (&self.path, &document.data.path)
                && !path.exists()
            {
                anyhow::bail!("{}: data.path: there is no {}", scene.display(), path.display());
            }
        }
        Ok(document)
    }
}

/// A name whose ending is a picture's.
fn picture_path(path: PathBuf) -> Result<PathBuf, FormatError> {
    PictureFormat::of(&path).map(|_| path)
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let report = picture(arguments)?;
    match arguments.json {
        true => print_json(&report),
        false => Ok(print(&format!("{}\n", report.output.display()))?),
    }
}

/// Writes the picture that the flags ask for.
pub(crate) fn picture(arguments: &Arguments) -> anyhow::Result<Report> {
    let document = arguments.document()?;
    let Some(data) = document.data.volume() else {
        let scene = arguments.scene.as_deref().unwrap_or_else(|| Path::new("the scene")).display();
        anyhow::bail!("{scene}: data.path is missing: add it, or name the data on the command line");
    };
    let output = arguments.output.clone().unwrap_or_else(|| PathBuf::from(data.data().stem() + ".png"));
    let format = PictureFormat::of(&output)?;
    let drawn = [("a colour bar", document.annotations.color_bar), ("axes", document.annotations.axes)];
    if let Some((what, _)) = drawn.iter().find(|(_, is_drawn)| *is_drawn && format != PictureFormat::Png) {
        anyhow::bail!("{}: {what} can only be drawn into a .png", output.display());
    }
    // What cannot be written is better known before the work than after it.
    check_writable(&output)?;
    arguments.save_scene.as_deref().map(check_writable).transpose()?;
    let source = data.source()?;
    if let Some(coarse) = data.coarse_part(&source) {
        let finest = coarse.data().max_level.unwrap_or(0);
        let stage = Stage::open(document.clone(), &coarse, coarse.source()?, None)?;
        let camera = stage.camera()?;
        let outlines = stage.outlines(&camera)?;
        let scenes = stage.scenes(camera, outlines.as_ref())?;
        stage.prepare();
        write(&stage, stage.films(&scenes, "coarse")?.0, &scenes, &output, format)?;
        note(&format!("amray: {} has levels up to {finest}; the finer ones follow", output.display()));
    }
    let stage = Stage::open(document, &data, source, None)?;
    let camera = stage.camera()?;
    let outlines = stage.outlines(&camera)?;
    let scenes = stage.scenes(camera, outlines.as_ref())?;
    if let Some(path) = &arguments.save_scene {
        stage.resolved(&camera)?.write(path)?;
    }
    let prepare_seconds = stage.prepare();
    let (films, statistics, seconds) = frames(&stage, &scenes, arguments.repeat)?;
    let [width, height] = stage.options.size;
    let size = [width * films.len(), height];
    write(&stage, films, &scenes, &output, format)?;
    let Stage { options, open_seconds, index_seconds, .. } = &stage;
    let mut sorted = seconds.clone();
    sorted.sort_by(f64::total_cmp);
    Ok(Report {
        output,
        size,
        open_seconds: *open_seconds,
        index_seconds: *index_seconds,
        prepare_seconds,
        layout: options.engine.into(),
        layout_bytes: stage.layout_bytes(),
        frame_seconds: seconds[seconds.len() - 1],
        frame_best_seconds: sorted[0],
        frame_median_seconds: sorted[sorted.len() / 2],
        frames: seconds.len(),
        rays: statistics.rays,
        secondary_rays: statistics.secondary_rays,
        samples: statistics.samples,
        interior_samples: statistics.interior_samples,
        skipped_share: statistics.skipped_length / statistics.ray_length.max(f64::MIN_POSITIVE),
        resident_bytes: memory::resident(),
        peak_resident_bytes: memory::peak_resident(),
        private_bytes: memory::private(),
    })
}

/// Writes what each eye sees.
fn write(
    stage: &Stage,
    films: Vec<Film>,
    scenes: &[Scene],
    output: &Path,
    format: PictureFormat,
) -> Result<(), FormatError> {
    if format == PictureFormat::Png {
        let picture = stage.picture(&films, scenes);
        return write_png(output, [picture.width(), picture.height()], picture.pixels());
    }
    let film = side_by_side(films);
    match format {
        PictureFormat::Npy => write_npy(output, film.size(), film.pixels()),
        _ => write_exr(output, film.size(), film.pixels()),
    }
}

/// What each eye sees as one film.
fn side_by_side(films: Vec<Film>) -> Film {
    films.into_iter().reduce(|left, right| left.beside(&right)).expect("there is a film for each eye")
}

/// Renders one frame or, with `--repeat`, a warm-up and that many frames, of each scene; the last
/// pictures and the seconds of each frame.
fn frames(
    stage: &Stage,
    scenes: &[Scene],
    repeat: Option<u16>,
) -> Result<(Vec<Film>, RenderStatistics, Vec<f64>), PathError> {
    let frame = |what: &str| {
        let start = Instant::now();
        let (films, statistics) = stage.films(scenes, what)?;
        Ok::<_, PathError>((films, statistics, start.elapsed().as_secs_f64()))
    };
    if repeat.is_some() {
        frame("warm-up")?;
    }
    let count = usize::from(repeat.unwrap_or(1));
    let mut all = Vec::with_capacity(count);
    loop {
        let (films, statistics, seconds) = frame("rendering")?;
        all.push(seconds);
        if all.len() == count {
            return Ok((films, statistics, all));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[test]
    fn arguments_made_here_are_those_of_the_command_line() {
        let parsed = crate::Arguments::try_parse_from(["amray", "render", "a.hdf5", "-o", "b.png"]).unwrap();
        let crate::Command::Render(parsed) = parsed.command else { panic!("{parsed:?}") };
        assert_eq!(format!("{:?}", Arguments::new("a.hdf5".into(), "b.png".into())), format!("{parsed:?}"));
    }
}
