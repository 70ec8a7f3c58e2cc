//! Plotfiles that AMReX's advection test wrote, in every version and number format. The expected values were read from
//! the files' bytes by other means.

use amray::hierarchy::{IndexBox, Residence};
use amray_testing::real_data;

use super::*;

/// One of AMReX's plotfiles.
fn data(name: &str) -> Option<PathBuf> {
    real_data(&format!("amrex/{name}"))
}

struct Expected {
    name: &'static str,
    time: f64,
    base: i64,
    ratios: [i64; 2],
    bricks: [usize; 3],
    voxel_type: VoxelType,
    residence: Residence,
    /// Level, brick on its level, cell of the brick, value.
    values: [(usize, usize, [usize; 3], f64); 3],
}

/// The files in the machine's own byte order can be mapped; this table takes that to be little-endian.
#[cfg(target_endian = "little")]
const EXPECTED: [Expected; 6] = [
    Expected {
        name: "plt_small",
        time: 0.26999380329536304,
        base: 32,
        ratios: [2, 2],
        bricks: [1, 17, 70],
        voxel_type: VoxelType::F64,
        residence: Residence::Mapped,
        values: [
            (0, 0, [3, 16, 16], 0.9994853687993028),
            (1, 16, [3, 16, 4], 1.0000000002971052),
            (2, 69, [3, 4, 4], 1.0098965630339556),
        ],
    },
    Expected {
        name: "plt_small_f32",
        time: 0.13213504454862215,
        base: 32,
        ratios: [2, 2],
        bricks: [1, 20, 74],
        voxel_type: VoxelType::F32,
        residence: Residence::Mapped,
        values: [
            (0, 0, [3, 16, 16], 0.9998871088027954),
            (2, 0, [3, 16, 8], 1.4740564823150635),
            (2, 73, [3, 4, 4], 1.0170327425003052),
        ],
    },
    Expected {
        name: "plt_small_rr42",
        time: 0.08769189676836167,
        base: 16,
        ratios: [4, 2],
        bricks: [1, 12, 76],
        voxel_type: VoxelType::F64,
        residence: Residence::Mapped,
        values: [
            (0, 0, [3, 8, 8], 1.026772570419377),
            (1, 11, [3, 12, 12], 1.000019534269583),
            (2, 75, [3, 8, 4], 1.0119967830943741),
        ],
    },
    Expected {
        name: "plt_ieee32_bigendian",
        time: 0.0,
        base: 16,
        ratios: [2, 2],
        bricks: [1, 1, 22],
        voxel_type: VoxelType::F32,
        residence: Residence::Owned,
        values: [
            (0, 0, [3, 8, 8], 1.0164355039596558),
            (2, 0, [3, 8, 16], 1.0000096559524536),
            (2, 21, [3, 4, 4], 1.0000009536743164),
        ],
    },
    Expected {
        name: "plt_hv2",
        time: 0.0,
        base: 16,
        ratios: [2, 2],
        bricks: [1, 1, 22],
        voxel_type: VoxelType::F64,
        residence: Residence::Mapped,
        values: [
            (0, 0, [3, 8, 8], 1.0164355972591703),
            (2, 0, [3, 8, 16], 1.0000097158882664),
            (2, 21, [3, 4, 4], 1.0000010280550962),
        ],
    },
    Expected {
        name: "plt_hv4",
        time: 0.0,
        base: 16,
        ratios: [2, 2],
        bricks: [1, 1, 22],
        voxel_type: VoxelType::F64,
        residence: Residence::Mapped,
        values: [
            (0, 0, [3, 8, 8], 1.0164355972591703),
            (1, 0, [3, 16, 16], 1.0000000009541614),
            (2, 21, [3, 4, 4], 1.0000010280550962),
        ],
    },
];

