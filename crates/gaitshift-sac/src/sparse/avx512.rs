//! The product that leaves out zeros, for processors with AVX-512: vectors of 16, so half as many instructions and loads, which
//! counts where another thread shares the core. Sums are those of the other kernels, in the same order.

use std::arch::x86_64::*;

use super::{Pattern, WORD};
use crate::dense::{Epilogue, Product};

/// Columns of a vector.
const WIDE: usize = 16;
/// Vectors of sums in a row at most: with more, a word's rows of B outgrow the first-level cache.
const MOST: usize = 8;

/// Columns from `first` on: `N` vectors, and half of one more where `HALF`.
///
/// # Safety
/// AVX-512 present, `product.check()` passed, the pattern is that of A, and the columns are there.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma,bmi1")]
unsafe fn strip<const N: usize, const HALF: bool>(
    first: usize,
    product: &mut Product<'_, f32>,
    pattern: &Pattern,
) {
    let Product {
        rows,
        a,
        b_stride,
        c_stride,
        epilogue,
        ..
    } = *product;
    let width = pattern.width();
    // SAFETY: rows, columns and marked elements, and so every pointer below, lie inside the slices.
    unsafe {
        for word in 0..width {
            // The part of B that all rows visit before the next.
            let b = product.b.as_ptr().add(word * WORD * b_stride + first);
            for row in 0..rows {
                let c = product.c.as_mut_ptr().add(row * c_stride + first);
                let mut sums = [_mm512_setzero_ps(); N];
                let mut half = _mm256_setzero_ps();
                let start = match epilogue {
                    _ if word > 0 => Some(c.cast_const()),
                    Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) => {
                        Some(bias.as_ptr().add(first))
                    }
                    Epilogue::None | Epilogue::Mask(..) => None,
                };
                if let Some(start) = start {
                    for (v, sum) in sums.iter_mut().enumerate() {
                        *sum = _mm512_loadu_ps(start.add(v * WIDE));
                    }
                    if HALF {
                        half = _mm256_loadu_ps(start.add(N * WIDE));
                    }
                }
                let factors = a.values.as_ptr().add(row * a.row + word * WORD * a.step);
                let mut left = pattern.words[row * width + word];
                while left != 0 {
                    let index = left.trailing_zeros() as usize;
                    left &= left - 1;
                    let factor = _mm512_set1_ps(*factors.add(index * a.step));
                    let vectors = b.add(index * b_stride);
                    for (v, sum) in sums.iter_mut().enumerate() {
                        *sum =
                            _mm512_fmadd_ps(factor, _mm512_loadu_ps(vectors.add(v * WIDE)), *sum);
                    }
                    if HALF {
                        let factor = _mm512_castps512_ps256(factor);
                        half =
                            _mm256_fmadd_ps(factor, _mm256_loadu_ps(vectors.add(N * WIDE)), half);
                    }
                }
                if word + 1 == width {
                    let (zero, half_zero) = (_mm512_setzero_ps(), _mm256_setzero_ps());
                    match epilogue {
                        Epilogue::None | Epilogue::Bias(_) => {}
                        Epilogue::BiasRelu(_) => {
                            // In this order of operands NaN stays NaN and is noticed.
                            for sum in &mut sums {
                                *sum = _mm512_max_ps(zero, *sum);
                            }
                            half = _mm256_max_ps(half_zero, half);
                        }
                        Epilogue::Mask(mask, stride) => {
                            let mask = mask.as_ptr().add(row * stride + first);
                            for (v, sum) in sums.iter_mut().enumerate() {
                                let mask = _mm512_loadu_ps(mask.add(v * WIDE));
                                let positive = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(mask, zero);
                                *sum = _mm512_maskz_mov_ps(positive, *sum);
                            }
                            if HALF {
                                let mask = _mm256_loadu_ps(mask.add(N * WIDE));
                                half = _mm256_and_ps(
                                    half,
                                    _mm256_cmp_ps::<_CMP_GT_OQ>(mask, half_zero),
                                );
                            }
                        }
                    }
                }
                for (v, &sum) in sums.iter().enumerate() {
                    _mm512_storeu_ps(c.add(v * WIDE), sum);
                }
                if HALF {
                    _mm256_storeu_ps(c.add(N * WIDE), half);
                }
            }
        }
    }
}

/// # Safety
/// AVX-512 present, `product.check()` passed, the pattern is that of A.
#[target_feature(enable = "avx512f,avx2,fma,bmi1")]
pub unsafe fn multiply(mut product: Product<'_, f32>, pattern: &Pattern) {
    let vectors = product.columns / WIDE;
    let odd = !product.columns.is_multiple_of(WIDE);
    let strips = vectors.div_ceil(MOST).max(1);
    for index in 0..strips {
        let (from, to) = (vectors * index / strips, vectors * (index + 1) / strips);
        let half = odd && index + 1 == strips;
        macro_rules! strips {
            ($($count:literal)+) => {
                match (to - from, half) {
                    $(
                        ($count, false) => strip::<$count, false>(from * WIDE, &mut product, pattern),
                        ($count, true) => strip::<$count, true>(from * WIDE, &mut product, pattern),
                    )+
                    _ => unreachable!(),
                }
            };
        }
        // SAFETY: passed on from the caller; the columns are there.
        unsafe { strips!(0 1 2 3 4 5 6 7 8) };
    }
}
