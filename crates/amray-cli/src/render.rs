//! `amray render`: one picture of the volume.

use std::path::{Path, PathBuf};
use std::time::Instant;

use amray::appearance::{Picture, automatic, color_bar};
use amray::render::{Engine, Film, PathError, RenderOptions, RenderStatistics};
use amray::scene::{Lighting, Scene, Shading};
use amray_formats::FormatError;
use amray_formats::output::check_writable;
use amray_formats::picture::{PictureFormat, write_exr, write_npy, write_png};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;

use crate::annotations::{self, AnnotationArguments};
use crate::appearance::AppearanceArguments;
use crate::data::Opened;
use crate::mode::ModeArguments;
use crate::progress::with_spinner;
use crate::sampling::LayoutName;
use crate::scene_file::SceneDocument;
use crate::view_file::ViewName;
use crate::{memory, print};

/// Pixels of a picture, where nothing says so.
pub(crate) const SIZE: [usize; 2] = [1024; 2];
const PANORAMA_SIZE: [usize; 2] = [2048, 1024];

#[derive(Debug, Default, Args)]
pub(crate) struct Arguments {
    /// A Chombo HDF5 file, or an AMReX plotfile (the directory or its Header)
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
    let said = if arguments.json { serde_json::to_string(&report)? } else { report.output.display().to_string() };
    Ok(print(&(said + "\n"))?)
}

