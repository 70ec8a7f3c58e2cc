//! `cargo xtask gallery`: renders figures and writes the page that shows them, with the command that made each.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};
use clap::Args;

use crate::figures::{FIGURES, Figure, Picture};

#[derive(Args)]
pub(crate) struct Arguments {
    /// Where pictures and their page (README.md) go
    #[arg(default_value = "target/gallery")]
    folder: PathBuf,
    /// The folder of real files [default: AMRAY_DATA, or ../shared/data]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Pixels, where a picture has no size of its own
    #[arg(long, default_value = "512x512")]
    size: String,
    /// One figure alone
    #[arg(long)]
    only: Option<String>,
}

/// Where things are.
struct Places {
    program: PathBuf,
    data: PathBuf,
    demo: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize()?;
    let build = ["build", "--release", "--workspace"];
    let built = Command::new(env!("CARGO")).args(build).current_dir(&root).status()?;
    if !built.success() {
        bail!("the program cannot be built");
    }
    let folder = &arguments.folder;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let data = arguments.data.clone().or_else(|| std::env::var_os("AMRAY_DATA").map(PathBuf::from));
    let places = Places {
        program: root.join("target/release/amray"),
        data: data.unwrap_or_else(|| root.join("../shared/data")),
        demo: folder.join("demo.hdf5"),
    };
    if !places.demo.exists() {
        places.amray(&["demo", "-o", &places.demo.to_string_lossy()])?;
    }
    let mut page = String::from("# Gallery\n\nMade by `cargo xtask gallery`.\n");
    let figures = FIGURES.iter().filter(|figure| arguments.only.as_ref().is_none_or(|only| only == figure.name));
    for Figure { name, caption, pictures } in figures {
        write!(page, "\n## {caption}\n")?;
        for (number, Picture { title, flags }) in pictures.iter().enumerate() {
            let file = format!("{name}-{}.png", number + 1);
            match places.draw(flags, &arguments.size, &folder.join(&file))? {
                true => write!(page, "\n![{title}]({file})\n{title}\n\n```\namray {flags} -o {file}\n```\n")?,
                false => write!(page, "\n{title}: its data are not here.\n\n```\namray {flags}\n```\n")?,
            }
        }
    }
    Ok(fs::write(folder.join("README.md"), page)?)
}

impl Places {
    /// Makes a picture; false where the data that it is of are missing.
    fn draw(&self, flags: &str, size: &str, output: &Path) -> anyhow::Result<bool> {
        let place = |word: &str| match (word.strip_prefix("DATA/"), word) {
            (Some(path), _) => self.data.join(path).to_string_lossy().into_owned(),
            (None, "DEMO") => self.demo.to_string_lossy().into_owned(),
            (None, word) => word.to_owned(),
        };
        let mut words: Vec<String> = flags.split_whitespace().map(place).collect();
        if !Path::new(&words[1]).exists() {
            return Ok(false);
        }
        if !words.iter().any(|word| word == "--size") {
            words.extend(["--size".into(), size.into()]);
        }
        words.extend(["-o".into(), output.to_string_lossy().into_owned()]);
        self.amray(&words.iter().map(String::as_str).collect::<Vec<_>>())?;
        Ok(true)
    }

    fn amray(&self, words: &[&str]) -> anyhow::Result<()> {
        let status = Command::new(&self.program).args(words).status()?;
        if !status.success() {
            bail!("amray {}: failed", words.join(" "));
        }
        Ok(())
    }
}
