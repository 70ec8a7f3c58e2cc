//! Stored integers and floats of any size and byte order as i64 and f64.

use hdf5_reader::{Datatype, H5Type};

/// The integer at the start of `bytes`; `None` where the type is no integer or the value does not fit.
pub(super) fn integer(datatype: &Datatype, bytes: &[u8]) -> Option<i64> {
    let Datatype::FixedPoint { size, signed, .. } = datatype else { return None };
    match (size, signed) {
        (1, true) => i8::from_bytes(bytes, datatype).ok().map(i64::from),
        (2, true) => i16::from_bytes(bytes, datatype).ok().map(i64::from),
        (4, true) => i32::from_bytes(bytes, datatype).ok().map(i64::from),
        (8, true) => i64::from_bytes(bytes, datatype).ok(),
        (1, false) => u8::from_bytes(bytes, datatype).ok().map(i64::from),
        (2, false) => u16::from_bytes(bytes, datatype).ok().map(i64::from),
        (4, false) => u32::from_bytes(bytes, datatype).ok().map(i64::from),
        (8, false) => u64::from_bytes(bytes, datatype).ok().and_then(|value| i64::try_from(value).ok()),
        _ => None,
    }
}

/// The float, or integer, at the start of `bytes`; `None` where the type is neither.
pub(super) fn float(datatype: &Datatype, bytes: &[u8]) -> Option<f64> {
    match datatype {
        Datatype::FloatingPoint { size: 4, .. } => f32::from_bytes(bytes, datatype).ok().map(f64::from),
        Datatype::FloatingPoint { size: 8, .. } => f64::from_bytes(bytes, datatype).ok(),
        _ => integer(datatype, bytes).map(|value| value as f64),
    }
}

/// A type in words, for messages.
pub(super) fn describe(datatype: &Datatype) -> String {
    match datatype {
        Datatype::FixedPoint { size, .. } => format!("integers of {size} bytes"),
        Datatype::FloatingPoint { size, .. } => format!("floats of {size} bytes"),
        Datatype::String { .. } | Datatype::VarLen { .. } => "strings".into(),
        Datatype::Compound { .. } => "compounds".into(),
        _ => "values of another type".into(),
    }
}

#[cfg(test)]
mod tests {
    use hdf5_reader::ByteOrder;

    use super::*;

    #[test]
    fn numbers_of_every_size_and_order() {
        let fixed = |size, signed, byte_order| Datatype::FixedPoint { size, signed, byte_order };
        assert_eq!(integer(&fixed(4, true, ByteOrder::LittleEndian), &(-7i32).to_le_bytes()), Some(-7));
        assert_eq!(integer(&fixed(2, true, ByteOrder::BigEndian), &(-7i16).to_be_bytes()), Some(-7));
        assert_eq!(integer(&fixed(1, false, ByteOrder::LittleEndian), &[255]), Some(255));
        assert_eq!(integer(&fixed(8, false, ByteOrder::LittleEndian), &[255; 8]), None);
        assert_eq!(integer(&fixed(3, true, ByteOrder::LittleEndian), &[1; 8]), None);
        assert_eq!(integer(&fixed(4, true, ByteOrder::LittleEndian), &[1; 3]), None);
        let floating = |size, byte_order| Datatype::FloatingPoint { size, byte_order };
        assert_eq!(float(&floating(4, ByteOrder::BigEndian), &0.25f32.to_be_bytes()), Some(0.25));
        assert_eq!(float(&floating(8, ByteOrder::LittleEndian), &0.1f64.to_le_bytes()), Some(0.1));
        assert_eq!(float(&floating(2, ByteOrder::LittleEndian), &[0; 2]), None);
        assert_eq!(float(&fixed(4, true, ByteOrder::LittleEndian), &3i32.to_le_bytes()), Some(3.0));
        assert_eq!(integer(&floating(4, ByteOrder::LittleEndian), &[0; 4]), None);
    }
}
