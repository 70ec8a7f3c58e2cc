//! The points between which a transfer function is linear, and fewer of them where that makes no visible difference.

use super::super::PreparedTransferFunction;

/// How far colours may be off: a quarter of what an 8-bit picture can show.
const COLOR_TOLERANCE: f64 = 1.0 / 1024.0;
/// By which share extinctions may be off for each of two reasons: because they bend, and because knots are left out.
const EXTINCTION_TOLERANCE: f64 = 1e-3;
/// Extinctions end here, in optical depth of a unit distance: infinite ones have no slope.
const MOST_DEPTH: f64 = 1e6;

/// The shortest line between knots, as a share of the distance between two points of the function.
const SHORTEST: f64 = 1.0 / 16384.0;

/// Knots nearer to each other than this are one, with a step.
const NEAREST: f64 = 1e-6;

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
        // As exact as it is kept, so that integrals fit to it.
        position: if place >= high { 1.0 } else { f64::from(((place - low) / width) as f32) },
        before: limited(function, function.before(place)),
        after: limited(function, function.after(place)),
    };
    let mut knots: Vec<Knot> = Vec::with_capacity(places.len());
    for place in places {
        let mut next = knot(place);
        if let Some(last) = knots.last_mut() {
            let (from, to) = (last.position, next.position);
            let middle = |share: f64| knot(low + width * (from + (to - from) * share));
            // An opacity of 1 at one end only: its extinction rises like a logarithm, and over the last bit, from where
            // a line starts, is higher by 1 in the mean.
            let rise = 2.0 / function.unit_distance();
            match [last.after, next.before].map(|look| look[0] >= MOST_DEPTH / function.unit_distance()) {
                [true, false] => last.after[0] = middle(SHORTEST).after[0] + rise,
                [false, true] => next.before[0] = middle(1.0 - SHORTEST).before[0] + rise,
                _ => {}
            }
            let last = *last;
            bend(&mut knots, (0.0, last.after), (1.0, next.before), &middle, function.unit_distance());
        }
        knots.push(next);
    }
    apart(knots)
}

/// Joins knots that are too near to each other for a line between them.
fn apart(knots: Vec<Knot>) -> Vec<Knot> {
    let mut kept: Vec<Knot> = Vec::with_capacity(knots.len());
    for knot in knots {
        match kept.last_mut() {
            Some(last) if knot.position - last.position < NEAREST => {
                last.after = knot.after;
                if knot.position == 1.0 {
                    last.position = 1.0;
                }
            }
            _ => kept.push(knot),
        }
    }
    kept
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
    if (line - middle.after[0]).abs() <= tolerance || to - from <= SHORTEST {
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
