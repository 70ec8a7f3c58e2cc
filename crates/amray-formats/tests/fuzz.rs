//! Every reader against damaged files: the corpus, and changes of it. `AMRAY_FUZZ_SECONDS=600 cargo test -p amray-formats
//! --release --test fuzz` looks for so long at each seed.

use std::path::Path;

use amray_formats::structured::StructuredVolume;
use amray_formats::{OpenOptions, open};
use amray_testing::fuzz;

/// A claim about compressed samples is found out slice by slice: more are not read.
const MOST_SAMPLES: u64 = 1 << 20;

fn corpus(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name)
}

#[test]
fn amr_data() {
    fuzz(&corpus("amr"), &|path| {
        let data = open(path, &OpenOptions::default()).map_err(|error| error.to_string())?;
        for field in 0..data.fields().len() {
            data.read_field(field, &|_| {}).map_err(|error| error.to_string())?;
        }
        Ok(())
    });
}

#[test]
fn structured_volumes() {
    fuzz(&corpus("volumes"), &|path| {
        let volume = StructuredVolume::open(path, None).map_err(|error| error.to_string())?;
        if volume.sample_count() < MOST_SAMPLES {
            let mut samples: Vec<f64> = Vec::new();
            let mut slices = volume.slices(0).map_err(|error| error.to_string())?;
            slices.read(volume.size()[2], &mut samples).map_err(|error| error.to_string())?;
        }
        Ok(())
    });
}
