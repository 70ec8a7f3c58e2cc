//! The program as a user runs it: what it prints, what it writes, and what it says when something is wrong.

mod common;

use std::path::{Path, PathBuf};

use amray_testing::real_data;

use common::{SMALL, amray, demo, fails, json, misused, npy, png, prints};

#[test]
fn a_demo_and_its_picture() {
    let directory = tempfile::tempdir().unwrap();
    let said = prints(directory.path(), &["demo", "--levels", "2", "--base", "16"]);
    assert_eq!(said, format!("picture: {}\n", directory.path().join("amray-demo.png").display()));
    let names: Vec<_> = std::fs::read_dir(&directory).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["amray-demo.png"], "data that is not kept is gone");
    prints(directory.path(), &[&["demo", "--keep"], SMALL].concat());
    assert_eq!(std::fs::read(directory.path().join("amray-demo.hdf5")).unwrap(), std::fs::read(demo()).unwrap());
}

#[test]
fn a_demo_never_lays_its_picture_over_its_data() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for name in ["demo.png", "demo.PNG", "demo.exr"] {
        let error = misused(here, &["demo", "--levels", "1", "--base", "16", "-o", name]);
        assert!(error.contains("this is where the data set goes"), "{error}");
    }
    // The picture cannot be written: the data set is not made either.
    std::fs::create_dir(here.join("a.png")).unwrap();
    let error = fails(here, &["demo", "--levels", "1", "--base", "16", "-o", "a.hdf5"]);
    assert!(error.starts_with("amray: a.png: cannot write: "), "{error}");
    assert_eq!(std::fs::read_dir(here).unwrap().count(), 1);
    let said = prints(here, &["demo", "--levels", "2", "--base", "8", "--ratio", "4", "-o=-b.hdf5"]);
    let [data, picture] = ["-b.hdf5", "-b.png"].map(|name| here.join(name));
    assert_eq!(said, format!("data:    {}\npicture: {}\n", data.display(), picture.display()));
    let info = json(&prints(here, &["info", data.to_str().unwrap(), "--json"]));
    assert_eq!(info["levels"][1]["ratio"], json("[4, 4, 4]"));
    // The picture is the one that no flags give.
    prints(here, &["render", data.to_str().unwrap(), "-o", "again.png"]);
    assert!(std::fs::read(picture).unwrap() == std::fs::read(here.join("again.png")).unwrap());
}

#[test]
fn info_describes() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    let object = json(&prints(directory.path(), &["info", path, "--json"]));
    let keys: Vec<_> = object.as_object().unwrap().keys().cloned().collect();
    assert_eq!(keys, ["bounds", "derived", "fields", "format", "levels", "padded_bytes", "time", "warnings"]);
    assert_eq!(object["format"], "Chombo HDF5");
    assert_eq!(object["levels"][0]["ratio"], json("[1, 1, 1]"));
    assert_eq!(object["levels"][1]["ratio"], json("[2, 2, 2]"));
    assert_eq!(object["levels"][0]["domain"], json("[[0, 0, 0], [15, 15, 15]]"));
    let [coarse, fine] = [0, 1].map(|level| object["levels"][level]["leaf_cells"].as_u64().unwrap());
    assert_eq!(8 * coarse + fine, 32 * 32 * 32, "leaf cells fill the domain");
    assert!(coarse > 0 && fine > 0, "both levels are seen: {coarse}, {fine}");
    let low = object["fields"][0]["min"].as_f64().unwrap();
    assert!(low < object["fields"][0]["max"].as_f64().unwrap());
    let text = prints(directory.path(), &["info", path]);
    assert!(text.starts_with("Chombo HDF5") && text.contains("mapped"), "{text}");
    let coarse_only = json(&prints(directory.path(), &["info", path, "--max-level", "0", "--json"]));
    assert_eq!(coarse_only["levels"].as_array().unwrap().len(), 1);
    assert_eq!(coarse_only["levels"][0]["leaf_cells"], 16 * 16 * 16);
}

