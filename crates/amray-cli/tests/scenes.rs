//! What flags put into a picture: surfaces, clips, outlines, cameras, paths and projections.

mod common;

use std::path::Path;

use common::{amray, demo, fails, json, misused, npy, png, prints};

/// The bytes of a small picture of the demo data with these flags.
fn picture(directory: &Path, flags: &[&str]) -> Vec<u8> {
    let data = demo().to_str().unwrap();
    let file = "picture.png";
    prints(directory, &[&["render", data, "--size", "48x32", "-o", file], flags].concat());
    png(&directory.join(file)).1
}

/// The alphas of a small picture.
fn alphas(directory: &Path, flags: &[&str]) -> Vec<f32> {
    let data = demo().to_str().unwrap();
    prints(directory, &[&["render", data, "--size", "48x32", "-o", "picture.npy"], flags].concat());
    npy::<f32>(&directory.join("picture.npy")).1.chunks_exact(4).map(|pixel| pixel[3]).collect()
}

#[test]
fn surfaces_are_drawn() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let plain = picture(directory, &[]);
    let iso = picture(directory, &["--iso", "0.5", "--hide-volume"]);
    let red = picture(directory, &["--iso", "0.5:1,0,0", "--hide-volume"]);
    assert!(plain != iso && iso != red);
    // Of white paper and what is lit of red paint, nothing is greener than red.
    assert!(red.chunks_exact(3).all(|pixel| pixel[0] >= pixel[1]) && red.iter().any(|channel| *channel < 100));
    assert_ne!(picture(directory, &["--iso", "0.5::0.5"]), picture(directory, &["--iso", "0.5"]));
    let slice = alphas(directory, &["--slice", "z", "--hide-volume"]);
    assert!(slice.contains(&1.0) && slice.contains(&0.0));
    let triangle = "solid t\nfacet normal 0 0 1\nouter loop\nvertex -9 -9 0\nvertex 9 -9 0\nvertex 0 9 0\nendloop\nendfacet\nendsolid t\n";
    std::fs::write(directory.join("t.stl"), triangle).unwrap();
    assert!(alphas(directory, &["--mesh", "t.stl:1,0,0", "--hide-volume"]).contains(&1.0));
}

#[test]
fn what_is_not_drawn_is_told() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let data = demo().to_str().unwrap();
    let render = |flags: &[&str]| amray(directory, &[&["render", data, "--size", "16", "-o", "a.png"], flags].concat());
    let output = render(&["--iso", "1e9"]);
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && warning.starts_with("amray: warning: isosurface 1000000000: "), "{warning}");
    std::fs::write(directory.join("empty.obj"), "# nothing\n").unwrap();
    let output = render(&["--mesh", "empty.obj"]);
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && warning.contains("empty.obj: there are no triangles"), "{warning}");
    let error = fails(directory, &["render", data, "--iso", "0.5:pressure"]);
    assert!(error.contains("pressure"), "{error}");
}

#[test]
fn fields_are_seen_together() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let plain = alphas(directory, &[]);
    // Another field's colours change no opacity, but the picture.
    let colored = ["--color-by", "temperature:plasma"];
    let largest = plain.iter().zip(alphas(directory, &colored)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(largest < 5e-3, "{largest}");
    assert_ne!(picture(directory, &colored), picture(directory, &["--tf", "plasma"]));
    // What is added hides more.
    let both = alphas(directory, &["--overlay", "temperature"]);
    assert!(both.iter().sum::<f32>() > plain.iter().sum::<f32>() + 1.0);
    let with_bars = picture(directory, &["--overlay", "temperature", "--color-bar"]);
    assert!(with_bars.len() > picture(directory, &["--color-bar"]).len());
    let data = demo().to_str().unwrap();
    for (flags, part) in [
        (&["--overlay", "pressure"][..], "pressure"),
        (&["--mode", "path", "--overlay", "temperature"], "--mode path is for one field"),
        (&["--engine", "query", "--color-by", "temperature"], "--engine query draws one field"),
        (
            &["--overlay", "density", "--overlay", "density", "--overlay", "density", "--color-by", "density"],
            "at most 3",
        ),
    ] {
        let error = fails(directory, &[&["render", data], flags].concat());
        assert!(error.contains(part), "{error}");
    }
    let message = misused(directory, &["render", "a", "--overlay", "density:nosuch"]);
    assert!(message.contains("nosuch"), "{message}");
}

