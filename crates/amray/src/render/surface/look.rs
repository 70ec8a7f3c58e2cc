//! What surfaces are like where rays meet them: their normals, and the colours that meshes bring.

use fearless_simd::prelude::*;

use super::layers::Layers;
use super::plan::SurfacePlan;
use crate::simd::{Doubles, Floats, Gather, Integers, LANES, LaneSet, Mask, lanes_of, mask_of};

/// How far off its surface, in cells of the finest level, a ray starts; and by how much of the way to it.
const OFF: f32 = 1e-2;
const ROUNDING: f32 = 1e-6;

impl SurfacePlan<'_> {
    /// How far off surfaces, in cells of the finest level, rays start that go on from where others met them `at`.
    #[inline(always)]
    pub(super) fn off<S: Gather>(&self, simd: S, at: Floats<S>) -> Floats<S> {
        let hierarchy = self.volume.hierarchy();
        let cell = hierarchy.levels()[hierarchy.finest_level()].cell_size().into_iter().fold(0.0, f64::max) as f32;
        // How far meshes may be from where they are met.
        let precision = self.meshes.iter().map(|mesh| mesh.mesh.precision()).fold(0.0, f64::max) as f32;
        at.abs() * Floats::splat(simd, ROUNDING / cell) + Floats::splat(simd, OFF.max(2.0 * precision / cell))
    }

    /// Puts the normals and colours of meshes that lanes meet into those that are there.
    #[inline(always)]
    pub(super) fn of_meshes<S: Gather>(
        &self,
        simd: S,
        packet: usize,
        ((numbers, lanes), layers): ((Integers<S>, LaneSet), &Layers),
        (normals, colors): (&mut [Floats<S>; 3], &mut [Floats<S>; 4]),
    ) {
        let first = Integers::splat(simd, self.first_mesh() as i32);
        let meshes = lanes_of(numbers.simd_ge(first)) & lanes;
        for lane in (0..LANES).filter(|lane| meshes >> lane & 1 == 1) {
            if let Some(layer) = layers.next(packet, lane) {
                for axis in 0..3 {
                    normals[axis][lane] = layer.hit.normal[axis];
                }
                for channel in 0..4 {
                    colors[channel][lane] = layer.hit.color[channel];
                }
            }
        }
    }

    /// Across isosurfaces and slices, in world space, of any length.
    #[inline(always)]
    pub(super) fn normals<S: Gather>(
        &self,
        simd: S,
        place: &[Doubles<S>; 3],
        (numbers, lanes): (Integers<S>, LaneSet),
    ) -> [Floats<S>; 3] {
        let zero = Floats::splat(simd, 0.0);
        let mut normals = [zero; 3];
        let rays = mask_of(simd, lanes);
        let isosurfaces = rays & numbers.simd_lt(Integers::splat(simd, self.levels.len() as i32));
        if isosurfaces.any_true() {
            normals = self.rise(simd, place, isosurfaces);
        }
        for (nth, coat) in self.coats.iter().enumerate() {
            if let Some(normal) = coat.normal {
                let here = numbers.simd_eq(Integers::splat(simd, nth as i32));
                for axis in 0..3 {
                    normals[axis] = here.select(Floats::splat(simd, normal[axis]), normals[axis]);
                }
            }
        }
        normals
    }

    /// How the values at places rise from one leaf cell before them to one behind, in world space: as between cells'
    /// centres, where VTK takes normals from. The gradient itself jumps from cell to cell; this does not.
    #[inline(always)]
    fn rise<S: Gather>(&self, simd: S, place: &[Doubles<S>; 3], rays: Mask<S>) -> [Floats<S>; 3] {
        let hierarchy = self.volume.hierarchy();
        let levels = hierarchy.levels();
        let middle = [place[0].store(), place[1].store(), place[2].store()];
        let here = self.sampler.sample::<S, Floats<S>>(simd, &middle, rays);
        let found: [i32; LANES] = here.levels.into();
        let mut rise = [Floats::splat(simd, 0.0); 3];
        for axis in 0..3 {
            let (mut low, mut high, mut inverse) = (middle, middle, [0.0; LANES]);
            for lane in 0..LANES {
                let level = &levels[found[lane].max(0) as usize];
                let cell = level.finest_cells()[axis] as f64;
                low[axis][lane] -= cell;
                high[axis][lane] += cell;
                inverse[lane] = (levels[0].cell_size()[0] / level.cell_size()[axis]) as f32;
            }
            let low = self.sampler.sample::<S, Floats<S>>(simd, &low, rays).values;
            let high = self.sampler.sample::<S, Floats<S>>(simd, &high, rays).values;
            // Next to where there is no value, the other side tells it.
            let (before, behind) = (here.values - low, high - here.values);
            let before = before.is_finite().select(before, behind);
            let behind = behind.is_finite().select(behind, before);
            rise[axis] = (before + behind) * Floats::from_slice(simd, &inverse);
        }
        rise
    }
}
