//! The file `Cell_H` of a level: its boxes, and where the values (FABs) of each lie.
//!
//! Line by line: version, way of writing, components, ghost cells, `(` number of boxes, the boxes, `)`, number of FABs,
//! `FabOnDisk: file offset` for each, tables of minima and maxima (version 2 none, 1 and 3 per FAB, 4 per component),
//! and from version 2 on, whose FABs have no headers, the number format.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use amray::hierarchy::IndexBox;

use super::real_format::{REAL_FORMAT, RealFormat};
use super::text::{INDEX_BOX, LineReader, Scanner};
use crate::FormatError;
use crate::relative_path::path_below;

/// The newest version of `Cell_H`.
const NEWEST_VERSION: u32 = 4;

/// What `Cell_H` says.
#[derive(Debug, PartialEq)]
pub(super) struct MultiFab {
    /// Values per cell.
    pub(super) components: u32,
    /// Ghost cells on either side, per axis.
    pub(super) ghosts: [i64; 3],
    /// The bricks, without ghost cells.
    pub(super) boxes: Vec<IndexBox>,
    /// Where each brick's values lie.
    pub(super) fabs: Vec<FabOnDisk>,
    /// The files that hold values.
    pub(super) files: Vec<PathBuf>,
    /// The number format; `None` where each FAB has a header that says so.
    pub(super) format: Option<RealFormat>,
}

/// Where a FAB starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FabOnDisk {
    /// Which of [`MultiFab::files`].
    pub(super) file: usize,
    /// The place of its first byte.
    pub(super) offset: u64,
}

impl MultiFab {
    /// Reads `Cell_H`, which must hold as many `components` and `grids` as `Header` says.
    pub(super) fn read(path: &Path, components: usize, grids: usize) -> Result<Self, FormatError> {
        let mut lines = LineReader::open(path)?;
        let version = lines.parse(format_args!("a version, 1 to {NEWEST_VERSION}"), |line| {
            line.number().filter(|version: &u32| (1..=NEWEST_VERSION).contains(version))
        })?;
        lines.number::<i32>("the way of writing, a number")?;
        let components = lines.parse(format_args!("{components} components, as in Header"), |line| {
            line.number().filter(|&found: &u32| u64::from(found) == components as u64)
        })?;
        let ghosts = lines.parse("the number of ghost cells, such as 1 or (1,1,0)", ghost_cells)?;

        lines.parse(format_args!("the number of boxes, ({grids} 0, as in Header"), |line| {
            line.symbol("(")?;
            line.number().filter(|&boxes: &usize| boxes == grids)
        })?;
        let mut boxes = Vec::new();
        for _ in 0..grids {
            boxes.push(lines.parse(INDEX_BOX, |line| line.index_box())?);
        }
        lines.parse("the end of the boxes, )", |line| line.symbol(")"))?;

        lines.parse(format_args!("the number of FABs, {grids}"), |line| {
            line.number().filter(|&fabs: &usize| fabs == grids)
        })?;
        let mut files =
            Files { directory: path.parent().unwrap_or(Path::new("")), paths: Vec::new(), numbers: HashMap::new() };
        let mut fabs = Vec::new();
        for _ in 0..grids {
            fabs.push(lines.parse("FabOnDisk:, a file beside this one and an offset", |line| files.fab_on_disk(line))?);
        }
        let format = match version {
            1 => None,
            _ => Some(format_after_tables(&mut lines)?),
        };
        Ok(Self { components, ghosts, boxes, fabs, files: files.paths, format })
    }
}

/// One number for all axes, or one per axis; not negative.
fn ghost_cells(line: &mut Scanner<'_>) -> Option<[i64; 3]> {
    let ghosts = match line.rest().starts_with('(') {
        true => line.index()?,
        false => [i64::from(line.number::<i32>()?); 3],
    };
    ghosts.iter().all(|&cells| cells >= 0).then_some(ghosts)
}

/// Steps over the tables of minima and maxima, which hold no parentheses.
fn format_after_tables(lines: &mut LineReader) -> Result<RealFormat, FormatError> {
    loop {
        let format = lines.parse(REAL_FORMAT, |line| match line.rest().starts_with('(') {
            true => RealFormat::scan(line).map(Some),
            false => Some(None),
        })?;
        if let Some(format) = format {
            return Ok(format);
        }
    }
}

