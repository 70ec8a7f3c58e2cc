//! What files may leave out or say otherwise, and what is refused.

use std::sync::Arc;

use amray::Volume;
use amray::hierarchy::Centering;
use amray::index::Index;
use amray::reconstruction::Method;
use amray_formats::{ChomboFile, DataSet, OpenOptions, derived_fields};

use crate::sample::{Attribute, Sample, Set, value};
use crate::{failure, message, open};

/// The error for the sample after `change`.
fn refused(change: impl Fn(&mut Sample)) -> String {
    refused_up_to(None, change)
}

fn refused_up_to(max_level: Option<usize>, change: impl Fn(&mut Sample)) -> String {
    let mut sample = Sample::new(2, [0; 3]);
    change(&mut sample);
    let (_directory, path) = sample.write();
    failure(&path, &OpenOptions { max_level, ..OpenOptions::default() }).expect("the file must be refused")
}

/// The sample after `change`, opened.
fn opened(change: impl Fn(&mut Sample)) -> ChomboFile {
    let mut sample = Sample::new(2, [0; 3]);
    change(&mut sample);
    open(&sample.write().1)
}

#[test]
fn levels_go_by_number() {
    let (_directory, path) = Sample::new(12, [0; 3]).write();
    let data = open(&path);
    let widths: Vec<_> = data.hierarchy().levels().iter().map(|level| level.cell_size()[0]).collect();
    assert_eq!(widths, (0..12).map(|level| 0.5f64.powi(level)).collect::<Vec<_>>());
    assert!(data.warnings().is_empty());
}

#[test]
fn finer_levels_than_asked_for_are_not_looked_at() {
    let mut sample = Sample::new(3, [0; 3]);
    sample.sets.retain(|path, _| !path.starts_with("level_2/"));
    sample.attributes.remove("level_1/ref_ratio");
    let (_directory, path) = sample.write();
    assert_eq!(failure(&path, &OpenOptions::default()).unwrap(), "level_1: no attribute ref_ratio or vec_ref_ratio");
    let options = OpenOptions { max_level: Some(1), ..OpenOptions::default() };
    assert_eq!(ChomboFile::open(&path, &options).unwrap().hierarchy().finest_level(), 1);
    let options = OpenOptions { max_level: Some(3), ..OpenOptions::default() };
    assert_eq!(failure(&path, &options).unwrap(), "no level 3; the finest level is 2");
}

#[test]
fn time_is_at_the_root_or_at_level_0() {
    assert_eq!(opened(|_| {}).time(), None);
    assert_eq!(opened(|sample| sample.attribute("level_0/time", Attribute::Real(1.5))).time(), Some(1.5));
    let both = |sample: &mut Sample| {
        sample.attribute("level_0/time", Attribute::Real(1.5));
        sample.attribute("time", Attribute::Real(2.5));
    };
    assert_eq!(opened(both).time(), Some(2.5));
}

#[test]
fn cells_have_a_width_per_axis() {
    let data = opened(|sample| {
        sample.attributes.remove("level_0/dx");
        sample.attributes.remove("level_1/dx");
        sample.attribute("level_0/vec_dx", Attribute::RealVector([0.5, 1.0, 2.0]));
        sample.attribute("origin", Attribute::RealVector([-1.0, 0.0, 3.0]));
    });
    assert_eq!(data.hierarchy().levels()[1].cell_size(), [0.25, 0.5, 1.0]);
    assert_eq!(data.hierarchy().bounds(), [[-1.0, 0.0, 3.0], [1.0, 4.0, 11.0]]);
    assert!(data.warnings().is_empty());
}

#[test]
fn without_dx_cells_are_one_wide() {
    let data = opened(|sample| sample.attributes.retain(|path, _| !path.ends_with("/dx")));
    assert_eq!(data.hierarchy().levels()[1].cell_size(), [0.5; 3]);
    assert_eq!(data.warnings(), ["level_0 has no dx: cells are taken to be 1 wide"]);
}

