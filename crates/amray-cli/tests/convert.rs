//! `amray convert` as a user runs it.

mod common;

use std::path::Path;

use amray_testing::{Random, real_data};
use serde_json::Value;

use common::{demo, fails, json, misused, prints};

/// A raw volume in which the half of low x is constant and the other one is not.
fn volume(directory: &Path, side: usize) {
    let mut random = Random(3);
    let value = |number: usize| if number % side < side / 2 { 1.0 } else { random.unit() as f32 };
    let bytes: Vec<u8> = (0..side * side * side).map(value).flat_map(f32::to_le_bytes).collect();
    std::fs::write(directory.join("v.raw"), bytes).unwrap();
}

fn convert(directory: &Path, flags: &[&str]) -> Value {
    json(&prints(directory, &[&["convert"], flags, &["--json"]].concat()))
}

#[test]
fn a_raw_volume_becomes_amr_data() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    volume(here, 32);
    let raw = ["v.raw", "-o", "v.hdf5", "--dims", "32,32,32", "--type", "f32"];
    let flags = ["--brick", "8", "--spacing", "0.5,1,2", "--origin", "-1,0,0.5"];
    let report = convert(here, &[&raw[..], &flags].concat());
    let keys: Vec<_> = report.as_object().unwrap().keys().cloned().collect();
    let expected =
        ["bytes", "cells", "fields", "format", "input", "levels", "original", "output", "peak_resident_bytes"];
    assert_eq!(keys, expected);
    // Of 64 fine bricks, half are dropped.
    let cells: Vec<_> = report["levels"].as_array().unwrap().iter().map(|level| &level["cells"]).collect();
    assert_eq!(cells, [512, 2048, 16384]);
    assert_eq!(report["bytes"], std::fs::metadata(here.join("v.hdf5")).unwrap().len());
    let original = &report["original"];
    assert_eq!(
        (&original["bytes"], &original["max_error"], &original["threshold"]),
        (&131_072.into(), &0.0.into(), &0.0.into())
    );
    assert_eq!(original["cells_share"], (512.0 + 2048.0 + 16384.0) / 32768.0);

    let info = json(&prints(here, &["info", "v.hdf5", "--json"]));
    assert_eq!(info["fields"][0]["name"], "value");
    assert_eq!(info["bounds"], json("[[-1.25, -0.5, -0.5], [14.75, 31.5, 63.5]]"));
    assert_eq!(info["levels"][2]["cell_size"], json("[0.5, 1.0, 2.0]"));
    assert_eq!(info["levels"][2]["bricks"], 32);
    prints(here, &["render", "v.hdf5", "--size", "16"]);

    let text = prints(here, &[&["convert"], &raw[..], &["--threshold", "0.3", "--levels", "2"]].concat());
    assert!(text.starts_with("v.hdf5: value, ") && text.contains("raw volume 32 x 32 x 32: 32 768 samples, 131 kB"));
    let error = text.lines().last().unwrap();
    assert!(error.starts_with("error at the samples: ") && error.ends_with("(threshold 0.3)"), "{text}");
}

#[test]
fn memory_stays_within_its_budget() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let peak = |side: usize| {
        volume(here, side);
        let dims = format!("{side},{side},{side}");
        let flags = ["v.raw", "-o", "v.hdf5", "--dims", &dims, "--type", "f32", "--memory", "7M", "--threshold", "0.1"];
        convert(here, &flags)["peak_resident_bytes"].as_u64()
    };
    // What the program itself takes, and then a volume of 4 budgets.
    let (Some(itself), Some(peak)) = (peak(16), peak(192)) else { return };
    assert!(peak < itself + 7_000_000, "{peak} bytes at most, of which {itself} are the program's own");
    let flags = ["convert", "v.raw", "-o", "v.hdf5", "--dims", "192,192,192", "--type", "f32", "--memory", "1M"];
    let error = fails(here, &flags);
    assert!(error.starts_with("amray: 1000000 bytes of memory, expected at least "), "{error}");
}

