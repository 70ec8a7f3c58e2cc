//! What rays ask a mesh.

use crate::local_ray::LocalRay;
use crate::mesh::{Mesh, area_vector, unit};
use crate::{Hit, Ray};

/// A triangle (in the tree's order) that a ray meets.
struct Met {
    t: f64,
    triangle: usize,
    /// How much each corner counts.
    weights: [f64; 3],
}

impl Mesh {
    /// The hit with the smallest `t`. Triangles have no back: they are hit from either side.
    ///
    /// Surfaces are watertight: a ray does not slip between triangles that share an edge or a vertex, and meets only
    /// one of them where it goes through that exactly. (So where such a ray meets the rim of an open surface is left to
    /// the triangle's place, like a pixel on an edge.)
    pub fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let mut nearest: Option<Met> = None;
        self.visit(ray, |met| {
            // Of those at one place, the same is taken whatever the tree looks like.
            let key = |met: &Met| (met.t, self.numbers[met.triangle]);
            if nearest.as_ref().is_none_or(|nearest| key(&met) < key(nearest)) {
                nearest.insert(met).t
            } else {
                f64::INFINITY
            }
        });
        nearest.map(|met| self.hit(&met))
    }

    /// All hits, sorted by `t`; `hits` is cleared first. A closed surface is hit an even number of times by a ray from
    /// outside to outside: exactly once for each time that it goes in or out.
    pub fn hits(&self, ray: &Ray, hits: &mut Vec<Hit>) {
        hits.clear();
        self.visit(ray, |met| {
            hits.push(self.hit(&met));
            f64::INFINITY
        });
        hits.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.triangle.cmp(&b.triangle)));
    }

    /// Whether there is any hit: the question of a shadow ray where the mesh is opaque.
    pub fn is_hit(&self, ray: &Ray) -> bool {
        let mut hit = false;
        self.visit(ray, |_| {
            hit = true;
            f64::NEG_INFINITY
        });
        hit
    }

    /// The share of light that gets through along a ray, 0 to 1: the product of 1 - `alpha` over all hits, in any
    /// order. It ends as soon as nothing is left.
    pub fn transmittance(&self, ray: &Ray, mut alpha: impl FnMut(&Hit) -> f32) -> f64 {
        let mut transmittance = 1.0;
        self.visit(ray, |met| {
            transmittance *= 1.0 - f64::from(alpha(&self.hit(&met)).clamp(0.0, 1.0));
            if transmittance > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY }
        });
        transmittance
    }

    /// Shows `meet` what the ray meets, roughly from near to far. It says up to which `t` more is of interest.
    #[inline]
    fn visit(&self, ray: &Ray, mut meet: impl FnMut(Met) -> f64) {
        let Some(local) = LocalRay::new(ray, &self.frame, self.local_bounds) else { return };
        let mut to = ray.to;
        self.tree.visit(&local, |triangles| {
            for triangle in triangles {
                let Some(crossing) = local.cross(self.corners(triangle)) else { continue };
                let t = local.t(crossing.distance);
                if t >= ray.from && t <= to {
                    to = to.min(meet(Met { t, triangle, weights: crossing.weights }));
                }
            }
            local.distance(to)
        });
    }

    /// All about a hit.
    fn hit(&self, met: &Met) -> Hit {
        let weights = met.weights.map(|weight| weight as f32);
        let vertices = self.triangles[met.triangle].map(|vertex| vertex as usize);
        let geometric_normal = unit(area_vector(self.corners(met.triangle)));
        let normal = match &self.normals {
            Some(normals) => match unit(mean(weights, vertices.map(|vertex| normals[vertex])).map(f64::from)) {
                [0.0, 0.0, 0.0] => geometric_normal,
                normal => normal,
            },
            None => geometric_normal,
        };
        let color = match &self.colors {
            Some(colors) => mean(weights, vertices.map(|vertex| colors[vertex])),
            None => [1.0; 4],
        };
        Hit { t: met.t, triangle: self.numbers[met.triangle], weights, normal, geometric_normal, color }
    }
}

