//! The points between which a transfer function is linear, and fewer of them where that makes no visible difference.

use super::super::PreparedTransferFunction;

/// How far colours may be off: a quarter of what an 8-bit picture can show.
const COLOR_TOLERANCE: f64 = 1.0 / 1024.0;
/// By which share extinctions may be off.
const EXTINCTION_TOLERANCE: f64 = 2e-3;
/// Extinctions end here, in optical depth of a unit distance: infinite ones have no slope.
const MOST_DEPTH: f64 = 1e6;

/// Extinction, red, green and blue.
pub(super) type Look = [f64; 4];

/// A point between two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    /// 0 to 1.
    pub(super) position: f64,
    /// What the function comes to from below, and goes on from; different at a step.
    pub(super) before: Look,
    pub(super) after: Look,
}

/// The function's knots between two values (positions, on a log scale), `ends`, which become 0 and 1.
pub(super) fn of_function(function: &PreparedTransferFunction, [low, high]: [f64; 2]) -> Vec<Knot> {
    let width = high - low;
    let mut places = vec![low];
    places.extend(function.point_positions().into_iter().filter(|&place| low < place && place < high));
    places.push(high);
    let knot = |place: f64| Knot {
        position: if place >= high { 1.0 } else { (place - low) / width },
        before: limited(function, function.before(place)),
        after: limited(function, function.after(place)),
    };
    let mut knots: Vec<Knot> = Vec::with_capacity(places.len());
    for place in places {
        let next = knot(place);
        if let Some(last) = knots.last().copied() {
            let middle = |share: f64| {
                let place = low + width * (last.position + (next.position - last.position) * share);
                knot(place)
            };
            bend(&mut knots, (0.0, last.after), (1.0, next.before), &middle, function.unit_distance());
        }
        knots.push(next);
    }
    knots
}

fn limited(function: &PreparedTransferFunction, [extinction, red, green, blue]: Look) -> Look {
    [extinction.min(MOST_DEPTH / function.unit_distance()), red, green, blue]
}

/// Appends knots between two places, until a line between neighbours is close enough to the extinction.
fn bend(
    knots: &mut Vec<Knot>,
    (from, first): (f64, Look),
    (to, last): (f64, Look),
    at: &impl Fn(f64) -> Knot,
    unit_distance: f64,
) {
    let share = (from + to) / 2.0;
    let middle = at(share);
    let line = (first[0] + last[0]) / 2.0;
    // What is nearly opaque within a unit distance may be less exact.
    let tolerance = EXTINCTION_TOLERANCE * middle.after[0] * (1.0 + middle.after[0] * unit_distance);
    if (line - middle.after[0]).abs() <= tolerance || to - from < 1e-4 {
        return;
    }
    bend(knots, (from, first), (share, middle.before), at, unit_distance);
    knots.push(middle);
    bend(knots, (share, middle.after), (to, last), at, unit_distance);
}

/// Leaves out knots from which the line between those that are left differs by no more than the tolerances.
pub(super) fn simplified(knots: Vec<Knot>) -> Vec<Knot> {
    let mut kept = vec![knots[0]];
    let mut first = 0;
    while first + 1 < knots.len() {
        // The farthest knot that a line from the first one reaches; the next one always is.
        let mut last = first + 1;
        while last + 1 < knots.len() && is_line(&knots[first..=last + 1]) {
            last += 1;
        }
        kept.push(knots[last]);
        first = last;
    }
    kept
}

/// Whether the knots between the first and the last lie on the line between these.
fn is_line(knots: &[Knot]) -> bool {
    let (from, to) = (&knots[0], &knots[knots.len() - 1]);
    knots[1..knots.len() - 1].iter().all(|knot| {
        let share = (knot.position - from.position) / (to.position - from.position);
        [knot.before, knot.after].iter().all(|look| {
            look.iter().enumerate().all(|(component, value)| {
                let line = from.after[component] + (to.before[component] - from.after[component]) * share;
                let tolerance = if component == 0 { EXTINCTION_TOLERANCE * value } else { COLOR_TOLERANCE };
                (line - value).abs() <= tolerance
            })
        })
    })
}
