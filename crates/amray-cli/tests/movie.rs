//! Movies: frames, what happens when they are stopped, and the file that ffmpeg makes of them.

mod common;

use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

use common::{demo, fails, json, misused, png, prints};

/// The small demo data, and flags of a small movie of it.
fn flags() -> Vec<&'static str> {
    vec!["movie", demo().to_str().unwrap(), "--size", "16x12"]
}

fn frame(directory: &Path, number: usize) -> Vec<u8> {
    png(&directory.join(format!("frame_{number:05}.png"))).1
}

fn changed(path: &Path) -> SystemTime {
    path.metadata().unwrap().modified().unwrap()
}

#[test]
fn a_movie_that_was_stopped_goes_on() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let movie = [&flags()[..], &["--frames", "5", "-o", "frames"]].concat();
    assert_eq!(prints(directory, &movie), "frames\n");
    let frames = directory.join("frames");
    let pictures: Vec<_> = (0..5).map(|number| frame(&frames, number)).collect();
    // Of a whole turn, no two frames are alike.
    assert!((1..5).all(|number| pictures[number] != pictures[number - 1] && pictures[number] != pictures[0]));
    assert!(!frames.join("frame_00005.png").exists());

    let kept = frames.join("frame_00001.png");
    let before = changed(&kept);
    std::fs::remove_file(frames.join("frame_00003.png")).unwrap();
    prints(directory, &movie);
    assert_eq!((changed(&kept), frame(&frames, 3) == pictures[3]), (before, true));

    let other = [&movie[..], &["--log"]].concat();
    let error = fails(directory, &other);
    assert!(error.contains("frames: there are 5 frames of another movie"), "{error}");
    assert_eq!(changed(&kept), before);
    prints(directory, &[&other[..], &["--restart"]].concat());
    assert!(frame(&frames, 1) != pictures[1]);
}

#[test]
fn time_steps_are_frames() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    std::fs::copy(demo(), directory.join("a.hdf5")).unwrap();
    let other = ["--levels", "2", "--base", "16", "--brick", "8", "--threshold", "0.5"];
    prints(directory, &[&["demo", "-o", "b.hdf5"][..], &other].concat());
    let movie = ["movie", "a.hdf5", "b.hdf5", "--size", "16x12", "-o", "steps"];
    prints(directory, &movie);
    let steps = directory.join("steps");
    let (first, second) = (frame(&steps, 0), frame(&steps, 1));
    assert!(first != second && !steps.join("frame_00002.png").exists());
    // Each step is held for two frames.
    prints(directory, &["movie", "a.hdf5", "b.hdf5", "--size", "16x12", "--frames", "4", "-o", "slow"]);
    let slow = directory.join("slow");
    assert!([0, 1].iter().all(|number| frame(&slow, *number) == first));
    assert!([2, 3].iter().all(|number| frame(&slow, *number) == second));
}

#[test]
fn cameras_go_from_key_to_key() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let keys =
        r#"[{"time": 0, "eye": [5, 0, 1], "target": [0, 0, 0]}, {"time": 3, "eye": [0, 7, 1], "target": [0, 0, 0]}]"#;
    std::fs::write(directory.join("keys.json"), keys).unwrap();
    prints(directory, &[&flags()[..], &["--frames", "3", "--keys", "keys.json", "-o", "way"]].concat());
    // The last frame is that of the last key.
    let data = demo().to_str().unwrap();
    prints(directory, &["render", data, "--size", "16x12", "--eye", "0,7,1", "--target", "0,0,0", "-o", "last.png"]);
    assert!(frame(&directory.join("way"), 2) == png(&directory.join("last.png")).1);
    std::fs::write(directory.join("keys.json"), "[{\"time\": 0}]").unwrap();
    let error = fails(directory, &[&flags()[..], &["--keys", "keys.json", "-o", "other"]].concat());
    assert!(error.contains("keys.json: [0]: missing field `eye`"), "{error}");
    misused(directory, &[&flags()[..], &["--keys", "keys.json", "--orbit", "-o", "other"]].concat());
}

