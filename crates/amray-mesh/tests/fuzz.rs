//! Every reader of meshes against damaged files: the corpus, and changes of it. `AMRAY_FUZZ_SECONDS=600 cargo test -p
//! amray-mesh --release --test fuzz` looks for so long at each seed.

use std::path::Path;

use amray_testing::fuzz;

#[test]
fn meshes() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    fuzz(&corpus, &|path| amray_mesh::files::open(path).map(drop).map_err(|error| error.to_string()));
}
