//! Files written by hand: what VTK's documentation allows and its own writers seldom make.

use std::fs;
use std::path::PathBuf;

use amray::hierarchy::{Centering, IndexBox, Residence};
use tempfile::TempDir;

use super::{opened, refused, values};

/// An image of 2 x 1 x 1 cells from `x` on, with more attributes, and what is in its piece.
fn image(x: f64, attributes: &str, piece: &str) -> String {
    format!(
        "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 2 0 1 0 1\" \
         Origin=\"{x} 0 0\" Spacing=\"1 1 1\" {attributes}><Piece Extent=\"0 2 0 1 0 1\">{piece}</Piece></ImageData>\
         </VTKFile>"
    )
}

fn array(name: &str, more: &str, numbers: &str) -> String {
    format!("<DataArray type=\"Float32\" Name=\"{name}\" format=\"ascii\" {more}>{numbers}</DataArray>")
}

const PHI: &str = "<CellData><DataArray type=\"Float32\" Name=\"phi\" format=\"ascii\">1 2</DataArray></CellData>";
const INDEX: &str = "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\"><vtkOverlappingAMR origin=\"10 0 0\">\
    <Block level=\"0\" spacing=\"1 1 1\"><DataSet index=\"0\" amr_box=\"0 1 0 0 0 0\" file=\"a/0.vti\"/>\
    <DataSet index=\"1\" amr_box=\"2 3 0 0 0 0\" file=\"a/1.vti\"/></Block></vtkOverlappingAMR></VTKFile>";

/// An index and its two images.
fn written(index: &str, images: [&str; 2]) -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    fs::create_dir(directory.path().join("a")).unwrap();
    for (number, image) in images.into_iter().enumerate() {
        fs::write(directory.path().join(format!("a/{number}.vti")), image).unwrap();
    }
    let path = directory.path().join("a.vthb");
    fs::write(&path, index).unwrap();
    (directory, path)
}

fn plain() -> [String; 2] {
    [image(10.0, "", PHI), image(12.0, "", PHI)]
}

fn boxes(path: &std::path::Path) -> ([f64; 3], Vec<IndexBox>) {
    let data = opened(path);
    (data.hierarchy().origin(), data.hierarchy().bricks().map(|brick| brick.cells).collect())
}

#[test]
fn old_indices_leave_places_to_the_images() {
    let images = plain();
    let images = [images[0].as_str(), images[1].as_str()];
    let (_directory, path) = written(INDEX, images);
    let expected = boxes(&path);
    assert_eq!(expected.0, [10.0, 0.0, 0.0]);
    let old = INDEX.replace("vtkOverlappingAMR", "vtkHierarchicalBoxDataSet");
    for index in [old.replace(" origin=\"10 0 0\"", ""), old.replace(" spacing=\"1 1 1\"", ""), old] {
        let (_directory, path) = written(&index, images);
        assert_eq!(boxes(&path), expected);
    }
}

#[test]
fn leaves_alone_find_their_places() {
    let index = "<VTKFile type=\"vtkNonOverlappingAMR\"><vtkNonOverlappingAMR><Block level=\"0\">\
        <DataSet index=\"0\" file=\"a/0.vti\"/></Block><Block level=\"1\"><DataSet index=\"0\" file=\"a/1.vti\"/></Block>\
        </vtkNonOverlappingAMR></VTKFile>";
    let nodes = array("at_nodes", "", "0 1 2 3 4 5 6 7 8 9 10 11");
    let coarse = image(10.0, "", &format!("{PHI}<PointData>{nodes}</PointData>"));
    // Two cells along each axis: one of the coarser ones.
    let fine = image(12.0, "", &PHI.replace("1 2", "1 2 3 4 5 6 7 8")).replace("1 0 1", "2 0 2");
    let fine = fine.replace("Spacing=\"1 1 1\"", "Spacing=\".5 .5 .5\"");
    let (_directory, path) = written(index, [&coarse, &fine]);
    let data = opened(&path);
    assert!(data.fields().len() == 1 && data.fields()[0].name == "phi");
    let levels = data.hierarchy().levels();
    assert_eq!((levels[0].ratio(), levels[1].ratio()), ([1; 3], [2; 3]));
    assert_eq!(data.hierarchy().bounds()[0], [10.0, 0.0, 0.0]);
}

