//! Athena++ files written here after the wiki's description: what real files at hand do not show.

use std::path::{Path, PathBuf};

use amray_testing::Random;
use rust_hdf5::{FileLocking, H5File, H5Group, H5Type};

use super::damage::{mutated, survive};
use super::{cells, names, opened, refused, values};

/// The axes x, y and z in data sets, whose last one is fastest.
const AXES: [usize; 3] = [2, 1, 0];

/// A root of 2x1x1 blocks, of which the first is refined.
#[derive(Clone)]
struct Athena {
    low: [f64; 3],
    high: [f64; 3],
    root: [i32; 3],
    /// Cells of a block with ghosts.
    stored: [usize; 3],
    ghosts: usize,
    /// Levels and logical locations.
    places: Vec<(i32, [i64; 3])>,
    /// Of a data set, if it is chunked.
    chunk: Option<[usize; 5]>,
    counts: Option<Vec<i32>>,
    coordinates: &'static str,
    names: Vec<&'static str>,
    /// By so much is a face inside of a block off, in cells.
    moved_face: f64,
    /// Cells along x in the data set that blocks do not have.
    more_cells: usize,
}

impl Athena {
    fn new(ghosts: usize) -> Self {
        let children = (0..8).map(|child| (1, [child & 1, child >> 1 & 1, child >> 2]));
        Self {
            low: [-1.0, 2.0, 0.5],
            high: [3.0, 3.0, 2.0],
            root: [8, 2, 6],
            stored: [4, 2, 6].map(|cells| cells + 2 * ghosts),
            ghosts,
            places: [(0, [1, 0, 0])].into_iter().chain(children).collect(),
            chunk: None,
            counts: Some(vec![2]),
            coordinates: "cartesian",
            names: vec!["rho", "press"],
            moved_face: 0.0,
            more_cells: 0,
        }
    }

    /// Cells of a block without ghosts.
    fn block(&self) -> [usize; 3] {
        self.stored.map(|cells| cells - 2 * self.ghosts)
    }

    /// Where something of a block lies along an axis, counted in cells from its first ghost cell on.
    fn position(&self, block: usize, axis: usize, cells: f64) -> f64 {
        let (level, place) = self.places[block];
        let width = (self.high[axis] - self.low[axis]) / f64::from(self.root[axis] << level);
        let first = place[axis] as f64 * self.block()[axis] as f64 - self.ghosts as f64;
        self.low[axis] + width * (first + cells)
    }

    fn center(&self, block: usize, cell: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| self.position(block, axis, (self.ghosts + cell[axis]) as f64 + 0.5))
    }

    fn faces(&self, axis: usize) -> Vec<f32> {
        let place = |block, face| face as f64 + if (block, axis, face) == (3, 1, 1) { self.moved_face } else { 0.0 };
        let faces =
            |block| (0..=self.stored[axis]).map(move |face| self.position(block, axis, place(block, face)) as f32);
        (0..self.places.len()).flat_map(faces).collect()
    }

    /// One value for each variable, block and cell: exact in single precision.
    fn values(&self) -> Vec<f32> {
        let [x, y, z] = self.stored;
        let cells = (x + self.more_cells) * y * z;
        (0..2 * self.places.len() * cells).map(|value| value as f32).collect()
    }

    /// The value of a variable in a cell of a block.
    fn value(&self, variable: usize, block: usize, cell: [usize; 3]) -> f64 {
        let block = variable * self.places.len() + block;
        AXES.iter().fold(block, |at, &axis| at * self.stored[axis] + self.ghosts + cell[axis]) as f64
    }

    fn write(&self, directory: &Path) -> PathBuf {
        let path = directory.join("a.athdf");
        let file = H5File::options().locking(FileLocking::BestEffort).create(&path).unwrap();
        let root = file.root_group();
        root.set_attr_string("Coordinates", self.coordinates).unwrap();
        root.set_attr_string_array("DatasetNames", &["prim"]).unwrap();
        root.set_attr_string_array("VariableNames", &self.names).unwrap();
        if let Some(counts) = &self.counts {
            root.set_attr_array_numeric("NumVariables", counts).unwrap();
        }
        root.set_attr_array_numeric("RootGridSize", &self.root).unwrap();
        root.set_attr_array_numeric("MeshBlockSize", &self.stored.map(|cells| cells as i32)).unwrap();
        let (blocks, [x, y, z]) = (self.places.len(), self.stored);
        for axis in 0..3 {
            let extent = [self.low[axis] as f32, self.high[axis] as f32, 1.0];
            root.set_attr_array_numeric(&format!("RootGridX{}", axis + 1), &extent).unwrap();
            set(&root, &format!("x{}f", axis + 1), &[blocks, self.stored[axis] + 1], &self.faces(axis));
        }
        set(&root, "Levels", &[blocks], &self.places.iter().map(|place| place.0).collect::<Vec<_>>());
        let locations: Vec<i64> = self.places.iter().flat_map(|place| place.1).collect();
        set(&root, "LogicalLocations", &[blocks, 3], &locations);
        let builder = root.new_dataset::<f32>().shape([2, blocks, z, y, x + self.more_cells]);
        let builder = if let Some(chunk) = &self.chunk { builder.chunk(chunk) } else { builder };
        builder.create("prim").unwrap().write_raw(&self.values()).unwrap();
        file.close().unwrap();
        path
    }
}

fn set<T: H5Type>(root: &H5Group, name: &str, shape: &[usize], values: &[T]) {
    root.new_dataset::<T>().shape(shape).create(name).unwrap().write_raw(values).unwrap();
}

