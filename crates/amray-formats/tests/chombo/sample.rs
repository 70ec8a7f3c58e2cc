//! Small Chombo files, written with a library that the reader does not use, that tests change one thing in.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rust_hdf5::format::messages::datatype::{CompoundMember, DatatypeMessage};
use rust_hdf5::{FileLocking, H5File, H5Group, H5Type};
use tempfile::TempDir;

/// A file to be written: attributes and data sets by their path.
#[derive(Clone)]
pub(crate) struct Sample {
    pub(crate) attributes: BTreeMap<String, Attribute>,
    pub(crate) sets: BTreeMap<String, Set>,
}

#[derive(Clone)]
pub(crate) enum Attribute {
    Integer(i32),
    Real(f64),
    Text(&'static str),
    Box([i32; 6]),
    IntegerVector([i32; 3]),
    RealVector([f64; 3]),
}

#[derive(Clone)]
pub(crate) enum Set {
    Boxes(Vec<[i32; 6]>),
    Integers(Vec<i64>),
    Singles(Vec<f32>),
    Doubles(Vec<f64>),
    /// With the chunks' length.
    Chunked(Vec<f64>, usize),
}

/// The value that samples give a cell; exact in single precision.
pub(crate) fn value(component: usize, level: usize, [i, j, k]: [i64; 3]) -> f64 {
    i as f64 + 16.0 * j as f64 + 256.0 * k as f64 + 4096.0 * component as f64 + level as f64 / 2.0
}

impl Sample {
    /// Levels of ratio 2 with two components, and ghost layers that hold no number. Level 0 has two boxes.
    pub(crate) fn new(levels: usize, ghosts: [i32; 3]) -> Self {
        Self::centered(levels, ghosts, 0)
    }

    /// [`Sample::new`] with values at nodes.
    pub(crate) fn nodal(levels: usize, ghosts: [i32; 3]) -> Self {
        let mut sample = Self::centered(levels, ghosts, 1);
        sample.attribute("data_centering", Attribute::Integer(7));
        sample
    }

    /// With so many more values than cells per axis of each box.
    fn centered(levels: usize, ghosts: [i32; 3], more: i32) -> Self {
        let mut sample = Self { attributes: BTreeMap::new(), sets: BTreeMap::new() };
        sample.attribute("Chombo_global/SpaceDim", Attribute::Integer(3));
        sample.attribute("num_levels", Attribute::Integer(levels as i32));
        sample.attribute("num_components", Attribute::Integer(2));
        sample.attribute("component_0", Attribute::Text("density"));
        sample.attribute("component_1", Attribute::Text("x-momentum"));
        sample.attribute("Expressions/scalar pressure", Attribute::Text("(gamma-1)*<x-momentum>"));
        for level in 0..levels {
            let group = format!("level_{level}");
            let last = (4 << level) - 1;
            sample.attribute(&format!("{group}/dx"), Attribute::Real(0.5f64.powi(level as i32)));
            sample.attribute(&format!("{group}/ref_ratio"), Attribute::Integer(2));
            sample.attribute(&format!("{group}/prob_domain"), Attribute::Box([0, 0, 0, last, last, last]));
            sample.attribute(&format!("{group}/data_attributes/comps"), Attribute::Integer(2));
            sample.attribute(&format!("{group}/data_attributes/ghost"), Attribute::IntegerVector([9; 3]));
            sample.attribute(&format!("{group}/data_attributes/outputGhost"), Attribute::IntegerVector(ghosts));
            let boxes = match level {
                0 => vec![[0, 0, 0, 2, 3, 3], [3, 0, 0, 3, 3, 3]],
                _ => vec![[0, 0, 0, 3, 3, 3]],
            };
            let mut values = Vec::new();
            let mut offsets = vec![0];
            for cells in &boxes {
                for component in 0..2 {
                    let [i, j, k, last_i, last_j, last_k] = *cells;
                    let places = [i, j, k, last_i + more, last_j + more, last_k + more];
                    values.extend(box_values(component, level, &places, ghosts));
                }
                offsets.push(values.len() as i64);
            }
            sample.set(&format!("{group}/boxes"), Set::Boxes(boxes));
            sample.set(&format!("{group}/data:offsets=0"), Set::Integers(offsets));
            sample.set(&format!("{group}/data:datatype=0"), Set::Doubles(values));
        }
        sample
    }

    pub(crate) fn attribute(&mut self, path: &str, attribute: Attribute) {
        self.attributes.insert(path.into(), attribute);
    }

    pub(crate) fn set(&mut self, path: &str, set: Set) {
        self.sets.insert(path.into(), set);
    }

    /// A level's values, as doubles.
    pub(crate) fn values(&self, level: usize) -> Vec<f64> {
        match &self.sets[&format!("level_{level}/data:datatype=0")] {
            Set::Doubles(values) => values.clone(),
            _ => panic!("the values are no longer doubles"),
        }
    }

