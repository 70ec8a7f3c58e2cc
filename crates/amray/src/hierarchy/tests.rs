//! Hierarchies that are refused, and why; what truncation and restriction do.

use super::*;

fn level(ratio: i64, cell_size: f64, domain: i64, bricks: &[([i64; 3], [i64; 3])]) -> LevelDescription {
    LevelDescription {
        ratio: [ratio; 3],
        cell_size: [cell_size; 3],
        domain: IndexBox::new([0; 3], [domain; 3]),
        bricks: bricks.iter().map(|&(low, high)| IndexBox::new(low, high)).collect(),
    }
}

fn two_levels() -> Vec<LevelDescription> {
    vec![level(1, 0.5, 8, &[([0; 3], [8; 3])]), level(2, 0.25, 16, &[([4; 3], [8; 3]), ([8, 4, 4], [12, 8, 8])])]
}

fn error(change: impl Fn(&mut Vec<LevelDescription>)) -> String {
    let mut levels = two_levels();
    change(&mut levels);
    Hierarchy::new([0.0; 3], levels).unwrap_err().to_string()
}

#[test]
fn accepts_and_describes_two_levels() {
    let hierarchy = Hierarchy::new([-1.0, 0.0, 2.0], two_levels()).unwrap();
    assert_eq!(hierarchy.bounds(), [[-1.0, 0.0, 2.0], [3.0, 4.0, 6.0]]);
    assert_eq!(hierarchy.brick_count(), 3);
    assert_eq!(hierarchy.cells(), 512 + 128);
    assert_eq!(hierarchy.levels()[0].finest_cells(), [2; 3]);
    assert_eq!(hierarchy.levels()[1].first_brick(), 1);
    assert_eq!(hierarchy.to_cells(1, [0.0, 1.0, 2.0]), [4.0, 4.0, 0.0]);
    assert_eq!(hierarchy.to_world(1, [4.0, 4.0, 0.0]), [0.0, 1.0, 2.0]);
    assert!(hierarchy.warnings().is_empty());
    let coarse = hierarchy.truncated(0);
    assert_eq!((coarse.finest_level(), coarse.levels()[0].finest_cells()), (0, [1; 3]));
}

#[test]
fn errors_name_level_brick_and_expectation() {
    assert_eq!(error(|levels| levels.iter_mut().for_each(|l| l.bricks.clear())), "no level holds any brick");
    assert_eq!(
        error(|levels| levels[1].bricks[1] = IndexBox::new([6, 4, 4], [10, 8, 8])),
        "level 1: bricks 0 and 1 overlap in ((6,4,4) (7,7,7)), expected disjoint bricks"
    );
    assert_eq!(
        error(|levels| levels[1].bricks[1].high[0] = 18),
        "level 1, brick 1: box ((8,4,4) (17,7,7)) leaves the domain ((0,0,0) (15,15,15))"
    );
    assert_eq!(
        error(|levels| levels[1].bricks[0].low[2] = 3),
        "level 1, brick 0: box ((4,4,3) (7,7,7)) cuts coarser cells, expected corners at multiples of [2, 2, 2]"
    );
    assert_eq!(
        error(|levels| levels[1].bricks[1].high[1] = 4),
        "level 1, brick 1: box ((8,4,4) (11,3,7)) holds no cell"
    );
    assert!(error(|levels| levels[1].cell_size = [0.125; 3]).contains("expected [0.25, 0.25, 0.25]"));
    assert!(error(|levels| levels[1].cell_size[1] = f64::NAN).contains("expected positive numbers"));
    assert!(error(|levels| levels[1].ratio[0] = 0).contains("expected at least 1 on every axis"));
    assert!(error(|levels| levels[1].ratio = [1; 3]).contains("expected at least 2 on one axis"));
    assert!(error(|levels| levels[1].domain.high[0] = 12).contains("expected ((0,0,0) (15,15,15))"));
    assert!(error(|levels| levels[0].domain.high[0] = i64::MAX / 2).contains("expected ((0,0,0)"));
    assert!(error(|levels| levels[0].domain.high[0] = i64::MAX).contains("too large"));
    assert!(Hierarchy::new([f64::INFINITY, 0.0, 0.0], two_levels()).is_err());
    let far = Hierarchy::new([1e20, 0.0, 0.0], two_levels()).unwrap_err().to_string();
    assert!(far.contains("too far from the origin"), "{far}");
    let giant = IndexBox::new([0; 3], [1 << 21; 3]);
    let giants = error(|levels| levels.iter_mut().for_each(|level| level.bricks = vec![giant]));
    assert!(giants.ends_with("cells, expected at most 1152921504606846976"), "{giants}");
}

#[test]
fn twenty_levels_are_exact_and_more_than_51_bits_are_refused() {
    let nested = |count: u32| {
        let levels = (0..count)
            .map(|l| {
                let cells = 1024i64 << l;
                let middle = cells / 2;
                let brick = if l == 0 { ([0; 3], [cells; 3]) } else { ([middle - 8; 3], [middle + 8; 3]) };
                level(if l == 0 { 1 } else { 2 }, 1.0 / cells as f64, cells, &[brick])
            })
            .collect();
        Hierarchy::new([0.0; 3], levels)
    };
    assert_eq!(nested(20).unwrap().finest_level(), 19);
    assert!(matches!(nested(45), Err(HierarchyError::Overflow { .. })));
}

#[test]
fn a_fine_brick_without_its_parent_is_a_warning() {
    let mut levels = two_levels();
    levels[0].bricks = vec![IndexBox::new([0; 3], [4, 8, 8])];
    let hierarchy = Hierarchy::new([0.0; 3], levels).unwrap();
    let expected = HierarchyWarning::ImproperNesting { level: 1, bricks: 1, of: 2, first: 1 };
    assert_eq!(hierarchy.warnings(), [expected]);
    assert!(hierarchy.truncated(0).warnings().is_empty());
}

#[test]
fn fields_must_fit_their_hierarchy() {
    let hierarchy = Hierarchy::new([0.0; 3], two_levels()).unwrap();
    let brick = |size: usize| BrickValues::owned(vec![0f32; size.pow(3)], [size; 3]).unwrap();
    let field = |sizes: &[usize]| {
        Field::new("rho", FieldValues::F32(sizes.iter().map(|&size| brick(size)).collect()), &hierarchy)
    };
    assert!(field(&[8, 4, 4]).is_ok());
    assert_eq!(field(&[8, 4]).unwrap_err().to_string(), "field rho: values of 2 bricks, expected 3");
    assert_eq!(
        field(&[8, 4, 5]).unwrap_err().to_string(),
        "field rho, level 1, brick 1: [5, 5, 5] values, expected [4, 4, 4]"
    );
}

#[test]
fn restriction_averages_what_is_covered_and_copies_nothing_else() {
    let mut levels = two_levels();
    levels[0].bricks = vec![IndexBox::new([0; 3], [8, 8, 4]), IndexBox::new([0, 0, 4], [8; 3])];
    let hierarchy = Hierarchy::new([0.0; 3], levels).unwrap();
    let field = Field::from_fn("x", &hierarchy, |level, [i, _, _]| if level == 0 { -7.0 } else { i as f64 });
    let restricted = field.restricted(&hierarchy);
    assert_eq!(restricted.value(0, [2, 2, 2]), 4.5);
    assert_eq!(restricted.value(0, [5, 3, 3]), 10.5);
    assert_eq!(restricted.value(0, [1, 2, 2]), -7.0);
    let coarse = restricted.truncated(&hierarchy.truncated(0));
    assert_eq!(coarse.value(0, [2, 2, 2]), 4.5);
}
