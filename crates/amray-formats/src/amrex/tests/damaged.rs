//! Damaged plotfiles are refused in one clear line, or are still plotfiles; nothing else happens.

use std::fs;

use amray::Volume;
use amray::hierarchy::IndexBox;
use amray::reconstruction::Method;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use tempfile::TempDir;

use super::super::real_format::ByteOrder;
use super::synthetic::{PLAIN, Synthetic};
use super::*;

const HEADER: &str = "Header";
const CELL_H: &str = "Level_1/Cell_H";
const DATA: &str = "Level_1/Cell_D_00001";

fn written(synthetic: Synthetic) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    synthetic.write(directory.path());
    directory
}

/// Opens a plotfile, looks at every value of every field, and samples a point of each.
fn read_all(path: &Path) -> Result<f64, FormatError> {
    let plotfile = open(path)?;
    // Damage can make a mesh that is sound, but takes its time.
    let few = plotfile.hierarchy().cells() < 1_000_000;
    let index = few.then(|| Arc::new(amray::index::Index::build(plotfile.hierarchy().clone())));
    let mut sum = 0.0;
    for field in 0..plotfile.fields().len() {
        let values = plotfile.read_field(field, &|_| ())?;
        if let Some(index) = &index {
            let volume = Volume::new(index.clone(), values.clone(), Method::Basis);
            let [low, high] = plotfile.hierarchy().bounds();
            volume.sample(&[std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) / 2.0)]);
        }
        for (number, brick) in plotfile.hierarchy().bricks().enumerate() {
            for cell in IndexBox::new([0; 3], brick.cells.size()).iter() {
                sum += values.value(number, cell.map(|index| index as usize));
            }
        }
    }
    Ok(sum)
}

fn assert_read_or_refused(path: &Path) {
    if let Err(error) = read_all(path) {
        let text = error.to_string();
        assert!(!text.contains(char::is_control), "{text:?}");
        assert!(text.starts_with(path.to_str().unwrap()), "{text}");
    }
}

/// The error that replacing the first `from` in `file` by `to` makes, without the path in front of it.
fn error(synthetic: Synthetic, file: &str, from: &str, to: &str) -> String {
    let directory = written(synthetic);
    let path = directory.path().join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let error = read_all(directory.path()).unwrap_err().to_string();
    error.strip_prefix(directory.path().to_str().unwrap()).unwrap().to_owned()
}

#[test]
fn errors_in_the_header_name_the_line() {
    let error = |from: &str, to: &str| error(PLAIN, HEADER, from, to);
    assert_eq!(error("V1.1\n2", "V1.1\n-2"), "/Header: line 2: \"-2\", expected the number of components, at least 1");
    assert_eq!(
        error("\n2\ndens", "\n9999999999\ndens"),
        "/Header: line 38: the file ends here, expected the name of component 35"
    );
    assert_eq!(error("\n3\n2.5", "\n2\n2.5"), "/Header: line 5: \"2\", expected 3 dimensions (others cannot be shown)");
    assert_eq!(error("2.5", "nan"), "/Header: line 6: \"nan\", expected the time, a finite number");
    assert_eq!(
        error("2.5\n1\n", "2.5\n3000000000\n"),
        "/Header: line 11: \"((-4,0,2) (3,3,5) (0,0,0)) ((-8,0,8) (7,3,23) (0,0,0))\", \
         expected a cell-centred box such as ((0,0,0) (15,15,15) (0,0,0)) for each of 3000000001 levels"
    );
    assert_eq!(
        error("10 0 -1", "1e400 0 -1"),
        "/Header: line 8: \"1e400 0 -1\", expected the domain's low corner, three finite numbers"
    );
    assert_eq!(
        error("0.25 1 0.5", "0.25 1"),
        "/Header: line 14: \"0.25 1\", expected the cell size of level 1, three finite numbers"
    );
    assert_eq!(error("0.5 \n0\n", "0.5 \n3\n"), "/Header: line 15: \"3\", expected a coordinate system, 0, 1 or 2");
    assert_eq!(
        error("\n1 3 2.5", "\n1 0 2.5"),
        "/Header: line 26: \"1 0 2.5\", expected level 1 to hold at least one grid (--max-level 0 leaves it out)"
    );
    assert_eq!(
        error("\n0 2 2.5", "\n0 0 2.5"),
        "/Header: line 17: \"0 0 2.5\", expected level 0 to hold at least one grid"
    );
    assert_eq!(
        error("Level_1/Cell", "Level_1/../../Cell"),
        "/Header: line 37: \"Level_1/../../Cell\", \
         expected the path of level 1's values below the plotfile, such as Level_1/Cell"
    );
}