    /// Writes the file into a directory of its own, which must be kept as long as the file is needed.
    pub(crate) fn write(&self) -> (TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sample.hdf5");
        let file = H5File::options().locking(FileLocking::BestEffort).create(&path).unwrap();
        let mut groups = BTreeMap::from([(String::new(), file.root_group())]);
        for (path, attribute) in &self.attributes {
            let (group, name) = split(path);
            attribute.write(group_at(&mut groups, group), name);
        }
        for (path, set) in &self.sets {
            let (group, name) = split(path);
            set.write(group_at(&mut groups, group), name);
        }
        drop(groups);
        file.close().unwrap();
        (directory, path)
    }
}

fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('/').unwrap_or(("", path))
}

fn group_at<'a>(groups: &'a mut BTreeMap<String, H5Group>, path: &str) -> &'a H5Group {
    if !groups.contains_key(path) {
        let (parent, name) = split(path);
        let group = group_at(groups, parent).create_group(name).unwrap();
        groups.insert(path.into(), group);
    }
    &groups[path]
}

fn box_values(component: usize, level: usize, cells: &[i32; 6], ghosts: [i32; 3]) -> Vec<f64> {
    let range = |axis: usize| cells[axis] - ghosts[axis]..=cells[axis + 3] + ghosts[axis];
    let inside = |cell: [i32; 3]| (0..3).all(|axis| (cells[axis]..=cells[axis + 3]).contains(&cell[axis]));
    let mut values = Vec::new();
    for k in range(2) {
        for j in range(1) {
            values.extend(range(0).map(|i| match inside([i, j, k]) {
                true => value(component, level, [i, j, k].map(i64::from)),
                false => f64::NAN,
            }));
        }
    }
    values
}

fn compound(names: &[&str], datatype: &DatatypeMessage, size: u32, element: u32) -> DatatypeMessage {
    let member = |(number, name): (usize, &&str)| CompoundMember {
        name: (*name).to_owned(),
        offset: number as u32 * element,
        datatype: datatype.clone(),
    };
    DatatypeMessage::compound(size, names.iter().enumerate().map(member).collect())
}

/// Chombo's boxes have 28 bytes: six integers and padding.
fn box_type() -> DatatypeMessage {
    compound(&["lo_i", "lo_j", "lo_k", "hi_i", "hi_j", "hi_k"], &i32::hdf5_type(), 28, 4)
}

fn box_bytes(corners: &[i32; 6]) -> impl Iterator<Item = u8> {
    corners.iter().flat_map(|corner| corner.to_le_bytes()).chain([0xee; 4]).collect::<Vec<_>>().into_iter()
}

impl Attribute {
    fn write(&self, group: &H5Group, name: &str) {
        let integers = compound(&["intvecti", "intvectj", "intvectk"], &i32::hdf5_type(), 12, 4);
        let reals = compound(&["x", "y", "z"], &f64::hdf5_type(), 24, 8);
        let result = match self {
            Self::Integer(value) => group.set_attr_numeric(name, value),
            Self::Real(value) => group.set_attr_numeric(name, value),
            Self::Text(text) => {
                // As Chombo does: as long as the text, without room for a NUL.
                let datatype = DatatypeMessage::FixedString { size: text.len() as u32, padding: 0, charset: 0 };
                group.set_attr_typed(name, datatype, text.as_bytes().to_vec())
            }
            Self::Box(corners) => group.set_attr_typed(name, box_type(), box_bytes(corners).collect()),
            Self::IntegerVector(values) => {
                group.set_attr_typed(name, integers, values.iter().flat_map(|value| value.to_le_bytes()).collect())
            }
            Self::RealVector(values) => {
                group.set_attr_typed(name, reals, values.iter().flat_map(|value| value.to_le_bytes()).collect())
            }
        };
        result.unwrap();
    }
}

impl Set {
    fn write(&self, group: &H5Group, name: &str) {
        match self {
            Self::Boxes(boxes) => {
                let set = group.new_dataset::<u8>().datatype(box_type()).shape([boxes.len()]).create(name).unwrap();
                if !boxes.is_empty() {
                    set.write_raw_bytes(&boxes.iter().flat_map(box_bytes).collect::<Vec<_>>()).unwrap();
                }
            }
            Self::Integers(values) => write_contiguous(group, name, values),
            Self::Singles(values) => write_contiguous(group, name, values),
            Self::Doubles(values) => write_contiguous(group, name, values),
            Self::Chunked(values, chunk) => {
                let set = group.new_dataset::<f64>().shape([values.len()]).chunk(&[*chunk]).resizable();
                let set = set.create(name).unwrap();
                for (number, values) in values.chunks(*chunk).enumerate() {
                    let mut bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
                    bytes.resize(chunk * 8, 0xee);
                    set.write_chunk(number, &bytes).unwrap();
                }
            }
        }
    }
}

fn write_contiguous<T: H5Type>(group: &H5Group, name: &str, values: &[T]) {
    let set = group.new_dataset::<T>().shape([values.len()]).create(name).unwrap();
    if !values.is_empty() {
        set.write_raw(values).unwrap();
    }
}
