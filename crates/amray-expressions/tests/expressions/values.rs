//! Values of expressions against the same arithmetic written in Rust, on random hierarchies.

use std::sync::Arc;

use crate::{center, evaluate, for_each_cell, program};
use amray::hierarchy::{Centering, Field, Hierarchy, VoxelType};
use amray_expressions::Definition;
use amray_testing::{Random, RandomMesh, Shape, noise};

/// What an expression may depend on in one cell.
#[derive(Debug)]
struct Cell {
    a: f64,
    b: f64,
    momentum: f64,
    position: [f64; 3],
    cell_size: [f64; 3],
    level: f64,
}

type Case = (&'static str, fn(&Cell) -> f64);

const CASES: [Case; 34] = [
    ("a", |cell| cell.a),
    ("-a + b * 2", |cell| -cell.a + cell.b * 2.0),
    ("<x-momentum>/a", |cell| cell.momentum / cell.a),
    ("a - b - <x-momentum>", |cell| cell.a - cell.b - cell.momentum),
    ("a / b / 4", |cell| cell.a / cell.b / 4.0),
    ("-a^2", |cell| -(cell.a * cell.a)),
    ("a^-b", |cell| cell.a.powf(-cell.b)),
    ("a^2^b", |cell| cell.a.powf(2f64.powf(cell.b))),
    ("a**3 - -b", |cell| cell.a * cell.a * cell.a + cell.b),
    ("sqrt(a^2 + b^2)", |cell| (cell.a * cell.a + cell.b * cell.b).sqrt()),
    ("pow(a, b)", |cell| cell.a.powf(cell.b)),
    ("(a + b) * (a - b)", |cell| (cell.a + cell.b) * (cell.a - cell.b)),
    ("log10(a) + log2(b) + ln(a) + log(b)", |cell| cell.a.log10() + cell.b.log2() + cell.a.ln() + cell.b.ln()),
    ("exp(-abs(a - b))", |cell| (-(cell.a - cell.b).abs()).exp()),
    ("min(a, b) + max(a, b, 0.5)", |cell| cell.a.min(cell.b) + cell.a.max(cell.b).max(0.5)),
    ("sin(a) + cos(b) + tan(a)", |cell| cell.a.sin() + cell.b.cos() + cell.a.tan()),
    ("asin(a) + acos(b) + atan(a)", |cell| cell.a.asin() + cell.b.acos() + cell.a.atan()),
    ("atan2(a, -b)", |cell| cell.a.atan2(-cell.b)),
    ("sinh(a) + cosh(b) + tanh(a)", |cell| cell.a.sinh() + cell.b.cosh() + cell.a.tanh()),
    ("floor(10*a) + ceil(10*b)", |cell| (10.0 * cell.a).floor() + (10.0 * cell.b).ceil()),
    ("if(a > b, a, -b)", |cell| if cell.a > cell.b { cell.a } else { -cell.b }),
    ("a < b", |cell| f64::from(cell.a < cell.b)),
    ("(a <= b) * 2 + (a != 0)", |cell| f64::from(cell.a <= cell.b) * 2.0 + 1.0),
    ("ge(a, b) + a+b<2*b", |cell| f64::from(f64::from(cell.a >= cell.b) + cell.a + cell.b < 2.0 * cell.b)),
    ("2*pi*a + e", |cell| 2.0 * std::f64::consts::PI * cell.a + std::f64::consts::E),
    ("x + 10*y + 100*z", |cell| cell.position[0] + 10.0 * cell.position[1] + 100.0 * cell.position[2]),
    ("sqrt(x^2 + y^2 + z^2) * a", |cell| {
        let [x, y, z] = cell.position;
        (x * x + y * y + z * z).sqrt() * cell.a
    }),
    ("level + cell_size", |cell| cell.level + cell.cell_size[0]),
    ("a * cell_volume", |cell| cell.a * cell.cell_size.iter().product::<f64>()),
    ("dot({a, b, 1}, {b, 2, a})", |cell| cell.a * cell.b + cell.b * 2.0 + cell.a),
    ("magnitude({a, b, 0} * 2 - {1, 1, 1} / b)", |cell| {
        let inverse = 1.0 / cell.b;
        let [x, y, z] = [cell.a * 2.0 - inverse, cell.b * 2.0 - inverse, -inverse];
        (x * x + y * y + z * z).sqrt()
    }),
    ("cross({a, b, 1}, {2, a, b})[2] + (-{a, b, 1})[0]", |cell| cell.a * cell.a - cell.b * 2.0 - cell.a),
    ("1e-1 * .5 + 2.e0*a", |cell| 0.1 * 0.5 + 2.0 * cell.a),
    ("((((a))))", |cell| cell.a),
];

fn fields(hierarchy: &Hierarchy) -> Vec<Field> {
    let shifted = |shift: i64| move |level: usize, [i, j, k]: [i64; 3]| 0.001 + noise(level, [i + shift, j, k]);
    vec![
        Field::from_fn("a", hierarchy, shifted(0)),
        Field::from_fn("b", hierarchy, shifted(100)),
        Field::from_fn("x-momentum", hierarchy, shifted(200)),
    ]
}

#[test]
fn values_are_those_of_the_same_arithmetic() {
    for seed in 0..20 {
        let mut random = Random(seed);
        let mesh = RandomMesh::new(&mut random, Shape::any(seed));
        let hierarchy = Arc::new(mesh.cut(&mut random));
        let fields = fields(&hierarchy);
        for (text, expected) in CASES {
            let found = evaluate(text, &hierarchy, &fields);
            assert_eq!(found.name(), text);
            for (place, brick) in hierarchy.bricks().enumerate() {
                for index in brick.cells.iter() {
                    let inside = std::array::from_fn(|axis| (index[axis] - brick.cells.low[axis]) as usize);
                    let [a, b, momentum] = [0, 1, 2].map(|field: usize| fields[field].value(place, inside));
                    let position = center(&hierarchy, brick.level, index);
                    let cell_size = hierarchy.levels()[brick.level].cell_size();
                    let cell = Cell { a, b, momentum, position, cell_size, level: brick.level as f64 };
                    let (found, expected) = (found.value(place, inside), expected(&cell));
                    let same = (found - expected).abs() <= 1e-14 * expected.abs().max(1.0)
                        || found.is_nan() && expected.is_nan();
                    assert!(same, "{text} in {cell:?}: {found}, expected {expected}");
                }
            }
        }
    }
}

#[test]
fn precision_is_that_of_the_fields() {
    let hierarchy = Arc::new(amray_testing::nested(8, 2, 4));
    let single = Field::from_fn("s", &hierarchy, |_, [i, ..]| i as f32 + 0.1);
    let double = Field::from_fn("d", &hierarchy, |_, [i, ..]| i as f64 + 0.1);
    let fields = [single.clone(), double];
    let voxel_type = |text: &str| evaluate(text, &hierarchy, &fields).voxel_type();
    assert_eq!(["s", "s*2", "s + x", "gradient_x(s*s)"].map(voxel_type), [VoxelType::F32; 4]);
    assert_eq!(["d", "d*s", "x", "1"].map(voxel_type), [VoxelType::F64; 4]);
    // Rounded once, at the end.
    let found = evaluate("s/3*3", &hierarchy, &fields);
    for_each_cell(&hierarchy, &found, |_, [i, ..], value| assert_eq!(value, f64::from(i as f32 + 0.1)));
}

#[test]
fn only_the_fields_that_matter_are_inputs_and_each_is_one() {
    let inputs = |text: &str| program(text, &["a", "b", "c"], &[]).unwrap().inputs().to_vec();
    assert_eq!(inputs("c + c*c"), [2]);
    assert_eq!(inputs("gradient_x(b + gradient_y(c)) * b"), [1, 2]);
    assert_eq!(inputs("{a, b, c}[1] + 0"), [1]);
    assert_eq!(inputs("x + 1"), [0usize; 0]);
    assert!(program("2*pi", &[], &[]).unwrap().is_constant());
    assert!(!program("2*x", &[], &[]).unwrap().is_constant());
    assert!(!program("gradient_x(x)", &[], &[]).unwrap().is_constant());
}

#[test]
fn fields_win_over_all_else_that_has_their_name() {
    let hierarchy = Arc::new(amray_testing::nested(8, 1, 4));
    let names = ["x", "e", "level", "linear x+10y", "x-momentum", "y-momentum", "z-momentum", "v_x", "v_y", "v_z"];
    let fields: Vec<Field> =
        (1..).zip(names).map(|(value, name)| Field::from_fn(name, &hierarchy, move |_, _| f64::from(value))).collect();
    for (text, expected) in [
        ("x*100 + e*10 + level", 123.0),
        ("<linear x+10y>", 4.0),
        ("-<linear x+10y>", -4.0),
        ("dot(momentum, {1, 10, 100})", 765.0),
        ("v[0] + v[1]*10 + v[2]*100", 1098.0),
    ] {
        assert_eq!(evaluate(text, &hierarchy, &fields).value(0, [0; 3]), expected, "{text}");
    }
}

#[test]
fn definitions_refer_to_one_another() {
    let definition = |name: &str, formula: &str| Definition { name: name.into(), formula: formula.into() };
    let definitions = [
        definition("pressure", "(gamma-1)*(<energy-density>-kinetic_energy*density)"),
        definition("gamma", "1.4"),
        definition("kinetic_energy", "dot(velocity,velocity)/2"),
        definition("velocity", "momentum/density"),
        definition("density", "1000"),
        definition("chicken", "egg + 1"),
        definition("egg", "chicken - 1"),
        definition("broken", "density +"),
        definition("lost", "broken * 2"),
    ];
    let fields = ["density", "x-momentum", "y-momentum", "z-momentum", "energy-density"];
    let bound = |text: &str| program(text, &fields, &definitions);
    let hierarchy = Arc::new(amray_testing::nested(8, 1, 8));
    let values = [2.0, 2.0, 4.0, 6.0, 20.0];
    let value = |text: &str| {
        let program = bound(text).unwrap();
        let field = |number: usize| Field::from_fn("", &hierarchy, |_, _| values[number]);
        let inputs: Vec<Field> = program.inputs().iter().map(|&number| field(number)).collect();
        program.evaluate(text, &hierarchy, &inputs, &|_| {}).unwrap().value(0, [0; 3])
    };
    assert!((value("pressure") - 0.4 * (20.0 - 7.0 * 2.0)).abs() < 1e-12);
    assert_eq!(["velocity_x", "velocity_y", "velocity[2]"].map(value), [1.0, 2.0, 3.0]);
    let message = |text: &str| bound(text).unwrap_err().to_string();
    assert_eq!(message("chicken"), "in chicken = \"egg + 1\": column 1: refers to itself");
    assert!(
        message("lost").starts_with("in broken = \"density +\": column 10: expected a number"),
        "{}",
        message("lost")
    );
    assert!(message("velocity").starts_with("column 1: a vector, expected a number"));
}

#[test]
fn chains_of_definitions_have_an_end() {
    let bound = |length: usize, formula: &dyn Fn(usize) -> String| {
        let mut definitions: Vec<Definition> =
            (0..length).map(|number| Definition { name: format!("d{number}"), formula: formula(number + 1) }).collect();
        definitions.push(Definition { name: format!("d{length}"), formula: "a".into() });
        program("d0", &["a"], &definitions).map_err(|error| error.to_string())
    };
    // Twice as many sums with each, were they not shared.
    assert!(bound(30, &|next| format!("d{next} + d{next}")).is_ok());
    assert!(bound(10_000, &|next| format!("d{next}")).unwrap_err().contains("too many others"));
    let many = |next: usize| (0..200).map(|term| format!("sin(d{next}*{term}.5)+")).collect::<String>() + "1";
    assert!(bound(6, &many).is_ok());
    assert!(bound(20, &many).unwrap_err().contains("more than 4096 operations"));
}

#[test]
fn node_centred_fields_are_evaluated_at_nodes() {
    let hierarchy = Arc::new(amray_testing::nested(4, 2, 4));
    let of =
        |centering| Field::centered_from_fn("f", centering, &hierarchy, |_, [i, j, k]| (i + 10 * j + 100 * k) as f64);
    let (cells, nodes) = (of(Centering::Cells), of(Centering::Nodes));
    let evaluated = |text: &str, fields: &[Field]| {
        program(text, &["f", "g"], &[]).unwrap().evaluate(text, &hierarchy, fields, &|_| {})
    };
    let field = evaluated("2 * f + x", std::slice::from_ref(&nodes)).unwrap();
    assert_eq!(field.centering(), Centering::Nodes);
    // The last node of the first brick, at the end of the unit cube.
    assert_eq!(field.value(0, [4, 4, 4]), 2.0 * 444.0 + 1.0);
    assert!(evaluated("f + g", &[cells, nodes.clone()]).unwrap_err().to_string().contains("one or the other"));
    assert!(evaluated("gradient_x(f)", &[nodes]).unwrap_err().to_string().contains("expected cell-centred ones"));
}
