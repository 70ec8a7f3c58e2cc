//! Readers of structured volumes against files written here, and damaged ones.

use std::io::Write;
use std::path::Path;

use amray::hierarchy::VoxelType;
use amray_formats::FormatError;
use amray_formats::structured::{ByteOrder, NumberType, RawLayout, StructuredVolume};
use flate2::Compression;
use flate2::write::GzEncoder;
use proptest::prelude::*;
use proptest::sample::Index;

use super::{file, read_all};

/// Samples along x, y and z of all files here.
const SIZE: [usize; 3] = [4, 3, 5];
const COUNT: i16 = 60;

/// x fastest.
fn numbers() -> Vec<f64> {
    (0..COUNT).map(f64::from).collect()
}

fn shorts(order: ByteOrder) -> Vec<u8> {
    match order {
        ByteOrder::Little => (0..COUNT).flat_map(i16::to_le_bytes).collect(),
        ByteOrder::Big => (0..COUNT).flat_map(i16::to_be_bytes).collect(),
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn nrrd(fields: &str, samples: &[u8]) -> Vec<u8> {
    let start = "NRRD0004\n# by hand\ntype: short\ndimension: 3\nsizes: 4 3 5\nendian: little\nkey:=value: 1\n";
    [start.as_bytes(), fields.as_bytes(), b"\n\n", samples].concat()
}

fn npy(order: &str, shape: &str, descriptor: &str, samples: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descriptor}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    [b"\x93NUMPY\x01\0", &(header.len() as u16).to_le_bytes()[..], header.as_bytes(), samples].concat()
}

/// A NIfTI header. Places are bytes from its start.
struct Header {
    order: ByteOrder,
    bytes: Vec<u8>,
}

impl Header {
    fn put<const N: usize>(&mut self, place: usize, mut little: [u8; N]) {
        if self.order == ByteOrder::Big {
            little.reverse();
        }
        self.bytes[place..place + N].copy_from_slice(&little);
    }

    fn short(&mut self, place: usize, value: i16) {
        self.put(place, value.to_le_bytes());
    }

    fn float(&mut self, place: usize, value: f32) {
        self.put(place, value.to_le_bytes());
    }
}

/// A header with something changed, and 16-bit samples behind it.
fn nifti(order: ByteOrder, change: impl Fn(&mut Header)) -> Vec<u8> {
    let mut header = Header { order, bytes: vec![0; 352] };
    header.put(0, 348i32.to_le_bytes());
    for (axis, length) in [3, 4, 3, 5].into_iter().enumerate() {
        header.short(40 + 2 * axis, length);
    }
    header.short(70, 4);
    for (axis, width) in [1.0, 0.5, 2.0, 1.5].into_iter().enumerate() {
        header.float(76 + 4 * axis, width);
    }
    header.float(108, 352.0);
    header.bytes[344..348].copy_from_slice(b"n+1\0");
    change(&mut header);
    [header.bytes, shorts(order)].concat()
}

fn opened(name: &str, content: &[u8]) -> (StructuredVolume, Vec<f64>) {
    let (_directory, path) = file(name, content);
    let volume = StructuredVolume::open(&path, None).unwrap_or_else(|error| panic!("{error}"));
    assert!(StructuredVolume::recognises(&path).unwrap());
    assert_eq!(volume.size(), SIZE);
    let values = read_all(&volume, 2).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read_all::<f64>(&volume, 5).unwrap(), values);
    (volume, values)
}

/// The error that opening the file or reading its samples gives, without the path.
fn failure(name: &str, content: &[u8]) -> String {
    let (_directory, path) = file(name, content);
    let error = look(&path).unwrap_err().to_string();
    error.strip_prefix(&format!("{}: ", path.display())).expect("an error starts with the path").to_owned()
}

