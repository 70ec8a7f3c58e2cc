//! Real output of simulation codes: every reconstruction agrees with a brute force that searches all bricks.

use std::path::Path;
use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::Hierarchy;
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{OpenOptions, open};
use amray_testing::{BruteForce, Random, real_data};

/// Points of the domain, and of each level, at which the first field is sampled, and each further one.
const POINTS: [usize; 2] = [60, 4];

/// The data sets of a folder of the test data.
fn data_sets(folder: &str) -> Vec<std::path::PathBuf> {
    let Some(folder) = real_data(folder) else { return Vec::new() };
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

/// Points all over the domain, and as many in the bricks of each level and just around them.
fn points(hierarchy: &Hierarchy, count: usize, random: &mut Random) -> Vec<[f64; 3]> {
    let mut points: Vec<_> = (0..count).map(|_| random.point(hierarchy.bounds())).collect();
    for (level, description) in hierarchy.levels().iter().enumerate() {
        for _ in 0..count {
            let number = random.integer(0, description.bricks().len() as i64 - 1) as usize;
            let around = description.bricks()[number].grown([1; 3]).intersection(&description.domain());
            let corners = [around.low, around.high].map(|corner| corner.map(|index| index as f64));
            points.push(hierarchy.to_world(level, random.point(corners)));
        }
    }
    points
}

fn agrees_with_brute_force(path: &Path) {
    let data = open(path, &OpenOptions::default()).unwrap();
    let index = Arc::new(Index::build(data.hierarchy().clone()));
    let mut random = Random(1);
    for (number, info) in data.fields().iter().enumerate() {
        let field = data.read_field(number, &|_| {}).unwrap();
        let points = points(data.hierarchy(), POINTS[number.min(1)], &mut random);
        let [low, high] = Volume::new(index.clone(), field.clone(), Method::Nearest).leaf_range().unwrap();
        let tolerance = 1e-5 * (high - low).max(f64::MIN_POSITIVE);
        let brute = BruteForce::new(data.hierarchy(), &field);
        for method in Method::ALL {
            let volume = Volume::new(index.clone(), field.clone(), method);
            for (point, found) in points.iter().zip(volume.sample(&points)) {
                let expected = brute.sample(method, *point);
                let close = (found - expected).abs() <= tolerance || found.is_nan() && expected.is_nan();
                let place = format!("{} {} {method} at {point:?}", path.display(), info.name);
                assert!(close, "{place}: {found}, expected {expected}");
            }
        }
    }
}

#[test]
fn chombo_files_sample_as_defined() {
    data_sets("chombo").iter().for_each(|path| agrees_with_brute_force(path));
}

#[test]
fn amrex_plotfiles_sample_as_defined() {
    data_sets("amrex").iter().for_each(|path| agrees_with_brute_force(path));
}

#[test]
fn files_of_vtk_sample_as_defined() {
    for name in ["vtk/synth3.vtkhdf", "vtk/synth3_raw.vthb"] {
        real_data(name).iter().for_each(|path| agrees_with_brute_force(path));
    }
}
