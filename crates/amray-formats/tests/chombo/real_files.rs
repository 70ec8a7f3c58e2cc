//! Real output of Chombo and GRChombo, held against readings with h5py.

use amray::hierarchy::{IndexBox, Level, Residence, VoxelType, VoxelType::F32, VoxelType::F64};
use amray_formats::DataSet;
use amray_testing::real_data;

use crate::{open, read};

const EULER: &[&str] = &["density", "x-momentum", "y-momentum", "z-momentum", "energy-density"];
const BLACK_HOLES: &[&str] = &["chi", "Weyl4_Re", "Weyl4_Im"];

/// What h5py finds in a file.
struct Expected {
    name: &'static str,
    time: f64,
    ratios: &'static [[i64; 3]],
    /// Of level 0.
    cell_size: [f64; 3],
    /// First and last cell of level 0.
    domain: [[i64; 3]; 2],
    bricks: &'static [usize],
    cells: u64,
    fields: &'static [&'static str],
    voxel_type: VoxelType,
    /// Over the cells of all levels, without ghosts.
    sum_of_last_field: f64,
    /// Field, level, brick, cell in the brick, value.
    samples: [(usize, usize, usize, [usize; 3], f64); 3],
}

#[rustfmt::skip]
const FILES: &[Expected] = &[
    Expected {
        name: "bbh_ghosts3",
        time: 0.0,
        ratios: &[[2, 2, 2], [2, 2, 2], [2, 2, 2]],
        cell_size: [4.0, 4.0, 4.0],
        domain: [[0, 0, 0], [31, 31, 15]],
        bricks: &[4, 4, 4, 8],
        cells: 73728,
        fields: BLACK_HOLES,
        voxel_type: F64,
        sum_of_last_field: -0.1955462914781967,
        samples: [(0, 0, 3, [14, 3, 12], 0.9749103196621106), (2, 3, 2, [4, 3, 15], -0.00018117704995787148), (1, 2, 2, [0, 14, 11], -0.00013664950757764918)],
    },
    Expected {
        name: "bbh_small",
        time: 4.0,
        ratios: &[[2, 2, 2], [2, 2, 2], [2, 2, 2], [2, 2, 2], [2, 2, 2]],
        cell_size: [4.0, 4.0, 4.0],
        domain: [[0, 0, 0], [31, 31, 15]],
        bricks: &[4, 4, 4, 8, 12, 18],
        cells: 165888,
        fields: BLACK_HOLES,
        voxel_type: F64,
        sum_of_last_field: -6.5808720998879044,
        samples: [(0, 0, 2, [13, 1, 12], 0.9790359186168941), (1, 5, 1, [3, 0, 7], 0.01605800141031339), (2, 3, 4, [8, 0, 5], -7.358759945604016e-05)],
    },
    Expected {
        name: "edge_negative_lo",
        time: 1.5,
        ratios: &[[4, 4, 4], [2, 2, 2]],
        cell_size: [0.125, 0.125, 0.125],
        domain: [[-16, -8, 0], [15, 15, 23]],
        bricks: &[18, 2, 2],
        cells: 63488,
        fields: &["linear x+10y+100z", "gauss"],
        voxel_type: F64,
        sum_of_last_field: 32494.43645506549,
        samples: [(1, 0, 16, [7, 5, 1], 3.0480070931487388e-05), (0, 2, 0, [11, 1, 23], 114.7578125), (1, 1, 0, [2, 9, 1], 0.4277907547360652)],
    },
    Expected {
        name: "edge_unnamed_nodx",
        time: 1.0,
        ratios: &[[4, 4, 4], [2, 2, 2]],
        cell_size: [1.0, 1.0, 1.0],
        domain: [[-16, -8, 0], [15, 15, 23]],
        bricks: &[18, 2, 2],
        cells: 63488,
        fields: &["component_0", "component_1"],
        voxel_type: F64,
        sum_of_last_field: 32494.43645506549,
        samples: [(1, 0, 12, [6, 6, 7], 0.001143756223589066), (0, 2, 1, [7, 10, 8], 92.9140625), (0, 1, 0, [5, 18, 10], 87.265625)],
    },
    Expected {
        name: "edge_vec_dx",
        time: 0.0,
        ratios: &[[2, 2, 2]],
        cell_size: [0.25, 0.125, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 2],
        cells: 6144,
        fields: &["linear x+10y+100z", "gauss"],
        voxel_type: F64,
        sum_of_last_field: 8.76091483205453,
        samples: [(1, 0, 0, [2, 15, 5], 3.447105315853988e-05), (1, 1, 0, [2, 3, 4], 9.794481861317364e-06), (1, 1, 0, [0, 2, 0], 6.538263162530419e-05)],
    },
    Expected {
        name: "edge_vec_dx_vec_ratio",
        time: 0.0,
        ratios: &[[2, 1, 4]],
        cell_size: [0.25, 0.125, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 1],
        cells: 8192,
        fields: &["linear x+10y+100z", "gauss"],
        voxel_type: F64,
        sum_of_last_field: 8.778413923053959,
        samples: [(1, 0, 0, [4, 9, 9], 3.341049034865761e-05), (1, 1, 0, [3, 6, 16], 1.1364262700691042e-06), (1, 1, 0, [3, 5, 21], 1.9050153192583696e-06)],
    },
    Expected {
        name: "explosion_f32series.000000",
        time: 0.0,
        ratios: &[[2, 2, 2], [2, 2, 2]],
        cell_size: [0.0625, 0.0625, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 22, 42],
        cells: 21184,
        fields: EULER,
        voxel_type: F32,
        sum_of_last_field: 678735.3292989731,
        samples: [(4, 0, 0, [5, 8, 9], 291.2499694824219), (4, 2, 37, [0, 3, 1], 291.2499694824219), (0, 1, 5, [0, 0, 7], 4.699995994567871)],
    },
    Expected {
        name: "explosion_f32series.000004",
        time: 0.019272174686193466,
        ratios: &[[2, 2, 2], [2, 2, 2]],
        cell_size: [0.0625, 0.0625, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 8, 37],
        cells: 36864,
        fields: EULER,
        voxel_type: F32,
        sum_of_last_field: 707991.423980236,
        samples: [(4, 0, 0, [6, 11, 7], 2.719425916671753), (0, 2, 26, [0, 7, 6], 3.1493020057678223), (3, 1, 1, [4, 6, 2], -0.2258763611316681)],
    },
    Expected {
        name: "explosion_f32series.000008",
        time: 0.04438349977135658,
        ratios: &[[2, 2, 2], [2, 2, 2]],
        cell_size: [0.0625, 0.0625, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 13, 114],
        cells: 81536,
        fields: EULER,
        voxel_type: F32,
        sum_of_last_field: 823291.636390686,
        samples: [(4, 0, 0, [2, 5, 12], 2.7748160362243652), (2, 2, 67, [0, 0, 3], -0.5720363855361938), (0, 1, 5, [7, 9, 4], 0.9421018362045288)],
    },
    Expected {
        name: "explosion_large",
        time: 0.023017284832096065,
        ratios: &[[2, 2, 2], [2, 2, 2]],
        cell_size: [0.015625, 0.015625, 0.015625],
        domain: [[0, 0, 0], [63, 63, 63]],
        bricks: &[8, 64, 251],
        cells: 2961920,
        fields: &["density"],
        voxel_type: F64,
        sum_of_last_field: 5486131.173784269,
        samples: [(0, 0, 1, [31, 31, 2], 3.171010997913274), (0, 2, 203, [18, 12, 9], 1.7920337599155656), (0, 1, 54, [0, 6, 0], 1.8235876696971884)],
    },
    Expected {
        name: "explosion_onelevel",
        time: 0.0041525922111794525,
        ratios: &[],
        cell_size: [0.0625, 0.0625, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1],
        cells: 4096,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 26410.000000000004,
        samples: [(2, 0, 0, [5, 6, 12], -0.15172802314576483), (0, 0, 0, [6, 10, 9], 1.9987222211251345), (2, 0, 0, [7, 8, 11], 4.283798653257902)],
    },
    Expected {
        name: "explosion_r2r4_mixed",
        time: 0.013745080219003988,
        ratios: &[[2, 2, 2], [4, 4, 4]],
        cell_size: [0.0625, 0.0625, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 1, 87],
        cells: 114304,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 2863201.0678673075,
        samples: [(1, 0, 0, [9, 6, 9], 0.00024921295435658796), (4, 2, 52, [0, 6, 8], 135.52681273532193), (4, 1, 0, [9, 11, 10], 51.911541563835044)],
    },
    Expected {
        name: "explosion_r4_3lev",
        time: 0.0041525922111794525,
        ratios: &[[4, 4, 4], [4, 4, 4]],
        cell_size: [0.0625, 0.0625, 0.0625],
        domain: [[0, 0, 0], [15, 15, 15]],
        bricks: &[1, 26, 75],
        cells: 87616,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 2795670.185634306,
        samples: [(3, 0, 0, [6, 6, 8], -0.00012413328602535), (2, 2, 13, [4, 0, 0], 1.9773853161083715e-06), (1, 1, 12, [1, 10, 4], -0.3459126010828045)],
    },
    Expected {
        name: "explosion_series.000000",
        time: 0.0,
        ratios: &[[2, 2, 2]],
        cell_size: [0.041666666666666664, 0.041666666666666664, 0.041666666666666664],
        domain: [[0, 0, 0], [23, 23, 23]],
        bricks: &[8, 23],
        cells: 18432,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 196807.50000000003,
        samples: [(3, 0, 0, [2, 4, 6], 0.0), (4, 1, 9, [2, 5, 0], 291.25000000000006), (4, 1, 8, [3, 8, 5], 291.25000000000006)],
    },
    Expected {
        name: "explosion_series.000004",
        time: 0.012848120301389227,
        ratios: &[[2, 2, 2]],
        cell_size: [0.041666666666666664, 0.041666666666666664, 0.041666666666666664],
        domain: [[0, 0, 0], [23, 23, 23]],
        bricks: &[8, 4],
        cells: 20224,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 201074.47225820992,
        samples: [(2, 0, 3, [9, 3, 3], 6.8833312606103885), (2, 1, 3, [0, 3, 2], -5.863731408102936), (3, 1, 2, [0, 13, 5], -4.816667309328543)],
    },
    Expected {
        name: "explosion_series.000008",
        time: 0.02933700925099552,
        ratios: &[[2, 2, 2]],
        cell_size: [0.041666666666666664, 0.041666666666666664, 0.041666666666666664],
        domain: [[0, 0, 0], [23, 23, 23]],
        bricks: &[8, 16],
        cells: 29184,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 223450.2000054235,
        samples: [(2, 0, 3, [9, 3, 3], 3.0052092834618236), (0, 1, 0, [3, 6, 2], 1.401657219123364), (0, 1, 4, [10, 11, 0], 1.245964083978544)],
    },
    Expected {
        name: "explosion_small",
        time: 0.015739672803174867,
        ratios: &[[2, 2, 2], [2, 2, 2]],
        cell_size: [0.03125, 0.03125, 0.03125],
        domain: [[0, 0, 0], [31, 31, 31]],
        bricks: &[8, 8, 98],
        cells: 118656,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 1779771.6768948992,
        samples: [(2, 0, 1, [12, 12, 7], -0.02966774629362653), (1, 2, 90, [0, 12, 3], 2.6804646227340934), (0, 1, 0, [10, 2, 11], 1.6261068020156872)],
    },
    Expected {
        name: "ramp_noncubic",
        time: 0.006121000687181525,
        ratios: &[[2, 2, 2], [2, 2, 2]],
        cell_size: [0.015625, 0.015625, 0.015625],
        domain: [[0, 0, 0], [63, 15, 7]],
        bricks: &[4, 8, 42],
        cells: 129536,
        fields: EULER,
        voxel_type: F64,
        sum_of_last_field: 44548849.7282088,
        samples: [(1, 0, 0, [7, 2, 2], 57.09715220187402), (1, 2, 8, [2, 9, 1], 57.15767664977295), (4, 1, 1, [2, 0, 2], 563.4999999999999)],
    },
];

