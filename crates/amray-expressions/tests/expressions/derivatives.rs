//! Slopes against their definition, with a look-up of every cell, and against what is known of linear fields.

use std::collections::HashMap;
use std::sync::Arc;

use crate::{center, evaluate, for_each_cell};
use amray::hierarchy::{Field, Hierarchy, IndexBox, LevelDescription};
use amray_testing::{Random, RandomMesh, Shape, nested, noise};

/// All cells, by level and index.
struct BruteForce<'a> {
    hierarchy: &'a Hierarchy,
    cells: HashMap<(usize, [i64; 3]), f64>,
}

impl<'a> BruteForce<'a> {
    fn new(hierarchy: &'a Hierarchy, field: &Field) -> Self {
        let mut cells = HashMap::new();
        for_each_cell(hierarchy, field, |level, cell, value| _ = cells.insert((level, cell), value));
        Self { hierarchy, cells }
    }

    /// The slope in a cell, as the page on derived fields defines it.
    fn slope(&self, level: usize, cell: [i64; 3], axis: usize) -> f64 {
        let value = self.cells[&(level, cell)];
        let [below, above] = [-1, 1].map(|step| self.neighbour(level, beside(cell, axis, step)));
        difference(below, value, above) / self.hierarchy.levels()[level].cell_size()[axis]
    }

    fn neighbour(&self, level: usize, cell: [i64; 3]) -> Option<f64> {
        if let Some(value) = self.cells.get(&(level, cell)) {
            return Some(*value);
        }
        let point = center(self.hierarchy, level, cell);
        let mut parent = cell;
        for coarser in (0..level).rev() {
            let ratio = self.hierarchy.levels()[coarser + 1].ratio();
            parent = std::array::from_fn(|axis| parent[axis].div_euclid(ratio[axis]));
            let Some(&value) = self.cells.get(&(coarser, parent)) else { continue };
            let middle = center(self.hierarchy, coarser, parent);
            let cell_size = self.hierarchy.levels()[coarser].cell_size();
            return Some((0..3).fold(value, |sum, axis| {
                let [below, above] =
                    [-1, 1].map(|step| self.cells.get(&(coarser, beside(parent, axis, step))).copied());
                sum + difference(below, value, above) * (point[axis] - middle[axis]) / cell_size[axis]
            }));
        }
        None
    }
}

fn beside(mut cell: [i64; 3], axis: usize, step: i64) -> [i64; 3] {
    cell[axis] += step;
    cell
}

/// The difference over one cell.
fn difference(below: Option<f64>, value: f64, above: Option<f64>) -> f64 {
    match (below, above) {
        (Some(below), Some(above)) => (above - below) / 2.0,
        (None, Some(above)) => above - value,
        (Some(below), None) => value - below,
        (None, None) => 0.0,
    }
}

#[test]
fn slopes_are_those_of_the_definition() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape::any(seed));
        let hierarchy = Arc::new(mesh.cut(&mut random));
        let fields = [Field::from_fn("f", &hierarchy, noise)];
        let reference = BruteForce::new(&hierarchy, &fields[0]);
        for (axis, text) in ["gradient_x(f)", "gradient_y(f)", "gradient_z(f)"].into_iter().enumerate() {
            for_each_cell(&hierarchy, &evaluate(text, &hierarchy, &fields), |level, cell, found| {
                let expected = reference.slope(level, cell, axis);
                let scale = 1.0 / hierarchy.levels()[level].cell_size()[axis];
                assert!(
                    (found - expected).abs() < 1e-12 * scale,
                    "{text} on level {level}, cell {cell:?} (seed {seed}): {found}, expected {expected}"
                );
            });
        }
    }
}

