//! The groups, attributes and data sets of a Chombo file.

use rust_hdf5::format::messages::datatype::{CompoundMember, DatatypeMessage};
use rust_hdf5::{H5Group, H5Type, Hdf5Error};

use super::tables::{CellSize, LevelTable};
use super::{LevelWriter, data_centering};
use crate::AmrContent;
use crate::hdf5_output::{ValueList, set_text};

/// Chombo's box: six 32-bit integers and, as its own files have it, four unused bytes.
const BOX_BYTES: u32 = 28;
const BOX_MEMBERS: [&str; 6] = ["lo_i", "lo_j", "lo_k", "hi_i", "hi_j", "hi_k"];
const VECTOR_MEMBERS: [&str; 3] = ["intvecti", "intvectj", "intvectk"];

/// What the file says of all levels alike.
pub(super) struct Layout<'a> {
    pub(super) content: &'a AmrContent<'a>,
    /// The world position of cell (0, 0, 0), where it is not the world's origin.
    pub(super) origin: Option<[f64; 3]>,
}

impl Layout<'_> {
    /// Fills the root group of an empty file and reserves the place of its values.
    pub(super) fn write(&self, root: &H5Group, tables: Vec<LevelTable>) -> Result<Vec<LevelWriter>, Hdf5Error> {
        let AmrContent { components, centering, time, .. } = self.content;
        set_text(root, "filetype", "VanillaAMRFileType")?;
        root.set_attr_numeric("num_levels", &(tables.len() as i32))?;
        root.set_attr_numeric("max_level", &(tables.len() as i32 - 1))?;
        root.set_attr_numeric("num_components", &(components.len() as i32))?;
        root.set_attr_numeric("iteration", &0i32)?;
        root.set_attr_numeric("time", time)?;
        if let Some(centering) = data_centering(*centering) {
            root.set_attr_numeric("data_centering", &centering)?;
        }
        if let Some(origin) = self.origin {
            set_numbers(root, "origin", origin)?;
        }
        for (number, name) in components.iter().enumerate() {
            set_text(root, &format!("component_{number}"), name)?;
        }
        let global = root.create_group("Chombo_global")?;
        global.set_attr_numeric("SpaceDim", &3i32)?;
        global.set_attr_numeric("testReal", &0f64)?;
        let write_level = |(number, table)| self.write_level(&root.create_group(&format!("level_{number}"))?, table);
        tables.into_iter().enumerate().map(write_level).collect()
    }

    fn write_level(&self, group: &H5Group, table: LevelTable) -> Result<LevelWriter, Hdf5Error> {
        match table.cell_size {
            CellSize::Cubic(width) => {
                group.set_attr_numeric("dx", &width)?;
                group.set_attr_numeric("ref_ratio", &table.ratio[0])?;
            }
            CellSize::PerAxis(widths) => {
                set_numbers(group, "vec_dx", widths)?;
                set_vector(group, "vec_ref_ratio", table.ratio)?;
            }
        }
        group.set_attr_numeric("dt", &0f64)?;
        group.set_attr_numeric("time", &self.content.time)?;
        group.set_attr_typed("prob_domain", box_type(), box_bytes(&table.domain).collect())?;
        let attributes = group.create_group("data_attributes")?;
        attributes.set_attr_numeric("comps", &(self.content.components.len() as i32))?;
        set_vector(&attributes, "ghost", [0; 3])?;
        set_vector(&attributes, "outputGhost", [0; 3])?;
        set_text(&attributes, "objectType", "FArrayBox")?;

        let count = table.boxes.len();
        let boxes = group.new_dataset::<u8>().datatype(box_type()).shape([count]).create("boxes")?;
        let processors = group.new_dataset::<i32>().shape([count]).create("Processors")?;
        // Nothing is allocated for an empty data set, and writing to it fails.
        if count > 0 {
            boxes.write_raw_bytes(&table.boxes.iter().flat_map(box_bytes).collect::<Vec<u8>>())?;
            processors.write_raw(&vec![0i32; count])?;
        }
        group.new_dataset::<i64>().shape([count + 1]).create("data:offsets=0")?.write_raw(&table.offsets)?;
        let total = table.offsets[count] as usize;
        let values = ValueList::create(group, "data:datatype=0", total, self.content.voxel_type)?;
        Ok(LevelWriter { values, offsets: table.offsets })
    }
}

fn compound<T: H5Type>(names: &[&str], size: u32) -> DatatypeMessage {
    let members = names.iter().enumerate().map(|(place, &name)| CompoundMember {
        name: name.into(),
        offset: (place * size_of::<T>()) as u32,
        datatype: T::hdf5_type(),
    });
    DatatypeMessage::compound(size, members.collect())
}

fn box_type() -> DatatypeMessage {
    compound::<i32>(&BOX_MEMBERS, BOX_BYTES)
}

fn box_bytes(corners: &[i32; 6]) -> impl Iterator<Item = u8> + use<> {
    let padding = [0; BOX_BYTES as usize - 24];
    (*corners).into_iter().flat_map(i32::to_le_bytes).chain(padding)
}

fn set_vector(group: &H5Group, name: &str, values: [i32; 3]) -> Result<(), Hdf5Error> {
    let bytes = values.into_iter().flat_map(i32::to_le_bytes).collect();
    group.set_attr_typed(name, compound::<i32>(&VECTOR_MEMBERS, 12), bytes)
}

fn set_numbers(group: &H5Group, name: &str, values: [f64; 3]) -> Result<(), Hdf5Error> {
    let bytes = values.into_iter().flat_map(f64::to_le_bytes).collect();
    group.set_attr_typed(name, compound::<f64>(&["x", "y", "z"], 24), bytes)
}
