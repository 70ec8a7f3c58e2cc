//! Files of every encoding, written by hand.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::super::testing::damage;
use super::*;

/// A quad and a strip over the same four points.
const POINTS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
const COLORS: [[u8; 3]; 4] = [[255, 0, 0], [0, 255, 0], [0, 0, 51], [255, 255, 255]];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Inline,
    AppendedRaw,
    AppendedBase64,
}

#[derive(Clone, Copy, Debug)]
struct Encoding {
    place: Place,
    is_big: bool,
    is_long: bool,
    compressor: &'static str,
}

fn base64(bytes: &[u8]) -> String {
    const CHARACTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let four = |three: &[u8]| {
        let bits = three.iter().fold(0, |bits, byte| bits << 8 | u32::from(*byte)) << (8 * (3 - three.len()));
        let character = |place: usize| match place <= three.len() {
            true => char::from(CHARACTERS[(bits >> (18 - 6 * place)) as usize & 63]),
            false => '=',
        };
        [0, 1, 2, 3].map(character)
    };
    bytes.chunks(3).flat_map(four).collect()
}

impl Encoding {
    fn number<const N: usize>(&self, little: [u8; N]) -> Vec<u8> {
        let mut bytes = little.to_vec();
        if self.is_big {
            bytes.reverse();
        }
        bytes
    }

    fn length(&self, length: usize) -> Vec<u8> {
        match self.is_long {
            true => self.number((length as u64).to_le_bytes()),
            false => self.number((length as u32).to_le_bytes()),
        }
    }

    /// An array as it is stored: the header, and the data. Compressed ones are in blocks of 16 bytes.
    fn stored(&self, data: &[u8]) -> [Vec<u8>; 2] {
        const BLOCK: usize = 16;
        let compress = |block: &[u8]| match self.compressor {
            "vtkZLibDataCompressor" => {
                let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                encoder.write_all(block).unwrap();
                encoder.finish().unwrap()
            }
            // A single run of literals.
            _ => [&[(block.len().min(15) as u8) << 4][..], if block.len() > 14 { &[1] } else { &[] }, block].concat(),
        };
        if self.compressor.is_empty() {
            return [self.length(data.len()), data.to_vec()];
        }
        let blocks: Vec<Vec<u8>> = data.chunks(BLOCK).map(compress).collect();
        let mut header = [blocks.len(), BLOCK, data.len() % BLOCK].map(|length| self.length(length)).concat();
        header.extend(blocks.iter().flat_map(|block| self.length(block.len())));
        [header, blocks.concat()]
    }

    fn file(&self) -> Vec<u8> {
        let mut appended = Vec::new();
        let mut array = |attributes: &str, data: Vec<u8>| {
            let [header, data] = self.stored(&data);
            // Headers of compressed data are encoded apart.
            let text = match self.compressor.is_empty() {
                true => base64(&[header.clone(), data.clone()].concat()),
                false => base64(&header) + &base64(&data),
            };
            let place = appended.len();
            let note = "<InformationKey name=\"RANGE\"><Value index=\"0\">7</Value></InformationKey>";
            match self.place {
                Place::Inline => {
                    return format!("<DataArray {attributes} format=\"binary\">\n {text}\n {note}</DataArray>\n");
                }
                Place::AppendedRaw => appended.extend([header, data].concat()),
                Place::AppendedBase64 => appended.extend(text.into_bytes()),
            }
            format!("<DataArray {attributes} format=\"appended\" offset=\"{place}\"/>\n")
        };
        let points = POINTS.as_flattened().iter().flat_map(|number| self.number(number.to_le_bytes())).collect();
        let mut integers = |name: &str, numbers: &[i64]| {
            let bytes = numbers.iter().flat_map(|number| self.number(number.to_le_bytes())).collect();
            array(&format!("type=\"Int64\" Name=\"{name}\""), bytes)
        };
        let polys = integers("connectivity", &[0, 1, 2, 3]) + &integers("offsets", &[4]);
        let strips = integers("connectivity", &[3, 2, 1, 0]) + &integers("offsets", &[4]);
        let unread = integers("values", &[1, 2, 3, 4]);
        let points = array("type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"", points);
        let colors = array("type=\"UInt8\" Name=\"RGB\" NumberOfComponents=\"3\"", COLORS.as_flattened().to_vec());

        let order = if self.is_big { "BigEndian" } else { "LittleEndian" };
        let length = if self.is_long { "UInt64" } else { "UInt32" };
        let compressor = self.compressor;
        let mut file = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" byte_order=\"{order}\" header_type=\"{length}\" \
             compressor=\"{compressor}\">\n<PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"1\" \
             NumberOfStrips=\"1\">\n<PointData Scalars=\"RGB\">{colors}</PointData>\n<CellData>{unread}</CellData>\n\
             <Points>{points}</Points>\n<Polys>{polys}</Polys>\n<Strips>{strips}</Strips></Piece></PolyData>\n"
        )
        .into_bytes();
        if self.place != Place::Inline {
            let encoding = if self.place == Place::AppendedRaw { "raw" } else { "base64" };
            file.extend(format!("<AppendedData encoding=\"{encoding}\">\n  _").into_bytes());
            file.extend(appended);
            file.extend(b"\n</AppendedData>");
        }
        file.extend(b"\n</VTKFile>\n");
        file
    }
}

