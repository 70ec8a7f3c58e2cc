//! Loads from sixteen places at once.
#![allow(unsafe_code)] // Gathers read memory at computed places; the callers vouch for them.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, u32x16};

use super::LANES;

/// An instruction set that can read at sixteen places.
pub trait Gather: Simd {
    /// The values at `base + index`.
    ///
    /// # Safety
    /// All sixteen places must be readable; they need not be aligned.
    unsafe fn gather(self, base: *const f32, index: i32x16<Self>) -> f32x16<Self>;

    /// The values at `base + index` and at the places right behind them.
    ///
    /// # Safety
    /// All thirty-two places must be readable; they need not be aligned.
    unsafe fn gather_pairs(self, base: *const f32, index: i32x16<Self>) -> [f32x16<Self>; 2];

    /// The values at `base + index`, minus `low`, times `scale`.
    ///
    /// # Safety
    /// All sixteen places must be readable; they need not be aligned.
    unsafe fn gather_scaled(self, base: *const f64, index: i32x16<Self>, low: f64, scale: f64) -> f32x16<Self>;

    /// The entries of a table as long as a register. Indices count modulo its length.
    fn look_up_16(self, table: &[f32; 16], index: i32x16<Self>) -> f32x16<Self>;

    /// The entries of a table as long as two registers. Indices count modulo its length.
    fn look_up_32(self, table: &[f32; 32], index: i32x16<Self>) -> f32x16<Self>;

    /// The entries of a table; indices must lie in it, but any are safe. [`SHORT_TABLES`] are quickest.
    #[inline(always)]
    fn look_up(self, table: &[f32], index: i32x16<Self>) -> f32x16<Self> {
        if let Ok(table) = table.try_into() {
            return self.look_up_16(table, index);
        }
        if let Ok(table) = table.try_into() {
            return self.look_up_32(table, index);
        }
        let natural: u32x16<Self> = index.bitcast();
        let index = natural.min(u32x16::splat(self, table.len() as u32 - 1)).bitcast();
        // SAFETY: the index lies in the table.
        unsafe { self.gather(table.as_ptr(), index) }
    }

    /// The entries of a table of two or more and those right behind them; indices must lie in it, but any are safe.
    #[inline(always)]
    fn look_up_pairs(self, table: &[f32], index: i32x16<Self>) -> [f32x16<Self>; 2] {
        assert!(table.len() >= 2, "a table of {}", table.len());
        let natural: u32x16<Self> = index.bitcast();
        let index = natural.min(u32x16::splat(self, table.len() as u32 - 2)).bitcast();
        // SAFETY: the index and the one behind it lie in the table.
        unsafe { self.gather_pairs(table.as_ptr(), index) }
    }
}

/// The lengths of tables that can be kept in registers.
pub(crate) const SHORT_TABLES: [usize; 2] = [16, 32];

