//! Boxes around tagged blocks: Berger and Rigoutsos, *An Algorithm for Point Clustering and Grid Generation*
//! (IEEE Transactions on Systems, Man and Cybernetics 21, 1991).

use std::cmp::Reverse;

use amray::hierarchy::IndexBox;

use super::blocks::{TILE_SIDE, Tile};

/// A box is good enough when this share of its blocks is tagged.
const EFFICIENCY: f64 = 0.7;

/// Disjoint boxes of at most `longest` blocks per side that hold all of `tags` and nothing that is not `allowed`;
/// `tags` must be allowed themselves.
pub(super) fn cluster(tags: &Tile, allowed: &Tile, longest: i64) -> Vec<IndexBox> {
    let mut boxes = Vec::new();
    let mut candidates = vec![IndexBox::new([0; 3], [TILE_SIDE; 3])];
    while let Some(candidate) = candidates.pop() {
        let Some((bounds, signatures)) = bounds_and_signatures(tags, &candidate) else { continue };
        let tagged: i64 = signatures[0].iter().sum();
        let blocks = bounds.cells() as i64;
        let efficient = tagged as f64 >= EFFICIENCY * blocks as f64;
        let size = bounds.size();
        if efficient && size.iter().all(|&side| side <= longest) && count(allowed, &bounds) == blocks {
            boxes.push(bounds);
            continue;
        }
        let hole_or_inflection = || hole(&signatures).or_else(|| inflection(&signatures));
        let cut = if efficient { None } else { hole_or_inflection() };
        let (axis, place) = cut.unwrap_or_else(|| middle(size, longest));
        let plane = bounds.low[axis] + place;
        let (mut below, mut above) = (bounds, bounds);
        below.high[axis] = plane;
        above.low[axis] = plane;
        candidates.extend([above, below]);
    }
    boxes
}

/// The smallest box around the candidate's tags, and per axis and plane of it the number of tags. `None` without tags.
fn bounds_and_signatures(tags: &Tile, candidate: &IndexBox) -> Option<(IndexBox, [Vec<i64>; 3])> {
    let mut signatures = candidate.size().map(|planes| vec![0; planes as usize]);
    for_each_row(tags, candidate, |y, z, row| {
        signatures[1][y] += i64::from(row.count_ones());
        signatures[2][z] += i64::from(row.count_ones());
        let mut rest = row;
        while rest != 0 {
            signatures[0][rest.trailing_zeros() as usize] += 1;
            rest &= rest - 1;
        }
    });
    let mut bounds = *candidate;
    for (axis, signature) in signatures.iter_mut().enumerate() {
        let first = signature.iter().position(|&tags| tags > 0)?;
        let last = signature.iter().rposition(|&tags| tags > 0)?;
        bounds.low[axis] = candidate.low[axis] + first as i64;
        bounds.high[axis] = candidate.low[axis] + last as i64 + 1;
        *signature = signature[first..=last].to_vec();
    }
    Some((bounds, signatures))
}

/// Visits the rows of `blocks` with their y and z counted from its low corner, and bit 0 at its low x.
fn for_each_row(tile: &Tile, blocks: &IndexBox, mut visit: impl FnMut(usize, usize, u32)) {
    let [length, ..] = blocks.size();
    let mask = u32::MAX >> (TILE_SIDE - length);
    for (z, plane) in (blocks.low[2]..blocks.high[2]).enumerate() {
        for (y, row) in (blocks.low[1]..blocks.high[1]).enumerate() {
            visit(y, z, tile.row(row, plane) >> blocks.low[0] & mask);
        }
    }
}

fn count(tile: &Tile, blocks: &IndexBox) -> i64 {
    let mut count = 0;
    for_each_row(tile, blocks, |_, _, row| count += i64::from(row.count_ones()));
    count
}

/// An axis and a plane without tags: the one nearest to the middle.
fn hole(signatures: &[Vec<i64>; 3]) -> Option<(usize, i64)> {
    let holes = signatures.iter().enumerate().flat_map(|(axis, signature)| {
        let empty = move |&(_, &tags): &(usize, &i64)| tags == 0;
        let places = signature.iter().enumerate().filter(empty);
        places.map(move |(place, _)| (off_middle(place, signature.len()), axis, place))
    });
    holes.min().map(|(_, axis, place)| (axis, place as i64))
}

