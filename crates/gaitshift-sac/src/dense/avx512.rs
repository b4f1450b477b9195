//! The dense product for processors with AVX-512: vectors of 16, tiles of 24 sums. Half the instructions and loads of the code
//! for AVX2, which counts where another thread shares the core; the same sums in the same order.

use std::arch::x86_64::*;

use super::{Epilogue, Product};

/// Columns of a vector.
const WIDE: usize = 16;
/// Rows that go through all columns before the next ones do; all tiles' rows divide it.
const BLOCK: usize = 24;

/// Vectors of the next strip of tiles when `left` remain, half a vector counted whole; a single one, whose tiles load
/// most, is avoided.
#[inline(always)]
fn tile_vectors(left: usize) -> usize {
    match left {
        5 => 3,
        _ => left.min(4),
    }
}

/// # Safety
/// AVX-512, AVX2 and FMA present, `product.check()` passed.
#[target_feature(enable = "avx512f,avx2,fma")]
pub unsafe fn multiply(mut product: Product<'_, f32>) {
    let product = &mut product;
    let columns = product.columns;
    for from in (0..product.rows).step_by(BLOCK) {
        let to = product.rows.min(from + BLOCK);
        let mut first = 0;
        while first < columns {
            let vectors = tile_vectors((columns - first).div_ceil(WIDE));
            let half = first + vectors * WIDE > columns;
            // SAFETY: passed on from the caller; rows and columns are there.
            unsafe {
                match (vectors, half) {
                    (4, false) => strip::<4, false, 6>(from, to, first, product),
                    (4, true) => strip::<3, true, 6>(from, to, first, product),
                    (3, false) => strip::<3, false, 8>(from, to, first, product),
                    (3, true) => strip::<2, true, 8>(from, to, first, product),
                    (2, false) => strip::<2, false, 12>(from, to, first, product),
                    (2, true) => strip::<1, true, 12>(from, to, first, product),
                    (_, false) => strip::<1, false, 24>(from, to, first, product),
                    (_, true) => strip::<0, true, 24>(from, to, first, product),
                }
            }
            first += vectors * WIDE;
        }
    }
}

/// Rows `from..to` of `V` vectors of columns, and half of one more where `HALF`, the first of which is `first`, in tiles of
/// `R` rows and what is left over.
#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn strip<const V: usize, const HALF: bool, const R: usize>(
    from: usize,
    to: usize,
    first: usize,
    product: &mut Product<'_, f32>,
) {
    let mut row = from;
    while row < to {
        // SAFETY: the tile lies inside what the caller passed on.
        unsafe {
            match to - row {
                left if left >= R => {
                    tile::<V, HALF, R>(row, first, product);
                    row += R;
                }
                left if left >= 4 => {
                    tile::<V, HALF, 4>(row, first, product);
                    row += 4;
                }
                2.. => {
                    tile::<V, HALF, 2>(row, first, product);
                    row += 2;
                }
                _ => {
                    tile::<V, HALF, 1>(row, first, product);
                    row += 1;
                }
            }
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f,avx2,fma")]
unsafe fn tile<const V: usize, const HALF: bool, const R: usize>(
    row: usize,
    first: usize,
    product: &mut Product<'_, f32>,
) {
    // SAFETY: the caller's tile lies inside the slices.
    unsafe {
        let a = product.a.values.as_ptr().add(row * product.a.row);
        let b = product.b.as_ptr().add(first);
        let c = product.c.as_mut_ptr().add(row * product.c_stride + first);
        let mut sums = [[_mm512_setzero_ps(); V]; R];
        let mut halves = [_mm256_setzero_ps(); R];
        if let Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) = product.epilogue {
            let bias = bias.as_ptr().add(first);
            for v in 0..V {
                let bias = _mm512_loadu_ps(bias.add(v * WIDE));
                for row in &mut sums {
                    row[v] = bias;
                }
            }
            if HALF {
                halves = [_mm256_loadu_ps(bias.add(V * WIDE)); R];
            }
        }
        for index in 0..product.shared {
            let b = b.add(index * product.b_stride);
            let vectors: [__m512; V] = std::array::from_fn(|v| _mm512_loadu_ps(b.add(v * WIDE)));
            let half = if HALF {
                _mm256_loadu_ps(b.add(V * WIDE))
            } else {
                _mm256_setzero_ps()
            };
            let a = a.add(index * product.a.step);
            for (r, row) in sums.iter_mut().enumerate() {
                let factor = _mm512_set1_ps(*a.add(r * product.a.row));
                for (sum, vector) in row.iter_mut().zip(vectors) {
                    *sum = _mm512_fmadd_ps(factor, vector, *sum);
                }
                if HALF {
                    halves[r] = _mm256_fmadd_ps(_mm512_castps512_ps256(factor), half, halves[r]);
                }
            }
        }
        for (r, row_of) in sums.iter().enumerate() {
            let c = c.add(r * product.c_stride);
            let mask = match product.epilogue {
                Epilogue::Mask(mask, stride) => mask.as_ptr().add((row + r) * stride + first),
                _ => std::ptr::null(),
            };
            for (v, &sum) in row_of.iter().enumerate() {
                let zero = _mm512_setzero_ps();
                let value = match product.epilogue {
                    Epilogue::None | Epilogue::Bias(_) => sum,
                    // In this order of operands NaN stays NaN and is noticed.
                    Epilogue::BiasRelu(_) => _mm512_max_ps(zero, sum),
                    Epilogue::Mask(..) => {
                        let mask = _mm512_loadu_ps(mask.add(v * WIDE));
                        _mm512_maskz_mov_ps(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(mask, zero), sum)
                    }
                };
                _mm512_storeu_ps(c.add(v * WIDE), value);
            }
            if HALF {
                let zero = _mm256_setzero_ps();
                let value = match product.epilogue {
                    Epilogue::None | Epilogue::Bias(_) => halves[r],
                    Epilogue::BiasRelu(_) => _mm256_max_ps(zero, halves[r]),
                    Epilogue::Mask(..) => {
                        let mask = _mm256_loadu_ps(mask.add(V * WIDE));
                        _mm256_and_ps(halves[r], _mm256_cmp_ps::<_CMP_GT_OQ>(mask, zero))
                    }
                };
                _mm256_storeu_ps(c.add(V * WIDE), value);
            }
        }
    }
}
