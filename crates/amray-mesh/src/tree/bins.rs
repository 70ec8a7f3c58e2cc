//! Where to cut a set of triangles in two: the surface area heuristic, over bins.
//!
//! A cut is as good as the boxes that it makes are small, weighted by how many triangles are in them (Wald, *On fast
//! Construction of SAH-based Bounding Volume Hierarchies*, Symposium on Interactive Ray Tracing 2007).

use super::bounds::Bounds;
use super::build::Primitive;

/// How many places to cut are compared, and one more.
const BINS: usize = 16;

/// The triangles whose middles lie in one of equal parts of an axis.
#[derive(Clone, Copy, Debug)]
struct Bin {
    bounds: Bounds,
    triangles: usize,
}

/// A cut across an axis: what lies in bins below `bin` is on the low side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    scale: BinScale,
    bin: usize,
}

/// From the middle of a triangle to its bin.
#[derive(Clone, Copy, Debug)]
struct BinScale {
    axis: usize,
    low: f32,
    per_unit: f32,
}

impl BinScale {
    /// None where all middles are as good as one.
    fn new(axis: usize, low: f32, high: f32) -> Option<Self> {
        let per_unit = BINS as f32 / (high - low);
        (high > low && per_unit.is_finite()).then_some(Self { axis, low, per_unit })
    }

    #[inline(always)]
    fn bin(&self, bounds: &Bounds) -> usize {
        (((bounds.twice_center(self.axis) - self.low) * self.per_unit) as usize).min(BINS - 1)
    }
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, triangles: 0 };

    #[inline(always)]
    fn include(&mut self, other: &Self) {
        self.bounds.include(&other.bounds);
        self.triangles += other.triangles;
    }

    fn cost(&self) -> f32 {
        self.bounds.half_area() * self.triangles as f32
    }
}

impl Cut {
    /// The best cut of triangles whose middles, doubled, lie in a box. None where they lie at one place.
    pub(super) fn best(primitives: &[Primitive], twice_centers: &Bounds) -> Option<Self> {
        let scales: [_; 3] =
            std::array::from_fn(|axis| BinScale::new(axis, twice_centers.low[axis], twice_centers.high[axis]));
        let mut bins = [[Bin::EMPTY; BINS]; 3];
        for primitive in primitives {
            for (bins, scale) in bins.iter_mut().zip(&scales) {
                if let Some(scale) = scale {
                    bins[scale.bin(&primitive.bounds)].include(&Bin { bounds: primitive.bounds, triangles: 1 });
                }
            }
        }
        let mut best: Option<(f32, Self)> = None;
        for (bins, scale) in bins.iter().zip(scales) {
            let Some(scale) = scale else { continue };
            for (bin, cost) in costs(bins) {
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, Self { scale, bin }));
                }
            }
        }
        best.map(|(_, cut)| cut)
    }

    /// Whether a triangle is on the low side.
    #[inline(always)]
    pub(super) fn is_below(&self, primitive: &Primitive) -> bool {
        self.scale.bin(&primitive.bounds) < self.bin
    }
}

/// The cuts between bins that leave triangles on both sides, with their costs.
fn costs(bins: &[Bin; BINS]) -> impl Iterator<Item = (usize, f32)> {
    let mut above = [(0.0, 0); BINS];
    let mut sum = Bin::EMPTY;
    for bin in (0..BINS).rev() {
        sum.include(&bins[bin]);
        above[bin] = (sum.cost(), sum.triangles);
    }
    let mut below = Bin::EMPTY;
    (1..BINS).filter_map(move |bin| {
        below.include(&bins[bin - 1]);
        let (cost_above, triangles_above) = above[bin];
        (below.triangles > 0 && triangles_above > 0).then(|| (bin, below.cost() + cost_above))
    })
}