#[test]
fn what_cannot_be_done_is_known_before_the_first_frame() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let error = fails(directory, &[&flags()[..], &["missing.hdf5", "-o", "steps"]].concat());
    assert!(error.starts_with("amray: missing.hdf5: cannot open"), "{error}");
    // Half-way, the eye is where it looks.
    let keys =
        r#"[{"time": 0, "eye": [5, 0, 0], "target": [0, 0, 0]}, {"time": 1, "eye": [-5, 0, 0], "target": [0, 0, 0]}]"#;
    std::fs::write(directory.join("keys.json"), keys).unwrap();
    let error = fails(directory, &[&flags()[..], &["--frames", "5", "--keys", "keys.json", "-o", "way"]].concat());
    assert!(error.starts_with("amray: frame 2: camera: eye and target"), "{error}");
    assert!(!directory.join("steps").exists() && !directory.join("way").exists());
}

#[test]
#[allow(clippy::print_stderr)] // A skipped test must say so.
fn movie_files_need_ffmpeg() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    let movie = [&flags()[..], &["--frames", "3", "-o", "a.mp4"]].concat();
    let command = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_amray"));
        command.args(&movie).current_dir(directory);
        command
    };
    let output = command().env("PATH", directory).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.starts_with("amray: a.mp4: there is no ffmpeg to make it: install it, or give a directory"),
        "{error}"
    );
    assert!(!output.status.success() && std::fs::read_dir(directory).unwrap().next().is_none());
    let error = fails(directory, &[&flags()[..], &["-o", "a.gif"]].concat());
    assert!(error.contains("a.gif: ending .gif, expected .mp4"), "{error}");
    if Command::new("ffmpeg").arg("-version").output().is_err() {
        eprintln!("skipped: there is no ffmpeg");
        return;
    }
    prints(directory, &movie);
    assert!(directory.join("a.mp4").metadata().unwrap().len() > 500);
    assert!(!directory.join("a.mp4.frames").exists());
    prints(directory, &[&movie[..], &["--keep-frames"]].concat());
    assert!(directory.join("a.mp4.frames/frame_00002.png").exists());
    // What ffmpeg would read something into: a number's place, a protocol, an option.
    for name in ["100%.mp4", "%05d.mp4", "a:b.mp4", "-a.mp4"] {
        prints(directory, &[&flags()[..], &["--frames", "1", &format!("--output={name}")]].concat());
        assert!(directory.join(name).exists(), "{name}");
        assert!(!directory.join(format!("{name}.frames")).exists(), "{name}");
    }
}

#[test]
fn patterns_name_the_steps_of_a_series() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    for name in ["s9.hdf5", "s10.hdf5"] {
        std::fs::copy(demo(), directory.join(name)).unwrap();
    }
    let other = ["--levels", "2", "--base", "16", "--brick", "8", "--threshold", "0.5"];
    prints(directory, &[&["demo", "-o", "s11.hdf5"][..], &other].concat());
    let info = json(&prints(directory, &["info", "s*.hdf5", "--json"]));
    let steps = info["steps"].as_array().unwrap();
    let found: Vec<_> = steps.iter().map(|step| (step["path"].as_str().unwrap(), step["same_mesh"] == true)).collect();
    assert_eq!(found, [("s9.hdf5", false), ("s10.hdf5", true), ("s11.hdf5", false)]);
    assert_eq!(prints(directory, &["info", "s*.hdf5"]).lines().count(), 4);

    prints(directory, &["movie", "s*.hdf5", "--size", "16x12", "--frames", "6", "-o", "pattern", "--memory", "100M"]);
    prints(directory, &["movie", "s9.hdf5", "s10.hdf5", "s11.hdf5", "--size", "16x12", "--frames", "6", "-o", "list"]);
    let frames = |name: &str| (0..6).map(|number| frame(&directory.join(name), number)).collect::<Vec<_>>();
    let (pattern, list) = (frames("pattern"), frames("list"));
    assert!(pattern == list && pattern[3] == pattern[0] && pattern[4] != pattern[3] && pattern[5] == pattern[4]);
    assert!(fails(directory, &["movie", "plt*", "-o", "none"]).contains("no data set has such a name"));
}
