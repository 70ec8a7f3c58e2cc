//! Expressions wherever the program takes a field's name.

mod common;

use amray_testing::real_data;

use common::{demo, fails, json, npy, prints};

#[test]
fn every_command_takes_expressions() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    std::fs::write(here.join("p.csv"), "0.3,0.4,0.5\n0.9,0.2,0.7\n").unwrap();
    let values = |field: &str| -> Vec<f64> {
        let said = prints(here, &["sample", path, "--points", "p.csv", "--method", "nearest", "--field", field]);
        said.lines().map(|line| line.parse().unwrap()).collect()
    };
    let [density, temperature] = ["density", "temperature"].map(values);
    let product = values("density * temperature^2");
    for place in 0..2 {
        let expected = density[place] * temperature[place] * temperature[place];
        assert!((product[place] - expected).abs() <= 1e-6 * expected, "{product:?}");
    }
    let object = json(&prints(here, &["info", path, "--json", "--field", "2*density"]));
    let once = json(&prints(here, &["info", path, "--json", "--field", "density"]));
    assert_eq!(object["fields"][0]["name"], "2*density");
    assert_eq!(object["fields"][0]["max"].as_f64().unwrap(), 2.0 * once["fields"][0]["max"].as_f64().unwrap());
    for arguments in [
        &["render", path, "--size", "16", "-o", "a.png", "--field=-log10(density)"][..],
        &["render", path, "--size", "16", "-o", "b.png", "--color-by", "gradient_magnitude(density):inferno"],
        &["render", path, "--size", "16", "-o", "c.png", "--overlay", "max(density, x):magma:0,2:0.5"],
        &["render", path, "--size", "16", "-o", "d.png", "--iso", "1:atan2(y, x)", "--hide-volume"],
        &["slice", path, "--size", "16", "-o", "e.png", "--axis", "z", "--field", "sqrt(x^2+y^2)"],
        &["project", path, "--size", "16x16", "-o", "f.png", "--field", "density*(level == 1)", "--restrict"],
    ] {
        prints(here, arguments);
    }
}

#[test]
fn scenes_keep_expressions() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    let flags = ["render", path, "--size", "24", "--field", "density/temperature", "--color-by", "sqrt(temperature)"];
    prints(here, &[&flags[..], &["-o", "a.npy", "--save-scene", "scene.json"]].concat());
    let scene = json(&std::fs::read_to_string(here.join("scene.json")).unwrap());
    assert_eq!(scene["data"]["field"], "density/temperature");
    assert_eq!(scene["fields"]["color_by"]["field"], "sqrt(temperature)");
    prints(here, &["render", "--scene", "scene.json", "-o", "b.npy"]);
    let [first, second] = ["a.npy", "b.npy"].map(|name| npy::<f32>(&here.join(name)));
    assert!(first == second, "the picture is the same");
}

#[test]
fn restriction_comes_before_what_follows() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let Some(path) = real_data("chombo/bbh_small.3d.hdf5") else { return };
    let path = path.to_str().unwrap();
    // Weyl4 is never averaged down: next to finer cells, slopes over covered ones are of stale values.
    let range = |flags: &[&str]| {
        let fixed = ["slice", path, "--axis", "z", "--size", "200", "--method", "nearest", "-o", "a.npy"];
        prints(here, &[&fixed[..], &["--field", "gradient_x(Weyl4_Re)"], flags].concat());
        npy::<f64>(&here.join("a.npy")).1
    };
    let (stale, restricted) = (range(&[]), range(&["--restrict"]));
    assert!(stale != restricted);
}

#[test]
fn what_is_no_expression_is_said_in_one_line() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    let said = |field: &str| fails(directory.path(), &["info", path, "--field", field]);
    let fields = "the fields are density, temperature";
    assert_eq!(said("sqrt(x"), format!("amray: {path}: expression \"sqrt(x\": column 7: expected ')'; {fields}"));
    assert_eq!(said("densty"), format!("amray: {path}: no field \"densty\", did you mean \"density\"?; {fields}"));
    assert!(said("").contains("expected a number, a name or a parenthesis"));
}

#[test]
fn info_lists_the_formulas_in_a_file() {
    let directory = tempfile::tempdir().unwrap();
    let Some(path) = real_data("chombo/explosion_small.3d.hdf5") else { return };
    let path = path.to_str().unwrap();
    let object = json(&prints(directory.path(), &["info", path, "--json"]));
    let formula = "(gamma-1)*(<energy-density>-kinetic_energy*density)";
    let derived = object["derived"].as_array().unwrap();
    assert!(derived.contains(&serde_json::json!({"name": "pressure", "formula": formula})), "{derived:?}");
    let text = prints(directory.path(), &["info", path]);
    assert!(text.contains(&format!("pressure        {formula}\n")), "{text}");
    let range = json(&prints(directory.path(), &["info", path, "--json", "--field", "pressure"]));
    assert!(range["fields"][0]["min"].as_f64().unwrap() > 0.9);
}
