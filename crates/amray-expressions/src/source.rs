//! Values of a field's bricks, row by row, as double precision.

use amray::hierarchy::{BrickValues, Field, FieldValues, Voxel};

/// Puts the values of the row of cells along x at `[j, k]`, counted from the low corner of the brick `place`, into `row`.
pub(crate) fn read_row(field: &Field, place: usize, [j, k]: [usize; 2], row: &mut [f64]) {
    match field.values() {
        FieldValues::F32(bricks) => read(&bricks[place], [j, k], row),
        FieldValues::F64(bricks) => read(&bricks[place], [j, k], row),
    }
}

fn read<T: Voxel>(brick: &BrickValues<T>, [j, k]: [usize; 2], row: &mut [f64]) {
    let (runs, rest) = row.as_chunks_mut::<8>();
    let mut i = 0;
    for run in runs {
        *run = brick.run::<8>([i, j, k]).map(Voxel::to_f64);
        i += run.len();
    }
    for value in rest {
        *value = brick.get([i, j, k]).to_f64();
        i += 1;
    }
}

#[cfg(test)]
mod tests {
    use amray::hierarchy::{Hierarchy, IndexBox, LevelDescription};

    use super::*;

    #[test]
    fn rows_of_any_length() {
        for length in [1, 7, 8, 21] {
            let cells = IndexBox::new([0; 3], [length, 2, 3]);
            let level = LevelDescription { ratio: [1; 3], cell_size: [1.0; 3], domain: cells, bricks: vec![cells] };
            let hierarchy = Hierarchy::new([0.0; 3], vec![level]).unwrap();
            let field = Field::from_fn("f", &hierarchy, |_, [i, j, k]| (i + 100 * j + 1000 * k) as f32);
            let mut row = vec![0.0; length as usize];
            read_row(&field, 0, [1, 2], &mut row);
            assert_eq!(row, (0..length).map(|i| (i + 2100) as f64).collect::<Vec<_>>());
        }
    }
}
