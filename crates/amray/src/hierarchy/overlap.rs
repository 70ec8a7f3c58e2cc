//! Which boxes of two lists share cells.

use super::IndexBox;

/// Below this many candidate pairs, comparing each with each is fastest.
const FEW_PAIRS: usize = 512;

/// Calls `visit(i, j, cells)` once for every `a[i]` and `b[j]` that share `cells`. `visit` returns whether to go on.
pub(super) fn for_each_overlap(a: &[IndexBox], b: &[IndexBox], mut visit: impl FnMut(usize, usize, IndexBox) -> bool) {
    let everywhere = IndexBox::new([i64::MIN; 3], [i64::MAX; 3]);
    let all = |boxes: &[IndexBox]| (0..boxes.len()).filter(|&i| !boxes[i].is_empty()).collect();
    Join { a, b, visit: &mut visit }.split(all(a), all(b), everywhere);
}

struct Join<'a, V> {
    a: &'a [IndexBox],
    b: &'a [IndexBox],
    visit: &'a mut V,
}

impl<V: FnMut(usize, usize, IndexBox) -> bool> Join<'_, V> {
    /// Reports the pairs among the candidates whose shared cells start in `region`. Returns whether to go on.
    fn split(&mut self, a: Vec<usize>, b: Vec<usize>, region: IndexBox) -> bool {
        if a.len() * b.len() > FEW_PAIRS
            && let Some((axis, plane)) = self.plane(&a, &b, &region)
        {
            let low = |boxes: &[IndexBox], list: &[usize]| -> Vec<usize> {
                list.iter().copied().filter(|&i| boxes[i].low[axis] < plane).collect()
            };
            let high = |boxes: &[IndexBox], list: &[usize]| -> Vec<usize> {
                list.iter().copied().filter(|&i| boxes[i].high[axis] > plane).collect()
            };
            let (mut below, mut above) = (region, region);
            below.high[axis] = plane;
            above.low[axis] = plane;
            let (low_a, low_b) = (low(self.a, &a), low(self.b, &b));
            let (high_a, high_b) = (high(self.a, &a), high(self.b, &b));
            drop((a, b));
            return self.split(low_a, low_b, below) && self.split(high_a, high_b, above);
        }
        for &i in &a {
            for &j in &b {
                let shared = self.a[i].intersection(&self.b[j]);
                // A pair that straddles a plane is met on both sides of it, but its low corner lies on one.
                if !shared.is_empty() && region.contains(shared.low) && !(self.visit)(i, j, shared) {
                    return false;
                }
            }
        }
        true
    }

    /// The plane that leaves the fewest pairs: per axis the median low face is tried. `None` where none helps.
    fn plane(&self, a: &[usize], b: &[usize], region: &IndexBox) -> Option<(usize, i64)> {
        let mut best = None;
        let mut fewest = a.len() * b.len() / 4 * 3;
        for axis in 0..3 {
            let mut lows: Vec<i64> =
                a.iter().map(|&i| self.a[i].low[axis]).chain(b.iter().map(|&j| self.b[j].low[axis])).collect();
            let middle = lows.len() / 2;
            let plane = *lows.select_nth_unstable(middle).1;
            if plane <= region.low[axis] || plane >= region.high[axis] {
                continue;
            }
            let below =
                |boxes: &[IndexBox], list: &[usize]| list.iter().filter(|&&i| boxes[i].low[axis] < plane).count();
            let above =
                |boxes: &[IndexBox], list: &[usize]| list.iter().filter(|&&i| boxes[i].high[axis] > plane).count();
            let pairs = below(self.a, a) * below(self.b, b) + above(self.a, a) * above(self.b, b);
            if pairs < fewest {
                fewest = pairs;
                best = Some((axis, plane));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn boxes(count: usize) -> impl Strategy<Value = Vec<IndexBox>> {
        let one = ([-20i64..20, -20i64..20, -20i64..20], [0i64..9, 0i64..9, 0i64..9])
            .prop_map(|(low, size)| IndexBox::new(low, std::array::from_fn(|axis| low[axis] + size[axis])));
        proptest::collection::vec(one, 0..count)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(50))]
        #[test]
        fn finds_each_pair_once(a in boxes(150), b in boxes(150)) {
            let mut found = Vec::new();
            for_each_overlap(&a, &b, |i, j, cells| {
                found.push((i, j, cells.low, cells.high));
                true
            });
            let mut expected = Vec::new();
            for (i, first) in a.iter().enumerate() {
                for (j, second) in b.iter().enumerate() {
                    let cells = first.intersection(second);
                    if !cells.is_empty() {
                        expected.push((i, j, cells.low, cells.high));
                    }
                }
            }
            found.sort_unstable();
            expected.sort_unstable();
            prop_assert_eq!(found, expected);
        }
    }
}
