//! What a transfer function makes of samples, apart from where they come from.

use fearless_simd::prelude::*;

use crate::appearance::{Radiance, Segments, TransferFunction, Window};
use crate::simd::{Floats, Gather, InstructionSet, Kernel, LANES, Mask};

/// Integrates light along sixteen rays at a time.
pub struct Integrator {
    segments: Segments,
    /// A packet's samples after the other's, in units of the range.
    values: Vec<[f32; LANES]>,
}

impl Integrator {
    /// For a function over the values from `low` to `high`, over `packets` of values that run through them and back.
    pub fn new(function: &TransferFunction, [low, high]: [f64; 2], packets: usize) -> Self {
        let value = |packet: usize, lane: usize| {
            let place = 0.05 * packet as f32 + 0.01 * lane as f32;
            0.5 - 0.5 * place.cos()
        };
        Self {
            segments: Segments::new(&function.prepared(1.0), low, high - low),
            values: (0..packets).map(|packet| std::array::from_fn(|lane| value(packet, lane))).collect(),
        }
    }

    /// Integrates over all samples, on this thread; what is left of the light behind them, summed over rays.
    pub fn run(&self) -> f32 {
        InstructionSet::best().run(self)
    }
}

impl Kernel for &Integrator {
    type Output = f32;

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> f32 {
        let segments = &self.segments;
        let mut light = Radiance::none(simd);
        let (all, window) = (Mask::splat(simd, true), Window::all(segments));
        let mut last = segments.place(simd, Floats::from_slice(simd, &self.values[0]), window);
        for values in &self.values {
            let place = segments.place(simd, Floats::from_slice(simd, values), window);
            let mean = segments.mean(simd, [&last, &place], &segments.slopes(simd, place.segment), all);
            light.add(simd, &mean, Floats::splat(simd, 1.0), all);
            last = place;
        }
        simd.reduce_sum_f32x16(light.transmittance)
    }
}