/// One load a lane: for instruction sets without gathers, and what the others are tested against.
macro_rules! gather_by_loads {
    ($simd:ty) => {
        impl Gather for $simd {
            #[inline(always)]
            unsafe fn gather(self, base: *const f32, index: i32x16<Self>) -> f32x16<Self> {
                let index: [i32; LANES] = index.into();
                // SAFETY: the caller vouches for all places.
                let values = index.map(|index| unsafe { base.offset(index as isize).read_unaligned() });
                values.simd_into(self)
            }

            #[inline(always)]
            unsafe fn gather_pairs(self, base: *const f32, index: i32x16<Self>) -> [f32x16<Self>; 2] {
                // SAFETY: the caller vouches for all places.
                unsafe { [self.gather(base, index), self.gather(base.wrapping_add(1), index)] }
            }

            #[inline(always)]
            unsafe fn gather_scaled(self, base: *const f64, index: i32x16<Self>, low: f64, scale: f64) -> f32x16<Self> {
                let index: [i32; LANES] = index.into();
                let values = index.map(|index| {
                    // SAFETY: the caller vouches for all places.
                    let value = unsafe { base.offset(index as isize).read_unaligned() };
                    ((value - low) * scale) as f32
                });
                values.simd_into(self)
            }

            #[inline(always)]
            fn look_up_16(self, table: &[f32; 16], index: i32x16<Self>) -> f32x16<Self> {
                let index: [i32; LANES] = index.into();
                index.map(|index| table[index as usize % 16]).simd_into(self)
            }

            #[inline(always)]
            fn look_up_32(self, table: &[f32; 32], index: i32x16<Self>) -> f32x16<Self> {
                let index: [i32; LANES] = index.into();
                index.map(|index| table[index as usize % 32]).simd_into(self)
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
gather_by_loads!(fearless_simd::x86::Sse2);
#[cfg(target_arch = "aarch64")]
gather_by_loads!(fearless_simd::aarch64::Neon);
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
gather_by_loads!(fearless_simd::Fallback);

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use fearless_simd::x86::{Avx2, Avx512};
    use fearless_simd::{f32x8, i32x8, kernel};

    use super::*;

    impl Gather for Avx512 {
        #[inline(always)]
        unsafe fn gather(self, base: *const f32, index: i32x16<Self>) -> f32x16<Self> {
            kernel!(
                #[inline(always)]
                fn gather(simd: Avx512, base: *const f32, index: i32x16<Avx512>) -> f32x16<Avx512> {
                    // SAFETY: the caller of the method vouches for all places.
                    unsafe { _mm512_i32gather_ps::<4>(index.into(), base).simd_into(simd) }
                }
            );
            gather(self, base, index)
        }

        #[inline(always)]
        unsafe fn gather_pairs(self, base: *const f32, index: i32x16<Self>) -> [f32x16<Self>; 2] {
            kernel!(
                #[inline(always)]
                fn gather_pairs(simd: Avx512, base: *const f32, index: i32x16<Avx512>) -> [f32x16<Avx512>; 2] {
                    let index: __m512i = index.into();
                    let [low, high] = [_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index)];
                    // A pair of f32 travels as the bits of one f64.
                    // SAFETY: the caller of the method vouches for all places.
                    let [low, high] = [low, high]
                        .map(|index| unsafe { _mm512_castpd_ps(_mm512_i32gather_pd::<4>(index, base.cast())) });
                    let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
                    let odd = _mm512_or_si512(even, _mm512_set1_epi32(1));
                    [
                        _mm512_permutex2var_ps(low, even, high).simd_into(simd),
                        _mm512_permutex2var_ps(low, odd, high).simd_into(simd),
                    ]
                }
            );
            gather_pairs(self, base, index)
        }

        #[inline(always)]
        unsafe fn gather_scaled(self, base: *const f64, index: i32x16<Self>, low: f64, scale: f64) -> f32x16<Self> {
            kernel!(
                #[inline(always)]
                fn gather_scaled(
                    simd: Avx512,
                    base: *const f64,
                    index: i32x16<Avx512>,
                    low: f64,
                    scale: f64,
                ) -> f32x16<Avx512> {
                    let index: __m512i = index.into();
                    let halves = [_mm512_castsi512_si256(index), _mm512_extracti64x4_epi64::<1>(index)];
                    let [first, second] = halves.map(|index| {
                        // SAFETY: the caller of the method vouches for all places.
                        let values = unsafe { _mm512_i32gather_pd::<8>(index, base) };
                        let above = _mm512_sub_pd(values, _mm512_set1_pd(low));
                        _mm512_cvtpd_ps(_mm512_mul_pd(above, _mm512_set1_pd(scale)))
                    });
                    _mm512_insertf32x8::<1>(_mm512_castps256_ps512(first), second).simd_into(simd)
                }
            );
            gather_scaled(self, base, index, low, scale)
        }

        #[inline(always)]
        fn look_up_16(self, table: &[f32; 16], index: i32x16<Self>) -> f32x16<Self> {
            kernel!(
                #[inline(always)]
                fn look_up(simd: Avx512, table: f32x16<Avx512>, index: i32x16<Avx512>) -> f32x16<Avx512> {
                    _mm512_permutexvar_ps(index.into(), table.into()).simd_into(simd)
                }
            );
            look_up(self, f32x16::from_slice(self, table), index)
        }

        #[inline(always)]
        fn look_up_32(self, table: &[f32; 32], index: i32x16<Self>) -> f32x16<Self> {
            kernel!(
                #[inline(always)]
                fn look_up(simd: Avx512, table: [f32x16<Avx512>; 2], index: i32x16<Avx512>) -> f32x16<Avx512> {
                    let [low, high] = table;
                    _mm512_permutex2var_ps(low.into(), index.into(), high.into()).simd_into(simd)
                }
            );
            let (low, high) = table.split_at(LANES);
            look_up(self, [f32x16::from_slice(self, low), f32x16::from_slice(self, high)], index)
        }
    }

    impl Gather for Avx2 {
        #[inline(always)]
        unsafe fn gather(self, base: *const f32, index: i32x16<Self>) -> f32x16<Self> {
            kernel!(
                #[inline(always)]
                fn gather(simd: Avx2, base: *const f32, index: i32x8<Avx2>) -> f32x8<Avx2> {
                    // SAFETY: the caller of the method vouches for all places.
                    unsafe { _mm256_i32gather_ps::<4>(base, index.into()).simd_into(simd) }
                }
            );
            let (low, high) = self.split_i32x16(index);
            self.combine_f32x8(gather(self, base, low), gather(self, base, high))
        }

        #[inline(always)]
        unsafe fn gather_pairs(self, base: *const f32, index: i32x16<Self>) -> [f32x16<Self>; 2] {
            kernel!(
                #[inline(always)]
                fn gather_pairs(simd: Avx2, base: *const f32, index: i32x8<Avx2>) -> [f32x8<Avx2>; 2] {
                    let index: __m256i = index.into();
                    let halves = [_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index)];
                    // A pair of f32 travels as the bits of one f64.
                    // SAFETY: the caller of the method vouches for all places.
                    let [low, high] =
                        halves.map(|index| unsafe { _mm256_castpd_ps(_mm256_i32gather_pd::<4>(base.cast(), index)) });
                    // Shuffles work within halves of the register: what they mix up is put in order by fours.
                    let order =
                        |mixed| _mm256_castpd_ps(_mm256_permute4x64_pd::<0b11_01_10_00>(_mm256_castps_pd(mixed)));
                    let even = order(_mm256_shuffle_ps::<0b10_00_10_00>(low, high));
                    let odd = order(_mm256_shuffle_ps::<0b11_01_11_01>(low, high));
                    [even.simd_into(simd), odd.simd_into(simd)]
                }
            );
            let (low, high) = self.split_i32x16(index);
            let ([low_even, low_odd], [high_even, high_odd]) =
                (gather_pairs(self, base, low), gather_pairs(self, base, high));
            [self.combine_f32x8(low_even, high_even), self.combine_f32x8(low_odd, high_odd)]
        }

        #[inline(always)]
        unsafe fn gather_scaled(self, base: *const f64, index: i32x16<Self>, low: f64, scale: f64) -> f32x16<Self> {
            kernel!(
                #[inline(always)]
                fn gather_scaled(
                    simd: Avx2,
                    base: *const f64,
                    index: i32x8<Avx2>,
                    low: f64,
                    scale: f64,
                ) -> f32x8<Avx2> {
                    let index: __m256i = index.into();
                    let halves = [_mm256_castsi256_si128(index), _mm256_extracti128_si256::<1>(index)];
                    let [first, second] = halves.map(|index| {
                        // SAFETY: the caller of the method vouches for all places.
                        let values = unsafe { _mm256_i32gather_pd::<8>(base, index) };
                        let above = _mm256_sub_pd(values, _mm256_set1_pd(low));
                        _mm256_cvtpd_ps(_mm256_mul_pd(above, _mm256_set1_pd(scale)))
                    });
                    _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second).simd_into(simd)
                }
            );
            let halves = self.split_i32x16(index);
            self.combine_f32x8(
                gather_scaled(self, base, halves.0, low, scale),
                gather_scaled(self, base, halves.1, low, scale),
            )
        }

        #[inline(always)]
        fn look_up_16(self, table: &[f32; 16], index: i32x16<Self>) -> f32x16<Self> {
            // SAFETY: the masked indices lie in the table.
            unsafe { self.gather(table.as_ptr(), index & i32x16::splat(self, 15)) }
        }

        #[inline(always)]
        fn look_up_32(self, table: &[f32; 32], index: i32x16<Self>) -> f32x16<Self> {
            // SAFETY: the masked indices lie in the table.
            unsafe { self.gather(table.as_ptr(), index & i32x16::splat(self, 31)) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{InstructionSet, Integers, Kernel};
    use super::*;

    struct Gathers<'a> {
        singles: &'a [f32],
        doubles: &'a [f64],
        table: &'a [f32; 40],
        index: [i32; LANES],
    }

    impl Kernel for Gathers<'_> {
        type Output = [[f32; LANES]; 7];
        fn run<S: Gather>(self, simd: S) -> Self::Output {
            let index = Integers::from_slice(simd, &self.index);
            // SAFETY: the indices, and those behind them, lie in the slices.
            unsafe {
                let [first, second] = simd.gather_pairs(self.singles.as_ptr(), index);
                [
                    *simd.gather(self.singles.as_ptr(), index),
                    *first,
                    *second,
                    *simd.gather_scaled(self.doubles.as_ptr(), index, 3.0, 0.5),
                    *simd.look_up(&self.table[..16], index & Integers::splat(simd, 15)),
                    *simd.look_up(&self.table[..32], index & Integers::splat(simd, 31)),
                    *simd.look_up(self.table, index),
                ]
            }
        }
    }

    #[test]
    fn every_instruction_set_gathers_the_same() {
        let singles: Vec<f32> = (0..100).map(|value| value as f32).collect();
        let doubles: Vec<f64> = (0..100).map(f64::from).collect();
        let table = std::array::from_fn(|place| 1000.0 + place as f32);
        let index: [i32; LANES] = std::array::from_fn(|lane| (lane as i32 * 37 + 5) % 98);
        for set in InstructionSet::available() {
            let found = set.run(Gathers { singles: &singles, doubles: &doubles, table: &table, index });
            let expected = [
                index.map(|i| i as f32),
                index.map(|i| i as f32),
                index.map(|i| i as f32 + 1.0),
                index.map(|i| (i as f32 - 3.0) * 0.5),
                index.map(|i| 1000.0 + (i % 16) as f32),
                index.map(|i| 1000.0 + (i % 32) as f32),
                index.map(|i| 1000.0 + i.min(39) as f32),
            ];
            assert_eq!(found, expected, "{}", set.name());
        }
    }
}
