//! Values sampled where they are: in a mapped file, or in someone else's memory.

use fearless_simd::prelude::*;

use super::pieces::{self, BrickPieces, PieceNode};
use super::{NO_BOX, RegionFrame, RegionValues, queried, region_places};
use crate::Volume;
use crate::hierarchy::with_voxels;
use crate::index::{Index, Region};
use crate::reconstruction::{AnySampler, LaneNumber, Method};
use crate::simd::{Floats, Gather, Mask};

/// How to march through a volume whose values stay where they are.
#[derive(Clone, Debug)]
pub(crate) struct InPlacePlan {
    pub(crate) pieces: Vec<PieceNode>,
    frames: Vec<RegionFrame>,
    /// The regions' first and last places.
    places: Vec<[[f64; 3]; 2]>,
    /// Per region, the place of its finest brick.
    bricks: Vec<u32>,
    /// Per level, cells of the finest level per cell.
    finest_cells: Vec<[f64; 3]>,
}

impl InPlacePlan {
    pub(crate) fn new(volume: &Volume) -> Self {
        let index = volume.index();
        let placed = index.regions().iter().zip(index.region_boxes()).map(|(region, cells)| {
            let Some((level, place)) = region.finest_level().and_then(|level| index.finest_brick(region, level)) else {
                return (RegionFrame::default(), 0);
            };
            let whole = [cells.low, cells.high];
            let pure = pure(index, region, whole, level, volume.method());
            let description = &index.hierarchy().levels()[level];
            let first = volume.field().centering().place();
            let low = description.brick_at(place).low.map(|cell| cell as f64 + first);
            let size = description.finest_cells();
            let local = |corner: [f64; 3]| -> [f32; 3] {
                std::array::from_fn(|axis| (corner[axis] / size[axis] as f64 - low[axis]) as f32)
            };
            let is_pure = pure == whole.map(|corner| corner.map(|cell| cell as f64));
            (RegionFrame { level: Some(level as u8), low, pure: pure.map(local), is_pure }, place as u32)
        });
        let (frames, bricks): (Vec<_>, Vec<_>) = placed.unzip();
        let (ranges, normalisation) = (volume.ranges(), volume.normalisation());
        let pieces = with_voxels!(volume.field().values(), values => {
            let source =
                BrickPieces { index, ranges, normalisation, centering: volume.field().centering(), frames: &frames, places: &bricks, bricks: values };
            pieces::tree(index, &source)
        });
        let levels = index.hierarchy().levels().iter();
        Self {
            pieces,
            frames,
            places: region_places(index),
            bricks,
            finest_cells: levels.map(|level| level.finest_cells().map(|cells| cells as f64)).collect(),
        }
    }

    /// Bytes of memory that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        let places = size_of_val(&*self.frames) + size_of_val(&*self.places) + size_of_val(&*self.bricks);
        (size_of_val(&*self.pieces) + places) as u64
    }
}

/// The box, in cells of the finest level, in which a region's finest brick alone has the values that a method needs.
fn pure(index: &Index, region: &Region, whole: [[i64; 3]; 2], level: usize, method: Method) -> [[f64; 3]; 2] {
    let nowhere = NO_BOX.map(|corner| corner.map(f64::from));
    match method {
        // Found in the brick, but only by the packets' own way.
        Method::Nearest => nowhere,
        Method::Nodal => whole.map(|corner| corner.map(|cell| cell as f64)),
        Method::Finest if level < index.hierarchy().finest_level() => nowhere,
        _ if (0..3).any(|axis| region.interior()[1][axis] <= region.interior()[0][axis]) => nowhere,
        _ => region.interior(),
    }
}

/// A field whose values stay where they are.
#[derive(Clone, Copy)]
pub(crate) struct InPlace<'a> {
    pub(crate) plan: &'a InPlacePlan,
    pub(crate) sampler: &'a AnySampler<'a>,
}

impl RegionValues for InPlace<'_> {
    #[inline(always)]
    fn frame(&self, region: usize) -> &RegionFrame {
        &self.plan.frames[region]
    }

    #[inline(always)]
    fn finest_cells(&self, level: u8) -> &[f64; 3] {
        &self.plan.finest_cells[usize::from(level)]
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        false
    }

    #[inline(always)]
    fn in_pure<S: Gather, N: LaneNumber<S>>(&self, simd: S, region: usize, point: [Floats<S>; 3]) -> N {
        if !self.sampler.is_packed() {
            return self.in_region(simd, region, point, Mask::splat(simd, true));
        }
        let mut point = point;
        if N::HAS_SLOPES {
            // On the box's high faces slopes are those from inside: beyond, the brick alone knows nothing.
            for axis in 0..3 {
                let last = self.frame(region).pure[1][axis].next_down();
                point[axis] = point[axis].min(Floats::splat(simd, last));
            }
        }
        self.sampler.in_brick(simd, self.plan.bricks[region] as usize, point)
    }

    #[inline(always)]
    fn in_region<S: Gather, N: LaneNumber<S>>(
        &self,
        simd: S,
        region: usize,
        point: [Floats<S>; 3],
        active: Mask<S>,
    ) -> N {
        let frame = self.frame(region);
        let size = self.finest_cells(frame.level.unwrap_or(0));
        queried(simd, self.sampler, (frame, size, &self.plan.places[region]), point, active)
    }
}
