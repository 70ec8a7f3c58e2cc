//! Numbers of mesh files that mean something: colours, vertices.

use amray_encoding::NumberType;

/// The number that stands for all of a colour.
pub(super) fn full_color(number: NumberType) -> f64 {
    match number {
        NumberType::F32 | NumberType::F64 => 1.0,
        NumberType::I8 | NumberType::U8 => 255.0,
        integer => 2f64.powi(8 * integer.bytes() as i32) - 1.0,
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
    fn vertices_are_whole_numbers() {
        assert_eq!(vertex_numbers(&[0.0, 4294967295.0]), Ok(vec![0, u32::MAX]));
        for wrong in [-1.0, 0.5, 4294967296.0, f64::NAN] {
            assert_eq!(vertex_numbers(&[wrong]), Err(format!("{wrong}, expected the number of a vertex")));
        }
    }
}