#[test]
fn slopes_of_linear_fields_are_exact_everywhere() {
    let mut meshes = 0;
    for seed in 0..60 {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape::default());
        let hierarchy = Arc::new(mesh.cut(&mut random));
        // Refined along every axis, no level is only one cell thick.
        if hierarchy.levels()[1..].iter().any(|level| level.ratio().contains(&1)) {
            continue;
        }
        meshes += 1;
        let matrix: [[f64; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit() * 2.0 - 1.0));
        let velocity = |row: usize| {
            let centers = hierarchy.clone();
            move |level: usize, cell: [i64; 3]| -> f64 {
                let point = center(&centers, level, cell);
                3.0 + (0..3).map(|axis| matrix[row][axis] * point[axis]).sum::<f64>()
            }
        };
        let fields: Vec<Field> = ["u", "v", "w"]
            .into_iter()
            .enumerate()
            .map(|(row, name)| Field::from_fn(name, &hierarchy, velocity(row)))
            .collect();
        let curl = [matrix[2][1] - matrix[1][2], matrix[0][2] - matrix[2][0], matrix[1][0] - matrix[0][1]];
        let length = |vector: [f64; 3]| vector.iter().map(|part| part * part).sum::<f64>().sqrt();
        for (text, expected) in [
            ("gradient_x(u)", matrix[0][0]),
            ("gradient_y(u)", matrix[0][1]),
            ("gradient_z(u)", matrix[0][2]),
            ("gradient(u)[1]", matrix[0][1]),
            ("gradient_magnitude(v)", length(matrix[1])),
            ("gradient_x(2*u - v)", 2.0 * matrix[0][0] - matrix[1][0]),
            ("divergence(u, v, w)", matrix[0][0] + matrix[1][1] + matrix[2][2]),
            ("divergence({u, v, w})", matrix[0][0] + matrix[1][1] + matrix[2][2]),
            ("vorticity_x(u, v, w)", curl[0]),
            ("vorticity_y(u, v, w)", curl[1]),
            ("vorticity_z(u, v, w)", curl[2]),
            ("curl({u, v, w})[2]", curl[2]),
            ("vorticity_magnitude(u, v, w)", length(curl)),
            ("gradient_x(gradient_y(u))", 0.0),
            ("gradient_z(x + 2*y + 3*z)", 3.0),
        ] {
            for_each_cell(&hierarchy, &evaluate(text, &hierarchy, &fields), |level, cell, found| {
                assert!(
                    (found - expected).abs() < 1e-10,
                    "{text} on level {level}, cell {cell:?}: {found}, {expected}"
                );
            });
        }
    }
    assert!(meshes > 10, "only {meshes} meshes");
}

#[test]
fn slopes_of_squares_are_exact_inside_and_one_sided_at_the_domains_faces() {
    let hierarchy = Arc::new(nested(8, 1, 4));
    for_each_cell(&hierarchy, &evaluate("gradient_x(x^2 + y)", &hierarchy, &[]), |_, cell, found| {
        let (x, width) = (center(&hierarchy, 0, cell)[0], 1.0 / 8.0);
        let expected = match cell[0] {
            0 => 2.0 * x + width,
            7 => 2.0 * x - width,
            _ => 2.0 * x,
        };
        assert!((found - expected).abs() < 1e-12, "{cell:?}: {found}, expected {expected}");
    });
}

#[test]
fn derivatives_get_better_with_smaller_cells() {
    let error = |base: i64| {
        let hierarchy = Arc::new(nested(base, 3, 8));
        let mut worst = 0f64;
        let found = evaluate("gradient_y(sin(3*x) * cos(2*y) * exp(z))", &hierarchy, &[]);
        for_each_cell(&hierarchy, &found, |level, cell, found| {
            let [x, y, z] = center(&hierarchy, level, cell);
            worst = worst.max((found + 2.0 * (3.0 * x).sin() * (2.0 * y).sin() * z.exp()).abs());
        });
        worst
    };
    let [coarse, fine] = [error(16), error(32)];
    assert!(fine < 0.6 * coarse && fine < 0.2, "{coarse}, then {fine}");
}

#[test]
fn a_layer_one_cell_thick_has_no_slope_across_it() {
    let cells = IndexBox::new([0, 0, 5], [4, 4, 6]);
    let level = LevelDescription { ratio: [1; 3], cell_size: [0.5; 3], domain: cells, bricks: vec![cells] };
    let hierarchy = Arc::new(Hierarchy::new([0.0; 3], vec![level]).unwrap());
    let fields = [Field::from_fn("f", &hierarchy, noise)];
    for_each_cell(&hierarchy, &evaluate("gradient_z(f)", &hierarchy, &fields), |_, _, found| assert_eq!(found, 0.0));
}
