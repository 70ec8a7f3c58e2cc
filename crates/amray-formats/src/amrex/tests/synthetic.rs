//! Writes small plotfiles: a mesh whose indices do not start at 0, ratios per axis, ghost cells, two fields, several
//! FABs a file; in any version and number format.

use std::fmt::Write;
use std::path::Path;

use amray::hierarchy::IndexBox;

use super::super::real_format::ByteOrder;
use super::VoxelType;

/// How a plotfile is to be written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Synthetic {
    /// Of `Cell_H`.
    pub(super) version: u32,
    pub(super) voxel_type: VoxelType,
    pub(super) byte_order: ByteOrder,
    pub(super) ghosts: [i64; 3],
}

pub(super) const FIELDS: [&str; 2] = ["density", "x velocity"];
pub(super) const RATIO: [i64; 3] = [2, 1, 4];
/// What ghost cells hold: nothing to be seen.
const GHOST: f64 = 1e30;

pub(super) const PLAIN: Synthetic =
    Synthetic { version: 1, voxel_type: VoxelType::F64, byte_order: ByteOrder::Little, ghosts: [0; 3] };

/// The two levels' domains.
pub(super) fn domains() -> [IndexBox; 2] {
    let coarse = IndexBox::new([-4, 0, 2], [4, 4, 6]);
    [coarse, coarse.refined(RATIO)]
}

/// The bricks of both levels.
pub(super) fn bricks() -> [Vec<IndexBox>; 2] {
    let coarse = vec![IndexBox::new([-4, 0, 2], [0, 4, 6]), IndexBox::new([0, 0, 2], [4, 4, 6])];
    let fine = vec![
        IndexBox::new([-4, 1, 12], [0, 3, 16]),
        IndexBox::new([0, 1, 12], [2, 3, 16]),
        IndexBox::new([2, 1, 16], [4, 2, 20]),
    ];
    [coarse, fine]
}

/// Another value for each field, level and cell; exact in single precision.
pub(super) fn value(field: usize, level: usize, [i, j, k]: [i64; 3]) -> f64 {
    (100_000 * field as i64 + 50_000 * level as i64 + i + 40 * j + 400 * k) as f64 + 0.5
}

impl Synthetic {
    pub(super) fn write(&self, directory: &Path) {
        std::fs::write(directory.join("Header"), header()).unwrap();
        for (level, bricks) in bricks().iter().enumerate() {
            self.write_level(directory, level, bricks);
        }
    }

    /// Two files: the first brick lies alone, behind some bytes that mean nothing, the others share a file.
    fn write_level(&self, directory: &Path, level: usize, bricks: &[IndexBox]) {
        let directory = directory.join(format!("Level_{level}"));
        std::fs::create_dir_all(&directory).unwrap();
        let mut files = [b"some bytes".to_vec(), Vec::new()];
        let mut places = String::new();
        for (brick, cells) in bricks.iter().enumerate() {
            let file = brick.min(1);
            writeln!(places, "FabOnDisk: Cell_D_{file:05} {}", files[file].len()).unwrap();
            self.append_fab(&mut files[file], level, cells);
        }
        for (file, bytes) in files.iter().enumerate() {
            std::fs::write(directory.join(format!("Cell_D_{file:05}")), bytes).unwrap();
        }
        let count = bricks.len();
        let ghosts = match self.ghosts {
            [x, y, z] if x == y && y == z => x.to_string(),
            [x, y, z] => format!("({x},{y},{z})"),
        };
        let boxes: String = bricks.iter().map(|&cells| box_text(cells) + "\n").collect();
        let per_fab = format!("{count},2\n{}\n", "0.5,1.5,\n".repeat(count));
        let tables = match self.version {
            1 | 3 => per_fab.repeat(2),
            4 => "0.5,0.5,\n1.5,1.5,\n".to_owned(),
            _ => String::new(),
        };
        let format = if self.version == 1 { String::new() } else { format!("{}\n", self.real_format()) };
        let text =
            format!("{}\n1\n2\n{ghosts}\n({count} 0\n{boxes})\n{count}\n{places}\n{tables}{format}", self.version);
        std::fs::write(directory.join("Cell_H"), text).unwrap();
    }

    fn append_fab(&self, bytes: &mut Vec<u8>, level: usize, cells: &IndexBox) {
        let stored = cells.grown(self.ghosts);
        if self.version == 1 {
            bytes.extend(format!("FAB {}{} 2\n", self.real_format(), box_text(stored)).bytes());
        }
        for field in 0..FIELDS.len() {
            for cell in stored.iter() {
                let value = if cells.contains(cell) { value(field, level, cell) } else { GHOST };
                match (self.voxel_type, self.byte_order) {
                    (VoxelType::F32, ByteOrder::Little) => bytes.extend((value as f32).to_le_bytes()),
                    (VoxelType::F32, ByteOrder::Big) => bytes.extend((value as f32).to_be_bytes()),
                    (VoxelType::F64, ByteOrder::Little) => bytes.extend(value.to_le_bytes()),
                    (VoxelType::F64, ByteOrder::Big) => bytes.extend(value.to_be_bytes()),
                }
            }
        }
    }

    fn real_format(&self) -> &'static str {
        match (self.voxel_type, self.byte_order) {
            (VoxelType::F32, ByteOrder::Little) => "((8, (32 8 23 0 1 9 0 127)),(4, (4 3 2 1)))",
            (VoxelType::F32, ByteOrder::Big) => "((8, (32 8 23 0 1 9 0 127)),(4, (1 2 3 4)))",
            (VoxelType::F64, ByteOrder::Little) => "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))",
            (VoxelType::F64, ByteOrder::Big) => "((8, (64 11 52 0 1 12 0 1023)),(8, (1 2 3 4 5 6 7 8)))",
        }
    }
}

/// `((0,0,0) (15,15,15) (0,0,0))`
fn box_text(cells: IndexBox) -> String {
    let corners = cells.to_string();
    format!("{} (0,0,0))", corners.strip_suffix(')').unwrap())
}

/// Cells of 0.5 x 1 x 2 from (10, 0, -1) on.
fn header() -> String {
    let [coarse, fine] = domains().map(box_text);
    let mut text = format!(
        "HyperCLaw-V1.1\n2\n{}\n{}\n3\n2.5\n1\n10 0 -1 \n14 4 7 \n2 \n\
         {coarse} {fine} \n3 6 \n0.5 1 2 \n0.25 1 0.5 \n0\n0\n",
        FIELDS[0], FIELDS[1]
    );
    for (level, bricks) in bricks().iter().enumerate() {
        writeln!(text, "{level} {} 2.5\n{}", bricks.len(), 3 * (level + 1)).unwrap();
        text.push_str(&"0 1\n0 1\n0 1\n".repeat(bricks.len()));
        writeln!(text, "Level_{level}/Cell").unwrap();
    }
    text
}
