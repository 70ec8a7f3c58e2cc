//! From frames to one file, by ffmpeg.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use amray_formats::output::check_writable;

use super::frames::{Frames, PATTERN};
use crate::data::absolute;

/// The program that encodes.
const FFMPEG: &str = "ffmpeg";
/// Files that it makes of frames.
const ENDINGS: [&str; 3] = ["mp4", "mkv", "webm"];

/// Makes a movie file.
pub(super) struct Encoder {
    output: PathBuf,
    ending: String,
    fps: f64,
}

impl Encoder {
    /// The encoder for an output; none where that is a directory.
    ///
    /// # Errors
    /// Where the output is neither, cannot be written, or there is no ffmpeg: better known before the work than after it.
    pub(super) fn of(output: &Path, fps: f64) -> anyhow::Result<Option<Self>> {
        let ending = output.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let Some(ending) = ending.filter(|_| !output.is_dir()) else { return Ok(None) };
        let name = output.display();
        if !ENDINGS.contains(&ending.as_str()) {
            anyhow::bail!(
                "{name}: ending .{ending}, expected .mp4, .mkv, .webm or, for numbered pictures, a directory"
            );
        }
        check_writable(output)?;
        let is_there = Command::new(FFMPEG).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if !is_there.is_ok_and(|status| status.success()) {
            anyhow::bail!(
                "{name}: there is no {FFMPEG} to make it: install it, or give a directory (-o frames) for numbered pictures"
            );
        }
        Ok(Some(Self { output: output.into(), ending, fps }))
    }

    /// Where frames lie until the movie is made.
    pub(super) fn frames_directory(&self) -> PathBuf {
        self.beside(".frames")
    }

    /// A name beside the output's.
    fn beside(&self, ending: &str) -> PathBuf {
        let mut name = self.output.clone().into_os_string();
        name.push(ending);
        name.into()
    }

    /// Makes the movie of all frames. It has its name only when it is complete.
    pub(super) fn encode(&self, frames: &Frames) -> anyhow::Result<()> {
        let part = self.beside(&format!(".part.{}", self.ending));
        let name = self.output.display();
        let made = Command::new(FFMPEG)
            // Names in which ffmpeg would find a number's place, a protocol or an option stay out of its sight.
            .current_dir(frames.directory())
            .args(["-y", "-loglevel", "error", "-framerate", &self.fps.to_string(), "-i", PATTERN])
            // Players know no other pixels, which come in pairs.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p"])
            .arg(absolute(&part))
            .stdin(Stdio::null())
            .output();
        let problem = match made {
            Ok(output) if output.status.success() => {
                fs::rename(&part, &self.output).err().map(|error| error.to_string())
            }
            Ok(output) => Some(format!("{FFMPEG}: {}", String::from_utf8_lossy(&output.stderr))),
            Err(error) => Some(format!("{FFMPEG}: {error}")),
        };
        let Some(problem) = problem else { return Ok(()) };
        // It may not have come so far.
        let _ = fs::remove_file(&part);
        anyhow::bail!(
            "{name}: cannot make the movie; the frames are in {}: {problem}",
            self.frames_directory().display()
        )
    }
}
