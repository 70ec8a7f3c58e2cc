//! What tests of pictures share: volumes, looks, views, and how far two pictures differ.
#![allow(dead_code)] // Each file of tests takes what it needs.

use std::sync::Arc;

use amray::Volume;
use amray::appearance::{ColorPoint, Opacity, OpacityPoint, Scale, TransferFunction};
use amray::hierarchy::{Field, Hierarchy};
use amray::index::Index;
use amray::reconstruction::Method;
use amray::render::{Film, RenderOptions, render};
use amray::scene::{Camera, Projection, Scene, Viewpoint};

/// The methods that can be chosen, and that of node-centred fields.
pub(crate) const METHODS: [Method; 8] = [
    Method::Nearest,
    Method::Finest,
    Method::Current,
    Method::Blend,
    Method::Basis,
    Method::Octant,
    Method::Prolong,
    Method::Nodal,
];

/// The volume with `value(level, cell)` in each cell, or at each node.
pub(crate) fn volume(hierarchy: Hierarchy, method: Method, value: impl Fn(usize, [i64; 3]) -> f64) -> Volume {
    let hierarchy = Arc::new(hierarchy);
    let field = Field::centered_from_fn("value", method.centering(), &hierarchy, value);
    Volume::new(Arc::new(Index::build(hierarchy)), field, method)
}

/// The volume with the value of `function` at each cell's centre, or at each node.
pub(crate) fn of_centers(hierarchy: Hierarchy, method: Method, function: impl Fn([f64; 3]) -> f64) -> Volume {
    let centers = hierarchy.clone();
    volume(hierarchy, method, |level, cell| {
        function(centers.to_world(level, cell.map(|index| index as f64 + method.centering().place())))
    })
}

/// From orange to blue, with an extinction that is linear between points of a value and an extinction.
pub(crate) fn extinction(points: &[(f64, f64)]) -> TransferFunction {
    let colors =
        vec![ColorPoint { value: 0.0, color: [1.0, 0.2, 0.0] }, ColorPoint { value: 1.0, color: [0.0, 0.4, 1.0] }];
    let points = points.iter().map(|&(value, opacity)| OpacityPoint { value, opacity }).collect();
    TransferFunction::new(Scale::Linear, colors, Opacity::Extinction(points)).unwrap()
}

/// Onto the unit cube's upper face.
pub(crate) fn front(projection: Projection) -> Viewpoint {
    Viewpoint { eye: [0.5, 0.5, 4.0], target: [0.5; 3], up: [0.0, 1.0, 0.0], projection }
}

/// From a corner, all of the volume in view.
pub(crate) fn oblique(volume: &Volume) -> Viewpoint {
    Viewpoint::framing(volume.hierarchy().bounds(), 30.0, 1.0)
}

pub(crate) fn picture(
    volume: &Volume,
    function: TransferFunction,
    viewpoint: Viewpoint,
    options: RenderOptions,
) -> Film {
    let camera = Camera::new(viewpoint).unwrap();
    render(&Scene::new(volume, function, 0.01, camera), &options, &|_| {}).0
}

/// The root of the mean square difference of all channels; not a number where one is none.
pub(crate) fn rms(a: &Film, b: &Film) -> f64 {
    let squares: f64 = differences(a, b).map(|difference| f64::from(difference).powi(2)).sum();
    (squares / a.pixels().as_flattened().len() as f64).sqrt()
}

/// The largest difference of a channel; not a number where one is none.
pub(crate) fn largest(a: &Film, b: &Film) -> f32 {
    // Not `max`: it would pass over what is not a number.
    differences(a, b).fold(0.0, |most, next| if next > most || next.is_nan() { next } else { most })
}

fn differences<'a>(a: &'a Film, b: &'a Film) -> impl Iterator<Item = f32> + 'a {
    a.pixels().as_flattened().iter().zip(b.pixels().as_flattened()).map(|(a, b)| (a - b).abs())
}
