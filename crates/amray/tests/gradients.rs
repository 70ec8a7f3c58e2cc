//! Gradients are the derivatives of the values, held on random hierarchies.

use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};
use amray::reconstruction::{Method, ValueAndGradient};
use amray_testing::{Case, Random, RandomMesh, Shape};
use proptest::prelude::*;

/// Every kink lies where a coordinate, in cells of the finest level, is a multiple of one half. A point nearer than
/// this to one is not asked: the differences would step over it.
const MARGIN: f64 = 0.01;

/// How far apart, in cells of the finest level, are the points whose values are differenced.
const STEP: f64 = 1e-3;

const LINEAR: [f64; 3] = [1.0, 2.0, 3.0];

fn linear(point: [f64; 3]) -> f64 {
    (0..3).map(|axis| LINEAR[axis] * point[axis]).sum()
}

fn finest_cell_size(case: &Case) -> [f64; 3] {
    case.hierarchy.levels()[case.hierarchy.finest_level()].cell_size()
}

/// The point in cells of the finest level, as far from kinks as the margin asks.
fn off_kinks(case: &Case, point: [f64; 3]) -> Option<[f64; 3]> {
    let cells = case.hierarchy.to_cells(case.hierarchy.finest_level(), point);
    let off = |position: f64| (2.0 * position - (2.0 * position).round()).abs() > 2.0 * MARGIN;
    cells.iter().all(|&position| off(position)).then_some(cells)
}

/// The value and the gradient at a point in cells of the finest level, the gradient per such a cell.
fn in_cells(case: &Case, method: Method, point: [f64; 3]) -> ValueAndGradient {
    let cell = case.index.domain().clamp(point.map(|position| position.floor() as i64));
    let found = case.sampler(method).sample_in_with_gradient(case.index.find_region(cell), point);
    let cell_size = finest_cell_size(case);
    ValueAndGradient { gradient: std::array::from_fn(|axis| found.gradient[axis] * cell_size[axis]), ..found }
}

/// The value some way along an axis from a point in cells of the finest level.
fn beside(case: &Case, method: Method, point: [f64; 3], axis: usize, step: f64) -> f64 {
    let mut other = point;
    other[axis] += step;
    case.sampler(method).sample(other)
}

/// Degrees between two directions.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| a[axis] * b[axis]).sum::<f64>();
    let cross: [f64; 3] = std::array::from_fn(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        a[next] * b[last] - a[last] * b[next]
    });
    dot(cross, cross).sqrt().atan2(dot(a, b)).to_degrees()
}