#[test]
fn vectors_points_and_hidden_cells() {
    let velocity = array("velocity", "NumberOfComponents=\"3\"", "1 2 3 4 5 6");
    let tensor = array("t", "NumberOfComponents=\"4\"", "1 2 3 4 5 6 7 8");
    let flags = array("vtkGhostType", "", "8 32");
    let points = array("phi", "", "0 1 2 3 4 5 6 7 8 9 10 11");
    let first = format!("{velocity}{tensor}{flags}</CellData><PointData>{points}</PointData>");
    let first = image(10.0, "", &PHI.replace("</CellData>", &first));
    let second = first.replace("8 32", "1 0");
    let (_directory, path) = written(INDEX, [&first, &second]);
    let data = opened(&path);
    let names: Vec<&str> = data.fields().iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["phi", "velocity_x", "velocity_y", "velocity_z", "t_0", "t_1", "t_2", "t_3", "phi_points"]);
    let read = |number| data.read_field(number, &|_| {}).unwrap();
    let found = values(data.hierarchy(), &read(2));
    assert!(found[0][0] == 2.0 && found[0][1].is_nan() && found[1] == [2.0, 5.0], "{found:?}");
    let found = values(data.hierarchy(), &read(7));
    assert!(found[0][0] == 4.0 && found[1] == [4.0, 8.0], "{found:?}");
    assert_eq!(read(8).centering(), Centering::Nodes);
    assert_eq!(values(data.hierarchy(), &read(8))[1], (0..12).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn vectors_are_used_where_they_are() {
    let mut first = image(
        10.0,
        "",
        "<CellData><DataArray type=\"Float64\" Name=\"v\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/>\
         </CellData>",
    )
    .replace("</VTKFile>", "<AppendedData encoding=\"raw\"> _")
    .into_bytes();
    first.extend(48u32.to_le_bytes());
    first.extend((1..7).flat_map(|number| f64::from(number).to_le_bytes()));
    first.extend(b"</AppendedData></VTKFile>");
    let directory = tempfile::tempdir().unwrap();
    fs::create_dir(directory.path().join("a")).unwrap();
    let path = directory.path().join("a.vthb");
    fs::write(&path, INDEX).unwrap();
    for number in 0..2 {
        fs::write(directory.path().join(format!("a/{number}.vti")), &first).unwrap();
    }
    let data = opened(&path);
    let field = data.read_field(1, &|_| {}).unwrap();
    assert!(field.bytes(Residence::Mapped) > 0 && field.bytes(Residence::Owned) == 0);
    assert_eq!(values(data.hierarchy(), &field), [[2.0, 5.0], [2.0, 5.0]]);
    // One byte less than is needed.
    first.truncate(first.len() - "</AppendedData></VTKFile>".len() - 1);
    fs::write(directory.path().join("a/1.vti"), &first).unwrap();
    assert_eq!(refused(&path), "a/1.vti: array \"v\": the file ends before the array does");
}

#[test]
fn what_is_wrong_is_named() {
    let of = |index: &str, images: [&str; 2]| {
        let (_directory, path) = written(index, images);
        refused(&path)
    };
    let [first, second] = plain();
    let index = |from: &str, to: &str| {
        assert!(INDEX.contains(from));
        of(&INDEX.replacen(from, to, 1), [&first, &second])
    };
    let second = |from: &str, to: &str| {
        assert!(second.contains(from));
        of(INDEX, [&first, &second.replacen(from, to, 1)])
    };
    let error = index("origin=", "grid_description=\"XY_PLANE\" origin=");
    assert!(error.ends_with("grid_description is \"XY_PLANE\", expected XYZ (three dimensions)"), "{error}");
    let error = index("0 1 0 0 0 0", "0 1 0 0 0");
    assert!(error.ends_with("element \"DataSet\": amr_box is \"0 1 0 0 0\", expected 6 numbers"), "{error}");
    let error = index("a/0.vti", "../0.vti");
    assert!(error.ends_with("file is \"../0.vti\", expected one below the index's directory"), "{error}");
    assert!(index("a/0.vti", "a/7.vti").starts_with("a/7.vti: cannot open: "));
    assert_eq!(
        index("2 3 0 0 0 0", "2 4 0 0 0 0"),
        "a/1.vti: Extent: [2, 1, 1] cells, expected [3, 1, 1] as a.vthb says"
    );
    assert_eq!(
        index("spacing=\"1 1 1\"", "spacing=\"1 0 1\""),
        "a.vthb: level 0: no spacing, expected three positive numbers"
    );
    assert!(index("level=\"0\"", "level=\"4000000000\"").contains("level is 4000000000, expected less than 64"));
    assert!(index("\"2 3 0", "\"1 3 0").starts_with("a.vthb: "));
    assert_eq!(second("\"phi\"", "\"psi\""), "a/1.vti: array \"phi\": there is no such array");
    assert_eq!(second("1 2<", "1 2 3<"), "a/1.vti: array \"phi\": there are 3 numbers, expected 2");
    assert!(second("\"ImageData\"", "\"PolyData\"").ends_with("the file's type is \"PolyData\", expected ImageData"));
    assert!(second("Piece Extent=\"0 2", "Piece Extent=\"2 2").contains("expected a cell or more along each axis"));
    let error = second("Spacing=", "Direction=\"0 1 0 1 0 0 0 0 1\" Spacing=");
    assert!(error.contains("expected axes along x, y and z"), "{error}");
    let error = second("<Piece Extent=\"0 2 0 1 0 1\">", "<Piece/><Piece>");
    assert!(error.ends_with("2 pieces, expected 1"), "{error}");
}

#[test]
fn bricks_without_a_file_are_left_out() {
    let [first, second] = plain();
    let (_directory, path) = written(&INDEX.replace(" file=\"a/1.vti\"", ""), [&first, &second]);
    let data = opened(&path);
    assert_eq!(data.warnings(), ["level 0: 1 bricks have no file and are left out"]);
    assert_eq!(data.hierarchy().brick_count(), 1);
}
