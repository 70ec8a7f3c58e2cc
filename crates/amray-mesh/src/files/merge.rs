//! Vertices that are the same become one.

use std::collections::HashMap;
use std::hash::Hash;

/// The places of distinct vertices, in the order in which they came first.
#[derive(Debug)]
pub(super) struct Distinct<T> {
    places: HashMap<T, u32>,
}

impl<T: Eq + Hash> Default for Distinct<T> {
    fn default() -> Self {
        Self { places: HashMap::new() }
    }
}

impl<T: Eq + Hash> Distinct<T> {
    /// The place of a vertex, and whether it came for the first time.
    pub(super) fn place(&mut self, vertex: T) -> (u32, bool) {
        // More than fit into memory would be needed for the numbers to run out.
        let next = self.places.len() as u32;
        let place = *self.places.entry(vertex).or_insert(next);
        (place, place == next)
    }
}
