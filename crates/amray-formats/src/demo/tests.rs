//! Whole data sets: is the mesh valid, is it fine where it must be, are the bytes always the same?

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use amray::hierarchy::{Hierarchy, IndexBox};
use hdf5_reader::Hdf5File;

use super::{Demo, DemoError, field};

fn silent(_: f64) {}

/// A small one whose level 2 has gaps.
fn small() -> Demo {
    Demo { levels: 3, base: 32, ..Demo::default() }
}

#[test]
fn the_field_has_the_same_bits_everywhere() {
    // Ambient gas, swept gas, ejecta, cavity.
    let expected = [
        ([3, 900, 17], [0x3fc1_7645_8c98_5a59, 0x3fe7_74e7_0abc_0ed0]),
        ([930, 520, 520], [0x3ff0_4e94_145a_b26b, 0x3fed_f7f9_17b0_e595]),
        ([700, 700, 500], [0x4002_917f_d9d6_5589, 0x3fd1_4875_f17c_cc67]),
        ([500, 520, 530], [0x3fe5_3d3c_baca_bf5e, 0x3fe8_1c66_1de0_7519]),
    ];
    for (cell, bits) in expected {
        let found = field::at_centre(cell, 1024);
        assert_eq!(found.map(f64::to_bits), bits, "{cell:?}: {found:?}");
    }
    let domain = IndexBox::new([0; 3], [48; 3]);
    for [density, temperature] in domain.iter().map(|cell| field::at_centre(cell, 48)) {
        assert!((0.05..8.0).contains(&density) && (0.05..10.0).contains(&temperature), "{density} {temperature}");
    }
}

#[test]
fn meshes_are_valid_and_properly_nested() {
    let odd = Demo { levels: 4, base: 9, brick: 8, threshold: 0.15, ..Demo::default() };
    let quartering = Demo { levels: 3, base: 17, ratio: 4, brick: 24, threshold: 0.4 };
    for demo in [small(), odd, quartering] {
        let hierarchy = demo.hierarchy(&silent).unwrap();
        assert_eq!(hierarchy.levels().len(), demo.levels);
        assert_eq!(hierarchy.warnings(), []);
        assert_eq!(hierarchy.levels()[0].cells(), (demo.base as u64).pow(3));
        let brick = demo.brick as i64;
        assert!(hierarchy.bricks().all(|found| found.cells.size().iter().all(|&side| side <= brick)));
        for pair in hierarchy.levels().windows(2) {
            let (coarse, fine) = (&pair[0], &pair[1]);
            for found in fine.bricks() {
                let aligned = |index: &i64| index % super::ALIGNMENT == 0 || *index == fine.domain().high[0];
                assert!(found.low.iter().chain(&found.high).all(aligned), "{found}");
                let needed = found.coarsened(fine.ratio()).grown([1; 3]).intersection(&coarse.domain());
                let covered = coarse.bricks().iter().map(|brick| brick.intersection(&needed).cells()).sum::<u64>();
                assert_eq!(covered, needed.cells(), "{found}");
            }
        }
    }
}

#[test]
fn every_level_refines_a_smaller_share_and_reaches_the_impact() {
    let demo = Demo { levels: 7, base: 16, threshold: 0.45, ..Demo::default() };
    let hierarchy = demo.hierarchy(&silent).unwrap();
    let shares = hierarchy.levels().iter().map(|level| level.cells() as f64 / level.domain().cells() as f64);
    let shares: Vec<f64> = shares.collect();
    assert!(shares.is_sorted_by(|coarse, fine| fine <= coarse) && shares[6] < 0.01, "{shares:?}");
    let finest = &hierarchy.levels()[6];
    let impact = field::IMPACT.map(|place| (place * finest.domain().high[0] as f64) as i64);
    assert!(finest.bricks().iter().any(|brick| brick.contains(impact)));
}

#[test]
fn it_is_fine_where_the_density_changes() {
    let hierarchy = small().hierarchy(&silent).unwrap();
    // The mean contrast of neighbours, all at the spacing of level 1, inside and outside of level 2.
    let (level, finest) = (&hierarchy.levels()[1], &hierarchy.levels()[2]);
    let footprints: Vec<IndexBox> = finest.bricks().iter().map(|brick| brick.coarsened([2; 3])).collect();
    let mut sums = [(0.0, 0); 2];
    for cell in level.domain().iter() {
        let [here, there] = [cell, [cell[0] + 1, cell[1], cell[2]]].map(|cell| field::at_centre(cell, 64)[0]);
        let sum = &mut sums[usize::from(footprints.iter().any(|brick| brick.contains(cell)))];
        *sum = (sum.0 + (here - there).abs() / (here + there), sum.1 + 1);
    }
    let [coarse, fine] = sums.map(|(sum, count)| sum / f64::from(count));
    assert!(fine > 10.0 * coarse, "{coarse} {fine}");
}

