//! Athena++ files. Numbers were computed from them with h5py.

use amray::reconstruction::Method;
use amray_formats::{OpenOptions, open};
use amray_testing::real_data;

use super::{assert_near, cells, integral, names, opened, refused, values};

fn file(name: &str) -> Option<std::path::PathBuf> {
    real_data(&format!("athena/{name}"))
}

#[test]
fn axes_and_blocks_are_where_their_locations_put_them() {
    let Some(path) = file("blast_offc.prim.00001.athdf") else { return };
    let data = opened(&path);
    assert_eq!((data.format(), names(&*data)), ("Athena++ HDF5", vec!["rho", "press", "vel1", "vel2", "vel3"]));
    assert_near(data.time().unwrap(), 0.03999999910593033);
    let bounds = data.hierarchy().bounds();
    assert_eq!(bounds[0], [-0.5, 0.0, 2.0]);
    (0..3).for_each(|axis| assert_near(bounds[1][axis], [1.5, 0.75, 3.200000047683716][axis]));
    // Leaves of 12, 73 and 184 blocks of 8^3, and what coarse blocks lie under them: all of the domain but for the finest.
    assert_eq!(cells(&*data), [32 * 16 * 24, (73 + 184 / 8) * 512, 184 * 512]);
    let known = [
        ([0.3203125, 0.439453125, 2.243750095], -0.06610257178544998),
        ([0.2578125, 0.509765625, 2.193749905], 0.40027347207069397),
        ([0.2265625, 0.533203125, 2.418749809], 0.7939356565475464),
        ([0.2890625, 0.568359375, 2.318749905], 0.9140717387199402),
        ([0.2265625, 0.404296875, 2.34375], -1.266107201576233),
        ([0.2109375, 0.287109375, 2.356249809], -1.2042633295059204),
    ];
    assert_eq!(values(&*data, "vel2", &known.map(|(point, _)| point)), known.map(|(_, value)| value));
    assert_near(integral(&*data, "rho"), 1.800000071487136);
    // The file beside it only names it.
    let directory = tempfile::tempdir().unwrap();
    std::fs::copy(&path, directory.path().join("a.athdf")).unwrap();
    let beside = directory.path().join("a.athdf.xdmf");
    std::fs::write(&beside, "<?xml version=\"1.0\" ?>\n<Xdmf Version=\"2.0\">\n <DataItem>\n a.athdf:/prim\n").unwrap();
    assert_eq!(cells(&*opened(&beside)), cells(&*data));
}

#[test]
fn values_of_two_data_sets_are_fields() {
    let Some(path) = file("blast_mhd.prim.00001.athdf") else { return };
    let data = opened(&path);
    assert_eq!(names(&*data), ["rho", "press", "vel1", "vel2", "vel3", "Bcc1", "Bcc2", "Bcc3"]);
    let known = [
        ([0.06640625, -0.01171875, -0.07421875], 0.31287965178489685),
        ([0.05078125, 0.08984375, 0.01171875], -0.13945335149765015),
        ([-0.05078125, -0.08984375, 0.02734375], 0.22177553176879883),
        ([0.03515625, 0.04296875, -0.04296875], 0.08492130041122437),
    ];
    assert_eq!(values(&*data, "Bcc3", &known.map(|(point, _)| point)), known.map(|(_, value)| value));
    assert_near(integral(&*data, "Bcc2"), 0.17677669207355962);
}

#[test]
fn ghost_zones_are_no_cells() {
    let Some(path) = file("blast_ghost.ghost.00001.athdf") else { return };
    let data = opened(&path);
    let known = [
        ([0.140625, 0.52734375, 2.215624809], 1.0692017078399658),
        ([0.203125, 0.36328125, 2.403124809], 0.40082812309265137),
        ([0.171875, 0.48046875, 2.346875191], 0.5585017800331116),
        ([0.265625, 0.59765625, 2.384375095], 1.1289629936218262),
    ];
    assert_eq!(values(&*data, "rho", &known.map(|(point, _)| point)), known.map(|(_, value)| value));
    assert_near(integral(&*data, "rho"), 1.8000000714277575);
    // No leaf on level 0, which is completed.
    assert_eq!(cells(&*data)[0], 16 * 8 * 16);
}

#[test]
fn bytes_are_numbers_too() {
    let Some(path) = file("blast_offc.u8.00001.athdf") else { return };
    let data = opened(&path);
    let known = [([0.0859375, 0.427734375, 2.518750191], 64.0), ([0.1328125, 0.556640625, 2.381249905], 16.0)];
    assert_eq!(values(&*data, "rho", &known.map(|(point, _)| point)), known.map(|(_, value)| value));
    assert_near(integral(&*data, "rho"), 113.40896294152571);
}

#[test]
fn what_has_no_place_or_no_even_cells_is_refused() {
    if let Some(path) = file("blast_offc.nomesh.00001.athdf") {
        assert!(refused(&path).ends_with("no attribute RootGridSize: the extents cannot be known"));
    }
    if let Some(path) = file("blast_rat.prim.00001.athdf") {
        assert!(refused(&path).contains("RootGridX1 has the cell ratio 1.0499"), "{}", refused(&path));
    }
}

#[test]
fn coarse_levels_are_means_of_the_leaves() {
    let Some(path) = file("blast8.out2.00002.athdf") else { return };
    let whole = integral(&*opened(&path), "press");
    assert_near(whole, 0.11044997720148331);
    for max_level in 0..3 {
        let data = open(&path, &OpenOptions { max_level: Some(max_level), ..OpenOptions::default() }).unwrap();
        assert_eq!(data.hierarchy().finest_level(), max_level);
        assert!((integral(&*data, "press") - whole).abs() < 1e-7 * whole);
        assert!(data.hierarchy().warnings().is_empty());
        // Blending looks at the coarse levels.
        let blended = super::volume(&*data, "press");
        let blended = amray::Volume::new(blended.index().clone(), blended.field().clone(), Method::Blend);
        assert!(blended.sample(&[[0.1, 0.0, -0.2]])[0].is_finite());
    }
    let options = OpenOptions { max_level: Some(3), ..OpenOptions::default() };
    assert!(open(&path, &options).err().unwrap().to_string().ends_with("no level 3; the finest level is 2"));
}
