//! `amray movie`: pictures of a moving camera, of time steps, or of both.

mod encoder;
mod frames;
mod keys;

use std::path::PathBuf;

use amray::scene::{Camera, CameraPath, Viewpoint, orbit};
use amray_formats::picture::write_png;
use clap::Args;
use serde_json::json;

use crate::data::absolute;
use crate::scene_file::SceneDocument;
use crate::series::{self, Steps};
use crate::{number, print};

use encoder::Encoder;
use frames::Frames;

/// Frames of a movie of one data set.
const FRAMES: u32 = 120;
/// A whole turn, in degrees.
const TURN: f64 = 360.0;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A data set, or several: the steps of a time series, in this order, or patterns in quotes ('plt*')
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Where the movie goes: a .mp4, .mkv or .webm (by ffmpeg), or a directory for numbered pictures
    #[arg(short, long, value_name = "FILE|DIRECTORY")]
    output: PathBuf,
    /// Frames in all [default: one for each data set, 120 for a single one]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Frames per second
    #[arg(long, value_name = "F", default_value = "24", value_parser = number::positive)]
    fps: f64,
    /// Turn the camera around its target by so many degrees in all [default: 360 for a single data set]
    #[arg(long, value_name = "DEGREES", num_args = 0..=1, default_missing_value = "360", value_parser = number::finite,
          allow_hyphen_values = true, conflicts_with = "keys")]
    orbit: Option<f64>,
    /// Lead the camera through the keys of a JSON file: [{"time": 0, "eye": [x, y, z], "target": [x, y, z]}, ...], with
    /// "up" and "fovy" where they are not 0,0,1 and 30; the last key's time is that of the last frame
    #[arg(long, value_name = "FILE.json")]
    keys: Option<PathBuf>,
    /// Begin anew, whatever frames there are of a movie that was stopped
    #[arg(long)]
    restart: bool,
    /// Keep the frames beside the movie
    #[arg(long)]
    keep_frames: bool,
    /// All else that makes the pictures: a scene file; flags that are given win
    #[arg(long, value_name = "FILE.json")]
    scene: Option<PathBuf>,
    #[command(flatten)]
    document: SceneDocument,
}

/// How the camera moves.
enum Motion {
    /// By so many degrees in all.
    Orbit(f64),
    Keys(CameraPath),
}

impl Motion {
    /// Where the camera is in a frame of `count`, which starts from a viewpoint.
    fn camera(&self, start: Viewpoint, frame: u32, count: u32) -> anyhow::Result<Camera> {
        let (position, last) = (f64::from(frame), f64::from(count.max(2) - 1));
        let viewpoint = match self {
            // After whole turns the first frame comes next, once.
            Self::Orbit(degrees) if degrees % TURN == 0.0 => orbit(start, degrees * position / f64::from(count))?,
            Self::Orbit(degrees) => orbit(start, degrees * position / last)?,
            Self::Keys(path) => {
                let [first, end] = path.times();
                path.at(first + (end - first) * position / last)
            }
        };
        Camera::new(viewpoint).map_err(|error| anyhow::anyhow!("frame {frame}: {error}"))
    }
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let encoder = Encoder::of(&arguments.output, arguments.fps)?;
    let paths = series::paths(&arguments.paths)?;
    let count = arguments.frames.unwrap_or(match &paths[..] {
        [_] => FRAMES,
        paths => u32::try_from(paths.len())?,
    });
    let motion = match (&arguments.keys, arguments.orbit) {
        (Some(path), _) => Motion::Keys(keys::read(path)?),
        (None, Some(degrees)) => Motion::Orbit(degrees),
        (None, None) => Motion::Orbit(if paths.len() == 1 { TURN } else { 0.0 }),
    };
    let mut document = arguments.document.clone();
    if let Some(scene) = &arguments.scene {
        document = document.or(SceneDocument::read(scene)?);
    }
    let directory = encoder.as_ref().map_or(arguments.output.clone(), Encoder::frames_directory);
    // Looks are those of the first step throughout.
    let sampling = document.sampling.clone();
    if paths.len() > 1 {
        // Two steps are in memory at a time.
        document.data.memory = document.data.memory.half();
    }
    let first = series::open(document, &paths[0], None)?;
    let camera = first.camera()?;
    let start = *camera.viewpoint();
    let cameras = (0..count).map(|frame| motion.camera(start, frame, count)).collect::<anyhow::Result<Vec<_>>>()?;
    // Not so how values lie: a later step may be larger.
    let document = SceneDocument { sampling, ..first.resolved(&camera)? };
    let frames = Frames::open(&directory, &described(&paths, &document, &motion, count)?, arguments.restart)?;
    let step_of = |frame: u32| (u64::from(frame) * paths.len() as u64 / u64::from(count)) as usize;
    let left: Vec<_> = (0..count).zip(cameras).filter(|(frame, _)| !frames.path(*frame).exists()).collect();
    let mut steps = Steps::new(&document, &paths, first.volume.index().clone());
    let mut step = (0, first);
    let mut of_steps = left.chunk_by(|a, b| step_of(a.0) == step_of(b.0)).peekable();
    while let Some(of_step) = of_steps.next() {
        let number = step_of(of_step[0].0);
        if step.0 != number {
            drop(step);
            step = (number, steps.open(number)?);
        }
        if let Some(next) = of_steps.peek() {
            steps.prepare(step_of(next[0].0));
        }
        let stage = &step.1;
        for &(frame, camera) in of_step {
            let outlines = stage.outlines(&camera)?;
            let scenes = stage.scenes(camera, outlines.as_ref())?;
            stage.prepare();
            let (films, _) = stage.films(&scenes, &format!("{}/{count}", frame + 1))?;
            let picture = stage.picture(&films, &scenes);
            write_png(&frames.path(frame), [picture.width(), picture.height()], picture.pixels())?;
        }
    }
    if let Some(encoder) = encoder {
        encoder.encode(&frames)?;
        if !arguments.keep_frames {
            frames.remove(count)?;
        }
    }
    Ok(print(&format!("{}\n", arguments.output.display()))?)
}

/// What frames depend on, as JSON.
fn described(paths: &[PathBuf], document: &SceneDocument, motion: &Motion, count: u32) -> anyhow::Result<String> {
    let paths: Vec<PathBuf> = paths.iter().map(|path| absolute(path)).collect();
    let motion = match motion {
        Motion::Orbit(degrees) => json!({ "orbit": degrees }),
        Motion::Keys(path) => json!({ "keys": format!("{path:?}") }),
    };
    let described = json!({ "frames": count, "paths": paths, "motion": motion, "scene": document });
    Ok(serde_json::to_string_pretty(&described)? + "\n")
}
