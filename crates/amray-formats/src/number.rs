//! Numbers as files of samples store them, and as amray's cells hold them.

use amray::hierarchy::{Voxel, VoxelType};

/// The type of a stored sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// 8 bits, signed.
    I8,
    /// 8 bits.
    U8,
    /// 16 bits, signed.
    I16,
    /// 16 bits.
    U16,
    /// 32 bits, signed.
    I32,
    /// 32 bits.
    U32,
    /// 64 bits, signed; rounded to double precision from 2^53 on.
    I64,
    /// 64 bits; rounded to double precision from 2^53 on.
    U64,
    /// IEEE single precision.
    F32,
    /// IEEE double precision.
    F64,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    /// The lowest.
    Little,
    /// The highest.
    Big,
}

impl NumberType {
    /// Every type.
    pub const ALL: [Self; 10] =
        [Self::I8, Self::U8, Self::I16, Self::U16, Self::I32, Self::U32, Self::I64, Self::U64, Self::F32, Self::F64];

    /// The name on the command line: `u8`, `f32`, ...
    pub fn name(self) -> &'static str {
        match self {
            Self::I8 => "i8",
            Self::U8 => "u8",
            Self::I16 => "i16",
            Self::U16 => "u16",
            Self::I32 => "i32",
            Self::U32 => "u32",
            Self::I64 => "i64",
            Self::U64 => "u64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Bytes per sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The smaller of amray's number types that holds every sample.
    pub fn voxel_type(self) -> VoxelType {
        match self {
            Self::I8 | Self::U8 | Self::I16 | Self::U16 | Self::F32 => VoxelType::F32,
            Self::I32 | Self::U32 | Self::I64 | Self::U64 | Self::F64 => VoxelType::F64,
        }
    }

    /// Appends the samples that `bytes`, a whole number of them, hold.
    pub(crate) fn decode<T: Voxel>(self, order: ByteOrder, bytes: &[u8], values: &mut Vec<T>) {
        match self {
            Self::I8 => put(bytes, order, values, |stored| i8::from_le_bytes(stored).into()),
            Self::U8 => put(bytes, order, values, |stored| u8::from_le_bytes(stored).into()),
            Self::I16 => put(bytes, order, values, |stored| i16::from_le_bytes(stored).into()),
            Self::U16 => put(bytes, order, values, |stored| u16::from_le_bytes(stored).into()),
            Self::I32 => put(bytes, order, values, |stored| i32::from_le_bytes(stored).into()),
            Self::U32 => put(bytes, order, values, |stored| u32::from_le_bytes(stored).into()),
            Self::I64 => put(bytes, order, values, |stored| i64::from_le_bytes(stored) as f64),
            Self::U64 => put(bytes, order, values, |stored| u64::from_le_bytes(stored) as f64),
            Self::F32 => put(bytes, order, values, |stored| f32::from_le_bytes(stored).into()),
            Self::F64 => put(bytes, order, values, f64::from_le_bytes),
        }
    }
}

/// Appends `number` of every `N` bytes, which it gets lowest first.
fn put<const N: usize, T: Voxel>(bytes: &[u8], order: ByteOrder, values: &mut Vec<T>, number: impl Fn([u8; N]) -> f64) {
    let (stored, _) = bytes.as_chunks::<N>();
    match order {
        ByteOrder::Little => values.extend(stored.iter().map(|&stored| T::from_f64(number(stored)))),
        ByteOrder::Big => values.extend(stored.iter().map(|&stored| {
            let mut lowest_first = stored;
            lowest_first.reverse();
            T::from_f64(number(lowest_first))
        })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_in_both_orders() {
        let cases: [(NumberType, &[u8], f64); 10] = [
            (NumberType::I8, &[0xfe], -2.0),
            (NumberType::U8, &[0xfe], 254.0),
            (NumberType::I16, &[0x00, 0x80], -32768.0),
            (NumberType::U16, &[0x01, 0x80], 32769.0),
            (NumberType::I32, &(-70_000i32).to_le_bytes(), -70_000.0),
            (NumberType::U32, &[0xff; 4], 4_294_967_295.0),
            (NumberType::I64, &(-(1i64 << 40)).to_le_bytes(), -(2f64.powi(40))),
            (NumberType::U64, &(1u64 << 63).to_le_bytes(), 2f64.powi(63)),
            (NumberType::F32, &1.5f32.to_le_bytes(), 1.5),
            (NumberType::F64, &0.1f64.to_le_bytes(), 0.1),
        ];
        for (place, (number, little, expected)) in cases.into_iter().enumerate() {
            assert_eq!((number, number.bytes()), (NumberType::ALL[place], little.len()));
            let big: Vec<u8> = little.iter().rev().copied().collect();
            let mut values: Vec<f64> = Vec::new();
            number.decode(ByteOrder::Little, little, &mut values);
            number.decode(ByteOrder::Big, &big, &mut values);
            assert_eq!(values, [expected; 2], "{}", number.name());
            let single: f32 = f32::from_f64(expected);
            assert!(number.voxel_type() == VoxelType::F64 || f64::from(single) == expected);
        }
    }
}