#[test]
fn pictures_in_three_formats_agree() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    for name in ["a.png", "a.exr", "a.npy"] {
        let said = prints(directory.path(), &["render", path, "--size", "64x48", "-o", name]);
        assert_eq!(said, format!("{name}\n"));
    }
    let (shape, film) = npy::<f32>(&directory.path().join("a.npy"));
    assert_eq!(shape, [48, 64, 4]);
    let visible = film.chunks_exact(4).filter(|pixel| pixel[3] > 0.1).count();
    assert!(visible > 200, "the first picture shows something: {visible} pixels");
    let exr = exr::prelude::read_first_rgba_layer_from_file(
        directory.path().join("a.exr"),
        |size, _| (size.width(), vec![[0f32; 4]; size.area()]),
        |(width, pixels), place, (red, green, blue, alpha): (f32, f32, f32, f32)| {
            pixels[place.y() * *width + place.x()] = [red, green, blue, alpha];
        },
    );
    let (width, pixels) = exr.unwrap().layer_data.channel_data.pixels;
    assert!(width == 64 && pixels.as_flattened() == film, "the .exr holds what the .npy holds");
    let ([width, height], bytes) = png(&directory.path().join("a.png"));
    assert_eq!([width, height], [64, 48]);
    for (pixel, rgb) in film.chunks_exact(4).zip(bytes.chunks_exact(3)) {
        for channel in 0..3 {
            let over_white = (pixel[channel] + 1.0 - pixel[3]) * 255.0;
            assert!((over_white - f32::from(rgb[channel])).abs() <= 0.51, "{pixel:?} {rgb:?}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_the_threads() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    let picture = |threads: &str| {
        let name = format!("{threads}.npy");
        prints(directory.path(), &["render", path, "--size", "80", "--threads", threads, "-o", &name]);
        std::fs::read(directory.path().join(name)).unwrap()
    };
    assert_eq!(picture("1"), picture("3"));
}

#[test]
fn render_reports_as_json() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    let said = prints(directory.path(), &["render", path, "--size", "32", "--repeat", "3", "--json", "-o", "a.png"]);
    let report = json(&said);
    assert_eq!((&report["frames"], &report["rays"]), (&3.into(), &(32 * 32).into()));
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("{key} is a number: {report}"));
    assert!(number("frame_best_seconds") <= number("frame_median_seconds"));
    assert!(number("frame_best_seconds") <= number("frame_seconds"));
    assert!(number("open_seconds") >= 0.0 && number("index_seconds") >= 0.0);
    assert!(number("samples") > f64::from(32 * 32));
    if cfg!(target_os = "linux") {
        assert!(number("private_bytes") > 0.0 && number("private_bytes") < number("resident_bytes"));
        assert!(number("resident_bytes") <= number("peak_resident_bytes"));
    }
}

#[test]
fn samples_are_values_at_points() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    let bounds = json(&prints(directory.path(), &["info", path, "--json"]))["bounds"].clone();
    let high = bounds[1][0].as_f64().unwrap();
    std::fs::write(
        directory.path().join("p.csv"),
        format!("x,y,z\n{h},{h},{h}\n{o},0,0\n", h = high / 2.0, o = 2.0 * high),
    )
    .unwrap();
    let text = prints(directory.path(), &["sample", path, "--points", "p.csv"]);
    let values: Vec<f64> = text.lines().map(|line| line.parse().unwrap()).collect();
    assert!(values[0].is_finite() && values[1].is_nan() && values.len() == 2, "{text}");
    prints(directory.path(), &["sample", path, "--points", "p.csv", "-o", "v.npy"]);
    let (shape, array) = npy::<f64>(&directory.path().join("v.npy"));
    assert_eq!((shape, array[0]), (vec![2], values[0]));
    prints(directory.path(), &["sample", path, "--points", "p.csv", "-o", "v2.NPY"]);
    assert_eq!(npy::<f64>(&directory.path().join("v2.NPY")).1[0], values[0]);
    prints(directory.path(), &["sample", path, "--points", "p.csv", "-o", "v.txt"]);
    assert_eq!(std::fs::read_to_string(directory.path().join("v.txt")).unwrap(), text);
}

