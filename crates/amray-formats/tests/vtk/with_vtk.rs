//! VTK itself reads what is written here, and what VTK writes in all of its encodings is read here. `AMRAY_PYTHON` names a
//! Python that has the packages `vtk` and `numpy`; without it these tests are skipped and say so.

use std::path::Path;
use std::process::Command;

use amray::hierarchy::{Centering, VoxelType};
use amray_formats::structured::StructuredVolume;

use super::{opened, uneven, value, values, write};

/// Runs a script of this directory's `vtk.py`; `None` where there is no Python for it.
fn python(task: &str, directory: &Path) -> Option<String> {
    let Some(python) = std::env::var_os("AMRAY_PYTHON") else {
        #[allow(clippy::print_stderr)] // Whoever runs the tests is to know what was not tested.
        {
            eprintln!("skipped: AMRAY_PYTHON names no Python with the packages vtk and numpy");
        }
        return None;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vtk/vtk.py");
    let output = Command::new(python).arg(script).arg(task).arg(directory).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

#[test]
fn vtk_reads_what_is_written_here() {
    let directory = tempfile::tempdir().unwrap();
    let hierarchy = uneven();
    for (name, centering) in [("cells", Centering::Cells), ("nodes", Centering::Nodes)] {
        for ending in ["vthb", "vtkhdf"] {
            let path = directory.path().join(format!("{name}.{ending}"));
            write(&path, &hierarchy, &["phi"], centering, VoxelType::F64);
        }
    }
    let Some(found) = python("read", directory.path()) else { return };
    // Level, low corner and cells of each brick, then its values.
    let mut lines = found.lines();
    for file in ["cells.vthb", "cells.vtkhdf", "nodes.vthb", "nodes.vtkhdf"] {
        let centering = if file.starts_with("cells") { Centering::Cells } else { Centering::Nodes };
        assert_eq!(lines.next(), Some(file));
        for brick in hierarchy.bricks() {
            let numbers: Vec<f64> =
                lines.next().unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect();
            let width = hierarchy.levels()[brick.level].cell_size();
            let corner = [0, 1, 2].map(|axis| hierarchy.origin()[axis] + brick.cells.low[axis] as f64 * width[axis]);
            let (cells, places) = (brick.cells.size().map(|cells| cells as f64), centering.values_of(&brick.cells));
            let head = [&[brick.level as f64][..], &corner, &width, &cells].concat();
            for (found, expected) in numbers.iter().zip(&head) {
                assert!((found - expected).abs() < 1e-12, "{file} {brick:?}: {:?}, expected {head:?}", &numbers[..10]);
            }
            let expected: Vec<f64> = places.iter().map(|place| value(brick.level, 0, place)).collect();
            assert_eq!(numbers[head.len()..], expected, "{file} {brick:?}");
        }
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn every_encoding_of_vtk_is_read() {
    let directory = tempfile::tempdir().unwrap();
    let Some(names) = python("write", directory.path()) else { return };
    let mut counts = [0; 2];
    for name in names.lines() {
        let path = directory.path().join(name);
        if name.ends_with(".vti") {
            counts[0] += 1;
            for field in ["points", "cells"] {
                let volume = StructuredVolume::open(&path, Some(field)).unwrap_or_else(|error| panic!("{error}"));
                let cells = usize::from(field == "cells");
                assert_eq!(volume.size(), [5 - cells, 4 - cells, 3 - cells], "{name}");
                let half = 0.5 * cells as f64;
                assert_eq!(volume.spacing(), [0.5, 0.25, 2.0]);
                assert_eq!(volume.origin(), [1.0 + 0.5 * half, 2.0 + 0.25 * half, 3.0 + 2.0 * half], "{name}");
                let mut samples: Vec<f64> = Vec::new();
                volume.slices(0).and_then(|mut slices| slices.read(volume.size()[2], &mut samples)).unwrap();
                let expected: Vec<f64> = (0..samples.len()).map(|number| number as f64 * 0.125).collect();
                assert_eq!(samples, expected, "{name} {field}");
            }
            // Without a name, the scalars that are marked as active.
            assert_eq!(StructuredVolume::open(&path, None).unwrap().size(), [5, 4, 3], "{name}");
        } else {
            counts[1] += 1;
            let data = opened(&path);
            let field = data.read_field(0, &|_| {}).unwrap();
            let sums: Vec<f64> = values(data.hierarchy(), &field).iter().map(|values| values.iter().sum()).collect();
            // Cells of value 0, 1, ... on each brick of 4^3 and 4^3 cells.
            assert_eq!((data.fields()[0].name.as_str(), sums), ("phi", vec![2016.0; 2]), "{name}");
        }
    }
    // Five modes, three compressors, two types of lengths.
    assert_eq!(counts, [30, 30]);
}
