//! PLY: a header that says which elements with which properties follow, as text or as numbers of either byte order.
//!
//! Read are the vertices' `x y z`, `nx ny nz` and `red green blue alpha`, the faces' `vertex_indices` (or
//! `vertex_index`), and the same of `tristrips`; everything else is passed over.

mod body;
mod header;
mod surface;

use super::error::Problem;
use crate::MeshDescription;
use body::Body;
use header::{Element, Header};
use surface::Surface;

pub(super) fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

pub(super) fn read(bytes: &[u8]) -> Result<MeshDescription, Problem> {
    let header = Header::parse(bytes)?;
    if !header.elements.iter().any(|element| element.name == "vertex") {
        return Err(Problem::new("header", "there is no element vertex"));
    }
    let mut body = Body::new(header.encoding, &bytes[header.bytes..]);
    let mut surface = Surface::default();
    for element in &header.elements {
        read_element(element, &mut body, &mut surface).map_err(|(row, problem)| {
            Problem::new(format!("element {}, number {row} of {}", element.name, element.count), problem)
        })?;
    }
    Ok(surface.mesh())
}

/// All of one kind of element; what is wrong, in words, and with which of them.
fn read_element(element: &Element, body: &mut Body<'_>, surface: &mut Surface) -> Result<(), (u64, String)> {
    let mut sink = surface.sink(element).map_err(|problem| (1, problem))?;
    body.holds(element).map_err(|problem| (1, problem))?;
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut list = Vec::new();
    for row in 0..element.count {
        for (place, property) in element.properties.iter().enumerate() {
            let at_row = |problem| (row + 1, problem);
            match property.length {
                None => sink.number(place, body.number(property.number).map_err(at_row)?),
                Some(length) => {
                    list.clear();
                    body.list(length, property.number, &mut list).map_err(at_row)?;
                    sink.list(place, &list).map_err(at_row)?;
                }
            }
        }
        sink.end_row();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::testing::damage;
    use super::*;

    const HEADER: &str = "comment made by hand
element camera 1
property float focus
property list uchar double path
element vertex 4
property float y
property float x
property uchar quality
property double z
property uchar red
property uchar green
property uchar blue
property short nx
property short ny
property short nz
element face 2
property uchar flags
property list uchar int vertex_indices
element tristrips 1
property list int int vertex_indices
end_header
";

    fn text() -> Vec<u8> {
        let body = "0.5 2 1 2\n0 0 9 0 255 0 0 0 0 1\n0 1 9 0 0 255 0 0 0 1\n1 1 9 0 0 0 51 0 0 1\n1 0 9 0.5 255 255 255 0 -2 1
7 4 0 1 2 3\n7 3 2 1 0\n9 0 1 2 3 -1 2 1 3 0\n";
        format!("ply\nformat ascii 1.0\n{HEADER}{body}").into_bytes()
    }

    fn binary(order: &str, line_end: &str) -> Vec<u8> {
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}").replace('\n', line_end).into_bytes();
        let mut put = |number: &[u8]| {
            let mut number = number.to_vec();
            if order == "little" {
                number.reverse();
            }
            bytes.extend(number);
        };
        put(&0.5f32.to_be_bytes());
        put(&[2]);
        put(&1f64.to_be_bytes());
        put(&2f64.to_be_bytes());
        let vertices = [
            ([0.0f32, 0.0], 0.0f64, [255u8, 0, 0], [0i16, 0, 1]),
            ([0.0, 1.0], 0.0, [0, 255, 0], [0, 0, 1]),
            ([1.0, 1.0], 0.0, [0, 0, 51], [0, 0, 1]),
            ([1.0, 0.0], 0.5, [255, 255, 255], [0, -2, 1]),
        ];
        for (yx, z, color, normal) in vertices {
            yx.iter().for_each(|number| put(&number.to_be_bytes()));
            put(&[9]);
            put(&z.to_be_bytes());
            color.iter().for_each(|number| put(&[*number]));
            normal.iter().for_each(|number| put(&number.to_be_bytes()));
        }
        for face in [&[0, 1, 2, 3][..], &[2, 1, 0]] {
            put(&[7]);
            put(&[face.len() as u8]);
            face.iter().for_each(|index: &i32| put(&index.to_be_bytes()));
        }
        [9i32, 0, 1, 2, 3, -1, 2, 1, 3, 0].iter().for_each(|number| put(&number.to_be_bytes()));
        bytes
    }

    #[test]
    fn text_and_both_byte_orders_say_the_same() {
        let expected = MeshDescription {
            vertices: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]],
            triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 0], [0, 1, 2], [2, 1, 3], [2, 1, 3], [3, 1, 0]],
            colors: Some(vec![[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 0.2, 1.0], [1.0; 4]]),
            normals: Some(vec![[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, -2.0, 1.0]]),
        };
        assert_eq!(read(&text()), Ok(expected.clone()));
        assert_eq!(read(&binary("little", "\n")), Ok(expected.clone()));
        assert_eq!(read(&binary("big", "\r\n")), Ok(expected));
    }

    #[test]
    fn elements_come_in_any_order_and_colors_may_be_fractions() {
        let text =
            "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar uint vertex_index\nelement nothing 4000000000
element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float red\nproperty float green
property float blue\nproperty float alpha\nend_header\n3 0 1 2\n0 0 0 1 0 0 0.5\n1 0 0 1 0 0 0.5\n0 1 0 1 0 0 1\n";
        let description = read(text.as_bytes()).unwrap();
        assert_eq!(description.triangles, [[0, 1, 2]]);
        assert_eq!(description.colors.unwrap()[1], [1.0, 0.0, 0.0, 0.5]);
        assert_eq!(description.normals, None);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |from: &str, to: &str| {
            let text = String::from_utf8(text()).unwrap();
            assert!(text.contains(from));
            read(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(
            error("ascii", "text"),
            "line 2: \"format text 1.0\", expected format ascii, binary_little_endian or binary_big_endian, and 1.0"
        );
        assert_eq!(
            error("short nx", "shorts nx"),
            "line 15: \"property shorts nx\", expected a property such as float x or list uchar int vertex_indices"
        );
        assert_eq!(error("element vertex", "element vertices"), "header: there is no element vertex");
        assert_eq!(
            error("property float x\n", "property float w\n"),
            "element vertex, number 1 of 4: there is no property x, expected x, y and z"
        );
        assert_eq!(
            error("element face 2", "element face 200000000000"),
            "element face, number 1 of 200000000000: 800000000000 bytes are needed at least, but the file has 44 more"
        );
        assert_eq!(error("7 4 0 1 2 3", "7 4 0 1 x 3"), "element face, number 1 of 2: \"x\", expected a number");
        assert_eq!(
            error("7 4 0 1 2 3", "7 4 0 1 -2 3"),
            "element face, number 1 of 2: -2, expected the number of a vertex"
        );
        assert_eq!(
            error("7 4 0 1 2 3", "7 4.5 0 1 2 3"),
            "element face, number 1 of 2: 4.5, expected the length of a list"
        );
        assert_eq!(
            error("9 0 1 2 3 -1", "99 0 1 2 3 -1"),
            "element tristrips, number 1 of 1: a list of 99 numbers needs 198 bytes at least, but the file has 20 more"
        );
        assert_eq!(
            error("end_header", "end"),
            "line 23: \"end\", expected a line of a header such as element vertex 8"
        );
        let file = binary("little", "\n");
        let end = read(&file[..file.len() - 1]).unwrap_err().to_string();
        assert!(
            end.starts_with("element tristrips, number 1 of 1: a list of 9 numbers needs 36 bytes at least"),
            "{end}"
        );
    }

    #[test]
    fn damaged_files_do_no_harm() {
        damage(&text(), read);
        damage(&binary("little", "\n"), read);
    }
}