#[test]
#[cfg(target_endian = "little")]
fn every_plotfile_opens_as_it_was_written() {
    for expected in EXPECTED {
        let Some(path) = data(expected.name) else { return };
        assert!(AmrexPlotfile::recognises(&path) && AmrexPlotfile::recognises(&path.join("Header")));
        let plotfile = open(&path.join("Header")).unwrap();
        let hierarchy = plotfile.hierarchy();
        assert_eq!(plotfile.time(), Some(expected.time), "{}", expected.name);
        assert_eq!(plotfile.warnings(), [""; 0]);
        assert_eq!(plotfile.fields(), [FieldInfo { name: "phi".into(), voxel_type: expected.voxel_type, unit: None }]);
        assert_eq!(hierarchy.bounds(), [[0.0; 3], [1.0; 3]]);
        let ratios: Vec<_> = hierarchy.levels().iter().map(|level| level.ratio()).collect();
        assert_eq!(ratios, [[1; 3], [expected.ratios[0]; 3], [expected.ratios[1]; 3]]);
        let bricks: Vec<_> = hierarchy.levels().iter().map(|level| level.bricks().len()).collect();
        assert_eq!(bricks, expected.bricks);
        assert_eq!(hierarchy.levels()[0].domain().size(), [expected.base; 3]);

        let field = read(&plotfile, 0);
        assert_eq!(field.bytes(expected.residence), hierarchy.cells() * expected.voxel_type.bytes() as u64);
        for (level, brick, cell, value) in expected.values {
            let found = field.value(hierarchy.levels()[level].first_brick() + brick, cell);
            assert_eq!(found, value, "{}, level {level}, brick {brick}, cell {cell:?}", expected.name);
        }
    }
}

/// AMReX converts to foreign formats by cutting off digits; all values here are positive.
fn cut_off(value: f64) -> f64 {
    let nearest = value as f32;
    f64::from(if f64::from(nearest) > value { nearest.next_down() } else { nearest })
}

#[test]
fn big_endian_single_precision_holds_the_shortened_double_precision() {
    let (Some(double), Some(single)) = (data("plt_hv2"), data("plt_ieee32_bigendian")) else { return };
    let (double, single) = (open(&double).unwrap(), open(&single).unwrap());
    let (exact, shortened) = (read(&double, 0), read(&single, 0));
    for (number, brick) in double.hierarchy().bricks().enumerate() {
        for cell in IndexBox::new([0; 3], brick.cells.size()).iter() {
            let cell = cell.map(|index| index as usize);
            assert_eq!(cut_off(exact.value(number, cell)), shortened.value(number, cell));
        }
    }
}

#[test]
fn finer_levels_can_be_left_out() {
    let Some(path) = data("plt_small") else { return };
    let plotfile = AmrexPlotfile::open(&path, &OpenOptions { max_level: Some(1), ..OpenOptions::default() }).unwrap();
    assert_eq!(plotfile.hierarchy().finest_level(), 1);
    assert_eq!(read(&plotfile, 0).value(17, [3, 16, 4]), 1.0000000002971052);
    let error = AmrexPlotfile::open(&path, &OpenOptions { max_level: Some(3), ..OpenOptions::default() })
        .unwrap_err()
        .to_string();
    assert_eq!(error, format!("{}: no level 3; the finest level is 2", path.join("Header").display()));
}

#[test]
fn particles_are_no_plotfile() {
    let Some(path) = data("plt_small") else { return };
    assert!(!AmrexPlotfile::recognises(&path.join("particles")));
    assert!(!AmrexPlotfile::recognises(&path.join("particles/Header")));
    assert!(!AmrexPlotfile::recognises(&path.join("Level_0")));
}

#[test]
fn the_files_of_levels_open_their_plotfile() {
    let Some(path) = data("plt_small") else { return };
    let whole = open(&path).unwrap();
    for name in ["Level_0/Cell_H", "Level_2/Cell_H", "Level_1/Cell_D_00000"] {
        assert!(AmrexPlotfile::recognises(&path.join(name)), "{name}");
        let plotfile = open(&path.join(name)).unwrap();
        assert_eq!(plotfile.hierarchy(), whole.hierarchy(), "{name}");
        assert_eq!(read(&plotfile, 0).value(17, [3, 16, 4]), 1.0000000002971052);
    }
    for name in ["Level_9/Cell_H", "Level_0/Cell_D_", "Level_0/Cell_D_99999", "Level_0/Cell"] {
        assert!(!AmrexPlotfile::recognises(&path.join(name)), "{name}");
    }
}