#[test]
fn slices_as_pictures_and_values() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    assert_eq!(prints(directory.path(), &["slice", path, "--axis", "y", "--size", "40"]), "small_y.png\n");
    prints(directory.path(), &["slice", path, "--axis", "z", "--size", "40", "-o", "v.npy", "--method", "nearest"]);
    let (shape, values) = npy::<f64>(&directory.path().join("v.npy"));
    assert!(shape == [40, 40] && values.iter().all(|value| value.is_finite()));
    let missed = fails(directory.path(), &["slice", path, "--axis", "x", "--at", "-5"]);
    assert!(missed.starts_with(&format!("amray: {path}: --at -5 misses the domain")), "{missed}");
}

#[test]
fn a_transfer_function_file_decides_the_picture() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    let function = r#"{"extinction_points": [[-1e9, 1, 0, 0, 1e9], [1e9, 1, 0, 0, 1e9]]}"#;
    std::fs::write(directory.path().join("red.json"), function).unwrap();
    prints(directory.path(), &["render", path, "--size", "16", "--tf", "red.json", "-o", "a.npy"]);
    let (_, film) = npy::<f32>(&directory.path().join("a.npy"));
    assert_eq!(film[4 * (8 * 16 + 8)..][..4], [1.0, 0.0, 0.0, 1.0]);
    std::fs::write(directory.path().join("bad.json"), "{\"points\": [[1, 2]]}").unwrap();
    let error = fails(directory.path(), &["render", path, "--tf", "bad.json"]);
    assert!(error.starts_with("amray: bad.json: "), "{error}");
}

#[test]
fn errors_are_one_line_that_helps() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    std::fs::write(here.join("text"), "hello").unwrap();
    std::fs::write(here.join("empty"), "").unwrap();
    std::fs::create_dir(here.join("folder")).unwrap();
    let expected = "expected Chombo, Athena++, FLASH or VTK HDF5, a VTK AMR index, an AMReX plotfile, an Enzo dump or \
                    a RAMSES output";
    assert_eq!(
        fails(here, &["info", "text"]),
        format!("amray: text: a text file that starts with \"hello\", {expected}")
    );
    assert_eq!(fails(here, &["info", "empty"]), format!("amray: empty: an empty file, {expected}"));
    assert_eq!(
        fails(here, &["info", "folder"]),
        format!("amray: folder: a directory without the files of a plotfile, a dump or an output, {expected}")
    );
    assert!(fails(here, &["info", "nowhere"]).starts_with("amray: nowhere: cannot open: "));
    let field = fails(here, &["render", path, "--field", "densty"]);
    assert!(field.contains("no field \"densty\", did you mean \"density\"?"), "{field}");
    let level = fails(here, &["render", path, "--max-level", "7"]);
    assert!(level.ends_with("no level 7; the finest level is 1"), "{level}");
    let range = fails(here, &["render", path, "--log", "--range", "-1,1"]);
    assert!(range.starts_with(&format!("amray: {path}: ")), "{range}");
    let range = fails(here, &["slice", path, "--axis", "x", "--log", "--range", "-1,1"]);
    assert!(range.starts_with(&format!("amray: {path}: ")), "{range}");
    assert!(fails(here, &["render", path, "--eye", "1,1,1", "--target", "1,1,1"]).contains("camera: eye and target"));
    std::fs::write(here.join("p.csv"), "1,2\n").unwrap();
    assert!(fails(here, &["sample", path, "--points", "p.csv"]).contains("line 1"));
    let lit = fails(here, &["render", path, "--engine", "query", "--shadows"]);
    assert!(lit.starts_with("amray: --engine query draws one field that glows"), "{lit}");
}