#[test]
fn an_empty_finest_level_can_be_left_out() {
    let directory = written(PLAIN);
    let header = directory.path().join(HEADER);
    fs::write(&header, fs::read_to_string(&header).unwrap().replacen("\n1 3 2.5", "\n1 0 2.5", 1)).unwrap();
    fs::remove_dir_all(directory.path().join("Level_1")).unwrap();
    let plotfile =
        AmrexPlotfile::open(directory.path(), &OpenOptions { max_level: Some(0), ..OpenOptions::default() }).unwrap();
    assert_eq!(plotfile.hierarchy().brick_count(), 2);
}

#[test]
fn levels_that_contradict_each_other_are_refused() {
    assert_eq!(
        error(PLAIN, HEADER, "0.25 1 0.5", "0.25 0.5 0.5"),
        ": level 1: domain ((-8,0,8) (7,3,23)), \
         expected ((-8,0,8) (7,7,23)) (the next coarser domain refined by [2, 2, 4])"
    );
    assert_eq!(
        error(PLAIN, CELL_H, "((0,1,12) (1,2,15)", "((0,1,12) (2,2,15)"),
        ": level 1, brick 1: box ((0,1,12) (2,2,15)) cuts coarser cells, expected corners at multiples of [2, 1, 4]"
    );
    assert_eq!(
        error(PLAIN, CELL_H, "((0,1,12) (1,2,15)", "((2147483647,1,12) (2147483647,2,15)"),
        ": level 1, brick 1: box ((2147483647,1,12) (2147483647,2,15)) leaves the domain ((-8,0,8) (7,3,23))"
    );
    assert_eq!(
        error(PLAIN, HEADER, "0.25 1 0.5", "0.3 1 0.5"),
        ": level 1: cell size [0.3, 1.0, 0.5], expected [0.25, 1.0, 0.5] (the next coarser cell divided by the ratio)"
    );
    assert_eq!(
        error(PLAIN, HEADER, "0.25 1 0.5", "0 1 0.5"),
        ": level 1: the cell size is [0.0, 1.0, 0.5], expected positive numbers"
    );
}

#[test]
fn fabs_that_do_not_fit_are_named() {
    let version_2 = Synthetic { version: 2, ..PLAIN };
    assert_eq!(
        error(version_2, CELL_H, "Cell_D_00001 256", "Cell_D_00001 257"),
        "/Level_1/Cell_D_00001: level 1, brick 2: the FAB takes 128 bytes from byte 257 on, but the file has 384"
    );
    assert_eq!(
        error(version_2, CELL_H, "Cell_D_00001 256", "Cell_D_00001 99999999999"),
        "/Level_1/Cell_D_00001: level 1, brick 2: \
         the FAB starts at byte 99999999999, expected a place inside the file's 384 bytes"
    );
    assert_eq!(
        error(version_2, CELL_H, "Cell_D_00001 0", "Cell_D_00000 10"),
        "/Level_1/Cell_D_00000: level 1: the FABs take 768 bytes, expected at most the file's 522"
    );
    assert_eq!(
        error(version_2, CELL_H, "\n0\n(3", "\n(0,2147483647,0)\n(3"),
        "/Level_1/Cell_D_00000: level 1, brick 0: \
         the FAB takes 1099511627776 bytes from byte 10 on, but the file has 522"
    );
    assert_eq!(
        error(PLAIN, CELL_H, "Cell_D_00000 10", "Cell_D_00000 0"),
        "/Level_1/Cell_D_00000: level 1, brick 0: the FAB's header is \
         \"some bytesFAB ((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 \"..., expected FAB and a number format"
    );
    assert_eq!(
        error(PLAIN, CELL_H, "((2,1,16) (3,1,19)", "((2,1,12) (3,1,19)"),
        "/Level_1/Cell_D_00001: level 1, brick 2: \
         the FAB's box is ((2,1,16) (3,1,19)), expected one that contains ((2,1,12) (3,1,19))"
    );
    let missing = error(PLAIN, CELL_H, "Cell_D_00001", "Cell_D_00007");
    assert!(missing.starts_with("/Level_1/Cell_D_00007: cannot open: "), "{missing}");
}