/// Writes the picture that the flags ask for.
pub(crate) fn picture(arguments: &Arguments) -> anyhow::Result<Report> {
    let mut document = arguments.document()?;
    let Some(volume_arguments) = document.data.volume() else {
        let scene = arguments.scene.as_deref().unwrap_or_else(|| Path::new("the scene")).display();
        anyhow::bail!("{scene}: data.path is missing: add it, or name the data on the command line");
    };
    let data = &volume_arguments.data;
    let output = arguments.output.clone().unwrap_or_else(|| PathBuf::from(data.stem() + ".png"));
    let format = PictureFormat::of(&output)?;
    let drawn = [("a colour bar", document.annotations.color_bar), ("axes", document.annotations.axes)];
    if let Some((what, _)) = drawn.iter().find(|(_, is_drawn)| *is_drawn && format != PictureFormat::Png) {
        anyhow::bail!("{}: {what} can only be drawn into a .png", output.display());
    }
    document.light_paths.check()?;
    // What cannot be written is better known before the work than after it.
    check_writable(&output)?;
    arguments.save_scene.as_deref().map(check_writable).transpose()?;
    let size = document.picture.size.unwrap_or(if document.camera.panorama { PANORAMA_SIZE } else { SIZE });
    let opened = volume_arguments.open()?;
    let colors = |data: &_, volume: &_| AppearanceArguments::default().transfer_function(data, volume);
    let surface_data = document.surfaces.data(&volume_arguments, &opened, colors)?;
    let Opened { volume, open_seconds, index_seconds, .. } = opened;
    let start = Instant::now();
    with_spinner("value ranges", || volume.ranges());
    let index_seconds = index_seconds + start.elapsed().as_secs_f64();
    let function = document.appearance.transfer_function(data, &volume)?;
    let longest = volume.hierarchy().longest_side();
    let unit_distance = document.picture.unit_distance.unwrap_or(longest / automatic::UNIT_DISTANCES);
    let camera = document.camera.camera(&volume, size, document.annotations.room())?;
    let lighting = document.lighting.lighting(&camera, longest, document.light_paths.is_path())?;
    let options = RenderOptions {
        size,
        samples_per_cell: document.picture.samples_per_cell.unwrap_or(1.0),
        samples_per_pixel: document.picture.spp.unwrap_or(1).into(),
        seed: document.picture.seed.unwrap_or(0),
        engine: document.sampling.engine(&volume),
        integration: document.sampling.integration(),
        adaptive: !document.sampling.every_cell,
    };
    check_possible(&document, options.engine, &lighting)?;
    if let Some(path) = &arguments.save_scene {
        document.data.field = Some(volume.field().name().into());
        document.data.method = Some(volume.method());
        document.camera = document.camera.resolved(&camera);
        document.appearance = AppearanceArguments::of(function.clone());
        document.lighting = document.lighting.resolved(&lighting);
        document.picture.size = Some(size);
        document.picture.unit_distance = Some(unit_distance);
        document.write(path)?;
    }
    let outlines = document.annotations.outlines(volume.hierarchy(), &camera, size, document.picture.background())?;
    let mut surfaces = document.surfaces.surfaces(&volume, &function, &surface_data);
    surfaces.extend(outlines.as_ref().map(annotations::surface));
    let opacity = if document.surfaces.hide_volume { 0.0 } else { document.picture.opacity.unwrap_or(1.0) };
    let function = function.scaled_opacity(opacity);
    let clips = document.clips.clips(&volume);
    let scene = Scene { lighting, surfaces, clips, ..Scene::new(&volume, function, unit_distance, camera) };
    let scenes = match document.camera.stereo {
        None => vec![scene],
        Some(stereo) => stereo.pair(&camera)?.map(|camera| Scene { camera, ..scene.clone() }).to_vec(),
    };
    let start = Instant::now();
    if let Engine::March(layout) = options.engine {
        with_spinner("preparing", || volume.prepare(layout));
    }
    let prepare_seconds = start.elapsed().as_secs_f64();
    let (films, statistics, seconds) = frames(&scenes, &options, (&document.light_paths, arguments.repeat))?;
    let film = films.iter().skip(1).fold(films[0].clone(), |left, right| left.beside(right));
    match format {
        PictureFormat::Png => {
            let behind = document.picture.background();
            let pictures =
                films.iter().zip(&scenes).map(|(film, scene)| drawn_film(film, scene, &document.annotations, behind));
            let picture = pictures.reduce(|left, right| left.beside(&right, bytes(behind)));
            let picture = picture.expect("there is a scene for each eye");
            write_png(&output, [picture.width(), picture.height()], picture.pixels())?;
        }
        PictureFormat::Exr => write_exr(&output, film.size(), film.pixels())?,
        PictureFormat::Npy => write_npy(&output, film.size(), film.pixels())?,
    }
    let mut sorted = seconds.clone();
    sorted.sort_by(f64::total_cmp);
    Ok(Report {
        output,
        size: film.size(),
        open_seconds,
        index_seconds,
        prepare_seconds,
        layout: options.engine.into(),
        layout_bytes: match options.engine {
            Engine::March(layout) => volume.layout_bytes(layout),
            Engine::Query => 0,
        },
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

/// Finds out whether what is asked for can be drawn together.
fn check_possible(document: &SceneDocument, engine: Engine, lighting: &Lighting) -> anyhow::Result<()> {
    let has_surfaces = !document.surfaces.is_empty() || document.annotations.has_outlines();
    if document.light_paths.is_path() && (engine == Engine::Query || has_surfaces) {
        anyhow::bail!(
            "--mode path is for volumes alone: drop surfaces (--iso, --slice, --mesh, outlines and axes) and --engine \
             query, or march"
        );
    }
    let is_plain = lighting.shading == Shading::Emissive && !has_surfaces;
    if engine == Engine::Query && !is_plain {
        anyhow::bail!(
            "--engine query draws volumes that glow, and nothing else: drop --shading, --shadows, --ao, --light, --iso, \
             --slice, --mesh, outlines and axes, or march"
        );
    }
    Ok(())
}

/// A scene's film as a picture, with all that explains it.
fn drawn_film(film: &Film, scene: &Scene, annotations: &AnnotationArguments, background: [f32; 4]) -> Picture {
    let ([width, height], behind) = (film.size(), bytes(background));
    let pixels = film.over(background);
    let mut picture = Picture::from_pixels(width, height, pixels).expect("a film has its size's pixels");
    annotations.draw(&mut picture, scene.volume.hierarchy(), &scene.camera, behind);
    if annotations.color_bar {
        let title = scene.volume.field().name();
        picture = picture.beside(&color_bar(&scene.transfer_function, title, height, behind), behind);
    }
    picture
}

fn bytes(color: [f32; 4]) -> [u8; 4] {
    color.map(|channel| (channel * 255.0).round() as u8)
}

/// Renders one frame or, with `--repeat`, a warm-up and that many frames, of each scene; the last
/// pictures and the seconds of each frame.
fn frames(
    scenes: &[Scene],
    options: &RenderOptions,
    (mode, repeat): (&ModeArguments, Option<u16>),
) -> Result<(Vec<Film>, RenderStatistics, Vec<f64>), PathError> {
    let frame = |what: &str| {
        let start = Instant::now();
        let (mut films, mut statistics) = (Vec::new(), RenderStatistics::default());
        for scene in scenes {
            let (film, more) = mode.film(scene, options, what)?;
            films.push(film);
            statistics = statistics + more;
        }
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
