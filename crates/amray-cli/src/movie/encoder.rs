//! From frames to one file, by ffmpeg.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use amray_formats::output::{OutputFile, check_writable};

use super::frames::{Frames, PATTERN};
use crate::data::absolute;

/// The program that encodes.
const FFMPEG: &str = "ffmpeg";
/// Files that it makes of frames: their endings, and what ffmpeg calls their kinds.
const KINDS: [(&str, &str); 3] = [("mp4", "mp4"), ("mkv", "matroska"), ("webm", "webm")];

/// Makes a movie file.
pub(super) struct Encoder {
    output: PathBuf,
    kind: &'static str,
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
        let Some((_, kind)) = KINDS.into_iter().find(|(known, _)| *known == ending) else {
            anyhow::bail!(
                "{name}: ending .{ending}, expected .mp4, .mkv, .webm or, for numbered pictures, a directory"
            );
        };
        check_writable(output)?;
        let is_there = Command::new(FFMPEG).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if !is_there.is_ok_and(|status| status.success()) {
            anyhow::bail!(
                "{name}: there is no {FFMPEG} to make it: install it, or give a directory (-o frames) for numbered pictures"
            );
        }
        Ok(Some(Self { output: output.into(), kind, fps }))
    }

    /// Where frames lie until the movie is made: beside it.
    pub(super) fn frames_directory(&self) -> PathBuf {
        let mut name = self.output.clone().into_os_string();
        name.push(".frames");
        name.into()
    }

    /// Makes the movie of all frames. It has its name only when it is complete.
    pub(super) fn encode(&self, frames: &Frames) -> anyhow::Result<()> {
        let file = OutputFile::create(&self.output)?;
        let made = Command::new(FFMPEG)
            // Names in which ffmpeg would find a number's place, a protocol or an option stay out of its sight.
            .current_dir(frames.directory())
            .args(["-y", "-loglevel", "error", "-framerate", &self.fps.to_string(), "-i", PATTERN])
            // Players know no other pixels, which come in pairs.
            .args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p", "-f", self.kind])
            .arg(absolute(file.temporary_path()))
            .stdin(Stdio::null())
            .output();
        let problem = match made {
            Ok(output) if output.status.success() => return Ok(file.finish()?),
            Ok(output) => String::from_utf8_lossy(&output.stderr).into_owned(),
            Err(error) => error.to_string(),
        };
        anyhow::bail!(
            "{}: cannot make the movie; the frames are in {}: {FFMPEG}: {problem}",
            self.output.display(),
            self.frames_directory().display()
        )
    }
}
