//! Sixteen lanes at a time: instruction sets chosen at run time, gathers, and the few functions that lanes need.
//!
//! Kernels are written once over a [`fearless_simd::Simd`] token at one width, sixteen lanes of `f32`, whatever the
//! registers of the machine. What the library does not have (gathers, table look-ups) is in `Gather`.

mod divisor;
mod doubles;
mod gather;
mod math;

use fearless_simd::{Level, SimdMask, f32x16, i32x16, mask32x16, u32x16};

pub(crate) use divisor::Divisor;
pub(crate) use doubles::Doubles;
pub(crate) use gather::{Gather, SHORT_TABLES};
pub(crate) use math::{exp2, log2};

/// Lanes of a packet.
pub(crate) const LANES: usize = 16;

pub(crate) type Floats<S> = f32x16<S>;
pub(crate) type Integers<S> = i32x16<S>;
pub(crate) type Naturals<S> = u32x16<S>;
pub(crate) type Mask<S> = mask32x16<S>;

/// Some of the lanes of a packet: bit `l` stands for lane `l`.
pub(crate) type LaneSet = u16;

/// The mask of some lanes.
#[inline(always)]
pub(crate) fn mask_of<S: Gather>(simd: S, lanes: LaneSet) -> Mask<S> {
    Mask::from_bitmask(simd, u64::from(lanes))
}

/// The lanes of a mask.
#[inline(always)]
pub(crate) fn lanes_of<S: Gather>(mask: Mask<S>) -> LaneSet {
    mask.to_bitmask() as LaneSet
}

/// The instructions that kernels are run with.
#[derive(Clone, Copy, Debug)]
pub struct InstructionSet(Level);

impl InstructionSet {
    /// The best one that this machine has.
    pub fn best() -> Self {
        Self(Level::new())
    }

    /// All that this machine has and amray makes use of, the best one first.
    pub fn available() -> Vec<Self> {
        let mut sets = vec![Self::best()];
        #[cfg(target_arch = "x86_64")]
        if let (Level::Avx512(_), Some(avx2)) = (Level::new(), Level::new().as_avx2()) {
            sets.push(Self(Level::Avx2(avx2)));
        }
        sets.push(Self(Level::baseline()));
        sets.dedup_by_key(|set| set.name());
        sets
    }

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(_) => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(_) => "AVX2",
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => "NEON",
            _ => "portable",
        }
    }

    /// Runs a kernel with these instructions.
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        use fearless_simd::Simd;
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512(simd) => simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            ),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2(simd) => simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            ),
            _ => portable(kernel),
        }
    }
}

/// Runs a kernel with what every machine of the target has.
fn portable<K: Kernel>(kernel: K) -> K::Output {
    match Level::baseline() {
        #[cfg(target_arch = "x86_64")]
        Level::Sse2(simd) => kernel.run(simd),
        #[cfg(target_arch = "aarch64")]
        Level::Neon(simd) => kernel.run(simd),
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        Level::Fallback(simd) => kernel.run(simd),
        #[allow(unreachable_patterns)] // Instruction sets beyond the baseline, where the target promises them.
        _ => unreachable!("a baseline that no target of amray has"),
    }
}

/// Work that is compiled once for each instruction set.
///
/// `run` and all that it calls must be `#[inline(always)]` functions: others lose the instruction set.
pub(crate) trait Kernel {
    type Output;
    fn run<S: Gather>(self, simd: S) -> Self::Output;
}