#[test]
fn clips_cut_volumes_away() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let whole = alphas(directory, &[]);
    assert_eq!(whole, alphas(directory, &["--clip-box", "-9,-9,-9:9,9,9", "--cut-box", "8,8,8:9,9,9"]));
    assert!(alphas(directory, &["--cut-box", "-9,-9,-9:9,9,9"]).iter().all(|alpha| *alpha == 0.0));
    let sum = |flags: &[&str]| alphas(directory, flags).iter().sum::<f32>();
    let [low, high] = [sum(&["--clip-plane", "-x"]), sum(&["--clip-plane", "x"])];
    let all: f32 = whole.iter().sum();
    assert!(low > 0.1 * all && high > 0.1 * all && low < all && high < all, "{low}, {high} of {all}");
    let message = misused(directory, &["render", "a", "--clip-box", "1,2,3"]);
    assert!(message.contains("two corners"), "{message}");
}

#[test]
fn outlines_and_axes_are_drawn() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let black = |flags: &[&str]| picture(directory, flags).chunks_exact(3).filter(|pixel| pixel[0] < 40).count();
    let [without, outlined] = [black(&["--hide-volume"]), black(&["--hide-volume", "--outline"])];
    assert!(without == 0 && outlined > 50, "{without}, {outlined}");
    let bricks = picture(directory, &["--hide-volume", "--brick-outlines"]);
    // Level 1 is blue.
    assert!(bricks.chunks_exact(3).any(|pixel| pixel[..3] == [86, 180, 233]));
    let error = fails(directory, &["render", demo().to_str().unwrap(), "--axes", "-o", "a.exr"]);
    assert!(error.contains("axes can only be drawn into a .png"), "{error}");
}

#[test]
fn cameras_see_all_around_and_with_two_eyes() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let data = demo().to_str().unwrap();
    prints(directory, &["render", data, "--size", "40x30", "--stereo", "-o", "pair.png"]);
    let ([width, height], pair) = png(&directory.join("pair.png"));
    assert_eq!([width, height], [80, 30]);
    let rows = || pair.chunks_exact(80 * 3);
    assert!(rows().any(|row| row[..120] != row[120..]));
    prints(directory, &["render", data, "--size", "40x20", "--panorama", "-o", "around.npy"]);
    assert_eq!(npy::<f32>(&directory.join("around.npy")).0, [20, 40, 4]);
    let error = fails(directory, &["render", data, "--panorama", "--stereo"]);
    assert!(error.contains("no stereo pair of a panorama"), "{error}");
    misused(directory, &["render", data, "--panorama", "--orthographic"]);
}

#[test]
fn paths_are_traced() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let data = demo().to_str().unwrap();
    let path = ["--mode", "path", "--spp", "2"];
    let film = picture(directory, &path);
    assert_eq!(film, picture(directory, &path));
    assert_ne!(film, picture(directory, &[&path[..], &["--albedo", "0.3", "--anisotropy", "-0.8"]].concat()));
    for (flags, part) in [
        (&["--mode", "path", "--engine", "query"][..], "--mode path is for one field"),
        (&["--mode", "path", "--albedo", "2"], "albedo is 2, expected a number from 0 to 1"),
        (&["--anisotropy", "0.5"], "add --mode path"),
    ] {
        let error = fails(directory, &[&["render", data, "--size", "16"], flags].concat());
        assert!(error.contains(part), "{flags:?}: {error}");
    }
}

#[test]
fn projections_are_values() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let data = demo().to_str().unwrap();
    let project = |reduction: &str| {
        let flags = ["project", data, "--size", "24x16", "--reduction", reduction, "-o", "values.npy", "--json"];
        let report = json(&prints(directory, &flags));
        let (shape, values) = npy::<f64>(&directory.join("values.npy"));
        assert_eq!((shape, &report["size"]), (vec![16, 24], &serde_json::json!([24, 16])));
        let finite = values.iter().copied().filter(|value| value.is_finite());
        assert_eq!(report["max"].as_f64(), finite.reduce(f64::max));
        values
    };
    let [integral, average, maximum, minimum] = ["integral", "average", "maximum", "minimum"].map(project);
    let mut seen = 0;
    for pixel in 0..integral.len() {
        // Rounding to single precision in between.
        let slack = 1e-5 * (1.0 + maximum[pixel].abs());
        if !integral[pixel].is_nan() {
            assert!(minimum[pixel] <= average[pixel] + slack && average[pixel] <= maximum[pixel] + slack);
            assert!(integral[pixel] / average[pixel] > 0.0);
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen}");
    prints(directory, &["project", data, "--size", "24x16"]);
    assert!(directory.join("small_integral.png").exists());
    let message = misused(directory, &["project", data, "--reduction", "median"]);
    assert!(message.contains("there are integral, average, maximum and minimum"), "{message}");
}

