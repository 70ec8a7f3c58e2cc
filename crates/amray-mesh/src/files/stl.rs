//! STL, binary and text: triangles with corners of their own, which are merged where they are at the same place.
//!
//! The normals of triangles are not read: they say nothing that the corners do not. Binary files may have colours, as
//! VisCAM and SolidView write them: 15 bits in the two bytes after each triangle.

use amray_encoding::shown;

use super::error::Problem;
use super::merge::Distinct;
use super::text::{lines, triple};
use crate::MeshDescription;

/// Text without meaning and the number of triangles.
const HEADER: usize = 84;
/// Normal, corners, colour.
const TRIANGLE: usize = 50;
const HAS_COLOR: u16 = 1 << 15;
const WHITE: u16 = HAS_COLOR | 0x7fff;

/// Corners that become a mesh.
#[derive(Debug, Default)]
struct Corners {
    distinct: Distinct<([u64; 3], u16)>,
    description: MeshDescription,
    colors: Vec<u16>,
}

/// Whether it is a text that says so, or a binary file of the right length.
pub(super) fn recognises(bytes: &[u8]) -> bool {
    is_text(bytes) || stated_length(bytes) == Some(bytes.len() as u64)
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshDescription, Problem> {
    // Many binary files begin with "solid" too: the length decides.
    match stated_length(bytes) {
        Some(length) if length == bytes.len() as u64 => Ok(binary(bytes)),
        _ if is_text(bytes) => text(bytes),
        Some(length) if length < bytes.len() as u64 => Ok(binary(&bytes[..length as usize])),
        Some(length) => {
            let (available, triangles) = (bytes.len(), (length - HEADER as u64) / TRIANGLE as u64);
            let problem = format!("the file has {available} bytes, expected {length} for its {triangles} triangles");
            Err(Problem::new("header", problem))
        }
        None => Err(Problem::new("header", format!("the file has {} bytes, expected at least {HEADER}", bytes.len()))),
    }
}

fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// How long a binary file with this header is.
fn stated_length(bytes: &[u8]) -> Option<u64> {
    let (_, count) = bytes.get(..HEADER)?.split_last_chunk::<4>()?;
    Some(HEADER as u64 + TRIANGLE as u64 * u64::from(u32::from_le_bytes(*count)))
}

fn binary(bytes: &[u8]) -> MeshDescription {
    let mut corners = Corners::default();
    let (triangles, _) = bytes[HEADER..].as_chunks::<TRIANGLE>();
    for triangle in triangles {
        let (numbers, attribute) = triangle.split_at(TRIANGLE - 2);
        let color = u16::from_le_bytes([attribute[0], attribute[1]]);
        let (numbers, _) = numbers.as_chunks::<4>();
        let numbers: [f32; 12] = std::array::from_fn(|place| f32::from_le_bytes(numbers[place]));
        let corner = |first: usize| [0, 1, 2].map(|axis| f64::from(numbers[first + axis]));
        corners.triangle([corner(3), corner(6), corner(9)], if color & HAS_COLOR != 0 { color } else { 0 });
    }
    corners.mesh()
}

fn text(bytes: &[u8]) -> Result<MeshDescription, Problem> {
    let mut corners = Corners::default();
    let mut open: Option<Vec<[f64; 3]>> = None;
    for (number, line) in lines(bytes, false) {
        let malformed = |expected: &str| Problem::at_line(number, format!("{}, expected {expected}", shown(&line)));
        let mut words = line.split_ascii_whitespace();
        let Some(word) = words.next() else { continue };
        match (word.to_ascii_lowercase().as_str(), &mut open) {
            ("outer", None) => open = Some(Vec::new()),
            ("vertex", Some(open)) => open.push(triple(&mut words).ok_or_else(|| malformed("vertex x y z"))?),
            ("endloop", Some(loop_corners)) => {
                let triangle = loop_corners.as_slice().try_into().map_err(|_| malformed("three vertices before it"))?;
                corners.triangle(triangle, 0);
                open = None;
            }
            ("solid" | "facet" | "endfacet" | "endsolid" | "color", None) => {}
            (_, None) => return Err(malformed("solid, facet, outer loop, endfacet or endsolid")),
            (_, Some(_)) => return Err(malformed("vertex or endloop")),
        }
    }
    match open {
        Some(_) => Err(Problem::new("end of file", "the file ends inside of a loop, expected endloop")),
        None => Ok(corners.mesh()),
    }
}

impl Corners {
    fn triangle(&mut self, corners: [[f64; 3]; 3], color: u16) {
        let places = corners.map(|corner| {
            // 0 and -0 are one place.
            let (place, is_new) = self.distinct.place((corner.map(|component| (component + 0.0).to_bits()), color));
            if is_new {
                self.description.vertices.push(corner);
                self.colors.push(color);
            }
            place
        });
        self.description.triangles.push(places);
    }

    fn mesh(self) -> MeshDescription {
        let mut description = self.description;
        if self.colors.iter().any(|color| color & HAS_COLOR != 0) {
            description.colors = Some(self.colors.into_iter().map(rgba).collect());
        }
        description
    }
}

/// Blue in the lowest five bits, then green, then red.
fn rgba(color: u16) -> [f32; 4] {
    let color = if color & HAS_COLOR != 0 { color } else { WHITE };
    let component = |shift: u16| f32::from(color >> shift & 31) / 31.0;
    [component(10), component(5), component(0), 1.0]
}

#[cfg(test)]
mod tests {
    use super::super::testing::damage;
    use super::*;

    const TEXT: &str =
        "solid two\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\r\n   vertex 0 1e0 0
  endloop\n endfacet\n FACET NORMAL 0 0 1\n  OUTER LOOP\n   vertex -0 1 0\n   vertex 1 0 0\n   VERTEX 1 1 0.5\n  endloop
 endfacet\nendsolid two\n";

    fn binary_file(header: &str, colors: [u16; 2]) -> Vec<u8> {
        let mut bytes = format!("{header:80}").into_bytes();
        bytes.extend(2u32.to_le_bytes());
        let triangles =
            [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[-0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5]]];
        for (triangle, color) in triangles.iter().zip(colors) {
            bytes.extend([0u8; 12]);
            bytes.extend(triangle.as_flattened().iter().flat_map(|number: &f32| number.to_le_bytes()));
            bytes.extend(color.to_le_bytes());
        }
        bytes
    }

    fn expected() -> MeshDescription {
        MeshDescription {
            vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]],
            triangles: vec![[0, 1, 2], [2, 1, 3]],
            ..MeshDescription::default()
        }
    }

    #[test]
    fn text_and_binary_say_the_same() {
        assert_eq!(read(TEXT.as_bytes()), Ok(expected()));
        assert_eq!(read(&binary_file("a file", [0, 7])), Ok(expected()));
        assert!(recognises(TEXT.as_bytes()) && recognises(&binary_file("a file", [0, 0])));
    }

    #[test]
    fn a_binary_file_may_call_itself_solid_and_have_more_at_its_end() {
        let mut bytes = binary_file("solid in binary", [0, 0]);
        assert_eq!(read(&bytes), Ok(expected()));
        bytes = binary_file("a file", [0, 0]);
        bytes.push(0);
        assert_eq!(read(&bytes), Ok(expected()));
    }

    #[test]
    fn colors_are_of_triangles() {
        let colors = [HAS_COLOR | 31 << 10 | 31, 0];
        let description = read(&binary_file("a file", colors)).unwrap();
        assert_eq!(description.vertices.len(), 6);
        let [purple, white] = [[1.0, 0.0, 1.0, 1.0], [1.0; 4]];
        assert_eq!(description.colors.unwrap(), [purple, purple, purple, white, white, white]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert_eq!(error(b"short"), "header: the file has 5 bytes, expected at least 84");
        let file = binary_file("a file", [0, 0]);
        assert_eq!(error(&file[..183]), "header: the file has 183 bytes, expected 184 for its 2 triangles");
        let text = |from: &str, to: &str| error(TEXT.replacen(from, to, 1).as_bytes());
        assert_eq!(text("vertex 0 0 0", "vertex 0 x 0"), "line 4: \"vertex 0 x 0\", expected vertex x y z");
        assert_eq!(text("vertex 0 0 0\n", "\n"), "line 7: \"endloop\", expected three vertices before it");
        assert_eq!(
            text("facet", "face"),
            "line 2: \"face normal 0 0 1\", expected solid, facet, outer loop, endfacet or endsolid"
        );
        assert_eq!(error(&TEXT.as_bytes()[..60]), "end of file: the file ends inside of a loop, expected endloop");
    }

    #[test]
    fn damaged_files_do_no_harm() {
        damage(TEXT.as_bytes(), read);
        damage(&binary_file("solid", [HAS_COLOR, 0]), read);
    }
}