/// The weighted mean of what three vertices have.
fn mean<const N: usize>(weights: [f32; 3], values: [[f32; N]; 3]) -> [f32; N] {
    std::array::from_fn(|component| (0..3).map(|vertex| weights[vertex] * values[vertex][component]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MeshDescription;

    /// Squares across z at heights 1 and 2 and 3, split along the diagonal, red to blue along x.
    fn layers(alpha: f32) -> Mesh {
        let mut description = MeshDescription::default();
        let mut colors = Vec::new();
        for height in [1.0, 2.0, 3.0] {
            let first = description.vertices.len() as u32;
            description.vertices.extend([
                [0.0, 0.0, height],
                [1.0, 0.0, height],
                [1.0, 1.0, height],
                [0.0, 1.0, height],
            ]);
            description.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            let [red, blue] = [[1.0, 0.0, 0.0, alpha], [0.0, 0.0, 1.0, alpha]];
            colors.extend([red, blue, blue, red]);
        }
        description.colors = Some(colors);
        Mesh::new(description).unwrap()
    }

    fn up(x: f64, y: f64) -> Ray {
        Ray { origin: [x, y, 0.0], direction: [0.0, 0.0, 0.5], from: 0.0, to: f64::INFINITY }
    }

    #[test]
    fn hits_know_their_place_color_and_normals() {
        let hit = layers(0.5).nearest(&up(0.75, 0.25)).unwrap();
        assert_eq!((hit.t, hit.triangle), (2.0, 0));
        assert_eq!(hit.weights, [0.25, 0.5, 0.25]);
        assert_eq!(hit.color, [0.25, 0.0, 0.75, 0.5]);
        assert_eq!(hit.geometric_normal, [0.0, 0.0, 1.0]);
        assert_eq!(hit.normal, hit.geometric_normal);
    }

    #[test]
    fn all_hits_are_sorted_and_a_diagonal_is_hit_once() {
        let mesh = layers(0.5);
        let mut hits = Vec::new();
        for (x, y) in [(0.75, 0.25), (0.25, 0.75), (0.5, 0.5), (0.125, 0.125)] {
            mesh.hits(&up(x, y), &mut hits);
            assert_eq!(hits.iter().map(|hit| hit.t).collect::<Vec<_>>(), [2.0, 4.0, 6.0]);
        }
        mesh.hits(&Ray { from: 2.0, to: 4.0, ..up(0.5, 0.25) }, &mut hits);
        assert_eq!(hits.len(), 2);
        mesh.hits(&Ray { from: 2.1, to: 3.9, ..up(0.5, 0.25) }, &mut hits);
        assert!(hits.is_empty());
        mesh.hits(&Ray { from: f64::NEG_INFINITY, origin: [0.5, 0.25, 2.5], ..up(0.0, 0.0) }, &mut hits);
        assert!(hits.iter().zip([-3.0, -1.0, 1.0]).all(|(hit, t)| (hit.t - t).abs() < 1e-12) && hits.len() == 3);
    }

    #[test]
    fn light_gets_through_all_layers() {
        let ray = up(0.25, 0.5);
        assert_eq!(layers(0.5).transmittance(&ray, |hit| hit.color[3]), 0.125);
        assert_eq!(layers(0.5).transmittance(&Ray { to: 4.5, ..ray }, |hit| hit.color[3]), 0.25);
        assert_eq!(layers(0.5).transmittance(&up(1.5, 0.5), |hit| hit.color[3]), 1.0);
        let mut asked = 0;
        let transmittance = layers(1.0).transmittance(&ray, |hit| {
            asked += 1;
            hit.color[3]
        });
        assert_eq!((transmittance, asked), (0.0, 1));
        assert!(layers(1.0).is_hit(&ray) && !layers(1.0).is_hit(&up(1.5, 0.5)));
    }

    #[test]
    fn normals_of_vertices_are_interpolated_where_there_are_any() {
        let description = |normals: [[f64; 3]; 3]| MeshDescription {
            vertices: vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
            triangles: vec![[0, 1, 2]],
            colors: None,
            normals: Some(normals.into()),
        };
        let normal = |normals| Mesh::new(description(normals)).unwrap().nearest(&up(0.5, 0.25)).unwrap().normal;
        let [x, y, z] = normal([[0.0, 0.0, -2.0], [5.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
        assert!((x - 0.5f32.sqrt()).abs() < 1e-6 && y == 0.0 && (z + 0.5f32.sqrt()).abs() < 1e-6, "{x} {y} {z}");
        assert_eq!(normal([[f64::NAN; 3], [0.0; 3], [0.0, 0.0, 0.0]]), [0.0, 0.0, 1.0]);
    }
}