#[test]
fn scene_files_give_the_same_picture() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    std::fs::copy(demo(), directory.join("data.hdf5")).unwrap();
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(directory.join("triangle.obj"), mesh).unwrap();
    let everything = [
        &["--size", "32x24", "--iso", "0.5:1,0,0:0.5", "--slice", "1,1,0:0,0,0:0.5", "--mesh", "triangle.obj"][..],
        &["--shadows", "--ao", "2", "--cut-box", "0,0,0:1,1,1", "--clip-plane", "-z:0.9", "--outline"],
        &["--log", "--opacity", "0.7", "--spp", "2", "--seed", "3", "--method", "prolong", "--samples-per-cell", "0.8"],
    ];
    let alternatives = [
        &["--size", "16", "--mode", "path", "--spp", "2", "--albedo", "0.5", "--orthographic"][..],
        &["--size", "16", "--panorama", "--tf", "magma", "--range", "0.2,0.9"],
        &["--size", "16", "--color-by", "temperature:plasma:1,4", "--overlay", "temperature:::0.5"],
        &["--size", "16", "--stereo", "0.1", "--engine", "query", "--preintegrate", "off"],
        &["--size", "16", "--max-level", "0", "--layout", "in-place", "--every-cell", "--fovy", "20"],
    ];
    let flags = std::iter::once(everything.concat()).chain(alternatives.iter().map(|flags| flags.to_vec()));
    for flags in flags {
        let save = ["render", "data.hdf5", "-o", "a.npy", "--save-scene", "scene.json"];
        prints(directory, &[&save[..], &flags].concat());
        // From anywhere.
        let elsewhere = tempfile::tempdir().unwrap();
        let scene = directory.join("scene.json");
        prints(elsewhere.path(), &["render", "--scene", scene.to_str().unwrap(), "-o", "b.npy"]);
        let [first, again] =
            [directory.join("a.npy"), elsewhere.path().join("b.npy")].map(|path| std::fs::read(path).unwrap());
        assert!(first == again, "{flags:?}");
    }
}

#[test]
fn flags_win_over_scene_files() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let data = demo().to_str().unwrap();
    let scene = format!(r#"{{"version": 1, "data": {{"path": {data:?}}}, "picture": {{"size": [20, 10]}}}}"#);
    std::fs::write(directory.join("scene.json"), scene).unwrap();
    prints(directory, &["render", "--scene", "scene.json", "-o", "a.png"]);
    assert_eq!(png(&directory.join("a.png")).0, [20, 10]);
    prints(directory, &["render", "--scene", "scene.json", "--size", "12", "-o", "a.png"]);
    assert_eq!(png(&directory.join("a.png")).0, [12, 12]);
    // One projection replaces the other.
    let scene = format!(r#"{{"version": 1, "data": {{"path": {data:?}}}, "camera": {{"panorama": true}}}}"#);
    std::fs::write(directory.join("around.json"), scene).unwrap();
    let parallel = ["--size", "12", "--orthographic", "-o"];
    prints(directory, &[&["render", "--scene", "around.json"], &parallel[..], &["b.npy"]].concat());
    prints(directory, &[&["render", data], &parallel[..], &["c.npy"]].concat());
    let [found, expected] = ["b.npy", "c.npy"].map(|name| std::fs::read(directory.join(name)).unwrap());
    assert!(found == expected);
}

#[test]
fn wrong_scene_files_are_explained() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let error = |json: &str| {
        std::fs::write(directory.join("scene.json"), json).unwrap();
        fails(directory, &["render", "--scene", "scene.json"])
    };
    for (json, expected) in [
        (r#"{"version": 1}"#, "amray: scene.json: data.path is missing"),
        (r#"{"version": 7}"#, "amray: scene.json: version: 7 is not known"),
        (r#"{"version": 1, "camera": {"eye": "here"}}"#, "amray: scene.json: camera.eye: invalid type: string"),
        (r#"{"version": 1, "data": {"path": "nosuch.hdf5"}}"#, "amray: scene.json: data.path: there is no "),
    ] {
        let line = error(json);
        assert!(line.contains(expected), "{json}: {line}");
    }
    assert!(fails(directory, &["render", "--scene", "none.json"]).contains("none.json: cannot read the scene"));
    assert!(misused(directory, &["render"]).contains("<PATH>"));
}

#[test]
fn the_schema_is_json() {
    let schema = json(&prints(Path::new("."), &["schema"]));
    assert_eq!(schema["title"], "amray scene");
    assert!(schema["properties"]["camera"].is_object());
}
