//! Samples of padded bricks, as marching takes them: rays of a packet go through regions side by side.

use fearless_simd::prelude::*;

use crate::Volume;
use crate::layout::{PaddedValues, RegionFrame, RegionValues};
use crate::simd::{Floats, Gather, InstructionSet, Kernel, LANES, Mask};

/// Samples along one way of a packet.
const STEPS: usize = 8;
/// How far neighbouring rays are apart, and how far a step goes, in cells.
const APART: f32 = 0.5;
const STEP: f32 = 0.9;
/// How far the rays nearest to a face are from it, and their neighbours from each other, in cells.
const FROM_FACE: f32 = 0.05;
const NEAR: f32 = 0.1;

/// Takes samples of a volume's padded copy.
pub struct RegionSampler<'a> {
    volume: &'a Volume,
    ways: Vec<Way>,
}

/// A packet's way through a region, in its local coordinates.
#[derive(Clone, Copy)]
struct Way {
    region: usize,
    /// Of the first ray.
    start: [f32; 3],
    /// From one ray to the next one in a row and in a column of the packet, and from one sample to the next.
    offsets: [[f32; 3]; 3],
    interior: bool,
}

impl<'a> RegionSampler<'a> {
    /// Through all of one brick of the finest level, which stays in the nearest cache.
    pub fn of_one_brick(volume: &'a Volume, packets: usize) -> Self {
        let index = volume.index();
        let finest = index.hierarchy().finest_level() as u8;
        let side = |frame: &RegionFrame, axis: usize| frame.pure[1][axis] - frame.pure[0][axis];
        let narrowest = |frame: &RegionFrame| (0..3).map(|axis| side(frame, axis)).fold(f32::INFINITY, f32::min);
        let of_finest = frames(volume).filter(|(_, frame)| frame.level == Some(finest));
        let widest = of_finest.max_by(|a, b| narrowest(a.1).total_cmp(&narrowest(b.1)));
        let (region, frame) = widest.expect("the finest level has a brick");
        // A little across the rows, as rays go.
        let offsets = [[0.0, APART, 0.0], [0.0, 0.0, APART], [STEP, 0.1, 0.05]];
        let way = |number: usize| {
            let start = |axis: usize| {
                let extent = 3.0 * (offsets[0][axis] + offsets[1][axis]) + (STEPS - 1) as f32 * offsets[2][axis];
                // Steps of these lengths cover a unit cube evenly (Roberts, 2018).
                let share = (number as f32 * [0.819_172_5, 0.671_043_6, 0.549_700_5][axis]).fract();
                frame.pure[0][axis] + share * (side(frame, axis) - extent).max(0.0)
            };
            Way { region, start: [start(0), start(1), start(2)], offsets, interior: true }
        };
        Self { volume, ways: (0..packets / STEPS).map(way).collect() }
    }

    /// Along the faces at which regions of different levels meet, less than half a cell away from them.
    pub fn of_borders(volume: &'a Volume, packets: usize) -> Self {
        let index = volume.index();
        let boxes = index.region_boxes();
        let mut ways = Vec::new();
        for (region, frame) in frames(volume).filter(|(_, frame)| !frame.is_pure) {
            let Some(level) = frame.level else { continue };
            let size = index.hierarchy().levels()[usize::from(level)].finest_cells();
            let local = |corner: [i64; 3]| -> [f32; 3] {
                std::array::from_fn(|axis| (corner[axis] as f64 / size[axis] as f64 - frame.low[axis]) as f32)
            };
            let ends = [local(boxes[region].low), local(boxes[region].high)];
            let is_wide = (0..3).all(|axis| ends[1][axis] - ends[0][axis] >= STEP * (STEPS + 1) as f32);
            for (axis, end) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                if !is_wide || (frame.pure[end][axis] - ends[end][axis]).abs() < FROM_FACE {
                    continue;
                }
                let inward = if end == 0 { 1.0 } else { -1.0 };
                let [along, across] = [(axis + 1) % 3, (axis + 2) % 3];
                let mut start: [f32; 3] = ends[0].map(|low| low + STEP);
                start[axis] = ends[end][axis] + inward * FROM_FACE;
                let mut offsets = [[0.0; 3]; 3];
                offsets[0][axis] = inward * NEAR;
                offsets[1][across] = APART;
                offsets[2][along] = STEP;
                ways.push(Way { region, start, offsets, interior: false });
            }
        }
        assert!(!ways.is_empty(), "a volume whose levels do not meet has no border");
        let ways = ways.into_iter().cycle().take(packets / STEPS).collect();
        Self { volume, ways }
    }

    /// How many samples [`run`](Self::run) takes.
    pub fn samples(&self) -> usize {
        self.ways.len() * STEPS * LANES
    }

    /// Takes all samples, in units of the field's range, on this thread; their sum.
    pub fn run(&self) -> f32 {
        let volume = self.volume;
        let padded = volume.padded();
        let sampler = volume.packet_sampler();
        let values = PaddedValues::new(padded, &sampler);
        InstructionSet::best().run(Samples { values, ways: &self.ways })
    }
}

struct Samples<'a> {
    values: PaddedValues<'a>,
    ways: &'a [Way],
}

impl Kernel for Samples<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Gather>(self, simd: S) -> f32 {
        let all = Mask::splat(simd, true);
        let mut sum = Floats::splat(simd, 0.0);
        for way in self.ways {
            let [row, column, step] = way.offsets;
            let mut start = [Floats::splat(simd, 0.0); 3];
            for axis in 0..3 {
                let mut places = [way.start[axis]; LANES];
                for (lane, place) in places.iter_mut().enumerate() {
                    *place += (lane % 4) as f32 * row[axis] + (lane / 4) as f32 * column[axis];
                }
                start[axis] = Floats::from_slice(simd, &places);
            }
            for number in 0..STEPS {
                let mut point = start;
                for axis in 0..3 {
                    point[axis] =
                        Floats::splat(simd, number as f32).mul_add(Floats::splat(simd, step[axis]), start[axis]);
                }
                sum += match way.interior {
                    true => self.values.pure(simd, way.region, point),
                    false => self.values.anywhere(simd, way.region, point, all),
                };
            }
        }
        simd.reduce_sum_f32x16(sum)
    }
}

/// The regions' places and frames.
fn frames(volume: &Volume) -> impl Iterator<Item = (usize, &RegionFrame)> {
    volume.padded().plan.regions.iter().map(|plan| &plan.frame).enumerate()
}
