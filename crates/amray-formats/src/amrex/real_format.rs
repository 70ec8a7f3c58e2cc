//! How a plotfile stores its numbers: AMReX's `RealDescriptor`, of which the two IEEE formats are read.

use amray::hierarchy::VoxelType;

use super::text::Scanner;

/// The next thing to expect of a descriptor that can be read.
pub(super) const REAL_FORMAT: &str =
    "a number format such as ((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1))), IEEE with 4 or 8 bytes";

/// Bits in all, of the exponent and of the mantissa; where sign, exponent and mantissa start; whether the mantissa's
/// first bit is stored; the exponent's bias.
const IEEE_64: [u32; 8] = [64, 11, 52, 0, 1, 12, 0, 1023];
const IEEE_32: [u32; 8] = [32, 8, 23, 0, 1, 9, 0, 127];

/// A number format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RealFormat {
    /// Single or double precision.
    pub(super) voxel_type: VoxelType,
    /// The order of a number's bytes.
    pub(super) byte_order: ByteOrder,
}

/// Which byte of a number comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteOrder {
    /// The least significant one.
    Little,
    /// The most significant one.
    Big,
}

impl ByteOrder {
    /// Whether this machine stores its numbers so.
    pub(super) fn is_native(self) -> bool {
        cfg!(target_endian = "little") == (self == Self::Little)
    }
}

impl RealFormat {
    /// `((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))`: the format's eight parameters, then which of its
    /// bytes, counted from the most significant one, comes first, second, ... in the file.
    pub(super) fn scan(text: &mut Scanner<'_>) -> Option<Self> {
        text.symbol("(")?;
        let voxel_type = match scan_array(text)?.as_slice() {
            format if format == IEEE_32 => VoxelType::F32,
            format if format == IEEE_64 => VoxelType::F64,
            _ => return None,
        };
        text.symbol(",")?;
        let order = scan_array(text)?;
        text.symbol(")")?;
        let bytes = 1..=voxel_type.bytes() as u32;
        let byte_order = match order {
            order if order.iter().copied().eq(bytes.clone().rev()) => ByteOrder::Little,
            order if order.iter().copied().eq(bytes) => ByteOrder::Big,
            _ => return None,
        };
        Some(Self { voxel_type, byte_order })
    }
}

/// A count and as many numbers: `(4, (4 3 2 1))`.
fn scan_array(text: &mut Scanner<'_>) -> Option<Vec<u32>> {
    text.symbol("(")?;
    let count: usize = text.number()?;
    text.symbol(",")?;
    text.symbol("(")?;
    let numbers = (0..count).map(|_| text.number()).collect::<Option<_>>()?;
    text.symbol(")")?;
    text.symbol(")")?;
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(text: &str) -> Option<RealFormat> {
        RealFormat::scan(&mut Scanner(text))
    }

    #[test]
    fn ieee_formats_in_both_orders() {
        use {ByteOrder::*, VoxelType::*};
        for (text, voxel_type, byte_order) in [
            ("((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))", F64, Little),
            ("((8, (64 11 52 0 1 12 0 1023)),(8, (1 2 3 4 5 6 7 8)))", F64, Big),
            ("((8, (32 8 23 0 1 9 0 127)),(4, (4 3 2 1)))", F32, Little),
            ("((8, (32 8 23 0 1 9 0 127)),(4, (1 2 3 4)))((0,0,0)", F32, Big),
        ] {
            assert_eq!(scan(text), Some(RealFormat { voxel_type, byte_order }), "{text}");
        }
    }

    #[test]
    fn other_formats_are_refused() {
        for text in [
            "",
            "((8, (32 8 23 0 1 9 0 127)),(4, (2 1 4 3)))",
            "((8, (32 8 23 0 1 9 0 127)),(8, (8 7 6 5 4 3 2 1)))",
            "((8, (64 15 48 0 1 16 1 16383)),(8, (1 2 3 4 5 6 7 8)))",
            "((8, (64 11 52 0 1 12 0 1023)),(0, ()))",
            "((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1",
            "((99999999999, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1)))",
        ] {
            assert_eq!(scan(text), None, "{text}");
        }
    }
}
