//! Several fields of one mesh, seen together: what lies along rays is the sum of what each of them gives off.

use fearless_simd::prelude::*;

use super::super::visibility::SeenLook;
use super::medium::{Interval, Medium, Points, Single, SingleHere};
use super::steep::{Sloped, SteepPlace, between};
use crate::appearance::{Glow, Place};
use crate::layout::{RegionFrame, RegionValues};
use crate::scene::MOST_FIELDS;
use crate::simd::{Floats, Gather, Mask};

/// Fields of one mesh and method, each under its own transfer function.
#[derive(Clone, Copy)]
pub(in super::super) struct Several<'a, V> {
    /// From one to [`MOST_FIELDS`].
    pub(in super::super) fields: &'a [Single<'a, V>],
    /// Whether the last field is not seen itself, but gives the first one its colours: its extinction is 1 everywhere.
    pub(in super::super) is_colored: bool,
    /// Per level, the domain's longest side over the cell size; `None` where no gradients are asked for.
    pub(in super::super) cells: Option<&'a [[f32; 3]]>,
}

/// Places in all transfer functions. The gradient is that of the densest field.
#[derive(Clone, Copy)]
pub(in super::super) struct SeveralPlaces<S: Gather> {
    fields: [Place<S>; MOST_FIELDS],
    gradient: [Floats<S>; 3],
}

impl<'a, V> Several<'a, V> {
    /// The fields that are seen, and what gives the first one its colours.
    #[inline(always)]
    fn split(&self) -> (&'a [Single<'a, V>], Option<&'a Single<'a, V>>) {
        match self.fields.split_last() {
            Some((colors, seen)) if self.is_colored => (seen, Some(colors)),
            _ => (self.fields, None),
        }
    }
}

impl<V: RegionValues> Sloped for Several<'_, V> {
    #[inline(always)]
    fn gradient<S: Gather>(_simd: S, [from, to]: [&SeveralPlaces<S>; 2]) -> [Floats<S>; 3] {
        between([&from.gradient, &to.gradient])
    }
}

impl<V: RegionValues> Medium for Several<'_, V> {
    type Sample<S: Gather> = SeveralPlaces<S>;
    type Here<S: Gather> = [SingleHere<S>; MOST_FIELDS];

    #[inline(always)]
    fn frame(&self, region: usize) -> &RegionFrame {
        self.fields[0].frame(region)
    }

    #[inline(always)]
    fn finest_cells(&self, level: u8) -> &[f64; 3] {
        self.fields[0].finest_cells(level)
    }

    #[inline(always)]
    fn nothing<S: Gather>(&self, simd: S) -> SeveralPlaces<S> {
        SeveralPlaces { fields: [Place::nowhere(simd); MOST_FIELDS], gradient: [Floats::splat(simd, 0.0); 3] }
    }

    #[inline(always)]
    fn select<S: Gather>(&self, mask: Mask<S>, yes: SeveralPlaces<S>, no: SeveralPlaces<S>) -> SeveralPlaces<S> {
        let mut selected = no;
        for number in 0..self.fields.len() {
            selected.fields[number] = Place::select(mask, yes.fields[number], no.fields[number]);
        }
        if self.cells.is_some() {
            for axis in 0..3 {
                selected.gradient[axis] = mask.select(yes.gradient[axis], no.gradient[axis]);
            }
        }
        selected
    }

    #[inline(always)]
    fn here<S: Gather>(&self, simd: S, look: Option<&SeenLook>) -> [SingleHere<S>; MOST_FIELDS] {
        // Looks know the window of the first field alone.
        let mut here = [self.fields[0].here(simd, look); MOST_FIELDS];
        for (number, field) in self.fields.iter().enumerate().skip(1) {
            here[number] = field.here(simd, None);
        }
        here
    }

    #[inline(always)]
    fn sample<S: Gather>(
        &self,
        simd: S,
        region: usize,
        here: &[SingleHere<S>; MOST_FIELDS],
        point: [Floats<S>; 3],
        points: Points<S>,
    ) -> SeveralPlaces<S> {
        let mut sample = self.nothing(simd);
        let mut densest = Floats::splat(simd, -1.0);
        let seen = self.split().0.len();
        for (number, field) in self.fields.iter().enumerate() {
            sample.fields[number] = match self.cells {
                Some(cells) if number < seen => {
                    let here = &here[number];
                    let SteepPlace { place, gradient } =
                        field.sample_with_gradient(simd, region, here, (point, points), cells);
                    let slopes = field.how.segments.slopes(simd, place.segment);
                    let extinction = slopes.mean(simd, place.position, place.position).extinction;
                    let is_denser = extinction.simd_gt(densest);
                    densest = is_denser.select(extinction, densest);
                    for axis in 0..3 {
                        sample.gradient[axis] = is_denser.select(gradient[axis], sample.gradient[axis]);
                    }
                    place
                }
                _ => field.sample(simd, region, &here[number], point, points),
            };
        }
        sample
    }

    #[inline(always)]
    fn interval<S: Gather>(
        &self,
        simd: S,
        here: &mut [SingleHere<S>; MOST_FIELDS],
        [from, to]: [&SeveralPlaces<S>; 2],
        length: Floats<S>,
        rays: Mask<S>,
    ) -> Option<Interval<S>> {
        let (seen, colors) = self.split();
        let zero = Floats::splat(simd, 0.0);
        let mut sum = Glow { extinction: zero, emission: [zero; 3] };
        let mut any = false;
        for (number, field) in seen.iter().enumerate() {
            let ends = [&from.fields[number], &to.fields[number]];
            let Some(interval) = field.interval(simd, &mut here[number], ends, length, rays) else { continue };
            let mut glow = interval.over(simd, length);
            if let (0, Some(colors)) = (number, colors) {
                let last = seen.len();
                let ends = [&from.fields[last], &to.fields[last]];
                let Some(interval) = colors.interval(simd, &mut here[last], ends, length, rays) else { continue };
                let color = interval.over(simd, length);
                // Where there is no colour, the field is not seen.
                glow.extinction *= color.extinction;
                for channel in 0..3 {
                    glow.emission[channel] = glow.extinction * color.emission[channel];
                }
            }
            any = true;
            sum.extinction += glow.extinction;
            for channel in 0..3 {
                sum.emission[channel] += glow.emission[channel];
            }
        }
        any.then_some(Interval { glow: sum, length, rays })
    }
}

impl<S: Gather> Interval<S> {
    /// What it gives off per length of a whole interval, of which it may be a part; nothing where it is not known.
    #[inline(always)]
    fn over(&self, simd: S, length: Floats<S>) -> Glow<S> {
        let zero = Floats::splat(simd, 0.0);
        let share = self.length.simd_eq(length).select(Floats::splat(simd, 1.0), Floats::splat(simd, 0.5));
        let mut glow = self.glow;
        glow.extinction = self.rays.select(glow.extinction * share, zero);
        for channel in 0..3 {
            glow.emission[channel] = self.rays.select(glow.emission[channel] * share, zero);
        }
        glow
    }
}
