//! What surfaces look like: colours, opacities and how they reflect.

use fearless_simd::prelude::*;

use crate::Volume;
use crate::appearance::PreparedTransferFunction;
use crate::hierarchy::{Hierarchy, Normalisation};
use crate::reconstruction::AnySampler;
use crate::scene::{Material, Paint, Surface};
use crate::simd::{Doubles, Floats, Gather, LANES, LaneSet, mask_of};

/// How a surface looks.
pub(super) struct Coat<'a> {
    paint: PreparedPaint<'a>,
    opacity: f32,
    pub(super) casts_shadows: bool,
    pub(super) material: Option<Material>,
    /// Across it, in world space and of length 1, where that is the same everywhere.
    pub(super) normal: Option<[f32; 3]>,
}

enum PreparedPaint<'a> {
    Own,
    Plain([f32; 3]),
    Field(Box<Colors<'a>>),
}

/// A field's colours.
struct Colors<'a> {
    sampler: AnySampler<'a>,
    normalisation: Normalisation,
    function: PreparedTransferFunction,
    hierarchy: &'a Hierarchy,
    /// From cells of the finest level of the scene's volume.
    from: &'a Hierarchy,
}

impl<'a> Coat<'a> {
    /// Of a surface in a scene with this volume.
    pub(super) fn new(volume: &'a Volume, surface: &'a Surface<'a>, normal: Option<[f64; 3]>) -> Self {
        let paint = match &surface.paint {
            Paint::Own => PreparedPaint::Own,
            Paint::Plain(color) => PreparedPaint::Plain(*color),
            Paint::Field(field, function) => PreparedPaint::Field(Box::new(Colors {
                sampler: field.packet_sampler(),
                normalisation: field.normalisation(),
                // Opacities do not matter.
                function: function.prepared(1.0),
                hierarchy: field.hierarchy(),
                from: volume.hierarchy(),
            })),
        };
        let normal = normal.map(|normal| {
            let length = normal.iter().map(|part| part * part).sum::<f64>().sqrt();
            normal.map(|part| (part / length) as f32)
        });
        let Surface { opacity, material, casts_shadows, .. } = *surface;
        Self { paint, opacity: opacity.clamp(0.0, 1.0), casts_shadows, material, normal }
    }

    /// How much light the surface lets through where it has a colour.
    pub(super) fn transparency(&self) -> f32 {
        if self.casts_shadows { 1.0 - self.opacity } else { 1.0 }
    }

    /// The opacity where the surface's own is `alpha`.
    pub(super) fn alpha(&self, alpha: f32) -> f32 {
        match self.paint {
            PreparedPaint::Own => alpha * self.opacity,
            PreparedPaint::Plain(_) | PreparedPaint::Field(_) => self.opacity,
        }
    }

    /// Whether nothing is seen through it, wherever it is.
    pub(super) fn is_opaque(&self) -> bool {
        self.opacity >= 1.0 && !matches!(self.paint, PreparedPaint::Field(_))
    }

    /// Puts the surface's colours and opacities at `places` of some lanes into those that are there, which are its own.
    #[inline(always)]
    pub(super) fn color<S: Gather>(
        &self,
        simd: S,
        places: &[Doubles<S>; 3],
        lanes: LaneSet,
        [red, green, blue, alpha]: &mut [Floats<S>; 4],
    ) {
        let here = mask_of(simd, lanes);
        let opacity = Floats::splat(simd, self.opacity);
        let [r, g, b, a] = match &self.paint {
            PreparedPaint::Own => [*red, *green, *blue, *alpha * opacity],
            PreparedPaint::Plain([r, g, b]) => {
                [Floats::splat(simd, *r), Floats::splat(simd, *g), Floats::splat(simd, *b), opacity]
            }
            PreparedPaint::Field(colors) => {
                let found = colors.at(simd, places, lanes);
                let [r, g, b, there] = &found;
                let there = Floats::from_slice(simd, there);
                [Floats::from_slice(simd, r), Floats::from_slice(simd, g), Floats::from_slice(simd, b), there * opacity]
            }
        };
        *red = here.select(r, *red);
        *green = here.select(g, *green);
        *blue = here.select(b, *blue);
        *alpha = here.select(a, *alpha);
    }
}

impl Colors<'_> {
    /// Red, green and blue at places, and whether there is a colour.
    #[inline(never)]
    fn at<S: Gather>(&self, simd: S, places: &[Doubles<S>; 3], lanes: LaneSet) -> [[f32; LANES]; 4] {
        simd.vectorize(
            #[inline(always)]
            || {
                let places = [places[0].store(), places[1].store(), places[2].store()];
                let (mut points, mut inside) = ([[0.0; LANES]; 3], lanes);
                let [from, to] = [self.from.finest_level(), self.hierarchy.finest_level()];
                let domain = &self.hierarchy.levels()[to].domain();
                for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
                    let world = self.from.to_world(from, [places[0][lane], places[1][lane], places[2][lane]]);
                    let cell = self.hierarchy.to_cells(to, world);
                    // A hair outside counts as inside: places on the domain's faces are rounded.
                    let holds = |axis: usize| {
                        let nearly = 1e-6 * (domain.high[axis] - domain.low[axis]) as f64;
                        let [low, high] = [domain.low[axis] as f64 - nearly, domain.high[axis] as f64 + nearly];
                        (low..=high).contains(&cell[axis])
                    };
                    if !(holds(0) && holds(1) && holds(2)) {
                        inside &= !(1 << lane);
                    }
                    for axis in 0..3 {
                        points[axis][lane] = cell[axis];
                    }
                }
                let samples = self.sampler.sample::<S, Floats<S>>(simd, &points, mask_of(simd, lanes));
                let values: [f32; LANES] = samples.values.into();
                let mut found = [[0.0; LANES]; 4];
                for lane in (0..LANES).filter(|lane| inside >> lane & 1 == 1) {
                    let value = self.normalisation.undo(values[lane]);
                    if value.is_finite() {
                        let [red, green, blue] = self.function.sample(value).color;
                        for (channel, part) in [red, green, blue, 1.0].into_iter().enumerate() {
                            found[channel][lane] = part;
                        }
                    }
                }
                found
            },
        )
    }
}