#[test]
fn levels_of_other_precision_are_refused() {
    let single = Synthetic { voxel_type: VoxelType::F32, byte_order: ByteOrder::Big, ..PLAIN };
    let (directory, other) = (written(PLAIN), written(single));
    for file in ["Cell_H", "Cell_D_00000", "Cell_D_00001"].map(|name| format!("Level_1/{name}")) {
        fs::copy(other.path().join(&file), directory.path().join(&file)).unwrap();
    }
    let error = open(directory.path()).unwrap_err().to_string();
    assert!(error.ends_with(": level 1, brick 0: values of 4 bytes, expected 8, as in the first brick"), "{error}");
}

#[test]
fn what_is_no_plotfile_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().display();
    let expected =
        format!("{path}: neither a directory with a file Header nor a file of a plotfile, expected an AMReX plotfile");
    assert_eq!(open(directory.path()).unwrap_err().to_string(), expected);
    assert!(!AmrexPlotfile::recognises(directory.path()));
    assert!(!AmrexPlotfile::recognises(Path::new("/nonexistent")));
    fs::create_dir(directory.path().join(HEADER)).unwrap();
    assert_eq!(open(directory.path()).unwrap_err().to_string(), expected);
    fs::remove_dir(directory.path().join(HEADER)).unwrap();
    fs::write(directory.path().join(HEADER), "CheckPointVersion_1.0\n3\n0.5\n2\n2\n4\n").unwrap();
    assert!(!AmrexPlotfile::recognises(directory.path()));
}

#[test]
fn two_dimensions_are_recognised_all_the_same() {
    let directory = written(PLAIN);
    let header = directory.path().join(HEADER);
    fs::write(&header, fs::read_to_string(&header).unwrap().replacen("\n3\n2.5", "\n2\n2.5", 1)).unwrap();
    assert!(AmrexPlotfile::recognises(directory.path()));
}

/// The most damage a full disk or a killed run can do: every file, cut off at every length.
#[test]
fn files_cut_off_anywhere_are_read_or_refused() {
    for synthetic in [PLAIN, Synthetic { version: 4, byte_order: ByteOrder::Big, ghosts: [1, 0, 0], ..PLAIN }] {
        let directory = written(synthetic);
        for file in [HEADER, CELL_H, DATA] {
            let path = directory.path().join(file);
            let whole = fs::read(&path).unwrap();
            for length in 0..whole.len() {
                fs::write(&path, &whole[..length]).unwrap();
                assert_read_or_refused(directory.path());
                if file == DATA {
                    assert!(read_all(directory.path()).is_err(), "{length} of {} bytes", whole.len());
                }
            }
            fs::write(&path, &whole).unwrap();
        }
        assert!(read_all(directory.path()).is_ok());
    }
}

/// Texts that break readers.
const AWKWARD: &[&str] =
    &["", "0", "-1", "nan", "1e400", "99999999999999999999", "2147483647", "-2147483648", "\n", "(", ")"];

fn awkward_bytes() -> impl Strategy<Value = Vec<u8>> {
    let any_bytes = proptest::collection::vec(any::<u8>(), 1..4);
    prop_oneof![select(AWKWARD).prop_map(|text| text.as_bytes().to_vec()), any_bytes]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn mutated_files_are_read_or_refused(
        version in 1u32..=4,
        ghosts in select([[0; 3], [1, 0, 2]].as_slice()),
        file in select([HEADER, CELL_H, DATA].as_slice()),
        changes in proptest::collection::vec((any::<Index>(), 0usize..6, awkward_bytes()), 1..4),
    ) {
        let directory = written(Synthetic { version, ghosts, ..PLAIN });
        let path = directory.path().join(file);
        let mut bytes = fs::read(&path).unwrap();
        for (place, removed, inserted) in changes {
            let start = place.index(bytes.len() + 1);
            let end = bytes.len().min(start + removed);
            bytes.splice(start..end, inserted);
        }
        fs::write(&path, &bytes).unwrap();
        assert_read_or_refused(directory.path());
    }
}
