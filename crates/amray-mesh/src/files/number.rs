//! Numbers as binary files store them.

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ByteOrder {
    /// The lowest.
    Little,
    /// The highest.
    Big,
}

impl NumberType {
    /// The length of a number.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number that `stored`, of its length, is.
    pub(super) fn value(self, stored: &[u8], order: ByteOrder) -> f64 {
        let mut bytes = [0; 8];
        bytes[..stored.len()].copy_from_slice(stored);
        if order == ByteOrder::Big {
            bytes[..stored.len()].reverse();
        }
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            // Rounded from 2^53 on; no index is that large.
            Self::I64 => i64::from_le_bytes(bytes) as f64,
            Self::U64 => u64::from_le_bytes(bytes) as f64,
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }

    /// The number that stands for all of a colour.
    pub(super) fn full_color(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::I8 | Self::U8 => 255.0,
            integer => 2f64.powi(8 * integer.bytes() as i32) - 1.0,
        }
    }
}

/// Numbers that say which vertices, as indices.
///
/// # Errors
/// What is wrong with one, in words.
pub(super) fn vertex_numbers(numbers: &[f64]) -> Result<Vec<u32>, String> {
    let index = |&number: &f64| {
        let index = number as u32;
        (f64::from(index) == number)
            .then_some(index)
            .ok_or_else(|| format!("{number}, expected the number of a vertex"))
    };
    numbers.iter().map(index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_numbers_in_either_order() {
        let numbers = [(NumberType::I16, vec![0xfe, 0xff], -2.0), (NumberType::F32, 1.5f32.to_le_bytes().into(), 1.5)];
        let large = [(NumberType::U64, 258u64.to_le_bytes().into(), 258.0), (NumberType::I8, vec![0x80], -128.0)];
        for (number, mut bytes, value) in numbers.into_iter().chain(large) {
            assert_eq!(number.value(&bytes, ByteOrder::Little), value);
            bytes.reverse();
            assert_eq!(number.value(&bytes, ByteOrder::Big), value);
        }
    }

    #[test]
    fn vertices_are_whole_numbers() {
        assert_eq!(vertex_numbers(&[0.0, 4294967295.0]), Ok(vec![0, u32::MAX]));
        for wrong in [-1.0, 0.5, 4294967296.0, f64::NAN] {
            assert_eq!(vertex_numbers(&[wrong]), Err(format!("{wrong}, expected the number of a vertex")));
        }
    }
}
