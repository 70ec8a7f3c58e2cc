//! Enzo dumps. Numbers were computed from them with h5py.

use amray_testing::real_data;

use super::{assert_near, cells, integral, names, opened, values};

#[test]
fn any_file_of_a_dump_opens_it() {
    let Some(directory) = real_data("enzo/collapse_deep/DD0005") else { return };
    let files = ["", "DD0005", "DD0005.hierarchy", "DD0005.boundary", "DD0005.cpu0000"];
    for data in files.map(|name| opened(&directory.join(name))) {
        let fields = ["Density", "GasEnergy", "Temperature", "TotalEnergy", "x-velocity", "y-velocity", "z-velocity"];
        assert_eq!((data.format(), names(&*data)), ("Enzo", fields.to_vec()));
        assert_eq!(cells(&*data), [4096, 1312, 2928, 3136, 8000]);
    }
}

#[test]
fn grids_are_on_the_levels_that_pointers_tell() {
    let Some(path) = real_data("enzo/collapse_deep/DD0005") else { return };
    let data = opened(&path);
    assert_near(data.time().unwrap(), 4.9999982330117);
    assert_eq!(data.fields()[0].unit.as_deref(), Some("1.673e-20 CGS"));
    // One in the leaf cells of each grid.
    let known = [
        ([0.90625, 0.65625, 0.40625], 0.9724083529021694),
        ([0.359375, 0.546875, 0.734375], 1.1462506324018846),
        ([0.640625, 0.328125, 0.140625], 1.0025818842600678),
        ([0.7265625, 0.2421875, 0.1640625], 1.0149650940305452),
        ([0.3515625, 0.4296875, 0.5859375], 14.17108694084714),
        ([0.30859375, 0.46484375, 0.63671875], 6.894295034637127),
        ([0.337890625, 0.466796875, 0.634765625], 113.46006268543616),
    ];
    assert_eq!(values(&*data, "Density", &known.map(|(point, _)| point)), known.map(|(_, value)| value));
    assert_near(integral(&*data, "Density"), 2.52801994737774);
    assert!(data.warnings().is_empty() && data.hierarchy().warnings().is_empty());
}

#[test]
fn other_ratios_and_domains() {
    let Some(path) = real_data("enzo/noh_refine4/DD0001") else { return };
    let data = opened(&path);
    assert_eq!(data.hierarchy().bounds(), [[-0.5, 1.0, 2.0], [0.5, 1.75, 2.5]]);
    assert_eq!(data.hierarchy().levels()[2].ratio(), [4; 3]);
    let known = [
        ([0.09375, 1.21875, 2.34375], -0.8237649056667309),
        ([-0.4140625, 1.1484375, 2.1796875], -0.34116522844655484),
        ([-0.451171875, 1.064453125, 2.115234375], -0.32391955160970987),
        ([-0.435546875, 1.087890625, 2.248046875], -0.25848650541047347),
        ([-0.357421875, 1.005859375, 2.041015625], -0.8891486432591436),
    ];
    assert_eq!(values(&*data, "x-velocity", &known.map(|(point, _)| point)), known.map(|(_, value)| value));
    assert_near(integral(&*data, "x-velocity"), -0.23976122813037834);
    let Some(path) = real_data("enzo/collapse/DD0000") else { return };
    assert_near(integral(&*opened(&path), "Density"), 2.5280227661132812);
}
