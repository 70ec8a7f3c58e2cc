//! What amray's tests are held against: random hierarchies, a brute-force evaluation of every reconstruction that shares
//! no code with the index, and damaged files.

mod brute_force;
mod case;
mod explosion;
mod fuzz;
mod nested;
mod random_mesh;
mod shell;
mod tiles;

use std::path::PathBuf;

pub use brute_force::BruteForce;
pub use case::{Case, noise};
pub use explosion::{explosion, random_packets, ray_packets};
pub use fuzz::{Reader, fuzz};
pub use nested::{nested, nested_cubes};
pub use random_mesh::{RandomMesh, Shape};
pub use shell::Shell;
pub use tiles::tiles;

/// A small, fast generator of pseudo-random numbers (splitmix64), the same on every machine.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number from 0 (inclusive) to 1 (exclusive).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// An integer from `low` to `high`, both inclusive.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        low + (self.bits() % (high - low + 1) as u64) as i64
    }

    /// `true` in `share` of the cases.
    pub fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// A point between `low` and `high`.
    pub fn point(&mut self, [low, high]: [[f64; 3]; 2]) -> [f64; 3] {
        std::array::from_fn(|axis| low[axis] + (high[axis] - low[axis]) * self.unit())
    }
}

/// A file or directory of real simulation output: `AMRAY_DATA` where it is set, else `../shared/data` beside the
/// project. `None`, with a word on standard error, where it is absent.
#[allow(clippy::print_stderr)] // A skipped test must say so.
pub fn real_data(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("AMRAY_DATA")
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")), PathBuf::from);
    let path = root.join(name);
    if !path.exists() {
        eprintln!("skipped: {} is not there (AMRAY_DATA says where to look)", path.display());
        return None;
    }
    Some(path)
}