/// Opens a file that claims to be no larger than its bytes may be, and reads it.
fn look(path: &Path) -> Result<(), FormatError> {
    let volume = StructuredVolume::open(path, None)?;
    // A claim about compressed samples is found out slice by slice.
    if volume.sample_count() < 1 << 20 {
        read_all::<f64>(&volume, 1)?;
    }
    Ok(())
}

#[test]
fn nrrd_in_every_encoding() {
    let little = shorts(ByteOrder::Little);
    let (volume, values) = opened("a.nrrd", &nrrd("encoding: raw\nspacings: 0.5 2 1.5", &little));
    assert_eq!((values, volume.spacing(), volume.origin()), (numbers(), [0.5, 2.0, 1.5], [0.0; 3]));
    assert_eq!((volume.format(), volume.number_type(), volume.voxel_type()), ("NRRD", NumberType::I16, VoxelType::F32));
    let fields = "encoding: gzip\nspace directions: (0.5,0,0) (0,2,0) (0,0,1.5)\nspace origin: (1,-2,3e1)";
    let (volume, values) = opened("a.nrrd", &nrrd(fields, &gzip(&little)));
    assert_eq!((values, volume.spacing(), volume.origin()), (numbers(), [0.5, 2.0, 1.5], [1.0, -2.0, 30.0]));
    let text: Vec<String> = (0..COUNT).map(|number| number.to_string()).collect();
    assert_eq!(opened("a.nrrd", &nrrd("encoding: text", text.join(" ").as_bytes())).1, numbers());
    assert_eq!(opened("a.nrrd", &nrrd("Encoding: ASCII", text.join(",\n").as_bytes())).1, numbers());
    let skipped = [b"12345", &little[..]].concat();
    assert_eq!(opened("a.nrrd", &nrrd("encoding: raw\nbyte skip: 5", &skipped)).1, numbers());
    let big = String::from_utf8(nrrd("encoding: raw", b"")).unwrap().replace("little", "big").replace('\n', "\r\n");
    assert_eq!(opened("a.nrrd", &[big.as_bytes(), &shorts(ByteOrder::Big)].concat()).1, numbers());
}

#[test]
fn detached_headers_name_their_samples() {
    let (directory, path) = file("a.nhdr", &nrrd("encoding: raw\ndata file: a.raw", b""));
    std::fs::write(directory.path().join("a.raw"), shorts(ByteOrder::Little)).unwrap();
    let volume = StructuredVolume::open(&path, None).unwrap();
    assert_eq!(read_all::<f32>(&volume, 3).unwrap(), numbers().iter().map(|&n| n as f32).collect::<Vec<_>>());
    assert_eq!(volume.sample_file(), directory.path().join("a.raw"));
    // Without an empty line, too.
    std::fs::write(&path, nrrd("encoding: raw\ndatafile: ./a.raw", b"").trim_ascii_end()).unwrap();
    assert!(StructuredVolume::open(&path, None).is_ok());
    for name in ["/etc/passwd", "../a.raw", "LIST", "missing.raw", "."] {
        let error = failure("a.nhdr", &nrrd(&format!("encoding: raw\ndata file: {name}"), b""));
        assert!(error.starts_with("data file: "), "{error}");
    }
}

