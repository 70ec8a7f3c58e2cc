//! Frames on disk: numbered pictures, and what they are of, so that a movie that was stopped can go on.

use std::fs;
use std::path::{Path, PathBuf};

use amray_formats::output::OutputFile;

/// What the frames of a directory are of.
const MANIFEST: &str = "movie.json";
/// The names of all frames, as ffmpeg has them.
pub(super) const PATTERN: &str = "frame_%05d.png";

/// A directory with the frames of one movie.
pub(super) struct Frames {
    directory: PathBuf,
}

impl Frames {
    /// The directory for frames that are `described` so; those that are there are kept.
    ///
    /// # Errors
    /// Where the directory has frames of another movie, unless this one is to `restart` it; and where it cannot be written.
    pub(super) fn open(directory: &Path, described: &str, restart: bool) -> anyhow::Result<Self> {
        let name = directory.display();
        fs::create_dir_all(directory)
            .map_err(|error| anyhow::anyhow!("{name}: cannot make the directory of frames: {error}"))?;
        let frames = Self { directory: directory.into() };
        let manifest = directory.join(MANIFEST);
        let is_same = fs::read_to_string(&manifest).is_ok_and(|found| found == described);
        if restart || !is_same {
            let old = frames.existing()?;
            if !restart && !old.is_empty() {
                anyhow::bail!(
                    "{name}: there are {} frames of another movie, or with other flags: name another output, or add \
                     --restart to remove them",
                    old.len()
                );
            }
            // First the frames: what is left of them must not be taken for those of the new movie.
            for path in old {
                fs::remove_file(&path)
                    .map_err(|error| anyhow::anyhow!("{}: cannot remove: {error}", path.display()))?;
            }
            OutputFile::write(&manifest, |file| std::io::Write::write_all(file, described.as_bytes()))?;
        }
        Ok(frames)
    }

    /// Where a frame is, once it is complete.
    pub(super) fn path(&self, number: u32) -> PathBuf {
        self.directory.join(format!("frame_{number:05}.png"))
    }

    /// Where all of them are.
    pub(super) fn directory(&self) -> &Path {
        &self.directory
    }

    /// All frames that are there.
    fn existing(&self) -> anyhow::Result<Vec<PathBuf>> {
        let is_frame = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let number = name.strip_prefix("frame_").and_then(|name| name.strip_suffix(".png"));
            number.is_some_and(|number| number.len() >= 5 && number.bytes().all(|digit| digit.is_ascii_digit()))
        };
        let entries = fs::read_dir(&self.directory)
            .map_err(|error| anyhow::anyhow!("{}: cannot read: {error}", self.directory.display()))?;
        Ok(entries.flatten().map(|entry| entry.path()).filter(is_frame).collect())
    }

    /// Removes the frames, and the directory if nothing else is in it.
    pub(super) fn remove(self, count: u32) -> anyhow::Result<()> {
        for path in (0..count).map(|number| self.path(number)).chain([self.directory.join(MANIFEST)]) {
            fs::remove_file(&path).map_err(|error| anyhow::anyhow!("{}: cannot remove: {error}", path.display()))?;
        }
        // Whoever has put something there keeps it.
        let _ = fs::remove_dir(&self.directory);
        Ok(())
    }
}
