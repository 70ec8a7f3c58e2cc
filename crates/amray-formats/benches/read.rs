//! How fast values come in: from a warm file of doubles to the single-precision copy that marching takes, against reading
//! the file's bytes and nothing else, as `cat file > /dev/null` does.

use std::fs::File;
use std::hint::black_box;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use amray::Volume;
use amray::hierarchy::{Centering, Hierarchy, VoxelType};
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{AmrContent, ChomboFile, ChomboWriter, DataSet, OpenOptions};
use divan::Bencher;
use divan::counter::BytesCount;

/// Cells per side of the only level: 512 MB of doubles.
const SIDE: i64 = 400;
const BYTES: u64 = (SIDE * SIDE * SIDE) as u64 * 8;

fn main() {
    divan::main();
    if let Some(path) = FILE.get() {
        // It is of no use any more, but no harm either.
        let _ = std::fs::remove_file(path);
    }
}

static FILE: OnceLock<PathBuf> = OnceLock::new();

/// The file, written once for a run.
fn file() -> &'static Path {
    FILE.get_or_init(|| {
        let path = std::env::temp_dir().join(format!("amray-read-{}.hdf5", std::process::id()));
        write(&path, &amray_testing::nested(SIDE, 1, 40));
        path
    })
}

fn write(path: &Path, hierarchy: &Hierarchy) {
    let content = AmrContent {
        hierarchy,
        components: &["density"],
        centering: Centering::Cells,
        voxel_type: VoxelType::F64,
        time: 0.0,
    };
    let writer = ChomboWriter::create(path, &content).unwrap();
    for brick in hierarchy.bricks() {
        let values: Vec<f64> = brick.cells.iter().map(|[i, j, k]| (i * j - k) as f64).collect();
        writer.write(brick.level, brick.number, 0, 0, &values).unwrap();
    }
    writer.finish().unwrap();
}

/// As `cat` does.
#[divan::bench(sample_count = 10, sample_size = 1)]
fn bytes(bencher: Bencher) {
    let path = file();
    bencher.counter(BytesCount::new(BYTES)).bench(|| {
        let (mut file, mut buffer) = (File::open(path).unwrap(), vec![0u8; 128 << 10]);
        while file.read(&mut buffer).unwrap() > 0 {
            black_box(&buffer);
        }
    });
}

/// Opened, read, and converted into padded bricks.
#[divan::bench(sample_count = 10, sample_size = 1)]
fn padded_copy(bencher: Bencher) {
    let path = file();
    let index = Arc::new(Index::build(open(path).hierarchy().clone()));
    bencher.counter(BytesCount::new(BYTES)).bench(|| {
        let field = open(path).read_field(0, &|_| {}).unwrap();
        amray::bench::padded_values(&Volume::new(index.clone(), field, Method::Current), [0.0, 160_000.0])
    });
}

fn open(path: &Path) -> ChomboFile {
    ChomboFile::open(path, &OpenOptions::default()).unwrap()
}
