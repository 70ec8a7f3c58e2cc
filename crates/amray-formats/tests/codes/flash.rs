//! FLASH files, written here after the FLASH4 User's Guide: no file of the code itself was at hand.

use std::path::{Path, PathBuf};

use amray_testing::Random;
use rust_hdf5::format::messages::datatype::{CompoundMember, DatatypeMessage};
use rust_hdf5::{FileLocking, H5File, H5Group, H5Type};

use super::{cells, names, opened, refused, values};

const BLOCK: usize = 4;

/// A root of 2x1x1 blocks, of which the first is refined, and its last child again. Parents stay in the file.
struct Flash {
    /// Corner, width and level of each block, and whether it is a leaf.
    blocks: Vec<([f64; 3], f64, i32, bool)>,
}

impl Flash {
    fn new() -> Self {
        let mut blocks = vec![([1.0, 2.0, -3.0], 1.0, 1, false), ([2.0, 2.0, -3.0], 1.0, 1, true)];
        let children = |[x, y, z]: [f64; 3], half: f64| {
            (0..8).map(move |child| {
                [
                    x + half * f64::from(child & 1),
                    y + half * f64::from(child >> 1 & 1),
                    z + half * f64::from(child >> 2),
                ]
            })
        };
        blocks.extend(children([1.0, 2.0, -3.0], 0.5).enumerate().map(|(child, corner)| (corner, 0.5, 2, child < 7)));
        blocks.extend(children([1.5, 2.5, -2.5], 0.25).map(|corner| (corner, 0.25, 3, true)));
        Self { blocks }
    }

    /// The position of the centre of a cell of a block.
    fn center(&self, block: usize, cell: [usize; 3]) -> [f64; 3] {
        let (corner, width, ..) = self.blocks[block];
        std::array::from_fn(|axis| corner[axis] + width * (cell[axis] as f64 + 0.5) / BLOCK as f64)
    }

    fn write(&self, path: &Path, single: bool) {
        let file = H5File::options().locking(FileLocking::BestEffort).create(path).unwrap();
        let root = file.root_group();
        let count = self.blocks.len();
        let bounds =
            self.blocks.iter().flat_map(|(corner, width, ..)| corner.iter().flat_map(move |low| [*low, low + width]));
        set(&root, "bounding box", &[count, 3, 2], &bounds.collect::<Vec<f64>>());
        set(&root, "refine level", &[count], &self.blocks.iter().map(|block| block.2).collect::<Vec<i32>>());
        let kinds = self.blocks.iter().map(|block| if block.3 { 1 } else { 2 });
        set(&root, "node type", &[count], &kinds.collect::<Vec<i32>>());
        list(&root, "integer scalars", &[("nxb", 4i32), ("nyb", 4), ("nzb", 4), ("dimensionality", 3)]);
        list(&root, "real scalars", &[("time", 0.25f64), ("dt", 1e-3)]);
        let names = DatatypeMessage::FixedString { size: 4, padding: 2, charset: 0 };
        let unknowns = root.new_dataset::<u8>().datatype(names).shape([2, 1]).create("unknown names").unwrap();
        unknowns.write_raw_bytes(b"denspres").unwrap();
        for (name, scale) in [("dens", 1.0), ("pres", 10.0)] {
            let cells = (0..count).flat_map(|block| (0..BLOCK.pow(3)).map(move |cell| (block, cell)));
            let value = |(block, cell): (usize, usize)| {
                let [x, y, z] = self.center(block, [cell % BLOCK, cell / BLOCK % BLOCK, cell / BLOCK / BLOCK]);
                // What parents hold must not be looked at.
                if self.blocks[block].3 { scale * (x + 10.0 * y + 100.0 * z) } else { f64::NAN }
            };
            let values: Vec<f64> = cells.map(value).collect();
            let shape = [count, BLOCK, BLOCK, BLOCK];
            match single {
                true => set(&root, name, &shape, &values.iter().map(|&value| value as f32).collect::<Vec<f32>>()),
                false => set(&root, name, &shape, &values),
            }
        }
        file.close().unwrap();
    }
}

fn set<T: H5Type>(root: &H5Group, name: &str, shape: &[usize], values: &[T]) {
    root.new_dataset::<T>().shape(shape).create(name).unwrap().write_raw(values).unwrap();
}

trait Number: H5Type + Copy {
    fn bytes(self) -> Vec<u8>;
}

impl Number for i32 {
    fn bytes(self) -> Vec<u8> {
        self.to_le_bytes().into()
    }
}

impl Number for f64 {
    fn bytes(self) -> Vec<u8> {
        self.to_le_bytes().into()
    }
}

/// Names of 80 characters, padded with spaces, with their values.
fn list<T: Number>(root: &H5Group, name: &str, values: &[(&str, T)]) {
    let text = DatatypeMessage::FixedString { size: 80, padding: 2, charset: 0 };
    let members = vec![
        CompoundMember { name: "name".into(), offset: 0, datatype: text },
        CompoundMember { name: "value".into(), offset: 80, datatype: T::hdf5_type() },
    ];
    let datatype = DatatypeMessage::compound((80 + size_of::<T>()) as u32, members);
    let set = root.new_dataset::<u8>().datatype(datatype).shape([values.len()]).create(name).unwrap();
    let bytes = values.iter().flat_map(|(name, value)| [format!("{name:80}").into_bytes(), value.bytes()].concat());
    set.write_raw_bytes(&bytes.collect::<Vec<u8>>()).unwrap();
}

fn file(directory: &Path, single: bool) -> PathBuf {
    let path = directory.join("flash_hdf5_chk_0000");
    Flash::new().write(&path, single);
    path
}

#[test]
fn leaves_are_read_and_completed() {
    let directory = tempfile::tempdir().unwrap();
    for single in [false, true] {
        let data = opened(&file(directory.path(), single));
        assert_eq!((data.format(), data.time(), names(&*data)), ("FLASH HDF5", Some(0.25), vec!["dens", "pres"]));
        assert_eq!(data.hierarchy().bounds(), [[1.0, 2.0, -3.0], [3.0, 3.0, -2.0]]);
        assert_eq!(cells(&*data), [2 * 64, 8 * 64, 8 * 64]);
        let flash = Flash::new();
        let centers: Vec<[f64; 3]> = (0..flash.blocks.len())
            .filter(|block| flash.blocks[*block].3)
            .flat_map(|block| [[0, 0, 0], [3, 1, 2]].map(|cell| flash.center(block, cell)))
            .collect();
        let expected = centers.iter().map(|[x, y, z]| 10.0 * (x + 10.0 * y + 100.0 * z));
        for (found, expected) in values(&*data, "pres", &centers).into_iter().zip(expected) {
            assert!((found - expected).abs() < if single { 1e-3 } else { 1e-9 }, "{found}, {expected}");
        }
    }
}

#[test]
fn damaged_files_are_refused_or_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), true);
    let content = std::fs::read(&path).unwrap();
    let mut random = Random(11);
    for _ in 0..400 {
        std::fs::write(&path, super::damage::mutated(&content, &mut random, usize::MAX)).unwrap();
        let _ = super::damage::survive(&path);
    }
    for _ in 0..40 {
        std::fs::write(&path, &content[..random.integer(0, content.len() as i64 - 1) as usize]).unwrap();
        assert!(super::damage::survive(&path).is_err());
    }
    let mut flash = Flash::new();
    flash.blocks[5].0[0] += 0.05;
    flash.write(&path, false);
    assert!(refused(&path).contains("block 5 reaches over"), "{}", refused(&path));
}