/// Whether there is neither a value nor a gradient.
fn is_nothing(found: ValueAndGradient) -> bool {
    found.value.is_nan() && found.gradient.iter().all(|slope| slope.is_nan())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn gradients_are_the_derivatives_of_values(seed: u64) {
        let (case, mut random) = Case::noisy(seed, Shape::any(seed));
        let mut kept = 0;
        for _ in 0..80 {
            let point = case.point(&mut random);
            let Some(cells) = off_kinks(&case, point) else { continue };
            kept += 1;
            for method in Method::ALL {
                let found = case.sampler(method).sample_world_with_gradient(point);
                let value = case.sample(method, point);
                if value.is_nan() {
                    prop_assert!(is_nothing(found), "{method} at {point:?}: {found:?} where there is no value");
                    continue;
                }
                prop_assert_eq!(found.value, value, "{} at {:?}", method, point);
                for axis in 0..3 {
                    let at = |steps: f64| beside(&case, method, cells, axis, steps * STEP);
                    let difference = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * STEP);
                    let slope = found.gradient[axis] * finest_cell_size(&case)[axis];
                    prop_assert!(
                        (slope - difference).abs() < 1e-6,
                        "{method} at {point:?}, axis {axis}: {slope} per cell, differences say {difference}"
                    );
                }
            }
        }
        prop_assert!(kept > 40, "{kept} of 80 points");
    }

    #[test]
    fn at_kinks_slopes_are_those_of_the_high_side(seed: u64) {
        let shape = Shape::any(seed);
        let (case, mut random) = Case::noisy(seed, shape);
        let domain = case.index.domain();
        for _ in 0..60 {
            let mut point = case.hierarchy.to_cells(case.hierarchy.finest_level(), case.point(&mut random));
            let at_kinks: [bool; 3] = std::array::from_fn(|_| random.chance(0.7));
            for axis in (0..3).filter(|&axis| at_kinks[axis]) {
                point[axis] = (2.0 * point[axis]).round() / 2.0;
            }
            for method in Method::ALL {
                let found = in_cells(&case, method, point);
                let value = case.sampler(method).sample(point);
                if value.is_nan() {
                    prop_assert!(is_nothing(found), "{method} at {point:?}: {found:?} where there is no value");
                    continue;
                }
                prop_assert_eq!(found.value, value, "{} at {:?}", method, point);
                // Fine cells over holes make values jump.
                if shape.holes && shape.improper_nesting {
                    continue;
                }
                for axis in (0..3).filter(|&axis| at_kinks[axis]) {
                    let step = if point[axis] == domain.high[axis] as f64 { -STEP } else { STEP };
                    let at = |steps: f64| beside(&case, method, point, axis, steps * step) - value;
                    let difference = (18.0 * at(1.0) - 9.0 * at(2.0) + 2.0 * at(3.0)) / (6.0 * step);
                    let slope = found.gradient[axis];
                    prop_assert!(
                        (slope - difference).abs() < 1e-4,
                        "{method} at {point:?}, axis {axis}: {slope} per cell, differences say {difference}"
                    );
                }
            }
        }
    }

    #[test]
    fn one_level_alone_has_the_gradient_of_a_linear_field(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape { levels: 1, ..Shape::default() });
        let case = Case::of_centers(mesh.cut(&mut random), linear);
        let domain = case.hierarchy.levels()[0].domain();
        let centers = [domain.low.map(|index| index as f64 + 0.5), domain.high.map(|index| index as f64 - 0.5)];
        for _ in 0..50 {
            let point = case.hierarchy.to_world(0, random.point(centers));
            for method in Method::ALL {
                let found = case.sampler(method).sample_world_with_gradient(point).gradient;
                let expected = if method == Method::Nearest { [0.0; 3] } else { LINEAR };
                for axis in 0..3 {
                    prop_assert!((found[axis] - expected[axis]).abs() < 1e-9, "{method} at {point:?}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn interiors_have_the_gradient_of_a_linear_field(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape { base: [6, 8], ..Shape::any(seed) });
        let case = Case::of_centers(mesh.cut(&mut random), linear);
        for region in case.index.regions() {
            let [low, high] = region.interior();
            if (0..3).any(|axis| high[axis] < low[axis]) {
                continue;
            }
            let finest = region.finest_level() == Some(case.hierarchy.finest_level());
            let point = case.hierarchy.to_world(case.hierarchy.finest_level(), random.point([low, high]));
            for method in Method::ALL {
                if method == Method::Nearest || method == Method::Finest && !finest {
                    continue;
                }
                let found = case.sampler(method).sample_world_with_gradient(point).gradient;
                for axis in 0..3 {
                    prop_assert!((found[axis] - LINEAR[axis]).abs() < 1e-9, "{method} at {point:?}: {found:?}");
                }
            }
        }
    }

    #[test]
    fn prolong_has_the_gradient_of_a_linear_field_across_levels(seed: u64) {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape { base: [10, 12], levels: 3, ..Shape::default() });
        let case = Case::of_centers(mesh.cut(&mut random), linear);
        // As far inside as cells are copied at the domain's boundary.
        let domain = case.hierarchy.levels()[0].domain();
        let margin = case.hierarchy.levels().len() as f64 + 0.5;
        let inside = [
            domain.low.map(|index| index as f64 + margin),
            domain.high.map(|index| index as f64 - margin),
        ];
        for _ in 0..100 {
            let point = case.hierarchy.to_world(0, random.point(inside));
            let found = case.sampler(Method::Prolong).sample_world_with_gradient(point).gradient;
            for axis in 0..3 {
                prop_assert!((found[axis] - LINEAR[axis]).abs() < 1e-9, "at {point:?}: {found:?}");
            }
        }
    }

    #[test]
    fn mirroring_and_permuting_the_axes_turns_gradients(seed: u64) {
        let (case, mut random) = Case::noisy(seed, Shape::any(seed));
        let mirrored = random.chance(0.5);
        let shift = random.integer(0, 2) as usize;
        let turned = case.turned(mirrored, shift);
        for _ in 0..40 {
            let point = case.point(&mut random);
            if off_kinks(&case, point).is_none() {
                continue;
            }
            let place = case.turned_point(mirrored, shift, point);
            for method in Method::ALL {
                let found = turned.sampler(method).sample_world_with_gradient(place).gradient;
                let original = case.sampler(method).sample_world_with_gradient(point).gradient;
                for axis in 0..3 {
                    let slope = original[(axis + shift) % 3];
                    let expected = if mirrored { -slope } else { slope };
                    prop_assert!(
                        (found[axis] - expected).abs() < 1e-6 || found[axis].is_nan() && expected.is_nan(),
                        "{method} at {point:?}: {original:?}, turned {found:?}"
                    );
                }
            }
        }
    }
}

/// A cube of 16^3 cells, the half with x < 8 refined by 2.
fn two_halves() -> Hierarchy {
    let coarse = LevelDescription {
        ratio: [1; 3],
        cell_size: [1.0; 3],
        domain: IndexBox::new([0; 3], [16; 3]),
        bricks: vec![IndexBox::new([0; 3], [16; 3])],
    };
    let fine = LevelDescription {
        ratio: [2; 3],
        cell_size: [0.5; 3],
        domain: IndexBox::new([0; 3], [32; 3]),
        bricks: vec![IndexBox::new([0; 3], [16, 32, 32])],
    };
    Hierarchy::new([0.0; 3], vec![coarse, fine]).unwrap()
}

/// How far the gradient of a linear field turns within one coarse cell of a 2:1 border, in degrees: an exact derivative
/// is as far off as its method is. `nearest` and `finest` are flat in places, where no direction is left.
#[test]
fn directions_at_a_border_are_as_far_off_as_documented() {
    const STEPS: i64 = 40;
    let case = Case::of_centers(two_halves(), linear);
    let grid = IndexBox::new([-STEPS, 0, 0], [STEPS, STEPS, STEPS]);
    for (method, mean, most) in [
        (Method::Current, 2.1, 48.5),
        (Method::Blend, 2.5, 41.7),
        (Method::Basis, 4.1, 15.5),
        (Method::Octant, 0.0, 0.0),
        (Method::Prolong, 0.0, 0.0),
    ] {
        let sampler = case.sampler(method);
        let (mut sum, mut farthest) = (0.0, 0.0f64);
        for place in grid.iter() {
            let point = place.map(|index| 8.0 + (index as f64 + 0.5) / STEPS as f64);
            let off = angle(sampler.sample_world_with_gradient(point).gradient, LINEAR);
            sum += off;
            farthest = farthest.max(off);
        }
        let found = [sum / grid.cells() as f64, farthest];
        let tolerance = if most == 0.0 { 1e-9 } else { 0.05 };
        let documented = (0..2).all(|i| (found[i] - [mean, most][i]).abs() <= tolerance);
        assert!(documented, "{method}: mean and most are {found:?}");
    }
}

#[test]
fn where_there_is_no_value_there_is_no_gradient() {
    let level = LevelDescription {
        ratio: [1; 3],
        cell_size: [2.0; 3],
        domain: IndexBox::new([0; 3], [8; 3]),
        bricks: vec![IndexBox::new([0; 3], [4, 8, 8])],
    };
    let hierarchy = Hierarchy::new([0.0; 3], vec![level]).unwrap();
    let case = Case::new(hierarchy, |_, cell| if cell == [2, 2, 2] { f64::NAN } else { cell[0] as f64 });
    for method in Method::ALL {
        let at = |point| case.sampler(method).sample_world_with_gradient(point);
        assert!(is_nothing(at([-0.1, 1.0, 1.0])), "{method}: outside");
        assert!(is_nothing(at([8.1, 1.0, 1.0])), "{method}: in a hole");
        assert!(is_nothing(at([4.9, 4.9, 4.9])), "{method}: a cell that is not a number takes part");
        assert!(at([0.0, 16.0, 0.0]).gradient.iter().all(|slope| slope.is_finite()), "{method}: on the boundary");
        if method != Method::Nearest {
            // At the centre of the cell before the one that is not a number.
            let ValueAndGradient { value, gradient } = at([3.0, 5.0, 5.0]);
            assert_eq!(value, 1.0, "{method}");
            assert!(gradient[0].is_nan() && gradient[1] == 0.0 && gradient[2] == 0.0, "{method}: {gradient:?}");
        }
    }
}

#[test]
fn corners_of_weight_zero_leave_the_value_alone() {
    // On the centres of the last fine cells, coarse cells that are not a number begin to count.
    let case = Case::of_centers(two_halves(), |point| if point[0] < 8.0 { linear(point) } else { f64::NAN });
    let mut random = Random(1);
    for _ in 0..100 {
        let [_, y, z] = random.point([[4.0; 3], [12.0; 3]]);
        for method in [Method::Blend, Method::Prolong] {
            let ValueAndGradient { value, gradient } = case.sampler(method).sample_world_with_gradient([7.75, y, z]);
            assert_eq!(value, case.sample(method, [7.75, y, z]), "{method} at {y}, {z}");
            assert!(gradient[0].is_nan() && (gradient[1] - LINEAR[1]).abs() < 1e-9, "{method}: {gradient:?}");
        }
    }
}

#[test]
fn a_level_that_begins_at_the_point_leaves_the_value_alone() {
    // Fine cells over holes; where x = 3, the coarse cells beyond the holes begin to count.
    let coarse = LevelDescription {
        ratio: [1; 3],
        cell_size: [2.0; 3],
        domain: IndexBox::new([0; 3], [4, 2, 1]),
        bricks: vec![IndexBox::new([2, 0, 0], [4, 2, 1])],
    };
    let fine = LevelDescription {
        ratio: [2; 3],
        cell_size: [1.0; 3],
        domain: IndexBox::new([0; 3], [8, 4, 2]),
        bricks: vec![IndexBox::new([0; 3], [4, 2, 2])],
    };
    let case = Case::of_centers(Hierarchy::new([0.0; 3], vec![coarse, fine]).unwrap(), linear);
    for method in Method::ALL {
        let value = case.sampler(method).sample_world_with_gradient([3.0, 1.8, 0.7]).value;
        assert_eq!(value, case.sample(method, [3.0, 1.8, 0.7]), "{method}");
    }
}

#[test]
fn volumes_sample_gradients_at_many_points() {
    let case = Case::of_centers(two_halves(), linear);
    let volume = Volume::new(Arc::new(case.index), case.field, Method::Prolong);
    let points = [[8.1, 7.0, 7.3], [3.0, 4.0, 5.0], [-1.0, 0.0, 0.0]];
    let [border, inside, outside] = volume.sample_with_gradients(&points)[..] else { panic!("three points") };
    for (found, point) in [(border, points[0]), (inside, points[1])] {
        assert!((found.value - linear(point)).abs() < 1e-9 && angle(found.gradient, LINEAR) < 1e-6, "{found:?}");
    }
    assert!(is_nothing(outside));
}
