//! One hierarchy that VTK wrote in three encodings.

use amray::hierarchy::Residence;
use amray_testing::real_data;

use super::{opened, values};

/// Cells and sums of `phi` per level, by h5py.
const LEVELS: [(u64, f64); 3] = [(32768, 507.42937671384703), (34816, 3253.9708777531514), (31744, 12879.455015540998)];

#[test]
fn three_encodings_are_one_hierarchy() {
    let mut first = None;
    for (name, format, residence) in [
        ("synth3.vtkhdf", "VTKHDF AMR", Residence::Mapped),
        ("synth3.vthb", "VTK AMR (XML)", Residence::Owned),
        ("synth3_raw.vthb", "VTK AMR (XML)", Residence::Mapped),
    ] {
        let Some(path) = real_data(&format!("vtk/{name}")) else { return };
        let data = opened(&path);
        assert_eq!((data.format(), data.fields().len(), data.fields()[0].name.as_str()), (format, 1, "phi"));
        let field = data.read_field(0, &|_| {}).unwrap();
        assert!(field.bytes(residence) > 0, "{name}");
        let hierarchy = data.hierarchy();
        let found = values(hierarchy, &field);
        let mut bricks = hierarchy.bricks().zip(&found).peekable();
        for (level, (cells, sum)) in LEVELS.into_iter().enumerate() {
            assert_eq!(hierarchy.levels()[level].cells(), cells);
            let mut of_level = 0.0;
            while let Some((_, values)) = bricks.next_if(|(brick, _)| brick.level == level) {
                of_level += values.iter().sum::<f64>();
            }
            assert!((of_level - sum).abs() < 1e-9 * sum, "level {level}: {of_level}");
        }
        assert_eq!(hierarchy.bounds(), [[0.0; 3], [1.0; 3]]);
        let (first_bricks, first_values) = first.get_or_insert_with(|| (hierarchy.clone(), found.clone()));
        assert!(first_bricks.bricks().eq(hierarchy.bricks()) && *first_values == found, "{name}");
    }
}
