//! Polygons and strips as triangles.

/// A polygon as a fan around its first corner; nothing where it has fewer than three.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let (first, others) = corners.split_first().map_or((0, corners), |(first, others)| (*first, others));
    others.windows(2).map(move |pair| [first, pair[0], pair[1]])
}

/// A strip, in which every corner but the first two makes a triangle with the two before; all have the same front.
pub(super) fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners.windows(3).enumerate().map(|(place, corners)| match place % 2 {
        0 => [corners[0], corners[1], corners[2]],
        _ => [corners[1], corners[0], corners[2]],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polygons_and_strips_keep_their_front() {
        assert_eq!(fan(&[3, 4, 5, 6]).collect::<Vec<_>>(), [[3, 4, 5], [3, 5, 6]]);
        assert_eq!(strip(&[0, 1, 2, 3, 4]).collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        for few in [&[][..], &[1], &[1, 2]] {
            assert_eq!(fan(few).count() + strip(few).count(), 0);
        }
    }
}
