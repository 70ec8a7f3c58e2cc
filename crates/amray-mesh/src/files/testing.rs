//! What every reader must stand: files that end anywhere, with any byte changed.

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::TestRunner;

use super::error::Problem;
use crate::MeshDescription;

/// Reads damaged variants of a file. None may panic, hang or fill the memory; errors are fine.
pub(super) fn damage(file: &[u8], read: impl Fn(&[u8]) -> Result<MeshDescription, Problem>) {
    for end in 0..file.len().min(2000) {
        let _ = read(&file[..end]);
    }
    let changes = prop::collection::vec((any::<Index>(), any::<u8>()), 1..4);
    let damaged = |(end, changes): (Index, Vec<(Index, u8)>)| {
        let mut bytes = file.to_vec();
        for (place, byte) in changes {
            bytes[place.index(file.len())] = byte;
        }
        let _ = read(&bytes);
        bytes.truncate(end.index(file.len()));
        let _ = read(&bytes);
        Ok(())
    };
    TestRunner::default().run(&(any::<Index>(), changes), damaged).unwrap();
}
