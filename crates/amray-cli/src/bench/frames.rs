//! How long frames take: several ways of rendering one scene, in turns, so that what else the machine does meets all of
//! them alike.

use std::str::FromStr;
use std::time::Instant;

use amray::render::{RenderOptions, RenderStatistics, render};
use amray::scene::Scene;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// How many threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Threads {
    Count(usize),
    /// As many as the program may use.
    All,
}

/// Threads to render with.
pub(super) struct Pool(ThreadPool);

/// Frames of one kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    /// The median.
    pub(super) seconds: f64,
    /// Of one frame.
    pub(super) statistics: RenderStatistics,
}

impl FromStr for Threads {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.parse() {
            _ if text == "all" => Ok(Self::All),
            Ok(count @ 1..=1024) => Ok(Self::Count(count)),
            _ => Err("expected numbers from 1 to 1024, or all"),
        }
    }
}

impl Threads {
    pub(super) fn count(self) -> usize {
        match self {
            Self::Count(count) => count,
            Self::All => rayon::current_num_threads(),
        }
    }
}

impl Pool {
    pub(super) fn new(threads: usize) -> anyhow::Result<Self> {
        Ok(Self(ThreadPoolBuilder::new().num_threads(threads).build()?))
    }

    pub(super) fn threads(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Renders a scene `repeat` times in each way, in turns, after a frame of each that does not count.
    pub(super) fn alternate<const WAYS: usize>(
        &self,
        scene: &Scene,
        ways: [RenderOptions; WAYS],
        repeat: usize,
    ) -> [Frames; WAYS] {
        self.0.install(|| {
            let warm_up = ways.map(|way| render(scene, &way, &|_| {}).1);
            let mut seconds = [(); WAYS].map(|()| Vec::with_capacity(repeat));
            for _ in 0..repeat {
                for (way, seconds) in ways.iter().zip(&mut seconds) {
                    let start = Instant::now();
                    render(scene, way, &|_| {});
                    seconds.push(start.elapsed().as_secs_f64());
                }
            }
            std::array::from_fn(|way| Frames { seconds: median(&mut seconds[way]), statistics: warm_up[way] })
        })
    }
}

impl Frames {
    /// How many a second, where a frame has `count`.
    pub(super) fn per_second(&self, count: u64) -> f64 {
        count as f64 / self.seconds
    }
}

/// The middle one; the mean of the middle two.
fn median(seconds: &mut [f64]) -> f64 {
    seconds.sort_by(f64::total_cmp);
    (seconds[(seconds.len() - 1) / 2] + seconds[seconds.len() / 2]) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 9.0]), 3.0);
    }

    #[test]
    fn thread_counts() {
        assert_eq!(["4", "all"].map(str::parse), [Ok(Threads::Count(4)), Ok(Threads::All)]);
        for wrong in ["0", "1025", "some", ""] {
            assert!(wrong.parse::<Threads>().is_err(), "{wrong}");
        }
        assert_eq!(Pool::new(3).unwrap().threads(), 3);
    }
}