#[test]
fn lights_and_shadows_change_the_picture() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    let picture = |flags: &[&str]| {
        prints(here, &[&["render", path, "--size", "32x32", "-o", "p.png"], flags].concat());
        std::fs::read(here.join("p.png")).unwrap()
    };
    let plain = picture(&[]);
    let pictures = [
        picture(&["--shading"]),
        picture(&["--shadows"]),
        picture(&["--shading", "--shadows", "--light", "point:0.5,0.5,0.5:1:0.2"]),
        picture(&["--ao", "4", "--ao-distance", "0.1"]),
    ];
    for (place, picture) in pictures.iter().enumerate() {
        assert!(*picture != plain && !pictures[..place].contains(picture), "{place}");
    }
}

#[test]
fn what_cannot_be_written_is_noticed_before_the_work() {
    let directory = tempfile::tempdir().unwrap();
    for arguments in [
        // There is no such data: the first to be missed is what was looked at first.
        &["render", "nowhere"][..],
        &["slice", "nowhere", "--axis", "x"],
        &["sample", "nowhere", "--points", "nothing"],
        &["demo", "--levels", "1", "--base", "8"],
    ] {
        let name = if arguments[0] == "demo" { "missing/a.hdf5" } else { "missing/a.png" };
        let error = fails(directory.path(), &[arguments, &["-o", name]].concat());
        assert!(error.starts_with(&format!("amray: {name}: cannot write: ")), "{error}");
        assert!(!error.contains(".part"), "{error}");
    }
}

#[test]
fn flags_change_the_picture_as_they_say() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let path = demo().to_str().unwrap();
    let film = |flags: &[&str]| {
        prints(here, &[&["render", path, "--size", "24", "-o", "a.npy"], flags].concat());
        npy::<f32>(&here.join("a.npy")).1
    };
    let plain = film(&[]);
    assert!(plain == film(&["--seed", "0", "--spp", "1"]), "what is not given is the default");
    for flags in [
        &["--restrict", "--method", "current"][..],
        &["--log"],
        &["--orthographic"],
        &["--spp", "2"],
        &["--seed", "1"],
        &["--unit-distance", "0.1"],
    ] {
        let changed = film(flags);
        assert!(changed.len() == plain.len() && changed != plain, "{flags:?}");
        assert!(changed.chunks_exact(4).any(|pixel| pixel[3] > 0.02), "{flags:?}");
    }
    assert_ne!(film(&["--method", "current"]), film(&["--restrict", "--method", "current"]));
    let corner = |flags: &[&str]| {
        prints(here, &[&["render", path, "--size", "160", "-o", "a.png"], flags].concat());
        let (size, bytes) = png(&here.join("a.png"));
        (size, [bytes[0], bytes[1], bytes[2]])
    };
    assert_eq!(corner(&["--background", "0,0.4,1"]), ([160, 160], [0, 102, 255]));
    let ([width, height], _) = corner(&["--color-bar"]);
    assert!(width > 160 && height == 160);
}

/// A file of views of the demo data set, in `directory`.
fn views(directory: &Path) -> PathBuf {
    let path = directory.join("views.json");
    let views = r#"{"front": {
        "field": "density", "eye": [3, 0.5, 0.5], "target": [0.5, 0.5, 0.5], "up": [0, 0, 1], "fovy": 30,
        "size": [40, 20], "tf": {"red": [[-1e9, 1, 0, 0, 1e9], [1e9, 1, 0, 0, 1e9]], "none": [[0, 1, 1, 1, 0]]}
    }, "other": {
        "field": "no such field", "eye": [3, 0.5, 0.5], "target": [0.5, 0.5, 0.5], "up": [0, 0, 1], "fovy": 30,
        "tf": {"red": [[0, 1, 0, 0, 1]]}
    }}"#;
    std::fs::write(&path, views).unwrap();
    path
}

