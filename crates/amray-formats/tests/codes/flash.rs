//! FLASH files, written here after the FLASH4 User's Guide: no file of the code itself was at hand.

use std::path::{Path, PathBuf};

use amray_testing::Random;
use rust_hdf5::format::messages::datatype::{CompoundMember, DatatypeMessage};
use rust_hdf5::{FileLocking, H5File, H5Group, H5Type};

use super::{cells, names, opened, refused, values};

/// A root of 2x1x1 blocks, of which the first is refined, and its last child again. Parents stay in the file. Neither
/// blocks nor the domain are cubes.
struct Flash {
    /// Corner and level of each block, and whether it is a leaf.
    blocks: Vec<([f64; 3], i32, bool)>,
    integers: Vec<(&'static str, i32)>,
    /// Runtime parameters.
    reals: Vec<(&'static str, f64)>,
    /// A list, and the coordinates it tells.
    geometry: Option<(&'static str, &'static str)>,
    /// Names of the data sets of `de` and `pres`.
    sets: [&'static str; 2],
    single: bool,
    guards: usize,
}

/// Cells of a block.
const BLOCK: [usize; 3] = [4, 2, 6];
/// The width of a block of the root.
const WIDTH: [f64; 3] = [1.0, 0.5, 2.25];

impl Flash {
    fn new() -> Self {
        let mut blocks = vec![([1.0, 2.0, -3.0], 1, false), ([2.0, 2.0, -3.0], 1, true)];
        let children = |corner: [f64; 3], level: i32| {
            let width = WIDTH.map(|width| width / f64::from(1 << (level - 1)));
            let place = move |child: i32, axis: usize| corner[axis] + width[axis] * f64::from(child >> axis & 1);
            (0..8).map(move |child| std::array::from_fn(|axis| place(child, axis)))
        };
        blocks.extend(children([1.0, 2.0, -3.0], 2).enumerate().map(|(child, corner)| (corner, 2, child < 7)));
        let (last, ..) = blocks[9];
        blocks.extend(children(last, 3).map(|corner| (corner, 3, true)));
        let integers = [("nxb", 4), ("nyb", 2), ("nzb", 6), ("dimensionality", 3), ("globalnumblocks", 18)];
        let geometry = Some(("string scalars", "cartesian"));
        let sets = ["de  ", "pres"];
        Self { blocks, integers: integers.into(), reals: Vec::new(), geometry, sets, single: false, guards: 0 }
    }

    fn width(&self, block: usize) -> [f64; 3] {
        WIDTH.map(|width| width / f64::from(1 << (self.blocks[block].1 - 1)))
    }

    /// The position of the centre of a cell of a block.
    fn center(&self, block: usize, cell: [usize; 3]) -> [f64; 3] {
        let (corner, width) = (self.blocks[block].0, self.width(block));
        std::array::from_fn(|axis| corner[axis] + width[axis] * (cell[axis] as f64 + 0.5) / BLOCK[axis] as f64)
    }

    fn bounds(&self) -> Vec<f64> {
        let ends = |block: usize| {
            let (corner, width) = (self.blocks[block].0, self.width(block));
            (0..3).flat_map(move |axis| [corner[axis], corner[axis] + width[axis]])
        };
        (0..self.blocks.len()).flat_map(ends).collect()
    }

    fn write(&self, path: &Path) {
        let file = H5File::options().locking(FileLocking::BestEffort).create(path).unwrap();
        let root = file.root_group();
        let count = self.blocks.len();
        match self.single {
            true => set(&root, "bounding box", &[count, 3, 2], &singles(&self.bounds())),
            false => set(&root, "bounding box", &[count, 3, 2], &self.bounds()),
        }
        set(&root, "refine level", &[count], &self.blocks.iter().map(|block| block.1).collect::<Vec<i32>>());
        let kinds = self.blocks.iter().map(|block| if block.2 { 1 } else { 2 });
        set(&root, "node type", &[count], &kinds.collect::<Vec<i32>>());
        list(&root, "integer scalars", &self.integers);
        list(&root, "real scalars", &[("time", 0.25f64), ("dt", 1e-3)]);
        if !self.reals.is_empty() {
            list(&root, "real runtime parameters", &self.reals);
        }
        if let Some((name, geometry)) = self.geometry {
            list(&root, name, &[("run_comment", ""), ("geometry", geometry)]);
        }
        let names = DatatypeMessage::FixedString { size: 4, padding: 2, charset: 0 };
        let unknowns = root.new_dataset::<u8>().datatype(names).shape([2, 1]).create("unknown names").unwrap();
        unknowns.write_raw_bytes(b"de  pres").unwrap();
        for (name, scale) in self.sets.into_iter().zip([1.0, 10.0]) {
            let [x, y, z] = BLOCK.map(|cells| cells + 2 * self.guards);
            let cells = (0..count).flat_map(|block| (0..x * y * z).map(move |cell| (block, cell)));
            let value = |(block, cell): (usize, usize)| {
                let center = self.center(block, [cell % x, cell / x % y, cell / x / y]);
                // What parents hold must not be looked at.
                if self.blocks[block].2 { scale * value_at(center) } else { f64::NAN }
            };
            let values: Vec<f64> = cells.map(value).collect();
            match self.single {
                true => set(&root, name, &[count, z, y, x], &singles(&values)),
                false => set(&root, name, &[count, z, y, x], &values),
            }
        }
        file.close().unwrap();
    }
}

fn value_at([x, y, z]: [f64; 3]) -> f64 {
    x + 10.0 * y + 100.0 * z
}

fn singles(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&value| value as f32).collect()
}

fn set<T: H5Type>(root: &H5Group, name: &str, shape: &[usize], values: &[T]) {
    root.new_dataset::<T>().shape(shape).create(name).unwrap().write_raw(values).unwrap();
}

trait Listed: Copy {
    fn datatype() -> DatatypeMessage;
    fn stored(self) -> Vec<u8>;
}

/// Texts fill 80 characters.
impl Listed for &str {
    fn datatype() -> DatatypeMessage {
        DatatypeMessage::FixedString { size: 80, padding: 2, charset: 0 }
    }

    fn stored(self) -> Vec<u8> {
        format!("{self:80}").into_bytes()
    }
}

impl Listed for i32 {
    fn datatype() -> DatatypeMessage {
        Self::hdf5_type()
    }

    fn stored(self) -> Vec<u8> {
        self.to_le_bytes().into()
    }
}

impl Listed for f64 {
    fn datatype() -> DatatypeMessage {
        Self::hdf5_type()
    }

    fn stored(self) -> Vec<u8> {
        self.to_le_bytes().into()
    }
}

/// Names of 80 characters, padded with spaces, with their values.
fn list<T: Listed>(root: &H5Group, name: &str, values: &[(&str, T)]) {
    let members = vec![
        CompoundMember { name: "name".into(), offset: 0, datatype: <&str>::datatype() },
        CompoundMember { name: "value".into(), offset: 80, datatype: T::datatype() },
    ];
    let size = 80 + values[0].1.stored().len();
    let datatype = DatatypeMessage::compound(size as u32, members);
    let set = root.new_dataset::<u8>().datatype(datatype).shape([values.len()]).create(name).unwrap();
    let bytes = values.iter().flat_map(|(name, value)| [name.stored(), value.stored()].concat());
    set.write_raw_bytes(&bytes.collect::<Vec<u8>>()).unwrap();
}

fn file(directory: &Path, change: impl Fn(&mut Flash)) -> PathBuf {
    let path = directory.join("flash_hdf5_chk_0000");
    let mut flash = Flash::new();
    change(&mut flash);
    flash.write(&path);
    path
}

/// Why a file with something changed is refused.
fn refused_with(change: impl Fn(&mut Flash)) -> String {
    let directory = tempfile::tempdir().unwrap();
    refused(&file(directory.path(), change))
}

/// What a run was told of its domain.
const DOMAIN: [(&str, f64); 6] =
    [("xmin", 1.0), ("xmax", 3.0), ("ymin", 2.0), ("ymax", 2.5), ("zmin", -3.0), ("zmax", -0.75)];

#[test]
fn leaves_are_read_and_completed() {
    let directory = tempfile::tempdir().unwrap();
    for single in [false, true] {
        let data = opened(&file(directory.path(), |flash| flash.single = single));
        assert_eq!((data.format(), data.time(), names(&*data)), ("FLASH HDF5", Some(0.25), vec!["de", "pres"]));
        assert_eq!(data.hierarchy().bounds(), [[1.0, 2.0, -3.0], [3.0, 2.5, -0.75]]);
        assert_eq!(cells(&*data), [2 * 48, 8 * 48, 8 * 48]);
        assert!(data.warnings().is_empty());
        let flash = Flash::new();
        let centers: Vec<[f64; 3]> = (0..flash.blocks.len())
            .filter(|block| flash.blocks[*block].2)
            .flat_map(|block| [[0, 0, 0], [3, 1, 2], [1, 0, 5]].map(|cell| flash.center(block, cell)))
            .collect();
        let expected = centers.iter().map(|&center| 10.0 * value_at(center));
        for (found, expected) in values(&*data, "pres", &centers).into_iter().zip(expected) {
            assert!((found - expected).abs() < if single { 1e-3 } else { 1e-9 }, "{found}, {expected}");
        }
    }
}

#[test]
fn the_domain_is_what_the_run_was_told() {
    let directory = tempfile::tempdir().unwrap();
    // Bounding boxes are not as exact.
    let told = |flash: &mut Flash| {
        flash.reals = DOMAIN.into();
        flash.reals[1].1 += 1e-9;
    };
    let data = opened(&file(directory.path(), told));
    assert_eq!(data.hierarchy().bounds(), [[1.0, 2.0, -3.0], [3.000000001, 2.5, -0.75]]);
    // Part of it is of no use.
    let data = opened(&file(directory.path(), |flash| flash.reals = DOMAIN[..5].into()));
    assert_eq!(data.hierarchy().bounds(), [[1.0, 2.0, -3.0], [3.0, 2.5, -0.75]]);
    let error = refused_with(|flash| {
        flash.reals = DOMAIN.into();
        flash.reals[5].1 = 0.0;
    });
    let expected = "real runtime parameters: zmax is 0, expected -0.75 by the bounding boxes of blocks";
    assert!(error.ends_with(expected), "{error}");
}

#[test]
fn other_coordinates_are_warned_of() {
    let directory = tempfile::tempdir().unwrap();
    for list in ["string scalars", "string runtime parameters"] {
        let data = opened(&file(directory.path(), |flash| flash.geometry = Some((list, "Cylindrical"))));
        assert_eq!(
            data.warnings(),
            ["the coordinates are cylindrical, but are shown as if they were Cartesian"],
            "{list}"
        );
    }
    assert!(opened(&file(directory.path(), |flash| flash.geometry = None)).warnings().is_empty());
}

#[test]
fn scalars_must_agree_with_the_blocks() {
    let error = refused_with(|flash| flash.integers[3].1 = 2);
    assert!(error.ends_with("integer scalars: dimensionality is 2, expected 3"), "{error}");
    let error = refused_with(|flash| flash.integers[4].1 = 20);
    assert!(error.ends_with("globalnumblocks is 20, expected 18 by the lists of blocks"), "{error}");
    let error = refused_with(|flash| flash.guards = 4);
    assert!(error.contains("de  : shape [18, 14, 10, 12], expected 4 dimensions"), "{error}");
    let directory = tempfile::tempdir().unwrap();
    assert_eq!(cells(&*opened(&file(directory.path(), |flash| flash.integers.truncate(3))))[0], 2 * 48);
}

#[test]
fn names_of_data_sets_need_no_padding() {
    let directory = tempfile::tempdir().unwrap();
    let data = opened(&file(directory.path(), |flash| flash.sets[0] = "de"));
    assert_eq!(names(&*data), ["de", "pres"]);
    let center = Flash::new().center(1, [0; 3]);
    assert!((values(&*data, "de", &[center])[0] - value_at(center)).abs() < 1e-9);
    let error = refused_with(|flash| flash.sets[0] = "dens");
    assert!(error.ends_with("unknown names: no data set de, expected one"), "{error}");
}

#[test]
fn damaged_files_are_refused_or_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = file(directory.path(), |flash| {
        flash.single = true;
        flash.reals = DOMAIN.into();
    });
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
    let error = refused_with(|flash| flash.blocks[5].0[0] += 0.05);
    assert!(error.contains("block 5 reaches over"), "{error}");
}
