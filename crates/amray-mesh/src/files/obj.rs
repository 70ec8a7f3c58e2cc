//! Wavefront OBJ: vertices, normals, and polygons that refer to both by number.
//!
//! Colours are the widespread extension of three more numbers after a vertex. Texture coordinates, groups, materials,
//! curves and lines are passed over.

use amray_encoding::shown;

use super::error::Problem;
use super::merge::Distinct;
use super::polygon::fan;
use super::text::{lines, triple};
use crate::MeshDescription;

/// What was read so far.
#[derive(Debug, Default)]
struct Reader {
    positions: Vec<[f64; 3]>,
    /// One per position.
    colors: Vec<Option<[f32; 4]>>,
    normals: Vec<[f64; 3]>,
    /// A vertex is a position with a normal, or without one.
    vertices: Distinct<(usize, Option<usize>)>,
    /// In their order.
    used: Vec<(usize, Option<usize>)>,
    triangles: Vec<[u32; 3]>,
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshDescription, Problem> {
    let mut reader = Reader::default();
    for (number, line) in lines(bytes, true) {
        let problem = |problem: String| Problem::at_line(number, format!("{}, {problem}", shown(&line)));
        let mut words = line.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match words.next() {
            Some("v") => reader.vertex(&mut words).ok_or_else(|| problem("expected a vertex v x y z".into()))?,
            Some("vn") => {
                let normal = triple(&mut words).ok_or_else(|| problem("expected a normal vn x y z".into()))?;
                reader.normals.push(normal);
            }
            Some("f") => reader.face(&mut words).map_err(problem)?,
            _ => {}
        }
    }
    Ok(reader.mesh())
}

impl Reader {
    fn vertex<'a>(&mut self, words: &mut impl Iterator<Item = &'a str>) -> Option<()> {
        self.positions.push(triple(words)?);
        // A single number more is the weight of a rational curve.
        let color = triple(words).map(|[r, g, b]| [r as f32, g as f32, b as f32, 1.0]);
        self.colors.push(color);
        Some(())
    }

    fn face<'a>(&mut self, words: &mut impl Iterator<Item = &'a str>) -> Result<(), String> {
        let mut corners = Vec::new();
        for word in words {
            let mut numbers = word.split('/');
            let position = numbers.next().unwrap_or_default();
            let normal = numbers.nth(1).filter(|normal| !normal.is_empty());
            let position = index(position, self.positions.len(), "vertex")?;
            let normal = normal.map(|normal| index(normal, self.normals.len(), "normal")).transpose()?;
            let (place, is_new) = self.vertices.place((position, normal));
            if is_new {
                self.used.push((position, normal));
            }
            corners.push(place);
        }
        if corners.len() < 3 {
            return Err("expected a face f with three corners or more".into());
        }
        self.triangles.extend(fan(&corners));
        Ok(())
    }

    fn mesh(self) -> MeshDescription {
        let (mut colors, mut normals) = (None, None);
        if self.colors.iter().any(Option::is_some) {
            let color = |&(position, _): &(usize, _)| self.colors[position].unwrap_or([1.0; 4]);
            colors = Some(self.used.iter().map(color).collect());
        }
        if self.used.iter().any(|(_, normal)| normal.is_some()) {
            let normal = |&(_, normal): &(_, Option<usize>)| normal.map_or([0.0; 3], |normal| self.normals[normal]);
            normals = Some(self.used.iter().map(normal).collect());
        }
        let vertices = self.used.iter().map(|&(position, _)| self.positions[position]).collect();
        MeshDescription { vertices, triangles: self.triangles, colors, normals }
    }
}

/// A number of a file, counted from 1, or backwards from -1, as an index.
fn index(word: &str, count: usize, what: &str) -> Result<usize, String> {
    let number: i64 =
        word.parse().map_err(|_| format!("expected the number of a {what} instead of {}", shown(word)))?;
    let index = if number < 0 { number.saturating_add_unsigned(count as u64) } else { number - 1 };
    let index = usize::try_from(index).ok().filter(|&index| number != 0 && index < count);
    index.ok_or_else(|| format!("expected a {what} from 1 to {count} instead of {number}"))
}

#[cfg(test)]
mod tests {
    use super::super::testing::damage;
    use super::*;

    #[test]
    fn polygons_are_fans_and_numbers_may_be_negative() {
        let text = "# a quad\no quad\nv 0 0 0\nv 1 0 0 # second\nv 1 1 0 1.0\nv 0 1 0\nusemtl red\n\
                    f 1/7 2/8 \\\n 3/9 4/1\nf -4 -3 -2\n";
        let description = read(text.as_bytes()).unwrap();
        assert_eq!(description.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        assert_eq!(description.vertices, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!((description.colors, description.normals), (None, None));
    }

    #[test]
    fn a_vertex_has_one_normal() {
        let text = "v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nvn 0 2 0\n\
                    f 1//1 2//1 3//1\nf 1/1/2 4//-1 2/5\n";
        let description = read(text.as_bytes()).unwrap();
        assert_eq!(description.triangles, [[0, 1, 2], [3, 4, 5]]);
        let [z, y, none] = [[0.0, 0.0, 1.0], [0.0, 2.0, 0.0], [0.0; 3]];
        assert_eq!(description.normals.unwrap(), [z, z, z, y, y, none]);
        assert_eq!(description.vertices[3..], [[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        let [red, green, white] = [[1.0, 0.0, 0.0, 1.0], [0.0, 0.5, 0.0, 1.0], [1.0; 4]];
        assert_eq!(description.colors.unwrap(), [red, green, white, red, white, green]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |face: &str| read(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}").as_bytes()).unwrap_err().to_string();
        assert_eq!(error("f 1 2 4"), "line 4: \"f 1 2 4\", expected a vertex from 1 to 3 instead of 4");
        assert_eq!(error("f 1 2 0"), "line 4: \"f 1 2 0\", expected a vertex from 1 to 3 instead of 0");
        assert_eq!(error("f 1 2 -4"), "line 4: \"f 1 2 -4\", expected a vertex from 1 to 3 instead of -4");
        let smallest = i64::MIN;
        assert!(error(&format!("f 1 2 {smallest}")).ends_with("from 1 to 3 instead of -9223372036854775808"));
        assert_eq!(error("f 1 2 x"), "line 4: \"f 1 2 x\", expected the number of a vertex instead of \"x\"");
        assert_eq!(error("f 1//1 2 3"), "line 4: \"f 1//1 2 3\", expected a normal from 1 to 0 instead of 1");
        assert_eq!(error("f 1 2"), "line 4: \"f 1 2\", expected a face f with three corners or more");
        assert_eq!(error("vn 1 2"), "line 4: \"vn 1 2\", expected a normal vn x y z");
    }

    #[test]
    fn damaged_files_do_no_harm() {
        damage(b"v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//-1 \\\n3//1 1/2/1\nf -1 -2 -3\n", read);
    }
}
