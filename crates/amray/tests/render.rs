//! Pictures: what they must equal, that they converge, and that neither bricks nor threads show.

mod common;

use std::f64::consts::TAU;

use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::Method;
use amray::render::{Film, RenderOptions};
use amray::scene::{Projection, Viewpoint};
use amray_testing::{Random, nested};

use common::{METHODS, extinction, front, largest, oblique, of_centers, picture, rms};

fn smooth([x, y, z]: [f64; 3]) -> f64 {
    0.5 + 0.25 * (TAU * x).sin() * (TAU * y).cos() + 0.25 * (TAU * (z + 0.5 * x)).sin()
}

fn small(samples_per_cell: f64) -> RenderOptions {
    RenderOptions { size: [48, 48], samples_per_cell, ..RenderOptions::default() }
}

#[test]
fn a_homogeneous_cube_absorbs_exponentially_however_it_is_refined_and_sampled() {
    for levels in [1, 3] {
        let volume = of_centers(nested(8, levels, 4), Method::Basis, |_| 0.5);
        for samples_per_cell in [0.3, 1.0, 3.7] {
            let options = RenderOptions { size: [5, 5], samples_per_cell, seed: 7, ..RenderOptions::default() };
            let view = front(Projection::Orthographic { height: 1.0 });
            let film = picture(&volume, extinction(&[(0.5, 2.5)]), view, options);
            let expected = 1.0 - (-2.5f32).exp();
            for &[red, _, blue, alpha] in film.pixels() {
                assert!((alpha - expected).abs() < 1e-5, "{levels} levels, {samples_per_cell}: {alpha}");
                assert!((red - 0.5 * expected).abs() < 1e-5 && (blue - 0.5 * expected).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn opacity_is_per_unit_distance() {
    let volume = of_centers(nested(8, 2, 4), Method::Current, |_| 0.5);
    let colors = vec![ColorPoint { value: 0.0, color: [1.0; 3] }];
    let opacity = Opacity::PerUnitDistance(vec![OpacityPoint { value: 0.0, opacity: 0.02 }]);
    let function = TransferFunction::new(Scale::Linear, colors, opacity).unwrap();
    let film = picture(&volume, function, front(Projection::Orthographic { height: 1.0 }), small(1.0));
    let expected = 1.0 - 0.98f32.powi(100);
    assert!((film.pixels()[500][3] - expected).abs() < 1e-5);
}

#[test]
fn the_error_falls_with_the_samples() {
    for method in [Method::Current, Method::Blend, Method::Basis, Method::Octant, Method::Prolong] {
        let volume = of_centers(nested(8, 3, 4), method, smooth);
        let film = |samples_per_cell| {
            let function = extinction(&[(0.0, 0.0), (0.3, 0.5), (1.0, 12.0)]);
            picture(&volume, function, oblique(&volume), small(samples_per_cell))
        };
        let converged = film(32.0);
        let errors = [1.0, 2.0, 4.0, 8.0].map(|samples| rms(&film(samples), &converged));
        // Midpoints on smooth data: a quarter for twice the samples, less where the reconstruction has kinks.
        assert!(errors.windows(2).all(|pair| pair[1] < 0.6 * pair[0]), "{method}: {errors:?}");
        assert!(errors[0] < 3e-3, "{method}: {errors:?}");
    }
}

#[test]
fn levels_do_not_show_on_smooth_data() {
    // The same function on meshes that are coarse, or fine, everywhere: a border between the levels that showed would
    // be an error beyond the coarse mesh's own.
    let function = || extinction(&[(0.0, 0.0), (1.0, 6.0)]);
    let film = |mesh, method| {
        let volume = of_centers(mesh, method, smooth);
        picture(&volume, function(), oblique(&volume), small(4.0))
    };
    let fine = film(nested(64, 1, 16), Method::Basis);
    let coarse_error = largest(&film(nested(32, 1, 16), Method::Basis), &fine);
    for method in [Method::Blend, Method::Basis, Method::Prolong] {
        let error = largest(&film(nested(32, 2, 16), method), &fine);
        // But for rounding: the largest error may be the same coarse cells'.
        assert!(error <= coarse_error + 1e-6, "{method}: {error}, coarse cells alone {coarse_error}");
    }
    assert!(coarse_error < 2.0 / 255.0, "{coarse_error}");
}

#[test]
fn bricks_do_not_show() {
    let mut random = Random(1);
    for method in METHODS {
        let seed = random.bits();
        let volumes = [3, 8, 16].map(|brick| {
            // Noise: every cell differs from its neighbours.
            of_centers(nested(8, 3, brick * 2), method, |[x, y, z]| {
                Random(seed ^ x.to_bits() ^ y.to_bits().rotate_left(20) ^ z.to_bits().rotate_left(40)).unit()
            })
        });
        // Where whole regions are invisible, the intervals next to them end on their faces: that is more exact, and
        // depends on the bricks by less than a picture can show.
        for (lowest, tolerance) in [(0.5, 1e-5), (0.0, 0.1 / 255.0)] {
            let function = || extinction(&[(0.2, lowest), (1.0, 20.0)]);
            let films = volumes.each_ref().map(|volume| picture(volume, function(), oblique(volume), small(1.0)));
            assert!(films[1..].iter().all(|film| largest(film, &films[0]) < tolerance), "{method} from {lowest}");
        }
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let volume = of_centers(nested(8, 3, 4), Method::Basis, smooth);
    let options = RenderOptions { size: [70, 45], samples_per_pixel: 3, ..RenderOptions::default() };
    let films = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&volume, extinction(&[(0.0, 0.0), (1.0, 12.0)]), oblique(&volume), options))
    });
    assert_eq!(films[0], films[1]);
}

#[test]
fn cameras_inside_and_looking_away() {
    let volume = of_centers(nested(8, 2, 4), Method::Basis, |_| 0.5);
    let perspective = Projection::Perspective { fovy: 60.0 };
    let inside = Viewpoint { eye: [0.5; 3], target: [0.5, 0.5, 0.0], ..front(perspective) };
    let options = RenderOptions { size: [3, 3], ..RenderOptions::default() };
    let film = picture(&volume, extinction(&[(0.5, 2.0)]), inside, options);
    assert!((film.pixels()[4][3] - (1.0 - (-1.0f32).exp())).abs() < 1e-5, "half of the cube lies ahead");
    let away = Viewpoint { target: [0.5, 0.5, 9.0], ..front(perspective) };
    assert_eq!(picture(&volume, extinction(&[(0.5, 2.0)]), away, options), Film::new([3, 3]));
}

#[test]
fn holes_and_not_a_number_are_empty() {
    let level = LevelDescription {
        ratio: [1; 3],
        cell_size: [0.25; 3],
        domain: IndexBox::new([0; 3], [4; 3]),
        bricks: vec![IndexBox::new([0, 0, 2], [4; 3])],
    };
    let half = of_centers(Hierarchy::new([0.0; 3], vec![level]).unwrap(), Method::Basis, |_| 0.5);
    let view = front(Projection::Orthographic { height: 1.0 });
    let options = RenderOptions { size: [3, 3], ..RenderOptions::default() };
    let film = picture(&half, extinction(&[(0.5, 2.0)]), view, options);
    assert!((film.pixels()[4][3] - (1.0 - (-1.0f32).exp())).abs() < 1e-5, "only the upper half is there");
    let nothing = of_centers(nested(8, 2, 4), Method::Basis, |_| f64::NAN);
    assert_eq!(picture(&nothing, extinction(&[(0.5, 2.0)]), view, options), Film::new([3, 3]));
}
