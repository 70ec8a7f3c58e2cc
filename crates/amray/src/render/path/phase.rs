//! Where light goes when it is scattered: in a medium by the phase function of Henyey and Greenstein (1941), on a surface
//! alike in all directions (Lambert).

use glam::DVec3;

use super::random::Random;

/// What scatters light.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scatterer {
    Medium(HenyeyGreenstein),
    /// With its normal, of length 1, on the side that the light comes from.
    Surface(DVec3),
}

impl Scatterer {
    /// How bright light from a direction, of length 1, makes what scatters all of it, over the light's own brightness;
    /// `direction` is where the path comes from.
    pub(super) fn brightness(self, direction: DVec3, toward_light: DVec3) -> f64 {
        match self {
            Self::Medium(phase) => phase.over_isotropic(direction.dot(toward_light)),
            Self::Surface(normal) => normal.dot(toward_light).max(0.0),
        }
    }

    /// The direction, of length 1, into which a path that came along `direction` goes on.
    pub(super) fn scatter(self, direction: DVec3, random: &mut Random) -> DVec3 {
        match self {
            Self::Medium(phase) => phase.scatter(direction, random),
            Self::Surface(normal) => {
                // A point on a sphere that touches the surface is as likely as the cosine.
                let (height, angle) = (2.0 * random.unit() - 1.0, std::f64::consts::TAU * random.unit());
                let (y, x) = angle.sin_cos();
                let radius = (1.0 - height * height).sqrt();
                let toward = normal + DVec3::new(x * radius, y * radius, height);
                // Not along the surface itself.
                if toward.length_squared() > 1e-12 { toward.normalize() } else { normal }
            }
        }
    }
}

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
    fn surfaces_scatter_by_the_cosine() {
        let normal = DVec3::new(1.0, -2.0, 0.5).normalize();
        let (surface, mut random) = (Scatterer::Surface(normal), Random::new(1, 2, 3));
        let count = 100_000;
        let cosines: Vec<f64> = (0..count).map(|_| surface.scatter(normal, &mut random).dot(normal)).collect();
        let mean = |power: i32| cosines.iter().map(|cosine| cosine.powi(power)).sum::<f64>() / f64::from(count);
        // The means of the cosine and of its square, within four standard errors.
        assert!((mean(1) - 2.0 / 3.0).abs() < 4.0 * (1.0f64 / 18.0 / 1e5).sqrt(), "{}", mean(1));
        assert!((mean(2) - 0.5).abs() < 4.0 * (1.0f64 / 12.0 / 1e5).sqrt(), "{}", mean(2));
        assert!(cosines.iter().all(|cosine| *cosine > -1e-12));
        assert_eq!(surface.brightness(normal, -normal), 0.0);
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
