//! Where to cut a node: at a face that cuts few bricks in two, near the middle of a long side.

use super::build::Candidate;
use super::faces::{FaceBox, Faces};

/// What it costs to cut all bricks of a node in two, where a face at a node's end instead of its middle costs 1. Higher
/// costs make no fewer regions; without any, there are three times as many.
const CUT_COST: f64 = 4.0;
/// With this many times as many faces in a node's width as bricks in the node, sorting beats a table of all faces.
const SPARSE: usize = 8;

/// Chooses cuts. Holds the memory for it, so that none is asked for at each node.
#[derive(Default)]
pub(super) struct Cutter {
    /// Per face of a node's width, how many bricks start and end there.
    table: Vec<[u32; 2]>,
    /// The faces of a node's bricks with the same numbers, in order.
    sorted: Vec<(u32, [u32; 2])>,
}

impl Cutter {
    /// The best axis and face at which to cut a node, if one of the `crossing` bricks (clipped to the node) has a face
    /// inside. `cell_size` is that of the finest level, in world units: which axis is widest is a question of the world.
    pub(super) fn cut(
        &mut self,
        faces: &Faces,
        cell_size: [f64; 3],
        node: &FaceBox,
        crossing: &[Candidate],
    ) -> Option<(usize, u32)> {
        if crossing.is_empty() {
            return None;
        }
        let ends: [[i64; 2]; 3] =
            std::array::from_fn(|axis| [node.low[axis], node.high[axis]].map(|face| faces.place(axis, face)));
        let width: [f64; 3] = std::array::from_fn(|axis| (ends[axis][1] - ends[axis][0]) as f64 * cell_size[axis]);
        let widest = width.into_iter().fold(0.0, f64::max);
        let per_brick = CUT_COST / crossing.len() as f64;
        let mut best = None;
        let mut lowest = f64::INFINITY;
        for axis in 0..3 {
            let narrow = 1.0 - width[axis] / widest;
            if narrow >= lowest {
                continue;
            }
            let [low, high] = ends[axis];
            let per_cell = 1.0 / (high - low) as f64;
            self.for_each_face(axis, node, crossing, |face, cut| {
                let off_middle = (2 * faces.place(axis, face) - low - high).abs() as f64 * per_cell;
                let cost = per_brick * f64::from(cut) + off_middle + narrow;
                if cost < lowest {
                    lowest = cost;
                    best = Some((axis, face));
                }
            });
        }
        best
    }

    /// Calls `visit` with the bricks' faces across `axis` inside the node, in order, each with the number of bricks
    /// that it would cut.
    fn for_each_face(&mut self, axis: usize, node: &FaceBox, crossing: &[Candidate], mut visit: impl FnMut(u32, u32)) {
        let (low, high) = (node.low[axis], node.high[axis]);
        let count = (high - low) as usize;
        let mut open = 0;
        if count > SPARSE * crossing.len().max(8) {
            self.sorted.clear();
            for Candidate { faces, .. } in crossing {
                self.sorted.extend([(faces.low[axis], [1, 0]), (faces.high[axis], [0, 1])]);
            }
            self.sorted.sort_unstable_by_key(|&(face, _)| face);
            for same in self.sorted.chunk_by(|a, b| a.0 == b.0) {
                let face = same[0].0;
                let [begin, end] = same.iter().fold([0, 0], |sum, (_, [begin, end])| [sum[0] + begin, sum[1] + end]);
                open -= end;
                if low < face && face < high {
                    visit(face, open);
                }
                open += begin;
            }
            return;
        }
        self.table.clear();
        self.table.resize(count + 1, [0; 2]);
        for Candidate { faces, .. } in crossing {
            self.table[(faces.low[axis] - low) as usize][0] += 1;
            self.table[(faces.high[axis] - low) as usize][1] += 1;
        }
        for (face, [begin, end]) in (low..high).zip(&self.table) {
            open -= end;
            if face > low && begin + end > 0 {
                visit(face, open);
            }
            open += begin;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sorting_few_faces_and_counting_many_agree() {
        let ends = [(0, 4), (4, 9), (2, 4), (0, 9), (3, 7), (7, 8)];
        let seen = |stretch: u32| {
            let of = |low: u32, high: u32| FaceBox { low: [low * stretch, 0, 0], high: [high * stretch, 1, 1] };
            let bricks = ends.map(|(low, high)| Candidate { faces: of(low, high), level: 0, number: 0 });
            let mut seen = Vec::new();
            Cutter::default().for_each_face(0, &of(0, 9), &bricks, |face, cut| seen.push((face / stretch, cut)));
            seen
        };
        assert_eq!(seen(1), [(2, 2), (3, 3), (4, 2), (7, 2), (8, 2)]);
        assert_eq!(seen(100), seen(1));
    }
}
