//! The demo's field in closed form: the remnant of a supernova.
//!
//! From outside to inside: calm ambient gas, a corrugated shock, swept-up gas with wisps, ejecta that reach into it in
//! Rayleigh-Taylor fingers and are knotted into filaments, and a thin cavity. The fronts between them are between a
//! few hundredths of the domain and nothing wide, so that every level finds less to refine than the one before; around
//! [`IMPACT`] alone they sharpen without end. Places are in the unit cube.

use super::noise::{gradient_noise, mix, vector_noise};

/// The field's components, in the order of [`at_centre`].
pub(super) const COMPONENTS: [&str; 2] = ["density", "temperature"];

const CENTRE: [f64; 3] = [0.5; 3];
/// No gas beyond this distance from the centre has felt the shock.
const CALM_RADIUS: f64 = 0.48;
/// A place on the shock: the nearer, the sharper the fronts.
pub(super) const IMPACT: [f64; 3] = [0.740_22, 0.288_97, 0.794_10];
/// A front's width per distance from [`IMPACT`].
const SHARPENING: f64 = 0.03;
/// Within this distance from it even worn fronts sharpen.
const IMPACT_RADIUS: f64 = 0.2;
/// The width of the widest fronts.
const WIDEST: f64 = 0.06;
const AMBIENT_PRESSURE: f64 = 0.1;

/// The components at the centre of a cell of a level with `side` cells per side.
pub(super) fn at_centre(cell: [i64; 3], side: i64) -> [f64; 2] {
    sample(cell.map(|index| (index as f64 + 0.5) / side as f64))
}

/// Density and temperature at a place.
fn sample(place: [f64; 3]) -> [f64; 2] {
    let from_centre = [0, 1, 2].map(|axis| place[axis] - CENTRE[axis]);
    let radius = length(from_centre);
    if radius > CALM_RADIUS {
        return state(ambient(place), AMBIENT_PRESSURE);
    }
    let direction = scaled(from_centre, 1.0 / radius.max(f64::MIN_POSITIVE));
    let shock_radius = 0.43 + 0.035 * noise(direction, 1.6, 3.0) + 0.010 * noise(direction, 5.0, 7.0);
    let depth = shock_radius - radius;
    let width = front_width(place, direction);
    let shocked = front(depth, width);
    if shocked == 0.0 {
        return state(ambient(place), AMBIENT_PRESSURE);
    }
    // The gas has been carried along: its structures are found where they came from.
    let stirred = smoothstep(12.0 * depth);
    let source = stir(from_centre, stirred);
    let swept = cube(length(source) / shock_radius);
    let density = remnant(source, swept, stirred, width);
    let pressure = 0.5 + 0.5 * swept;
    if shocked == 1.0 {
        return state(density, pressure);
    }
    state(mix(ambient(place), density, shocked), mix(AMBIENT_PRESSURE, pressure, shocked))
}

fn state(density: f64, pressure: f64) -> [f64; 2] {
    [density, pressure / density]
}

fn ambient(place: [f64; 3]) -> f64 {
    0.13 + 0.05 * noise(place, 2.3, 11.0) + 0.06 * place[2]
}

/// Some parts of a front are sharp, some worn: the root of the width is spread evenly, but for [`IMPACT`]'s part.
fn front_width(place: [f64; 3], direction: [f64; 3]) -> f64 {
    let wear = (0.5 + noise(direction, 3.1, 23.0)).clamp(0.0, 1.0);
    let distance = length([0, 1, 2].map(|axis| place[axis] - IMPACT[axis]));
    (WIDEST * square(wear) * (distance / IMPACT_RADIUS).min(1.0)).max(SHARPENING * distance)
}

/// Moves a place by three octaves of turbulence.
fn stir(place: [f64; 3], strength: f64) -> [f64; 3] {
    let mut stirred = place;
    for (octave, frequency) in [5.0, 10.2, 20.6].into_iter().enumerate() {
        let eddy = vector_noise(lattice(stirred, frequency, 5.0 + 9.0 * octave as f64));
        let reach = 0.2 * strength / frequency;
        stirred = [0, 1, 2].map(|axis| stirred[axis] + reach * eddy[axis]);
    }
    stirred
}

/// The density behind the shock.
fn remnant(place: [f64; 3], swept: f64, stirred: f64, width: f64) -> f64 {
    let radius = length(place);
    let direction = scaled(place, 1.0 / radius.max(f64::MIN_POSITIVE));
    let cavity_radius = 0.20 + 0.05 * noise(direction, 2.7, 31.0);
    let hollow = front(cavity_radius - radius, width);
    if hollow == 1.0 {
        return cavity(place);
    }
    let lobes = noise(direction, 1.9, 37.0);
    let fingers = ridge(noise(direction, 5.3, 1.0));
    let tips = ridge(noise(direction, 11.7, 2.0));
    let contact_radius = 0.26 + 0.07 * lobes + 0.065 * fingers + 0.030 * tips * (0.4 + fingers.abs());
    let inside = front(contact_radius - radius, width);
    let outer = if inside < 1.0 { swept_gas(place, swept, stirred) } else { 0.0 };
    let inner = if inside > 0.0 { ejecta(place, direction) } else { 0.0 };
    let density = mix(outer, inner, inside);
    if hollow == 0.0 { density } else { mix(density, cavity(place), hollow) }
}

/// Densest at the shock.
fn swept_gas(place: [f64; 3], swept: f64, stirred: f64) -> f64 {
    let wisps = square(square(crest(place, 13.0, 41.0)));
    0.20 + 0.9 * swept + 0.35 * stirred * wisps
}

fn ejecta(place: [f64; 3], direction: [f64; 3]) -> f64 {
    let web = crest(place, 9.0, 51.0);
    let knots = crest(place, 17.0, 57.0);
    let patches = (0.5 + noise(direction, 2.1, 71.0)).max(0.0);
    0.65 + 2.5 * patches * square(square(web)) + 0.5 * square(knots) * (0.3 + web)
}

fn cavity(place: [f64; 3]) -> f64 {
    0.12 + 0.9 * square(cube(crest(place, 9.0, 61.0)))
}

/// 0 well outside a front, 1 well inside it; `depth` is the distance inward.
fn front(depth: f64, width: f64) -> f64 {
    smoothstep(depth / width)
}

fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// 1 on a web of creases, falling to 0 away from them.
fn crest(place: [f64; 3], frequency: f64, offset: f64) -> f64 {
    ridge(noise(place, frequency, offset)).max(0.0)
}

fn ridge(noise: f64) -> f64 {
    1.0 - (2.0 * noise).abs()
}

fn noise(place: [f64; 3], frequency: f64, offset: f64) -> f64 {
    gradient_noise(lattice(place, frequency, offset))
}

/// Different offsets give independent noises.
fn lattice(place: [f64; 3], frequency: f64, offset: f64) -> [f64; 3] {
    [frequency * place[0] + offset, frequency * place[1] + 0.7 * offset, frequency * place[2] - 0.4 * offset]
}

/// `f64::powi` may round differently from machine to machine.
fn square(x: f64) -> f64 {
    x * x
}

fn cube(x: f64) -> f64 {
    x * x * x
}

fn length(vector: [f64; 3]) -> f64 {
    (vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]).sqrt()
}

fn scaled(vector: [f64; 3], factor: f64) -> [f64; 3] {
    vector.map(|component| component * factor)
}