#[test]
fn amr_data_change_their_format_alone() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    let report = convert(here, &[path, "-o", "copy.h5"]);
    assert!(report.get("original").is_none() && report["fields"] == json(r#"["density", "temperature"]"#));
    assert!(std::fs::read(here.join("copy.h5")).unwrap() == std::fs::read(path).unwrap());
    let info = |name: &str| json(&prints(here, &["info", name, "--json"]));
    convert(here, &[path, "-o", "one.hdf5", "--field", "temperature", "--max-level", "0"]);
    let (one, all) = (info("one.hdf5"), info(path));
    assert_eq!(one["fields"].as_array().unwrap().len(), 1);
    assert_eq!((&one["levels"].as_array().unwrap()[..], &one["bounds"]).0.len(), 1);
    convert(here, &[path, "-o", "two.hdf5", "--field", "temperature", "--field", "density", "--restrict"]);
    let two = info("two.hdf5");
    assert_eq!(
        (&two["fields"][0], &two["fields"][1], &two["levels"]),
        (&all["fields"][1], &all["fields"][0], &all["levels"])
    );
    assert_ne!(std::fs::read(here.join("two.hdf5")).unwrap(), std::fs::read(path).unwrap());
}

#[test]
fn vtk_data_hold_the_same() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    for name in ["vtk.vthb", "vtk.vtkhdf"] {
        let report = convert(here, &[path, "-o", name]);
        // Two components in double precision, and what is around them.
        let values = 16 * report["cells"].as_u64().unwrap();
        assert!((values..values + values / 10).contains(&report["bytes"].as_u64().unwrap()), "{report}");
        convert(here, &[name, "-o", "back.hdf5"]);
        assert!(std::fs::read(here.join("back.hdf5")).unwrap() == std::fs::read(path).unwrap(), "{name}");
        prints(here, &["render", name, "--size", "16"]);
    }
    // Over its own images, no index is written, not even from a file of another name.
    let index = std::fs::read(here.join("vtk.vthb")).unwrap();
    std::fs::write(here.join("vtk.vth"), &index).unwrap();
    for name in ["vtk.vthb", "vtk.vth"] {
        let error = fails(here, &["convert", name, "-o", "vtk.vthb"]);
        assert!(error.ends_with("vtk.vthb: this is the input, expected another name"), "{error}");
    }
}

#[test]
fn images_of_vtk_become_amr_data() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let numbers = |count: usize| (0..count).map(|number| number.to_string()).collect::<Vec<_>>().join(" ");
    let array = |name: &str, count: usize| {
        format!("<DataArray type=\"Int16\" Name=\"{name}\" format=\"ascii\">{}</DataArray>", numbers(count))
    };
    let image = format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 8 0 8 0 8\" Origin=\"1 2 3\" Spacing=\"1 1 .5\">\
         <Piece Extent=\"0 8 0 8 0 8\"><PointData Scalars=\"heat\">{}</PointData><CellData>{}</CellData></Piece>\
         </ImageData></VTKFile>",
        array("heat", 729),
        array("mass", 512)
    );
    std::fs::write(here.join("v.vti"), image).unwrap();
    let report = convert(here, &["v.vti", "-o", "v.hdf5", "--brick", "4", "--field", "mass"]);
    assert_eq!((&report["original"]["size"], &report["format"]), (&json("[8, 8, 8]"), &"VTK ImageData".into()));
    let info = json(&prints(here, &["info", "v.hdf5", "--json"]));
    assert_eq!(info["bounds"], json("[[1.0, 2.0, 3.0], [9.0, 10.0, 7.0]]"));
    assert_eq!(convert(here, &["v.vti", "-o", "v.hdf5"])["original"]["size"], json("[9, 9, 9]"));
    let unknown = fails(here, &["convert", "v.vti", "-o", "v.hdf5", "--field", "mess"]);
    assert!(unknown.ends_with("no field \"mess\", did you mean \"mass\"?; the fields are mass, heat"), "{unknown}");
    let hint = fails(here, &["info", "v.vti"]);
    assert!(hint.contains("a structured volume (amray convert makes AMR data of it), expected"), "{hint}");
}