#[test]
fn nrrd_that_is_not_read_says_why() {
    let error = |from: &str, to: &str| {
        let text = String::from_utf8(nrrd("encoding: raw\nspacings: 1 1 1", b"")).unwrap();
        assert!(text.contains(from));
        failure("a.nrrd", &[text.replace(from, to).as_bytes(), &shorts(ByteOrder::Little)].concat())
    };
    assert_eq!(error("dimension: 3", "dimension: 4"), "dimension: \"4\", expected 3");
    assert_eq!(error("type: short", "type: block"), "type: \"block\" is not known");
    assert_eq!(error("sizes: 4 3 5", "sizes: 4 3"), "sizes: \"4 3\" is not known");
    assert!(error("sizes: 4 3 5", "sizes: 4 0 5").starts_with("sizes: size [4, 0, 5], expected 1 to 2147483647"));
    assert!(error("sizes: 4 3 5", "sizes: 2000000000 2000000000 5").contains("samples per axis"));
    assert_eq!(error("raw", "bzip2"), "encoding: \"bzip2\" is not known");
    assert_eq!(error("endian: little\n", ""), "header: no field endian");
    assert!(error("spacings: 1 1 1", "spacings: 1 nan 1").starts_with("grid: the spacing is [1.0, NaN, 1.0]"));
    assert!(
        error("spacings: 1 1 1", "space directions: (1,0,0) (0,1,0.1) (0,0,1)").starts_with("space directions: [[")
    );
    assert!(error("spacings: 1 1 1", "space directions: (1,0,0) (0,-1,0) (0,0,1)").contains("upwards"));
    assert!(error("spacings: 1 1 1", "space directions: none (1,0,0) (0,0,1)").contains("expected three finite"));
    assert!(error("spacings: 1 1 1", "line skip: 1").starts_with("line skip: "));
    assert!(error("spacings: 1 1 1", "byte skip: -1").starts_with("byte skip: "));
    assert_eq!(error("type: short", "what is this"), "line 3: \"what is this\", expected `field: value`");
    let short = error("sizes: 4 3 5", "sizes: 4 4 5");
    assert!(short.ends_with("120 bytes from there on, expected 160 for 4 x 4 x 5 samples"), "{short}");
    let bad = failure("a.nrrd", &nrrd("encoding: text", format!("1 2 x4 {}", "5 ".repeat(99)).as_bytes()));
    assert_eq!(bad, "samples: \"x4\" is no number (sample 2 of these slices)");
    let long = failure("a.nrrd", &nrrd("encoding: text", &[b'1'; 500]));
    assert_eq!(long, "samples: a word too long for a number");
    let few = failure("a.nrrd", &nrrd("encoding: gzip", &gzip(&[0; 119])));
    assert_eq!(few, "samples: the file ends before the last of them");
}

#[test]
fn numpy_arrays_are_z_y_x_in_any_order() {
    for (order, mark) in [(ByteOrder::Little, "<i2"), (ByteOrder::Big, ">i2")] {
        let (volume, values) = opened("a.npy", &npy("False", "(5, 3, 4)", mark, &shorts(order)));
        assert_eq!((values, volume.spacing(), volume.origin()), (numbers(), [1.0; 3], [0.0; 3]));
        // The same array, first index fastest.
        let [width, height, depth] = [4, 3, 5];
        let transposed = (0..width).flat_map(|x| (0..height).flat_map(move |y| (0..depth).map(move |z| [x, y, z])));
        let bytes: Vec<u8> = transposed
            .map(|[x, y, z]: [i16; 3]| x + width * (y + height * z))
            .flat_map(|number| if order == ByteOrder::Big { number.to_be_bytes() } else { number.to_le_bytes() })
            .collect();
        assert_eq!(opened("a.npy", &npy("True", "(5, 3, 4)", mark, &bytes)).1, numbers());
    }
    let doubles: Vec<u8> = numbers().iter().flat_map(|number| number.to_le_bytes()).collect();
    let (volume, values) = opened("a.npy", &npy("False", "(5, 3, 4)", "<f8", &doubles));
    assert_eq!((values, volume.voxel_type()), (numbers(), VoxelType::F64));
    let error = |order, shape, mark| failure("a.npy", &npy(order, shape, mark, &doubles));
    let flat = error("False", "(15, 4)", "<f8");
    let expected = "'shape': (15, 4), }, expected a shape of three axes (z, y, x)";
    assert!(flat.starts_with("NumPy header: {'descr': '<f8'") && flat.ends_with(expected), "{flat}");
    assert!(error("False", "(5, 3, 4)", "<c16").ends_with("expected a descr that is one of integers or floats"));
    assert!(error("Maybe", "(5, 3, 4)", "<f8").ends_with("expected a fortran_order that is True or False"));
    let short = error("False", "(5, 4, 4)", "<f8");
    assert!(short.ends_with("480 bytes from there on, expected 640 for 4 x 4 x 5 samples"), "{short}");
    let far = [b"\x93NUMPY\x02\0", &u32::MAX.to_le_bytes()[..], &doubles].concat();
    assert_eq!(failure("a.npy", &far), "NumPy header: 4294967295 bytes long, expected at most 65536");
    assert!(failure("a.npy", b"\x93NUMPY").contains("expected version"));
}

