//! What is known of a scene's surfaces before the first ray: where planes lie, and which parts of the volume isosurfaces
//! can be in.

use crate::Volume;
use crate::hierarchy::Normalisation;
use crate::layout::PieceNode;
use crate::reconstruction::AnySampler;
use crate::scene::{Shape, Surface};

use super::super::plane::Plane;
use super::super::visibility::NodeLook;
use super::super::walk::{Levels, looks};
use super::coat::Coat;
use super::layers::MeshPlan;

/// The surfaces of a scene. They are numbered: isosurfaces from the lowest value on, then slices,
/// then meshes.
pub(in super::super) struct SurfacePlan<'a> {
    pub(super) volume: &'a Volume,
    pub(in super::super) sampler: AnySampler<'a>,
    /// The isosurfaces' values, and which parts of the volume have to be looked at for them.
    pub(super) levels: Vec<f32>,
    pub(super) looks: Vec<NodeLook>,
    pub(super) planes: Vec<Plane>,
    pub(super) meshes: Vec<MeshPlan<'a>>,
    pub(super) coats: Vec<Coat<'a>>,
}

impl<'a> SurfacePlan<'a> {
    /// Surfaces over a volume with these pieces; `None` where there are none.
    pub(in super::super) fn new(volume: &'a Volume, surfaces: &'a [Surface<'a>], pieces: &[PieceNode]) -> Option<Self> {
        if surfaces.is_empty() {
            return None;
        }
        let Normalisation { low, scale } = volume.normalisation();
        let (mut isosurfaces, mut planes, mut slices) = (Vec::new(), Vec::new(), Vec::new());
        let (mut meshes, mut shells) = (Vec::new(), Vec::new());
        for surface in surfaces {
            match surface.shape {
                Shape::Isosurface(value) => isosurfaces.push((((value - low) * scale) as f32, surface)),
                Shape::Slice { point, normal } => {
                    planes.push(Plane::new(volume.hierarchy(), point, normal));
                    slices.push(Coat::new(volume, surface, Some(normal)));
                }
                Shape::Mesh(mesh) => {
                    let coat = Coat::new(volume, surface, None);
                    meshes.push(MeshPlan { mesh, is_opaque: coat.is_opaque() && mesh.is_opaque() });
                    shells.push(coat);
                }
            }
        }
        isosurfaces.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let (levels, isosurfaces): (Vec<f32>, Vec<_>) = isosurfaces.into_iter().unzip();
        let looks = match levels.is_empty() {
            true => Vec::new(),
            false => looks(pieces, |node| Levels(&levels).rank_of_all(node.range)),
        };
        let mut coats: Vec<_> = isosurfaces.into_iter().map(|surface| Coat::new(volume, surface, None)).collect();
        coats.append(&mut slices);
        coats.append(&mut shells);
        Some(Self { volume, sampler: volume.packet_sampler(), levels, looks, planes, meshes, coats })
    }

    /// The number of the first mesh.
    pub(super) fn first_mesh(&self) -> usize {
        self.levels.len() + self.planes.len()
    }
}