#[test]
fn real_data_are_converted() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let Some(amrex) = real_data("amrex") else { return };
    for name in ["plt_small", "plt_small_rr42", "plt_ieee32_bigendian"] {
        let path = amrex.join(name);
        let path = path.to_str().unwrap();
        prints(here, &["convert", path, "-o", "a.hdf5"]);
        let [mut before, mut after] = [path, "a.hdf5"].map(|path| json(&prints(here, &["info", path, "--json"])));
        for info in [&mut before, &mut after] {
            info.as_object_mut().unwrap().remove("format");
        }
        assert_eq!(before, after, "{name}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    volume(here, 8);
    let error = |flags: &[&str]| fails(here, &[&["convert"], flags].concat());
    let path = demo().to_str().unwrap();
    let unknown = error(&["v.raw", "-o", "a.hdf5"]);
    assert!(
        unknown.ends_with("or a structured volume (NRRD, NumPy, NIfTI, VTK ImageData; raw with --dims)"),
        "{unknown}"
    );
    let length = error(&["v.raw", "-o", "a.hdf5", "--dims", "8,8,9", "--type", "f32"]);
    assert!(
        length.ends_with("v.raw: raw volume: 2048 bytes, expected 2304 for 8 x 8 x 9 samples of type f32"),
        "{length}"
    );
    let volume = error(&[path, "-o", "a.hdf5", "--threshold", "1"]);
    assert!(volume.ends_with("are for structured volumes, these are AMR data"), "{volume}");
    let data = error(&["v.raw", "-o", "a.hdf5", "--dims", "8,8,8", "--type", "f32", "--restrict"]);
    assert!(data.ends_with("are for AMR data, this is a volume"), "{data}");
    let nameless = error(&["v.raw", "-o", "a.hdf5", "--dims", "8,8,8", "--type", "f32", "--field", "a"]);
    assert!(nameless.ends_with("--field is for files that name their fields, a raw volume does not"), "{nameless}");
    assert!(error(&[path, "-o", "a.hdf5", "--field", "densty"]).contains("did you mean \"density\"?"));
    assert!(error(&["nowhere", "-o", "a.hdf5"]).starts_with("amray: nowhere: cannot open: "));
    assert!(error(&["nowhere", "-o", "missing/a.hdf5"]).starts_with("amray: missing/a.hdf5: cannot write: "));
    for flags in [
        &["v.raw", "-o", "a.vti"][..],
        &["v.raw"],
        &["v.raw", "-o", "a.hdf5", "--dims", "8,8,8"],
        &["v.raw", "-o", "a.hdf5", "--dims", "8,8", "--type", "f32"],
        &["v.raw", "-o", "a.hdf5", "--dims", "8,8,8", "--type", "f16"],
        &["v.raw", "-o", "a.hdf5", "--big-endian"],
        &["v.raw", "-o", "a.hdf5", "--memory", "lots"],
    ] {
        misused(here, &[&["convert"], flags].concat());
    }
    assert_eq!(std::fs::read_dir(here).unwrap().count(), 1);
}

#[test]
fn the_input_is_never_the_output() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    std::fs::copy(demo(), here.join("a.hdf5")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.hdf5", here.join("link.h5")).unwrap();
    for output in ["a.hdf5", "./a.hdf5", "link.h5"] {
        let error = fails(here, &["convert", "a.hdf5", "-o", output]);
        assert_eq!(error, format!("amray: {output}: this is the input, expected another name"));
    }
    // The samples of a detached header are input, too.
    volume(here, 8);
    std::fs::rename(here.join("v.raw"), here.join("samples.h5")).unwrap();
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 8 8 8\nencoding: raw\nendian: little\n";
    std::fs::write(here.join("v.nhdr"), format!("{header}data file: samples.h5\n")).unwrap();
    let error = fails(here, &["convert", "v.nhdr", "-o", "samples.h5"]);
    assert_eq!(error, "amray: samples.h5: this is the input, expected another name");
    prints(here, &["convert", "v.nhdr", "-o", "v.h5"]);
}
