//! How near pictures are to what they would be with samples without end.

use amray::render::{Engine, Film, RenderOptions, render};
use amray::scene::Scene;

/// Samples per cell of the reference, none of which is spared.
const CONVERGED: f64 = 16.0;
/// By how much pictures are smaller per side than those whose time is measured: the reference takes as long as one.
const SMALLER: usize = 4;

/// The peak signal-to-noise ratio in decibels of pictures rendered in some ways, each against the converged one of the
/// same reconstruction. `None` where they are equal.
pub(super) fn psnr<const WAYS: usize>(scene: &Scene, ways: [RenderOptions; WAYS]) -> [Option<f64>; WAYS] {
    let smaller = ways.map(|way| RenderOptions { size: way.size.map(|side| side.div_ceil(SMALLER)), ..way });
    let film = |way: &RenderOptions| render(scene, way, &|_| {}).0;
    let converged =
        film(&RenderOptions { engine: Engine::Query, samples_per_cell: CONVERGED, adaptive: false, ..smaller[0] });
    smaller.map(|way| decibels(&film(&way), &converged))
}

/// Over all channels, of which 1 is the peak.
fn decibels(film: &Film, reference: &Film) -> Option<f64> {
    let [channels, wanted] = [film, reference].map(|film| film.pixels().as_flattened());
    let squares = channels.iter().zip(wanted).map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum::<f64>();
    (squares > 0.0).then(|| -10.0 * (squares / channels.len() as f64).log10())
}