#[test]
fn ratios_may_differ_per_axis() {
    let data = opened(|sample| {
        sample.attributes.remove("level_0/ref_ratio");
        sample.attributes.remove("level_1/dx");
        sample.attribute("level_0/vec_ref_ratio", Attribute::IntegerVector([2, 1, 4]));
        sample.attribute("level_1/prob_domain", Attribute::Box([0, 0, 0, 7, 3, 15]));
    });
    assert_eq!(data.hierarchy().levels()[1].ratio(), [2, 1, 4]);
    assert_eq!(data.hierarchy().levels()[1].cell_size(), [0.5, 1.0, 0.25]);
}

#[test]
fn names_are_made_up_where_there_are_none() {
    let names = |data: &ChomboFile| data.fields().iter().map(|field| field.name.clone()).collect::<Vec<_>>();
    let data = opened(|sample| sample.attributes.retain(|path, _| !path.starts_with("component_")));
    assert_eq!((names(&data), data.warnings().len()), (vec!["component_0".into(), "component_1".into()], 0));
    let data = opened(|sample| sample.attribute("component_1", Attribute::Text("two\nlines")));
    assert_eq!(names(&data), ["density", "component_1"]);
    assert_eq!(data.warnings(), ["the name of component 1 is unreadable: it is called component_1"]);
    let data = opened(|sample| sample.attribute("component_1", Attribute::Text("density")));
    assert_eq!(data.warnings(), ["several components are called density: the name stands for the first"]);
}

#[test]
fn formulas_are_derived_fields() {
    let formulas = |change: &dyn Fn(&mut Sample)| -> Vec<String> {
        derived_fields(&opened(change)).iter().map(|field| format!("{}: {}", field.name, field.formula)).collect()
    };
    // Its gamma is not known.
    assert_eq!(formulas(&|_| {}), [""; 0]);
    let found = formulas(&|sample| {
        for (name, formula) in [
            ("scalar gamma", "1.4"),
            ("vector both", "{density, <x-momentum>, gamma} * density"),
            ("scalar density", "2 * <x-momentum>"),
            ("scalar circle", "circle + 1"),
            ("scalar foreign", "time_derivative(density)"),
            ("scalar two\nlines", "density"),
            ("scalar ", "density"),
            ("tensor stress", "density"),
            ("unkind", "density"),
        ] {
            sample.attribute(&format!("Expressions/{name}"), Attribute::Text(formula));
        }
        sample.attribute("Expressions/scalar number", Attribute::Real(1.0));
    });
    let both = "({density, <x-momentum>, gamma} * density)";
    let components =
        ["x", "y", "z"].into_iter().enumerate().map(|(number, axis)| format!("both_{axis}: {both}[{number}]"));
    let expected: Vec<String> = ["pressure: (gamma-1)*<x-momentum>".into()].into_iter().chain(components).collect();
    let sorted = |mut formulas: Vec<String>| {
        formulas.sort_unstable();
        formulas
    };
    assert_eq!(sorted(found), sorted(expected));
}

#[test]
fn chombo_global_is_not_needed() {
    let data = opened(|sample| sample.attributes.retain(|path, _| !path.starts_with("Chombo_global/")));
    assert_eq!(data.hierarchy().brick_count(), 3);
}

#[test]
fn ghost_layers_default_to_none() {
    let data = opened(|sample| sample.attributes.retain(|path, _| !path.contains("data_attributes")));
    assert_eq!(data.hierarchy().brick_count(), 3);
}

