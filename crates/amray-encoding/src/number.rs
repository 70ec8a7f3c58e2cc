//! Numbers as binary files store them.

/// The type of a stored number.
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

impl ByteOrder {
    /// This machine's.
    pub const NATIVE: Self = if cfg!(target_endian = "little") { Self::Little } else { Self::Big };
}

impl NumberType {
    /// Every type.
    pub const ALL: [Self; 10] =
        [Self::I8, Self::U8, Self::I16, Self::U16, Self::I32, Self::U32, Self::I64, Self::U64, Self::F32, Self::F64];

    /// The name on amray's command line: `u8`, `f32`, ...
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

    /// Bytes per number.
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Appends the numbers that `bytes`, a whole number of them, hold, each through `from`.
    pub fn decode<T>(self, order: ByteOrder, bytes: &[u8], from: impl Fn(f64) -> T, values: &mut impl Extend<T>) {
        match self {
            Self::I8 => put(bytes, order, values, |stored| from(i8::from_le_bytes(stored).into())),
            Self::U8 => put(bytes, order, values, |stored| from(u8::from_le_bytes(stored).into())),
            Self::I16 => put(bytes, order, values, |stored| from(i16::from_le_bytes(stored).into())),
            Self::U16 => put(bytes, order, values, |stored| from(u16::from_le_bytes(stored).into())),
            Self::I32 => put(bytes, order, values, |stored| from(i32::from_le_bytes(stored).into())),
            Self::U32 => put(bytes, order, values, |stored| from(u32::from_le_bytes(stored).into())),
            Self::I64 => put(bytes, order, values, |stored| from(i64::from_le_bytes(stored) as f64)),
            Self::U64 => put(bytes, order, values, |stored| from(u64::from_le_bytes(stored) as f64)),
            Self::F32 => put(bytes, order, values, |stored| from(f32::from_le_bytes(stored).into())),
            Self::F64 => put(bytes, order, values, |stored| from(f64::from_le_bytes(stored))),
        }
    }

    /// The number that `stored`, of its length, is.
    pub fn value(self, order: ByteOrder, stored: &[u8]) -> f64 {
        let mut value = Last(0.0);
        self.decode(order, stored, |value| value, &mut value);
        value.0
    }
}

/// Keeps the last of the numbers it is shown.
struct Last(f64);

impl Extend<f64> for Last {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, numbers: I) {
        self.0 = numbers.into_iter().last().unwrap_or(self.0);
    }
}

/// Appends `number` of every `N` bytes, which it gets lowest first.
fn put<const N: usize, T>(bytes: &[u8], order: ByteOrder, values: &mut impl Extend<T>, number: impl Fn([u8; N]) -> T) {
    let (stored, _) = bytes.as_chunks::<N>();
    match order {
        ByteOrder::Little => values.extend(stored.iter().map(|&stored| number(stored))),
        ByteOrder::Big => values.extend(stored.iter().map(|&stored| {
            let mut lowest_first = stored;
            lowest_first.reverse();
            number(lowest_first)
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
            let mut values = Vec::new();
            number.decode(ByteOrder::Little, little, |value| value, &mut values);
            number.decode(ByteOrder::Big, &big, |value| value, &mut values);
            values.extend([number.value(ByteOrder::Little, little), number.value(ByteOrder::Big, &big)]);
            assert_eq!(values, [expected; 4], "{}", number.name());
        }
    }
}