#[test]
fn real_files_open_as_h5py_reads_them() {
    for expected in FILES {
        let Some(path) = real_data(&format!("chombo/{}.3d.hdf5", expected.name)) else { return };
        let name = expected.name;
        let data = open(&path);
        assert_eq!(data.warnings(), <&[String]>::default(), "{name}");
        assert_eq!((data.format(), data.time()), ("Chombo HDF5", Some(expected.time)), "{name}");
        let fields: Vec<_> = data.fields().iter().map(|field| field.name.as_str()).collect();
        assert_eq!(fields, expected.fields, "{name}");
        assert!(data.fields().iter().all(|field| field.voxel_type == expected.voxel_type), "{name}");

        let hierarchy = data.hierarchy();
        assert_eq!(hierarchy.origin(), [0.0; 3], "{name}");
        let levels = hierarchy.levels();
        assert_eq!(levels[0].ratio(), [1; 3]);
        let ratios: Vec<_> = levels[1..].iter().map(Level::ratio).collect();
        assert_eq!(ratios, expected.ratios, "{name}");
        assert_eq!(levels.iter().map(|level| level.bricks().len()).collect::<Vec<_>>(), expected.bricks, "{name}");
        assert_eq!((levels[0].cell_size(), hierarchy.cells()), (expected.cell_size, expected.cells), "{name}");
        let [first, last] = expected.domain;
        assert_eq!(levels[0].domain(), IndexBox::from_corners(first, last).unwrap(), "{name}");

        for (field, level, brick, cell, value) in expected.samples {
            let field = read(&data, field);
            assert_eq!(field.value(levels[level].first_brick() + brick, cell), value, "{name}");
        }
        let last = read(&data, fields.len() - 1);
        assert_eq!((last.name(), last.voxel_type()), (*expected.fields.last().unwrap(), expected.voxel_type));
        let bytes = expected.cells * expected.voxel_type.bytes() as u64;
        assert_eq!((last.bytes(Residence::Mapped), last.bytes(Residence::Owned)), (bytes, 0), "{name}");
        let (mut sum, mut magnitude) = (0.0, 0.0);
        for (number, brick) in hierarchy.bricks().enumerate() {
            let cells = IndexBox::new([0; 3], brick.cells.size());
            let values = cells.iter().map(|cell| last.value(number, cell.map(|index| index as usize)));
            // Brick by brick, so that little is lost to rounding.
            let (brick_sum, brick_magnitude) = values.fold((0.0, 0.0), |(a, b), value| (a + value, b + value.abs()));
            sum += brick_sum;
            magnitude += brick_magnitude;
        }
        assert!((sum - expected.sum_of_last_field).abs() <= 1e-12 * magnitude, "{name}: {sum}");
    }
}