#[test]
fn what_is_no_chombo_file_is_said() {
    let mut sample = Sample::new(1, [0; 3]);
    sample.attributes = [("time".to_owned(), Attribute::Real(1.0))].into();
    sample.sets = [("grid/x".to_owned(), Set::Integers(vec![1])), ("y".to_owned(), Set::Integers(vec![1]))].into();
    let (directory, path) = sample.write();
    assert_eq!(
        failure(&path, &OpenOptions::default()).unwrap(),
        "an HDF5 file that holds grid, y, expected Chombo HDF5 (a group level_0, and Chombo_global or the attributes \
         num_levels and num_components)"
    );
    let text = directory.path().join("text");
    std::fs::write(&text, "Chombo_global level_0 num_levels").unwrap();
    let error = failure(&text, &OpenOptions::default()).unwrap();
    assert!(error.starts_with("not an HDF5 file, expected Chombo HDF5"), "{error}");
    let missing = directory.path().join("missing");
    let error = ChomboFile::open(&missing, &OpenOptions::default()).err().unwrap();
    assert!(message(&missing, &error).starts_with("cannot open: "), "{error}");
}

#[test]
fn other_kinds_of_data_are_refused() {
    assert_eq!(
        refused(|sample| sample.attribute("Chombo_global/SpaceDim", Attribute::Integer(2))),
        "Chombo_global: SpaceDim is 2, expected 3: only 3-D data can be rendered"
    );
    assert_eq!(
        refused(|sample| sample.attribute("data_centering", Attribute::Integer(1))),
        "/: data_centering is 1, expected 0 (cells) or 7 (nodes)"
    );
}

#[test]
fn a_level_without_boxes_is_refused() {
    let empty = |level: usize| {
        move |sample: &mut Sample| {
            sample.set(&format!("level_{level}/boxes"), Set::Boxes(vec![]));
            sample.set(&format!("level_{level}/data:offsets=0"), Set::Integers(vec![0]));
            sample.set(&format!("level_{level}/data:datatype=0"), Set::Doubles(vec![]));
        }
    };
    assert_eq!(refused(empty(0)), "level_0/boxes: no boxes, expected at least one");
    assert_eq!(refused(empty(1)), "level_1/boxes: no boxes, expected at least one; --max-level 0 leaves the level out");
}

#[test]
fn attributes_that_make_no_sense_are_named() {
    let integer =
        |path: &'static str, value| move |sample: &mut Sample| sample.attribute(path, Attribute::Integer(value));
    let gone = |path: &'static str| move |sample: &mut Sample| sample.attributes.retain(|other, _| other != path);
    assert_eq!(refused(gone("num_levels")), "/: no attribute num_levels");
    assert_eq!(refused(integer("num_levels", 0)), "/: num_levels is 0, expected at least 1");
    assert_eq!(refused(integer("num_levels", 3)), "/: no group level_2, expected it by the attribute num_levels");
    assert_eq!(refused(gone("num_components")), "/: no attribute num_components");
    assert_eq!(refused(integer("num_components", -1)), "/: num_components is -1, expected at least 1");
    let comps = "level_0/data_attributes: comps is 2, expected 3 by num_components";
    assert_eq!(refused(integer("num_components", 3)), comps);
    assert_eq!(refused(gone("level_0/ref_ratio")), "level_0: no attribute ref_ratio or vec_ref_ratio");
    assert_eq!(refused(gone("level_1/prob_domain")), "level_1: no attribute prob_domain");
    assert_eq!(
        refused(integer("level_1/prob_domain", 3)),
        "level_1: attribute prob_domain holds integers of 4 bytes, \
         expected a compound of the integers lo_i, lo_j, lo_k, hi_i, hi_j, hi_k"
    );
    assert_eq!(
        refused(|sample| sample.attribute("level_0/dx", Attribute::Text("wide"))),
        "level_0: attribute dx holds strings, expected a number"
    );
    assert_eq!(
        refused(|sample| {
            sample.attribute("level_0/data_attributes/outputGhost", Attribute::IntegerVector([0, -1, 0]));
        }),
        "level_0/data_attributes: outputGhost is [0, -1, 0], expected no negative numbers"
    );
    assert_eq!(
        refused(integer("level_0/ref_ratio", 0)),
        "level 1: refinement ratio [0, 0, 0], expected at least 1 on every axis"
    );
}