#[test]
fn the_same_bytes_with_any_number_of_threads() {
    let directory = tempfile::tempdir().unwrap();
    let bytes = |threads: usize| {
        let path = directory.path().join(format!("{threads}.hdf5"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| small().write(&path, &silent)).unwrap();
        std::fs::read(path).unwrap()
    };
    assert!(bytes(1) == bytes(5));
}

#[test]
fn the_file_holds_the_field() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("demo.hdf5");
    let farthest = AtomicU64::new(0);
    let progress = |share: f64| {
        assert!((0.0..=1.0).contains(&share));
        farthest.fetch_max(share.to_bits(), Ordering::Relaxed);
    };
    small().write(&path, &progress).unwrap();
    assert_eq!(f64::from_bits(farthest.into_inner()), 1.0);

    let hierarchy = small().hierarchy(&silent).unwrap();
    let file = Hdf5File::open(&path).unwrap();
    let name = |number: usize| {
        let name = file.root_group().unwrap().attribute(&format!("component_{number}")).unwrap();
        name.read_string().unwrap()
    };
    assert_eq!([name(0), name(1)], field::COMPONENTS);
    for (number, level) in hierarchy.levels().iter().enumerate() {
        let boxes = file.dataset(&format!("/level_{number}/boxes")).unwrap();
        assert_eq!(boxes.num_elements().unwrap(), level.bricks().len() as u64);
        assert_values(&file, number, &hierarchy);
    }
}

/// The last brick's values are the field's.
fn assert_values(file: &Hdf5File, number: usize, hierarchy: &Hierarchy) {
    let level = &hierarchy.levels()[number];
    let brick = level.bricks().last().unwrap();
    let written = file.dataset(&format!("/level_{number}/data:datatype=0")).unwrap().read_array::<f64>().unwrap();
    let side = level.domain().high[0];
    assert_eq!(written.len() as u64, 2 * level.cells());
    let component = |number: usize| brick.iter().map(move |cell| field::at_centre(cell, side)[number]);
    let expected: Vec<f64> = component(0).chain(component(1)).collect();
    let tail = written.iter().skip(written.len() - expected.len());
    assert!(tail.eq(&expected), "level {number}");
}

#[test]
fn parameters_out_of_range_are_refused() {
    let message = |demo: Demo| demo.write(Path::new("/nonexistent/demo.hdf5"), &silent).unwrap_err().to_string();
    let default = Demo::default();
    assert_eq!(message(Demo { levels: 0, ..default }), "the number of levels is 0, expected 1 to 12");
    assert_eq!(message(Demo { levels: 13, ..default }), "the number of levels is 13, expected 1 to 12");
    assert_eq!(message(Demo { base: 7, ..default }), "the base is 7, expected 8 to 1024 cells per side");
    assert_eq!(message(Demo { ratio: 3, ..default }), "the ratio is 3, expected 2 or 4");
    let brick = "expected a multiple of 8 from 8 to 128 cells";
    assert_eq!(message(Demo { brick: 0, ..default }), format!("the brick size is 0, {brick}"));
    assert_eq!(message(Demo { brick: 20, ..default }), format!("the brick size is 20, {brick}"));
    for threshold in [0.0, 1.0, f64::NAN] {
        let expected = format!("the threshold is {threshold}, expected a number between 0 and 1");
        assert_eq!(message(Demo { threshold, ..default }), expected);
    }
    assert_eq!(
        message(Demo { base: 1024, levels: 12, ratio: 4, ..default }),
        "the finest level's width is 4294967296, expected at most 2147483647 cells per side"
    );
    let written = Demo { levels: 1, base: 8, ..default }.write(Path::new("/nonexistent/demo.hdf5"), &silent);
    assert!(matches!(written, Err(DemoError::Format(_))));
}

#[test]
fn nothing_is_refined_where_nothing_differs_enough() {
    let hierarchy = Demo { base: 16, threshold: 0.99, ..Demo::default() }.hierarchy(&silent).unwrap();
    assert_eq!(hierarchy.levels().len(), 1);
}