#[test]
fn nifti_in_both_orders_and_compressed() {
    for order in [ByteOrder::Little, ByteOrder::Big] {
        let bytes = nifti(order, |_| ());
        for content in [&bytes, &gzip(&bytes)] {
            let (volume, values) = opened("a.nii", content);
            assert_eq!((values, volume.spacing(), volume.origin()), (numbers(), [0.5, 2.0, 1.5], [0.0; 3]));
            assert!(volume.warnings().is_empty() && volume.voxel_type() == VoxelType::F32);
        }
        let scaled = nifti(order, |header| {
            header.float(112, 2.0);
            header.float(116, -1.0);
        });
        let (volume, values) = opened("a.nii", &scaled);
        assert_eq!(values, numbers().iter().map(|number| 2.0 * number - 1.0).collect::<Vec<_>>());
        assert_eq!(volume.voxel_type(), VoxelType::F64);
    }
    let unscaled = nifti(ByteOrder::Little, |header| header.float(112, f32::NAN));
    assert_eq!(opened("a.nii", &unscaled).1, numbers());
}

#[test]
fn nifti_volumes_are_where_the_scanner_had_them_unless_turned() {
    let placed = |code: usize, across: f32| {
        let bytes = nifti(ByteOrder::Little, |header| {
            header.short(code, 1);
            for (axis, width) in [0.5, 2.0, 1.5].into_iter().enumerate() {
                header.float(280 + 16 * axis + 4 * axis, width);
                header.float(280 + 16 * axis + 12, axis as f32 + 1.0);
                header.float(268 + 4 * axis, axis as f32 + 4.0);
            }
            header.float(284, across);
            header.float(260, across);
        });
        let (volume, _) = opened("a.nii", &bytes);
        (volume.origin(), volume.warnings().len())
    };
    assert_eq!(placed(254, 0.0), ([1.0, 2.0, 3.0], 0));
    assert_eq!(placed(252, 0.0), ([4.0, 5.0, 6.0], 0));
    assert_eq!(placed(254, 0.3), ([0.0; 3], 1));
    assert_eq!(placed(252, 0.3), ([0.0; 3], 1));
}

#[test]
fn nifti_that_is_not_read_says_why() {
    let error = |change: &dyn Fn(&mut Header)| failure("a.nii", &nifti(ByteOrder::Little, change));
    assert_eq!(error(&|header| header.short(70, 32)), "NIfTI header: datatype 32, expected integers or floats");
    assert_eq!(error(&|header| header.short(40, 2)), "NIfTI header: 2 axes, expected 3");
    let movie = error(&|header| {
        header.short(40, 4);
        header.short(48, 7);
    });
    assert_eq!(movie, "NIfTI header: axes of [4, 3, 5, 7] samples, expected one volume of three axes");
    assert!(error(&|header| header.short(42, -4)).starts_with("NIfTI header: size [0, 3, 5], expected 1 to "));
    assert!(error(&|header| header.float(108, 10.0)).starts_with("NIfTI header: vox_offset 10, expected"));
    assert!(error(&|header| header.float(108, f32::NAN)).starts_with("NIfTI header: vox_offset NaN, expected"));
    assert!(error(&|header| header.float(84, 0.0)).starts_with("grid: the spacing is [0.5, 0.0, 1.5]"));
    assert!(error(&|header| header.short(46, 6)).contains("expected 144 for 4 x 3 x 6 samples"));
}

