//! VTK ImageData: `.vti`, as VTK's and ParaView's XML writers make it, of one piece.

use std::path::Path;

use amray::hierarchy::Centering;
use amray_encoding::shown;

use super::samples::{Encoding, Fastest, Samples};
use super::{StructuredVolume, checked_size};
use crate::FormatError;
use crate::mapped_file;
use crate::vtk::{Image, ImageArray};

/// Opens the array `name` or, without one, the scalars that the file marks as active, else its first ones.
pub(super) fn open(path: &Path, name: Option<&str>) -> Result<StructuredVolume, FormatError> {
    let map = mapped_file::map(path)?;
    let image = Image::parse(path, &map)?;
    let (chosen, others) = choose(path, &image, name)?;
    let ImageArray { centering, array, .. } = chosen;
    let location = image.location(array)?;
    let size = checked_size(path, "Extent", image.size(*centering))?;
    let samples = Samples {
        path: path.into(),
        offset: location.start,
        encoding: Encoding::Vtk(location),
        number: array.number,
        order: image.byte_order(),
        scaling: None,
        size,
        fastest: Fastest::X,
    };
    let (spacing, corner) = (image.spacing(), image.corner());
    let origin = match centering {
        Centering::Cells => [0, 1, 2].map(|axis| corner[axis] + 0.5 * spacing[axis]),
        Centering::Nodes => corner,
    };
    let warnings = if others.is_empty() || name.is_some() {
        Vec::new()
    } else {
        vec![format!("array {} is taken, and not {}", shown(&array.name), others.join(", "))]
    };
    Ok(StructuredVolume { format: "VTK ImageData", samples: samples.checked()?, spacing, origin, warnings })
}

/// The array to take, and the names of the others.
fn choose<'a>(
    path: &Path,
    image: &'a Image<'_>,
    name: Option<&str>,
) -> Result<(&'a ImageArray, Vec<String>), FormatError> {
    let scalars = || image.arrays().iter().filter(|array| array.array.components == 1 && !array.is_flags());
    let names = || scalars().map(|array| array.array.name.clone()).collect::<Vec<_>>();
    let chosen = match name {
        Some(name) => scalars().find(|array| array.array.name == name),
        None => scalars().find(|array| array.is_active).or_else(|| scalars().next()),
    };
    match (chosen, name) {
        (Some(chosen), _) => {
            let others = scalars().filter(|other| !std::ptr::eq(*other, chosen));
            Ok((chosen, others.map(|other| shown(&other.array.name)).collect()))
        }
        (None, Some(name)) => Err(FormatError::unknown_field(path, name, names())),
        (None, None) => Err(FormatError::malformed(path, "Piece", "no array of scalars in its cells or at its points")),
    }
}
