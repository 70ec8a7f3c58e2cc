//! Data larger than the memory that they may take.

mod common;

use std::path::Path;

use common::{amray, json, npy, prints};

#[test]
fn a_budget_far_below_the_data_gives_the_same_picture() {
    let directory = tempfile::tempdir().unwrap();
    let directory = directory.path();
    // Two fields of 63 MB, brick by brick side by side.
    prints(directory, &["demo", "-o", "large.hdf5", "--levels", "3", "--base", "64", "--threshold", "0.4"]);
    let bytes = std::fs::metadata(directory.join("large.hdf5")).unwrap().len();
    assert!(bytes > 100 << 20, "{bytes}");
    let render = |output: &str, flags: &[&str]| {
        let common = ["render", "large.hdf5", "--size", "64", "--json", "-o", output];
        let found = amray(directory, &[&common, flags].concat());
        let errors = String::from_utf8(found.stderr).unwrap();
        assert!(found.status.success(), "{errors}");
        (json(std::str::from_utf8(&found.stdout).unwrap()), errors)
    };
    let (unrestricted, errors) = render("all.npy", &["--layout", "in-place"]);
    assert_eq!(errors, "");
    let (restricted, errors) = render("few.npy", &["--memory", "40M"]);
    assert_eq!(errors, "amray: few.npy has levels up to 0; the finer ones follow\n");
    assert_eq!(restricted["layout"], "in-place");
    let pixels = |name: &str| npy::<f32>(&directory.join(name)).1;
    assert_eq!(pixels("all.npy"), pixels("few.npy"));
    let [all, few] = [unrestricted, restricted].map(|report| report["peak_resident_bytes"].as_u64());
    // Where the system tells. Pages come before they can go, the faster the less the machine has to do otherwise.
    if let (Some(all), Some(few)) = (all, few) {
        assert!(all > bytes && few < bytes, "{few} and {all} bytes of {bytes}");
    }
}

#[test]
fn amounts_are_checked() {
    let usage = common::misused(Path::new("."), &["info", "a.hdf5", "--memory", "4 elephants"]);
    assert!(usage.contains("--memory"), "{usage}");
}