#[test]
fn raw_volumes_have_the_length_that_is_stated() {
    let (_directory, path) = file("a.raw", &shorts(ByteOrder::Big));
    let layout = RawLayout { size: [4, 3, 5], number_type: NumberType::I16, byte_order: ByteOrder::Big };
    let volume = StructuredVolume::open_raw(&path, &layout).unwrap();
    assert_eq!(read_all::<f64>(&volume, 2).unwrap(), numbers());
    let error = StructuredVolume::open_raw(&path, &RawLayout { size: [4, 3, 4], ..layout }).unwrap_err().to_string();
    assert!(error.ends_with("raw volume: 120 bytes, expected 96 for 4 x 3 x 4 samples of type i16"), "{error}");
    assert!(StructuredVolume::open_raw(&path, &RawLayout { size: [u64::MAX; 3], ..layout }).is_err());
    let placed = volume.placed(Some([1.0, 2.0, 3.0]), Some([0.5; 3])).unwrap();
    assert_eq!((placed.spacing(), placed.origin()), ([1.0, 2.0, 3.0], [0.5; 3]));
    assert!(placed.clone().placed(Some([0.0; 3]), None).is_err() && placed.placed(None, Some([f64::NAN; 3])).is_err());
    let error = StructuredVolume::open(&path, None).unwrap_err().to_string();
    assert!(error.ends_with("expected a structured volume (NRRD, NumPy, NIfTI, VTK ImageData)"), "{error}");
    assert!(!StructuredVolume::recognises(path.parent().unwrap()).unwrap());
    assert!(StructuredVolume::recognises(Path::new("/nonexistent")).is_err());
}

/// One file of each kind, and its name.
fn sound() -> Vec<(&'static str, Vec<u8>)> {
    let little = shorts(ByteOrder::Little);
    let text: Vec<String> = (0..COUNT).map(|number| number.to_string()).collect();
    let nifti = nifti(ByteOrder::Big, |header| header.short(254, 1));
    vec![
        ("raw.nrrd", nrrd("encoding: raw\nspace directions: (1,0,0) (0,1,0) (0,0,1)", &little)),
        ("gzip.nrrd", nrrd("encoding: gz\nspacings: 1 1 1\nspace origin: (1,2,3)", &gzip(&little))),
        ("text.nrrd", nrrd("encoding: txt", text.join(" ").as_bytes())),
        ("c.npy", npy("False", "(5, 3, 4)", "<i2", &little)),
        ("f.npy", npy("True", "(5, 3, 4)", "<i2", &little)),
        ("a.nii.gz", gzip(&nifti)),
        ("a.nii", nifti),
    ]
}

#[test]
fn truncated_files_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    for (name, content) in sound() {
        let path = directory.path().join(name);
        for length in 0..content.len() {
            std::fs::write(&path, &content[..length]).unwrap();
            match look(&path) {
                Err(error) => {
                    let error = error.to_string();
                    assert!(error.starts_with(path.to_str().unwrap()) && !error.contains('\n'), "{error:?}");
                }
                // The last number's last digit may be missed.
                Ok(()) => assert!(length + 1 == content.len() && name == "text.nrrd", "{name} of {length} bytes"),
            }
        }
        std::fs::write(&path, &content).unwrap();
        look(&path).unwrap();
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_are_read_or_refused(
        which in any::<Index>(),
        damage in proptest::collection::vec((any::<Index>(), any::<u8>()), 1..4),
    ) {
        let (name, mut content) = which.get(&sound()).clone();
        for (place, byte) in damage {
            let place = place.index(content.len());
            content[place] = byte;
        }
        let (_directory, path) = file(name, &content);
        if let Err(error) = look(&path) {
            let error = error.to_string();
            prop_assert!(!error.contains('\n'), "{:?}", error);
        }
    }
}