/// All cells of the blocks, and their values.
fn assert_read(path: &Path, athena: &Athena) {
    let data = opened(path);
    assert_eq!(names(&*data), ["rho", "press"]);
    assert_eq!(data.hierarchy().bounds(), [athena.low, athena.high]);
    let [x, y, z] = athena.block();
    let of_block = |block| (0..x * y * z).map(move |cell| (block, [cell % x, cell / x % y, cell / x / y]));
    let places: Vec<_> = (0..athena.places.len()).flat_map(of_block).collect();
    let centers: Vec<[f64; 3]> = places.iter().map(|&(block, cell)| athena.center(block, cell)).collect();
    for (variable, name) in ["rho", "press"].into_iter().enumerate() {
        let expected: Vec<f64> = places.iter().map(|&(block, cell)| athena.value(variable, block, cell)).collect();
        assert_eq!(values(&*data, name, &centers), expected, "{name}");
    }
}

#[test]
fn chunks_of_any_shape_hold_the_same_values() {
    let directory = tempfile::tempdir().unwrap();
    for ghosts in [0, 2] {
        let mut athena = Athena::new(ghosts);
        // From no chunks to chunks of all variables, of several blocks and of parts of blocks, none of which need fit.
        let chunks = [[1, 1, 6, 2, 4], [1, 4, 6, 2, 4], [2, 9, 6, 2, 4], [2, 5, 4, 1, 3], [1, 2, 6, 2, 1]];
        for chunk in std::iter::once(None).chain(chunks.map(Some)) {
            athena.chunk = chunk;
            let path = athena.write(directory.path());
            assert_read(&path, &athena);
            assert_eq!(cells(&*opened(&path)), [8 * 2 * 6, 8 * 4 * 2 * 6]);
        }
    }
}

/// Why a file with something changed is refused.
fn refused_with(change: impl Fn(&mut Athena)) -> String {
    let directory = tempfile::tempdir().unwrap();
    let mut athena = Athena::new(1);
    change(&mut athena);
    refused(&athena.write(directory.path()))
}

#[test]
fn faces_inside_of_blocks_must_be_even_too() {
    let error = refused_with(|athena| athena.moved_face = 0.125);
    assert!(error.contains("x2f: face 1 of block 3 is at 2.53125, expected 2.5 by its level and location"), "{error}");
    let directory = tempfile::tempdir().unwrap();
    let mut athena = Athena::new(1);
    athena.moved_face = 1e-5;
    assert_read(&athena.write(directory.path()), &athena);
    // Far from the origin, single precision tells neighbouring faces apart and not much more.
    let far = |position: f64| position + 100_000.0;
    (athena.low, athena.high) = (athena.low.map(far), athena.high.map(far));
    assert_read(&athena.write(directory.path()), &athena);
}

#[test]
fn flat_blocks_and_places_nowhere_are_refused() {
    let error = refused_with(|athena| {
        athena.stored[2] = 1;
        athena.ghosts = 0;
    });
    assert!(error.ends_with("MeshBlockSize is [6, 4, 1], expected three dimensions of several cells"), "{error}");
    let error = refused_with(|athena| athena.places[4].1[1] = 1 << 39);
    assert!(error.contains("block 4 is at [1, 549755813888, 0], outside of any domain"), "{error}");
    // As far as locations go.
    let error = refused_with(|athena| athena.places[4].1[1] = (1 << 32) - 1);
    assert!(error.contains("x2f: face 0 of block 4 is at 2147483648"), "{error}");
}

#[test]
fn variables_are_counted_by_the_data_sets() {
    let directory = tempfile::tempdir().unwrap();
    let athena = Athena { counts: None, ..Athena::new(0) };
    assert_read(&athena.write(directory.path()), &athena);
    let error = refused_with(|athena| athena.names.push("vel1"));
    assert!(error.ends_with("VariableNames holds 3 names, expected 2 by the shapes of the data sets"), "{error}");
    let error = refused_with(|athena| athena.counts = Some(vec![2, 1]));
    assert!(error.ends_with("NumVariables holds 2 counts, expected 1 by DatasetNames"), "{error}");
    let error = refused_with(|athena| athena.counts = Some(vec![3]));
    assert!(error.ends_with("prim: 2 variables, expected 3 by NumVariables"), "{error}");
}

#[test]
fn data_sets_have_the_cells_of_the_blocks() {
    let error = refused_with(|athena| athena.more_cells = 2);
    let expected = "prim: shape [2, 9, 8, 4, 8], expected 5 dimensions of at least 9 blocks that end in [8, 4, 6]";
    assert!(error.ends_with(expected), "{error}");
}

#[test]
fn control_characters_stay_out_of_messages() {
    let directory = tempfile::tempdir().unwrap();
    let athena = Athena { coordinates: "round\u{1b}[31m", names: vec!["rho", "pr\ness"], ..Athena::new(0) };
    let data = opened(&athena.write(directory.path()));
    assert_eq!(names(&*data), ["rho", "pr ess"]);
    assert_eq!(data.warnings(), ["the coordinates are round [31m, but are shown as if they were Cartesian"]);
}
#[test]
fn damaged_chunks_are_refused_or_read() {
    let directory = tempfile::tempdir().unwrap();
    let athena = Athena { chunk: Some([1, 4, 8, 4, 3]), ..Athena::new(1) };
    let path = athena.write(directory.path());
    let content = std::fs::read(&path).unwrap();
    let mut random = Random(5);
    for _ in 0..400 {
        std::fs::write(&path, mutated(&content, &mut random, usize::MAX)).unwrap();
        let _ = survive(&path);
    }
}