/// The distinct files that FABs lie in.
struct Files<'a> {
    directory: &'a Path,
    paths: Vec<PathBuf>,
    numbers: HashMap<String, usize>,
}

impl Files<'_> {
    /// `FabOnDisk: Cell_D_00000 196697`
    fn fab_on_disk(&mut self, line: &mut Scanner<'_>) -> Option<FabOnDisk> {
        line.symbol("FabOnDisk:")?;
        let name = line.word()?;
        let path = path_below(name)?;
        let offset = line.number()?;
        let file = *self.numbers.entry(name.to_owned()).or_insert_with(|| {
            self.paths.push(self.directory.join(path));
            self.paths.len() - 1
        });
        Some(FabOnDisk { file, offset })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEGINNING: &str = "1\n2\n(1,1,0)\n(2 0\n((0,0,0) (7,7,7) (0,0,0))\n((8,0,0) (15,7,7) (0,0,0))\n)\n2\n\
        FabOnDisk: Cell_D_00001 0\nFabOnDisk: Cell_D_00000 4096\n\n";

    fn read(text: &str) -> Result<MultiFab, String> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("Cell_H");
        std::fs::write(&path, text).unwrap();
        let text_of = |error: FormatError| error.to_string().replace(&format!("{}: ", path.display()), "");
        let mut multifab = MultiFab::read(&path, 2, 2).map_err(text_of)?;
        multifab.files.iter_mut().for_each(|file| *file = file.strip_prefix(directory.path()).unwrap().into());
        Ok(multifab)
    }

    #[test]
    fn all_versions() {
        let single = "((8, (32 8 23 0 1 9 0 127)),(4, (4 3 2 1)))\n";
        let per_fab = "2,2\n0.5,1.5,\n2.5,3.5,\n\n2,2\n0.5,1.5,\nnan,3.5,\n\n";
        let version_1 = read(&format!("1\n{BEGINNING}{per_fab}")).unwrap();
        let expected = MultiFab {
            components: 2,
            ghosts: [1, 1, 0],
            boxes: vec![IndexBox::new([0; 3], [8; 3]), IndexBox::new([8, 0, 0], [16, 8, 8])],
            fabs: vec![FabOnDisk { file: 0, offset: 0 }, FabOnDisk { file: 1, offset: 4096 }],
            files: vec!["Cell_D_00001".into(), "Cell_D_00000".into()],
            format: None,
        };
        assert_eq!(version_1, expected);
        let format = RealFormat::scan(&mut Scanner(single));
        for (version, tables) in [(2, ""), (3, per_fab), (4, "0.5,1.5,\n2.5,3.5,\n")] {
            let found = read(&format!("{version}\n{BEGINNING}{tables}{single}")).unwrap();
            assert_eq!((found.format, found.fabs), (format, expected.fabs.clone()), "version {version}");
        }
    }

    #[test]
    fn errors_name_the_line() {
        let error = |from: &str, to: &str| read(&format!("2\n{BEGINNING}").replacen(from, to, 1)).unwrap_err();
        assert_eq!(error("2\n1", "5\n1"), "line 1: \"5\", expected a version, 1 to 4");
        assert_eq!(error("\n2\n(1", "\n3\n(1"), "line 3: \"3\", expected 2 components, as in Header");
        assert_eq!(error("(1,1,0)", "-1"), "line 4: \"-1\", expected the number of ghost cells, such as 1 or (1,1,0)");
        assert_eq!(error("(2 0", "(3 0"), "line 5: \"(3 0\", expected the number of boxes, (2 0, as in Header");
        assert_eq!(
            error("(7,7,7) (0", "(7,7,7) (1"),
            format!("line 6: \"((0,0,0) (7,7,7) (1,0,0))\", expected {INDEX_BOX}")
        );
        let beside = "expected FabOnDisk:, a file beside this one and an offset";
        assert_eq!(error("Cell_D_00000", "../Cell_D"), format!("line 11: \"FabOnDisk: ../Cell_D 4096\", {beside}"));
        assert_eq!(error(" 4096", " -1"), format!("line 11: \"FabOnDisk: Cell_D_00000 -1\", {beside}"));
        assert_eq!(error("none", ""), format!("line 13: the file ends here, expected {REAL_FORMAT}"));
        assert_eq!(
            error("4096\n\n", "4096\n((8, (64 15 48\n"),
            format!("line 12: \"((8, (64 15 48\", expected {REAL_FORMAT}")
        );
    }
}
