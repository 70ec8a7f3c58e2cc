//! Random numbers that depend on a seed, a pixel and a pass alone: on nothing that happens elsewhere in a picture.

/// A generator: SplitMix64 (Steele, Lea and Flood, *Fast Splittable Pseudorandom Number Generators*, 2014), started at
/// a place of its sequence that no other path is likely to come near.
#[derive(Clone, Debug)]
pub(super) struct Random(u64);

/// The odd number next to 2^64 over the golden ratio: a sequence of its multiples meets every number once.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl Random {
    /// Of one path.
    pub(super) fn new(seed: u64, pixel: u64, pass: u64) -> Self {
        Self([pixel, pass].into_iter().fold(mix(seed ^ STEP), |state, part| mix(state ^ mix(part.wrapping_mul(STEP)))))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        mix(self.0)
    }

    /// From 0 to 1, which is never reached.
    #[inline]
    pub(super) fn unit(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        (self.bits() >> 11) as f64 * SCALE
    }

    /// Distributed like the optical depth that light passes before it meets something: finite, 0 or more.
    #[inline]
    pub(super) fn optical_depth(&mut self) -> f64 {
        -(-self.unit()).ln_1p()
    }
}

/// Every bit of the result depends on every bit of `state`.
#[inline]
fn mix(state: u64) -> u64 {
    let state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    state ^ (state >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_paths_are_not_alike() {
        // First numbers of many paths: their mean and variance, and the correlation of neighbours along each way, within
        // four standard errors.
        let count = 20_000;
        let first = |seed, pixel, pass| Random::new(seed, pixel, pass).unit() - 0.5;
        let ways: [fn(u64) -> [u64; 3]; 3] = [|i| [i, 0, 0], |i| [0, i, 0], |i| [0, 0, i]];
        for way in ways {
            let numbers: Vec<f64> = (0..=count).map(way).map(|[seed, pixel, pass]| first(seed, pixel, pass)).collect();
            let mean = |of: &dyn Fn(usize) -> f64| (0..count as usize).map(of).sum::<f64>() / count as f64;
            let error = 4.0 / (count as f64).sqrt();
            assert!(mean(&|i| numbers[i]).abs() < error * (1f64 / 12.0).sqrt());
            assert!((mean(&|i| numbers[i] * numbers[i]) - 1.0 / 12.0).abs() < error * (1f64 / 180.0).sqrt());
            assert!(mean(&|i| numbers[i] * numbers[i + 1]).abs() < error / 12.0);
        }
    }

    #[test]
    fn optical_depths_are_exponential() {
        let mut random = Random::new(1, 2, 3);
        let count = 100_000;
        let depths: Vec<f64> = (0..count).map(|_| random.optical_depth()).collect();
        let error = 4.0 / f64::from(count).sqrt();
        assert!((depths.iter().sum::<f64>() / f64::from(count) - 1.0).abs() < error);
        let beyond_two = depths.iter().filter(|&&depth| depth > 2.0).count() as f64 / f64::from(count);
        assert!((beyond_two - (-2f64).exp()).abs() < error);
    }
}