fn expected() -> MeshDescription {
    let color = |color: [u8; 3]| [color[0], color[1], color[2], 255].map(|component| f32::from(component) / 255.0);
    MeshDescription {
        vertices: POINTS.map(|point| point.map(f64::from)).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [3, 2, 1], [1, 2, 0]],
        colors: Some(COLORS.map(color).into()),
        normals: None,
    }
}

fn encodings() -> impl Iterator<Item = Encoding> {
    let places = [Place::Inline, Place::AppendedRaw, Place::AppendedBase64];
    let compressors = ["", "vtkZLibDataCompressor", "vtkLZ4DataCompressor"];
    places.into_iter().flat_map(move |place| {
        compressors.into_iter().flat_map(move |compressor| {
            [(false, false), (true, true), (false, true)].map(|(is_big, is_long)| Encoding {
                place,
                is_big,
                is_long,
                compressor,
            })
        })
    })
}

const TEXT: &str = "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">
<PointData Normals=\"n\"><DataArray type=\"Float64\" Name=\"n\" NumberOfComponents=\"3\" format=\"ascii\">
0 0 1 0 0 1 0 0 2</DataArray><DataArray type=\"UInt8\" Name=\"Color\" NumberOfComponents=\"4\" format=\"ascii\">
255 0 0 51 255 0 0 51 255 0 0 51</DataArray></PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">
0 0 0 1 0 <InformationKey name=\"a\">4</InformationKey> 0 0 1 0 </DataArray></Points><Polys>
<DataArray type=\"Int32\" Name=\"connectivity\">0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\">3</DataArray>
</Polys></Piece><Piece NumberOfPoints=\"0\"/><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points>
<DataArray type=\"Float32\" NumberOfComponents=\"3\">5 0 0 6 0 0 5 1 0</DataArray></Points><Polys>
<DataArray type=\"Int32\" Name=\"connectivity\">0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\">3</DataArray>
</Polys></Piece></PolyData></VTKFile>";

#[test]
fn every_encoding_says_the_same() {
    for encoding in encodings() {
        let file = encoding.file();
        assert!(recognises(&file));
        assert_eq!(read(&file), Ok(expected()), "{encoding:?}");
    }
}

#[test]
fn pieces_are_joined() {
    let description = read(TEXT.as_bytes()).unwrap();
    assert_eq!(description.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(description.vertices[..4], [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 0.0, 0.0]]);
    assert_eq!(description.normals.unwrap()[2..4], [[0.0, 0.0, 2.0], [0.0; 3]]);
    assert_eq!(description.colors.unwrap()[2..4], [[1.0, 0.0, 0.0, 0.2], [1.0; 4]]);
}

#[test]
fn what_is_wrong_is_named() {
    let error = |from: &str, to: &str| {
        assert!(TEXT.contains(from));
        read(TEXT.replacen(from, to, 1).as_bytes()).unwrap_err().to_string()
    };
    assert_eq!(
        error("\"PolyData\"", "\"ImageData\""),
        "byte 0, element \"VTKFile\": the file's type is \"ImageData\", expected PolyData"
    );
    let lzma = error("\"PolyData\"", "\"PolyData\" compressor=\"vtkLZMADataCompressor\"");
    let expected = "expected vtkZLibDataCompressor, vtkLZ4DataCompressor or none";
    assert_eq!(
        lzma,
        format!("byte 0, element \"VTKFile\": the compressor \"vtkLZMADataCompressor\" is not known, {expected}")
    );
    assert_eq!(error("0 0 0 1", "0 0 1"), "piece 1, Points: there are 8 numbers, expected 9");
    assert_eq!(error("0 0 0 1", "0 0 x 1"), "piece 1, Points: \"x\", expected a number");
    let connectivity = "piece 1, Polys, array \"connectivity\"";
    assert_eq!(error(">0 1 2<", ">0 1 3<"), format!("{connectivity}: 3, expected one of 3 points"));
    assert_eq!(error(">0 1 2<", ">0 1 -1<"), format!("{connectivity}: -1, expected the number of a vertex"));
    assert_eq!(error(">3<", ">4<"), format!("{connectivity}: there are 3 numbers, expected 4"));
    assert_eq!(error("\"offsets\"", "\"ends\""), "piece 1, Polys, array \"offsets\": there is no such array");
    assert_eq!(error(">3<", ">3.5<"), "piece 1, Polys, array \"offsets\": 3.5, expected an end");
    let huge = error("NumberOfPoints=\"3\"", "NumberOfPoints=\"18446744073709551615\"");
    assert_eq!(huge, "piece 1, Points: there are 9 numbers, expected 55340232221128654845");
    assert!(error("</Piece>", "</Peace>").starts_with("byte "));
}

#[test]
fn damaged_files_do_no_harm() {
    damage(TEXT.as_bytes(), read);
    for encoding in encodings() {
        damage(&encoding.file(), read);
    }
}
