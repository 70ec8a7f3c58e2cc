//! Numbers as files store them, and as amray's cells hold them.

use amray::hierarchy::VoxelType;
pub use amray_encoding::{ByteOrder, NumberType};

/// The smaller of amray's number types that holds every such number; but integers of eight bytes are rounded from 2^53 on.
pub(crate) fn voxel_type(number: NumberType) -> VoxelType {
    match number {
        NumberType::I8 | NumberType::U8 | NumberType::I16 | NumberType::U16 | NumberType::F32 => VoxelType::F32,
        NumberType::I32 | NumberType::U32 | NumberType::I64 | NumberType::U64 | NumberType::F64 => VoxelType::F64,
    }
}

/// Whether such numbers are floats, which cells can hold as they are.
pub(crate) fn is_float(number: NumberType) -> bool {
    matches!(number, NumberType::F32 | NumberType::F64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_but_the_longest_fits() {
        for number in NumberType::ALL {
            let least = match number {
                NumberType::F32 | NumberType::F64 => number.bytes(),
                integer => integer.bytes() * 2,
            };
            assert!(voxel_type(number).bytes() >= least.min(size_of::<f64>()), "{}", number.name());
        }
    }
}
