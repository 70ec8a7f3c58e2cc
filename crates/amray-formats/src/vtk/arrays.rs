//! Arrays as fields: a field for each component, and values that VTK hides.

use amray::hierarchy::{BrickValues, Centering, Voxel, VoxelType};

use crate::store::Store;
use crate::{FieldInfo, FormatError};

/// The array of flags, one for each cell or point.
pub(super) const FLAGS: &str = "vtkGhostType";

/// Both formats' name for the arrays of cells or of points.
pub(super) fn section(centering: Centering) -> &'static str {
    match centering {
        Centering::Cells => "CellData",
        Centering::Nodes => "PointData",
    }
}

/// Where a field is in a file: one component of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Component {
    /// The array's name.
    pub(super) array: String,
    pub(super) centering: Centering,
    /// The number of components of the array, and which one it is.
    pub(super) components: u64,
    pub(super) component: u64,
}

/// An array as a file states it.
pub(super) struct StatedArray<'a> {
    pub(super) name: &'a str,
    pub(super) centering: Centering,
    pub(super) components: u64,
    pub(super) voxel_type: VoxelType,
}

/// More components than these are no field of anything.
const MOST_COMPONENTS: u64 = 64;

/// The fields of arrays, in their order: `velocity_x` and so on for the components of a vector. Flags are no field; nor are
/// arrays without a name. An array at points whose name a cell's has too gets `_points` behind it.
pub(super) fn fields<'a>(arrays: impl IntoIterator<Item = StatedArray<'a>>) -> (Vec<FieldInfo>, Vec<Component>) {
    let mut fields: Vec<FieldInfo> = Vec::new();
    let mut places = Vec::new();
    for StatedArray { name, centering, components, voxel_type } in arrays {
        if name == FLAGS || name.is_empty() || name.contains(char::is_control) || components > MOST_COMPONENTS {
            continue;
        }
        for component in 0..components {
            let mut field = match (components, component) {
                (1, _) => name.to_owned(),
                (2 | 3, component) => format!("{name}_{}", ["x", "y", "z"][component as usize]),
                (_, component) => format!("{name}_{component}"),
            };
            while fields.iter().any(|other| other.name == field) {
                field.push_str("_points");
            }
            fields.push(FieldInfo { name: field, voxel_type, unit: None });
            places.push(Component { array: name.to_owned(), centering, components, component });
        }
    }
    (fields, places)
}

/// The values without those that the flags hide: they become NaN, which shows nothing.
///
/// # Errors
/// [`FormatError::Io`] where the store cannot keep them.
pub(super) fn without_hidden<T: Voxel>(
    values: BrickValues<T>,
    flags: &[u8],
    centering: Centering,
    store: &Store,
) -> Result<BrickValues<T>, FormatError> {
    // `vtkDataSetAttributes`: HIDDENCELL and HIDDENPOINT. Cells that finer ones refine, or that are copies of another
    // brick's, have flags too: what stands in them does no harm.
    let hidden = match centering {
        Centering::Cells => 32,
        Centering::Nodes => 2,
    };
    if flags.iter().all(|flag| flag & hidden == 0) {
        return Ok(values);
    }
    let mut shown = values.to_vec();
    for (value, flag) in shown.iter_mut().zip(flags) {
        if flag & hidden != 0 {
            *value = T::from_f64(f64::NAN);
        }
    }
    store.keep(shown, values.size())
}