#[test]
fn every_cell_is_where_the_file_puts_it() {
    let Some(path) = real_data("chombo/edge_negative_lo.3d.hdf5") else { return };
    let data = open(&path);
    let linear = read(&data, 0);
    for (number, brick) in data.hierarchy().bricks().enumerate() {
        for cell in brick.cells.iter() {
            let [x, y, z] = data.hierarchy().to_world(brick.level, cell.map(|index| index as f64 + 0.5));
            let inside = std::array::from_fn(|axis| (cell[axis] - brick.cells.low[axis]) as usize);
            assert_eq!(linear.value(number, inside), x + 10.0 * y + 100.0 * z, "level {} {cell:?}", brick.level);
        }
    }
}

#[test]
fn ghost_layers_are_no_cells() {
    // Behind walls this file's ghost cells hold 1.23456789e+300.
    let Some(path) = real_data("chombo/ramp_noncubic.3d.hdf5") else { return };
    let data = open(&path);
    for field in 0..data.fields().len() {
        let field = read(&data, field);
        for (number, brick) in data.hierarchy().bricks().enumerate() {
            let size = brick.cells.size();
            let all = IndexBox::new([0; 3], size);
            assert!(all.iter().all(|cell| field.value(number, cell.map(|index| index as usize)).abs() < 1e6));
        }
    }
}
