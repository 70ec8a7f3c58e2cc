//! Where light goes when it is scattered: the phase function of Henyey and Greenstein (1941).

use glam::DVec3;

use super::random::Random;

/// A phase function with one parameter, the mean cosine of the angle by which light is turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct HenyeyGreenstein(pub(super) f64);

/// Where light is nearly scattered alike in all directions, cosines would come from differences of equal numbers; how
/// it matters is less than the differences that it makes.
const ISOTROPIC: f64 = 1e-6;

impl HenyeyGreenstein {
    /// How much light is turned by an angle of this cosine, over what it would be if all directions were alike.
    #[inline]
    pub(super) fn over_isotropic(self, cosine: f64) -> f64 {
        let g = self.0;
        let square = 1.0 + g * g - 2.0 * g * cosine;
        (1.0 - g * g) / (square * square.sqrt())
    }

    /// The direction, of length 1, into which light that came along `direction` goes on.
    pub(super) fn scatter(self, direction: DVec3, random: &mut Random) -> DVec3 {
        let g = self.0;
        let share = random.unit();
        let cosine = if g.abs() < ISOTROPIC {
            1.0 - 2.0 * share
        } else {
            let part = (1.0 - g * g) / (1.0 - g + 2.0 * g * share);
            ((1.0 + g * g - part * part) / (2.0 * g)).clamp(-1.0, 1.0)
        };
        let sine = (1.0 - cosine * cosine).sqrt();
        let (across, along) = (std::f64::consts::TAU * random.unit()).sin_cos();
        let [right, up] = [direction.any_orthonormal_vector(), direction.cross(direction.any_orthonormal_vector())];
        (direction * cosine + right * (sine * along) + up * (sine * across)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_light_goes_somewhere_and_the_mean_cosine_is_the_parameter() {
        for g in [-0.9, -0.3, 0.0, 1e-7, 0.5, 0.9] {
            let count = 200_000;
            let cosines = (0..count).map(|i| -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(count));
            let values = cosines.map(|cosine| (cosine, HenyeyGreenstein(g).over_isotropic(cosine) / f64::from(count)));
            let (whole, mean) =
                values.fold((0.0, 0.0), |(whole, mean), (cosine, value)| (whole + value, mean + cosine * value));
            assert!((whole - 1.0).abs() < 1e-6 && (mean - g).abs() < 1e-6, "{g}: {whole}, {mean}");
        }
    }

    #[test]
    fn directions_are_distributed_as_the_function_says() {
        let count = 100_000;
        for (place, g) in [-0.7, 0.0, 0.2, 0.85].into_iter().enumerate() {
            let mut random = Random::new(7, place as u64, 0);
            let from = DVec3::new(0.6, 0.0, -0.8);
            let mut shares = [0; 10];
            let mut sum = DVec3::ZERO;
            for _ in 0..count {
                let to = HenyeyGreenstein(g).scatter(from, &mut random);
                assert!((to.length() - 1.0).abs() < 1e-12);
                shares[((to.dot(from) + 1.0) * 5.0).clamp(0.0, 9.0) as usize] += 1;
                sum += to;
            }
            // The mean direction is the parameter times the old one.
            assert!((sum / f64::from(count) - from * g).length() < 4.0 / f64::from(count).sqrt());
            for (bin, &found) in shares.iter().enumerate() {
                let fine = (0..1000).map(|i| -1.0 + (bin as f64 + (f64::from(i) + 0.5) / 1000.0) / 5.0);
                let expected: f64 = fine.map(|cosine| HenyeyGreenstein(g).over_isotropic(cosine) / 10_000.0).sum();
                let error = 4.5 * (expected * (1.0 - expected) / f64::from(count)).sqrt();
                let found = f64::from(found) / f64::from(count);
                assert!((found - expected).abs() < error, "{g}, bin {bin}: {found} and not {expected}");
            }
        }
    }
}
