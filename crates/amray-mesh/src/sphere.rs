//! A sphere as a mesh.

use std::f64::consts::PI;

use crate::MeshDescription;

impl MeshDescription {
    /// A closed sphere with normals: as many `rings` from pole to pole, twice as many around; at least 2. `center` and
    /// `radius` are in world units.
    pub fn sphere(center: [f64; 3], radius: f64, rings: u32) -> Self {
        let rings = rings.max(2);
        let around = 2 * rings;
        let mut normals = vec![[0.0, 0.0, 1.0]];
        for ring in 1..rings {
            let (sine, cosine) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
            normals.extend((0..around).map(|step| {
                let (y, x) = (2.0 * PI * f64::from(step) / f64::from(around)).sin_cos();
                [sine * x, sine * y, cosine]
            }));
        }
        normals.push([0.0, 0.0, -1.0]);

        let south = normals.len() as u32 - 1;
        let mut triangles = Vec::new();
        for step in 0..around {
            let next = (step + 1) % around;
            triangles.push([0, 1 + step, 1 + next]);
            for ring in 0..rings - 2 {
                let [upper, lower] = [1 + ring * around, 1 + (ring + 1) * around];
                triangles.push([upper + step, lower + step, lower + next]);
                triangles.push([upper + step, lower + next, upper + next]);
            }
            triangles.push([south, south - around + next, south - around + step]);
        }
        let vertices =
            normals.iter().map(|normal| std::array::from_fn(|axis| center[axis] + radius * normal[axis])).collect();
        Self { vertices, triangles, colors: None, normals: Some(normals) }
    }
}