#[test]
fn values_that_do_not_fit_the_boxes_are_refused() {
    let offsets = |values: &[i64]| {
        let values = values.to_vec();
        move |sample: &mut Sample| sample.set("level_0/data:offsets=0", Set::Integers(values.clone()))
    };
    let expected = "expected 2 components of [3, 4, 4] cells with [0, 0, 0] ghost layers between them";
    let place = "level_0/data:offsets=0";
    assert_eq!(refused(offsets(&[0, 96])), format!("{place}: 2 offsets, expected 3 (one more than boxes)"));
    assert_eq!(refused(offsets(&[0, 95, 128])), format!("{place}: level 0, brick 0: offsets 0 to 95, {expected}"));
    assert_eq!(refused(offsets(&[96, 0, 32])), format!("{place}: level 0, brick 0: offsets 96 to 0, {expected}"));
    assert_eq!(refused(offsets(&[-96, 0, 32])), format!("{place}: level 0, brick 0: offsets -96 to 0, {expected}"));
    assert_eq!(refused(offsets(&[1, 97, 129])), "level_0/data:datatype=0: 128 values, expected 129 by data:offsets=0");
    assert_eq!(
        refused(|sample| {
            sample.attribute("level_1/data_attributes/outputGhost", Attribute::IntegerVector([1, 0, 0]));
        }),
        "level_1/data:offsets=0: level 1, brick 0: offsets 0 to 128, \
         expected 2 components of [4, 4, 4] cells with [1, 0, 0] ghost layers between them"
    );
}

#[test]
fn data_sets_of_other_kinds_are_refused() {
    assert_eq!(refused(|sample| sample.sets.retain(|path, _| path != "level_1/boxes")), "level_1: no data set boxes");
    assert_eq!(
        refused(|sample| sample.set("level_1/boxes", Set::Integers(vec![0]))),
        "level_1/boxes: integers of 8 bytes, expected compounds of lo_i, lo_j, lo_k, hi_i, hi_j, hi_k"
    );
    assert_eq!(
        refused(|sample| sample.set("level_1/data:datatype=0", Set::Integers(vec![0; 128]))),
        "level_1/data:datatype=0: integers of 8 bytes, expected floats of 4 or 8 bytes"
    );
    assert_eq!(
        refused(|sample| sample.set("level_1/data:datatype=0", Set::Singles(vec![0.0; 128]))),
        "level_1/data:datatype=0: floats of 4 bytes, expected 8 bytes as on level 0"
    );
    assert_eq!(
        refused(|sample| sample.set("level_1/data:offsets=0", Set::Doubles(vec![0.0, 128.0]))),
        "level_1/data:offsets=0: floats of 8 bytes, expected integers"
    );
    assert_eq!(
        refused(|sample| sample.set("level_1/boxes", Set::Boxes(vec![[0, 0, 0, 3, 3, 40]]))),
        "level 1, brick 0: box ((0,0,0) (3,3,40)) leaves the domain ((0,0,0) (7,7,7))"
    );
}

#[test]
fn values_may_belong_to_nodes() {
    for ghosts in [[0; 3], [1, 0, 2]] {
        let (_directory, path) = Sample::nodal(2, ghosts).write();
        let data = open(&path);
        let field = data.read_field(1, &|_| {}).unwrap();
        assert_eq!(field.centering(), Centering::Nodes);
        for (place, brick) in data.hierarchy().bricks().enumerate() {
            for node in Centering::Nodes.values_of(&brick.cells).iter() {
                let inside = std::array::from_fn(|axis| (node[axis] - brick.cells.low[axis]) as usize);
                assert_eq!(field.value(place, inside), value(1, brick.level, node));
            }
        }
        // On level 1, a node of level 0 has half its index per axis.
        let volume = Volume::new(Arc::new(Index::build(data.hierarchy().clone())), field, Method::default());
        assert_eq!(volume.sample_with_gradients(&[[0.75, 0.5, 0.0]])[0].value, value(1, 1, [1, 1, 0]) + 0.5);
    }
    let cells = refused(|sample| sample.attribute("data_centering", Attribute::Integer(7)));
    assert!(cells.contains("level 0, brick 0: offsets 0 to 96"), "{cells}");
}
