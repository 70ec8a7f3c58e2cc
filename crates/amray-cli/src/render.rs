//! `amray render`: one picture of the volume.

use std::path::PathBuf;
use std::time::Instant;

use amray::appearance::{Picture, automatic, color_bar};
use amray::render::{Engine, Film, PathError, RenderOptions, RenderStatistics};
use amray::scene::{CameraError, Scene, Shading};
use amray_formats::FormatError;
use amray_formats::output::check_writable;
use amray_formats::picture::{PictureFormat, write_exr, write_npy, write_png};
use clap::Args;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;

use crate::annotations::{self, AnnotationArguments};
use crate::appearance::AppearanceArguments;
use crate::clips::ClipArguments;
use crate::data::{DataArguments, Opened, VolumeArguments};
use crate::lighting::LightingArguments;
use crate::mode::ModeArguments;
use crate::progress::with_spinner;
use crate::sampling::{LayoutName, SamplingArguments};
use crate::surfaces::SurfaceArguments;
use crate::view::ViewArguments;
use crate::view_file::{View, ViewName};
use crate::{memory, number, print};

/// Pixels of a picture, where nothing says so.
pub(crate) const SIZE: [usize; 2] = [1024; 2];
const PANORAMA_SIZE: [usize; 2] = [2048, 1024];

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    volume: VolumeArguments,
    /// Where to write the picture: .png, .exr or .npy [default: the data's name with .png]
    #[arg(short, long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(picture_path))]
    output: Option<PathBuf>,
    /// Field, camera, size and transfer function from a file of views; flags that are given win
    #[arg(long = "view", value_name = "FILE:NAME:TF")]
    view_name: Option<ViewName>,
    /// Pixels [default: 1024x1024]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = number::size)]
    size: Option<[usize; 2]>,
    #[command(flatten)]
    view: ViewArguments,
    #[command(flatten)]
    appearance: AppearanceArguments,
    #[command(flatten)]
    lighting: LightingArguments,
    #[command(flatten)]
    surfaces: SurfaceArguments,
    #[command(flatten)]
    annotations: AnnotationArguments,
    #[command(flatten)]
    clips: ClipArguments,
    #[command(flatten)]
    mode: ModeArguments,
    /// A pair of pictures for the left and the right eye, side by side, each of --size; SEPARATION is in world units
    /// [default: a thirtieth of the way to the target]
    #[arg(long, value_name = "SEPARATION", num_args = 0..=1, value_parser = number::positive)]
    stereo: Option<Option<f64>>,
    /// Multiply all opacities
    #[arg(long, value_name = "A", default_value = "1", value_parser = number::positive)]
    opacity: f64,
    /// The length that opacities refer to [default: a hundredth of the domain's longest side]
    #[arg(long, value_name = "D", value_parser = number::positive)]
    unit_distance: Option<f64>,
    /// Samples per cell width along a ray
    #[arg(long, value_name = "R", default_value = "1", value_parser = number::samples_per_cell)]
    samples_per_cell: f64,
    /// Rays per pixel
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..))]
    spp: u16,
    /// Seed of the noise that hides banding
    #[arg(long, value_name = "SEED", default_value = "0")]
    seed: u64,
    #[command(flatten)]
    sampling: SamplingArguments,
    /// What is behind the volume in a .png, each 0 to 1
    #[arg(long, value_name = "R,G,B[,A]", default_value = "1,1,1", value_parser = number::color)]
    background: [f32; 4],
    /// Draw a colour bar beside the picture (.png)
    #[arg(long)]
    color_bar: bool,
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
        Self {
            volume: VolumeArguments { data: DataArguments { path: data, max_level: None }, ..Default::default() },
            output: Some(picture),
            view_name: None,
            size: None,
            view: ViewArguments::default(),
            appearance: AppearanceArguments::default(),
            lighting: LightingArguments::default(),
            surfaces: SurfaceArguments::default(),
            annotations: AnnotationArguments::default(),
            clips: ClipArguments::default(),
            mode: ModeArguments::default(),
            stereo: None,
            opacity: 1.0,
            unit_distance: None,
            samples_per_cell: 1.0,
            spp: 1,
            seed: 0,
            sampling: SamplingArguments::default(),
            background: [1.0; 4],
            color_bar: false,
            repeat: None,
            json: false,
        }
    }

    /// The background's colour.
    fn behind(&self) -> [u8; 4] {
        self.background.map(|channel| (channel * 255.0).round() as u8)
    }

    /// A scene's film as a picture, with all that explains it.
    fn drawn(&self, film: &Film, scene: &Scene) -> Picture {
        let ([width, height], behind) = (film.size(), self.behind());
        let pixels = film.over(self.background);
        let mut picture = Picture::from_pixels(width, height, pixels).expect("a film has its size's pixels");
        self.annotations.draw(&mut picture, scene.volume.hierarchy(), &scene.camera, behind);
        if self.color_bar {
            let title = scene.volume.field().name();
            picture = picture.beside(&color_bar(&scene.transfer_function, title, height, behind), behind);
        }
        picture
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
    let output = arguments.output.clone().unwrap_or_else(|| PathBuf::from(arguments.volume.data.stem() + ".png"));
    let format = PictureFormat::of(&output)?;
    arguments.mode.check()?;
    let drawn = [("a colour bar", arguments.color_bar), ("axes", arguments.annotations.axes)];
    if let Some((what, _)) = drawn.iter().find(|(_, is_drawn)| *is_drawn && format != PictureFormat::Png) {
        anyhow::bail!("{}: {what} can only be drawn into a .png", output.display());
    }
    // What cannot be written is better known before the work than after it.
    check_writable(&output)?;
    let view = arguments.view_name.as_ref().map(ViewName::read).transpose()?;
    let view = view.as_ref();
    let size = arguments.size.or(view.and_then(|view| view.size)).unwrap_or(if arguments.view.panorama {
        PANORAMA_SIZE
    } else {
        SIZE
    });
    let field = arguments.volume.field.clone().or(view.and_then(|view| view.field.clone()));
    let opened = VolumeArguments { field, ..arguments.volume.clone() }.open()?;
    let colors = |data: &_, volume: &_| AppearanceArguments::default().transfer_function(data, volume);
    let surface_data = arguments.surfaces.data(&arguments.volume, &opened, colors)?;
    let Opened { volume, open_seconds, index_seconds, .. } = opened;
    let start = Instant::now();
    with_spinner("value ranges", || volume.ranges());
    let index_seconds = index_seconds + start.elapsed().as_secs_f64();
    let function = match view {
        Some(View { transfer_function, .. }) if !arguments.appearance.is_given() => transfer_function.clone(),
        _ => arguments.appearance.transfer_function(&arguments.volume.data, &volume)?,
    };
    let camera = view.map_or_else(|| arguments.view.clone(), |view| arguments.view.or(&view.into()));
    let longest = volume.hierarchy().longest_side();
    let unit_distance = arguments.unit_distance.unwrap_or(longest / automatic::UNIT_DISTANCES);
    let camera = camera.camera(&volume, size, arguments.annotations.room())?;
    let lighting = arguments.lighting.lighting(&camera, longest, arguments.mode.is_path())?;
    let options = RenderOptions {
        size,
        samples_per_cell: arguments.samples_per_cell,
        samples_per_pixel: arguments.spp.into(),
        seed: arguments.seed,
        engine: arguments.sampling.engine(&volume),
        integration: arguments.sampling.preintegrate.into(),
        adaptive: !arguments.sampling.every_cell,
    };
    let has_surfaces = !arguments.surfaces.is_empty() || arguments.annotations.has_outlines();
    if arguments.mode.is_path() && (options.engine == Engine::Query || has_surfaces) {
        anyhow::bail!(
            "--mode path is for volumes alone: drop surfaces (--iso, --slice, --mesh, outlines and axes) and --engine query, or \
             march"
        );
    }
    let is_plain = lighting.shading == Shading::Emissive && !has_surfaces;
    if options.engine == Engine::Query && !is_plain {
        anyhow::bail!(
            "--engine query draws volumes that glow, and nothing else: drop --shading, --shadows, --ao, --light, --iso, \
             --slice, --mesh, outlines and axes, or march"
        );
    }
    let background = arguments.background;
    let outlines = arguments.annotations.outlines(volume.hierarchy(), &camera, size, background)?;
    let mut surfaces = arguments.surfaces.surfaces(&volume, &function, &surface_data);
    surfaces.extend(outlines.as_ref().map(annotations::surface));
    let opacity = if arguments.surfaces.hide_volume { 0.0 } else { arguments.opacity };
    let function = function.scaled_opacity(opacity);
    let clips = arguments.clips.clips(&volume);
    let scene = Scene { lighting, surfaces, clips, ..Scene::new(&volume, function, unit_distance, camera) };
    let scenes = eyes(&scene, arguments.stereo)?;
    let start = Instant::now();
    if let Engine::March(layout) = options.engine {
        with_spinner("preparing", || volume.prepare(layout));
    }
    let prepare_seconds = start.elapsed().as_secs_f64();
    let (films, statistics, seconds) = frames(&scenes, &options, arguments)?;
    let film = films.iter().skip(1).fold(films[0].clone(), |left, right| left.beside(right));
    match format {
        PictureFormat::Png => {
            let pictures = films.iter().zip(&scenes).map(|(film, scene)| arguments.drawn(film, scene));
            let picture = pictures.reduce(|left, right| left.beside(&right, arguments.behind()));
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

/// How many times as far as its eyes are apart a target is that is looked at comfortably.
const COMFORTABLE: f64 = 30.0;

/// The scene as it is seen: by one eye, or by the left and the right one.
fn eyes<'a>(scene: &Scene<'a>, stereo: Option<Option<f64>>) -> Result<Vec<Scene<'a>>, CameraError> {
    let Some(separation) = stereo else { return Ok(vec![scene.clone()]) };
    let cameras = scene.camera.stereo_pair(separation.unwrap_or(scene.camera.distance() / COMFORTABLE))?;
    Ok(cameras.into_iter().map(|camera| Scene { camera, ..scene.clone() }).collect())
}

/// Renders one frame or, with `--repeat`, a warm-up and that many frames, of each scene; the last
/// pictures and the seconds of each frame.
fn frames(
    scenes: &[Scene],
    options: &RenderOptions,
    arguments: &Arguments,
) -> Result<(Vec<Film>, RenderStatistics, Vec<f64>), PathError> {
    let frame = |what: &str| {
        let start = Instant::now();
        let (mut films, mut statistics) = (Vec::new(), RenderStatistics::default());
        for scene in scenes {
            let (film, more) = arguments.mode.film(scene, options, what)?;
            films.push(film);
            statistics = statistics + more;
        }
        Ok::<_, PathError>((films, statistics, start.elapsed().as_secs_f64()))
    };
    if arguments.repeat.is_some() {
        frame("warm-up")?;
    }
    let count = usize::from(arguments.repeat.unwrap_or(1));
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