/// An axis and the plane where the signature's curvature changes its sign most: an edge in the tags.
fn inflection(signatures: &[Vec<i64>; 3]) -> Option<(usize, i64)> {
    let edges = signatures.iter().enumerate().flat_map(|(axis, signature)| {
        let curvature: Vec<i64> = signature.windows(3).map(|three| three[0] - 2 * three[1] + three[2]).collect();
        let changes = curvature.windows(2).enumerate().filter(|(_, pair)| pair[0] * pair[1] < 0);
        let edge = |(number, pair): (usize, &[i64])| {
            // The first curvature is that of plane 1, and the edge lies behind the pair's first plane.
            let place = number + 2;
            ((pair[1] - pair[0]).abs(), Reverse(off_middle(place, signature.len())), axis, place)
        };
        changes.map(edge).collect::<Vec<_>>()
    });
    edges.max().map(|(.., axis, place)| (axis, place as i64))
}

/// The longest axis, halved; where it has to be cut again, at a multiple of what is allowed.
fn middle(size: [i64; 3], longest: i64) -> (usize, i64) {
    let axis = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
    let half = size[axis] / 2;
    (axis, if half > longest { half / longest * longest } else { half })
}

fn off_middle(place: usize, planes: usize) -> usize {
    (2 * place).abs_diff(planes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const EVERYWHERE: IndexBox = IndexBox::new([0; 3], [TILE_SIDE; 3]);

    fn tile(blocks: impl IntoIterator<Item = IndexBox>) -> Tile {
        let mut tile = Tile::empty();
        blocks.into_iter().for_each(|blocks| blocks.iter().for_each(|block| tile.insert(block)));
        tile
    }

    #[test]
    fn two_blobs_make_two_bricks() {
        let blobs = [IndexBox::new([1, 2, 3], [5, 6, 7]), IndexBox::new([9, 2, 20], [12, 6, 24])];
        assert_eq!(cluster(&tile(blobs), &tile([EVERYWHERE]), 4), blobs);
    }

    #[test]
    fn an_edge_is_found_where_nothing_is_empty() {
        // A thin plate beside a thick one: no plane without tags.
        let plates = [IndexBox::new([0, 0, 0], [4, 2, 8]), IndexBox::new([4, 0, 0], [8, 8, 8])];
        assert_eq!(cluster(&tile(plates), &tile([EVERYWHERE]), 8), plates);
    }

    #[test]
    fn a_full_box_is_cut_into_the_largest_bricks() {
        let boxes = cluster(&tile([EVERYWHERE]), &tile([EVERYWHERE]), 4);
        assert_eq!(boxes.len(), 512);
        assert!(boxes.iter().all(|found| found.size() == [4; 3]));
    }

    #[test]
    fn no_box_holds_what_is_not_allowed() {
        // Seven blocks of eight are tagged: one box, were the eighth allowed.
        let square = IndexBox::new([3; 3], [5; 3]);
        let corner = IndexBox::new([4; 3], [5; 3]);
        let mut tags = Tile::empty();
        square.iter().filter(|&block| !corner.contains(block)).for_each(|block| tags.insert(block));
        assert_eq!(cluster(&tags, &tile([EVERYWHERE]), 4), [square]);
        let boxes = cluster(&tags, &tags, 4);
        assert!(boxes.iter().all(|found| !found.intersects(&corner)));
        assert_eq!(boxes.iter().map(IndexBox::cells).sum::<u64>(), 7);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn boxes_are_small_efficient_disjoint_and_miss_nothing(
            blobs in proptest::collection::vec(([0i64..30, 0i64..30, 0i64..30], [1i64..12, 1i64..12, 1i64..12]), 0..7),
            forbidden in proptest::collection::vec([0i64..32, 0i64..32, 0i64..32], 0..40),
            longest in 1i64..9,
        ) {
            let blobs = blobs.into_iter().map(|(low, size)| {
                IndexBox::new(low, std::array::from_fn(|axis| (low[axis] + size[axis]).min(TILE_SIDE)))
            });
            let mut allowed = Tile::empty();
            EVERYWHERE.iter().filter(|block| !forbidden.contains(block)).for_each(|block| allowed.insert(block));
            let tags = tile(blobs).intersection(&allowed);
            let boxes = cluster(&tags, &allowed, longest);
            let mut held = 0;
            for (number, found) in boxes.iter().enumerate() {
                prop_assert!(found.size().iter().all(|&side| side <= longest));
                prop_assert_eq!(count(&allowed, found), found.cells() as i64);
                let tagged = count(&tags, found);
                prop_assert!(tagged as f64 >= EFFICIENCY * found.cells() as f64);
                prop_assert!(boxes[..number].iter().all(|other| !other.intersects(found)));
                held += tagged;
            }
            prop_assert_eq!(held, count(&tags, &EVERYWHERE));
        }
    }
}
