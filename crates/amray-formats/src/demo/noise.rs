//! Lattice noise that has the same digits on every machine: integers, and the four exact operations on f64.
//!
//! Perlin, *Improving Noise* (SIGGRAPH 2002), with gradients from a hash instead of a table.

/// Gradient noise: smooth, 0 at integer places, about -0.8 to 0.8, features of size 1. `|place|` stays below 2^31.
pub(super) fn gradient_noise(place: [f64; 3]) -> f64 {
    let Cell { corner, fraction: [x, y, z], fade } = Cell::around(place);
    let towards = |i: usize, j: usize, k: usize| {
        let gradient = corner_values(corner, [i, j, k]);
        gradient[0] * (x - i as f64) + gradient[1] * (y - j as f64) + gradient[2] * (z - k as f64)
    };
    let row = |j: usize, k: usize| mix(towards(0, j, k), towards(1, j, k), fade[0]);
    let plane = |k: usize| mix(row(0, k), row(1, k), fade[1]);
    mix(plane(0), plane(1), fade[2])
}

/// Three smooth noises at the price of one, each -1 to 1.
pub(super) fn vector_noise(place: [f64; 3]) -> [f64; 3] {
    let Cell { corner, fade, .. } = Cell::around(place);
    let values = |i: usize, j: usize, k: usize| corner_values(corner, [i, j, k]);
    let row = |j: usize, k: usize| mix_vectors(values(0, j, k), values(1, j, k), fade[0]);
    let plane = |k: usize| mix_vectors(row(0, k), row(1, k), fade[1]);
    mix_vectors(plane(0), plane(1), fade[2])
}

/// `a` where `share` is 0, `b` where it is 1.
pub(super) fn mix(a: f64, b: f64, share: f64) -> f64 {
    a + (b - a) * share
}

fn mix_vectors(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|axis| mix(a[axis], b[axis], share))
}

/// Where a place lies in the lattice.
struct Cell {
    corner: [i32; 3],
    fraction: [f64; 3],
    /// The fraction, with vanishing first and second derivatives at 0 and 1.
    fade: [f64; 3],
}

impl Cell {
    fn around(place: [f64; 3]) -> Self {
        let corner = place.map(floor);
        let fraction = std::array::from_fn(|axis| place[axis] - f64::from(corner[axis]));
        Self { corner, fraction, fade: fraction.map(|t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0)) }
    }
}

/// `f64::floor` is a call on processors of the baseline instruction set.
fn floor(value: f64) -> i32 {
    let truncated = value as i32;
    truncated - i32::from(f64::from(truncated) > value)
}

/// Three numbers from -1 to 1 for each lattice corner.
fn corner_values(corner: [i32; 3], step: [usize; 3]) -> [f64; 3] {
    const PRIMES: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];
    let scattered = |axis: usize| (corner[axis] as u32).wrapping_add(step[axis] as u32).wrapping_mul(PRIMES[axis]);
    let mut hash = scattered(0) ^ scattered(1) ^ scattered(2);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    // A product is mixed best in its high bits.
    [hash >> 2, hash >> 12, hash >> 22].map(|bits| f64::from((bits & 1023) as i32 - 512) * (1.0 / 512.0))
}