#[test]
fn a_view_decides_the_picture() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    views(here);
    let path = demo().to_str().unwrap();
    let render = |flags: &[&str]| {
        prints(here, &[&["render", path, "-o", "a.npy", "--view"], flags].concat());
        npy::<f32>(&here.join("a.npy"))
    };
    let (shape, film) = render(&["views.json:front:red"]);
    let middle = |film: &[f32]| film[film.len() / 2 + 80..][..4].to_vec();
    assert_eq!((shape, middle(&film)), (vec![20, 40, 4], vec![1.0, 0.0, 0.0, 1.0]));
    assert!(render(&["views.json:front:none"]).1.iter().all(|channel| *channel == 0.0));
    // What is given wins.
    assert_eq!(render(&["views.json:front:red", "--size", "24x12"]).0, [12, 24, 4]);
    assert_ne!(render(&["views.json:front:red", "--eye", "0.5,3,0.7"]).1, film);
    assert_ne!(render(&["views.json:front:red", "--tf", "viridis"]).1, film);
    assert!(render(&["views.json:other:red", "--field", "density"]).1.iter().any(|channel| *channel > 0.0));
    let error = |view: &str| fails(here, &["render", path, "--view", view]);
    assert_eq!(error("none.json:a:b").split(": ").nth(1), Some("none.json"));
    let expected = "amray: views.json: no view is named \"back\"; there are front, other";
    assert_eq!(error("views.json:back:red"), expected);
    assert!(error("views.json:other:red").contains("no such field"));
    assert!(misused(here, &["render", path, "--view", "views.json"]).contains("expected FILE:NAME:TF"));
}

#[test]
fn bench_measures_both_engines() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    views(here);
    let path = demo().to_str().unwrap();
    let quick = ["bench", path, "--size", "32x32", "--repeat", "1"];
    let flags = ["--method", "current,basis", "--thread-counts", "1,2,1", "--json"];
    let report = json(&prints(here, &[&quick[..], &flags].concat()));
    let keys = |value: &serde_json::Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(&report), ["data", "index", "machine", "repeat", "rows", "size"]);
    assert_eq!(keys(&report["index"]), ["bytes", "regions", "seconds"]);
    let rows = report["rows"].as_array().unwrap();
    let place = |row: &serde_json::Value| {
        let text = |key: &str| row[key].as_str().unwrap().to_owned();
        (
            text("transfer_function"),
            text("method"),
            row["max_level"].as_u64().unwrap(),
            row["threads"].as_u64().unwrap(),
        )
    };
    let mut expected = Vec::new();
    for function in ["opaque", "translucent", "sparse"] {
        for method in ["current", "basis"] {
            for (level, threads) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
                expected.push((function.to_owned(), method.to_owned(), level, threads));
            }
        }
    }
    assert_eq!(rows.iter().map(place).collect::<Vec<_>>(), expected);
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} is a number: {row}"));
        for key in ["march_fps", "query_fps", "ratio", "ratio_same_samples", "march_msamples_per_s", "samples_per_ray"]
        {
            assert!(number(key) > 0.0, "{key}: {row}");
        }
        for key in ["interior_share", "skipped_share"] {
            assert!((0.0..=1.0).contains(&number(key)), "{key}: {row}");
        }
        // These are pictures of 8x8 pixels: similar to their reference, whatever quality that is.
        assert!(number("march_psnr") > 20.0 && number("query_psnr") > 20.0, "{row}");
        assert!((number("ratio") - number("march_fps") / number("query_fps")).abs() < 1e-9 * number("ratio"));
    }
    let flags = ["--view", "views.json:front:red", "--max-level", "1", "--method", "current", "--thread-counts", "1"];
    let text = prints(here, &[&quick[..], &flags].concat());
    assert!(text.contains("front:red: frames per second at 32x32") && text.contains(" 0..1"), "{text}");
    assert!(!text.contains("translucent") && !text.contains("0..0"), "{text}");
}

#[test]
fn bench_says_what_is_wrong() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    views(here);
    let path = demo().to_str().unwrap();
    let error = fails(here, &["bench", path, "--max-level", "0,7"]);
    assert_eq!(error, format!("amray: {path}: --max-level 7: the finest level is 1"));
    let error = fails(here, &["bench", path, "--view", "views.json:front:red", "--view", "views.json:other:red"]);
    assert!(error.contains("expected views of one field"), "{error}");
    misused(here, &["bench", path, "--method", "current,cubic"]);
    misused(here, &["bench", path, "--thread-counts", "0"]);
}

#[test]
fn wrong_usage_is_exit_code_two() {
    let directory = tempfile::tempdir().unwrap();
    let path = demo().to_str().unwrap();
    for arguments in [
        &["frobnicate"][..],
        &["render"],
        &["render", path, "--size", "0"],
        &["render", path, "--fovy", "-3"],
        &["render", path, "--fovy", "180"],
        &["render", path, "--samples-per-cell", "1e17"],
        &["render", path, "--samples-per-cell", "0.001"],
        &["render", path, "-o", "a.jpg"],
        &["slice", path, "--axis", "x", "-o", "a.exr"],
        &["demo", "--levels", "13"],
        &["demo", "--base", "7"],
        &["demo", "--ratio", "3"],
        &["demo", "--brick", "12"],
        &["demo", "--threshold", "1"],
        &["render", path, "--range", "2,1"],
        &["render", path, "--method", "cubic"],
        &["render", path, "--threads", "0"],
        &["slice", path],
        &["slice", path, "--axis", "w"],
    ] {
        misused(directory.path(), arguments);
    }
    assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 0);
    let ending = misused(directory.path(), &["render", path, "-o", "a.jpg"]);
    assert!(ending.contains("ending .jpg, expected .png, .exr or .npy"), "{ending}");
    assert!(misused(directory.path(), &["render", path, "--tf", "rainbow-ish"]).contains("viridis"));
    assert!(misused(directory.path(), &["demo", "--base", "7"]).contains("expected 8 to 1024 cells per side"));
}

#[test]
fn real_files_give_pictures_without_flags() {
    let directory = tempfile::tempdir().unwrap();
    let Some(chombo) = real_data("chombo") else { return };
    let mut paths: Vec<_> = std::fs::read_dir(chombo).unwrap().map(|entry| entry.unwrap().path()).collect();
    if let Some(amrex) = real_data("amrex") {
        paths.extend(std::fs::read_dir(amrex).unwrap().map(|entry| entry.unwrap().path()));
    }
    for path in paths {
        let path = path.to_str().unwrap();
        let info = amray(directory.path(), &["info", path]);
        let said = String::from_utf8_lossy(&info.stderr);
        assert!(info.status.success() && said.is_empty(), "{path}: warnings are part of the description: {said}");
        let bounds = json(&prints(directory.path(), &["info", path, "--json"]))["bounds"].clone();
        let bound = |end: usize, axis: usize| bounds[end][axis].as_f64().unwrap();
        let [x, y, z] = [0, 1, 2].map(|axis| bound(0, axis) + 0.37 * (bound(1, axis) - bound(0, axis)));
        let outside = bound(1, 0) + 1.0;
        std::fs::write(directory.path().join("p.csv"), format!("{x},{y},{z}\n{outside},{y},{z}\n")).unwrap();
        let text = prints(directory.path(), &["sample", path, "--points", "p.csv"]);
        let values: Vec<f64> = text.lines().map(|line| line.parse().unwrap()).collect();
        assert!(values.len() == 2 && values[0].is_finite() && values[1].is_nan(), "{path}: {text}");
        prints(directory.path(), &["slice", path, "--axis", "x", "--size", "32", "-o", "slice.png"]);
        prints(directory.path(), &["render", path, "--size", "48", "-o", "a.npy"]);
        let (_, film) = npy::<f32>(&directory.path().join("a.npy"));
        let visible = film.chunks_exact(4).filter(|pixel| pixel[3] > 0.02).count();
        assert!(visible > 10, "{path}: {visible} visible pixels");
    }
}
