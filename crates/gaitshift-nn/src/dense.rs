//! Products of dense matrices, in tiles of a few rows by a few vectors of columns whose sums stay in registers.

use crate::product::{Columns, Epilogue, Kernel, Product, Registers, run};
use crate::simd::{LANES, Scalar, Simd, Vector};

/// Rows that go through all columns before the next ones do: their part of A stays in the first-level cache.
const BLOCK: usize = 24;

/// C = A B with the fastest kernel of this processor.
///
/// # Panics
/// When a matrix does not lie inside its slice, its rows overlap, or the columns are no multiple of 8.
pub fn multiply<T: Scalar>(product: Product<'_, T>) {
    product.check();
    run(Dense(product));
}

struct Dense<'a, T>(Product<'a, T>);

impl<T: Scalar> Kernel<T> for Dense<'_, T> {
    #[inline(always)]
    fn run<W: Simd<T>, H: Simd<T>>(self, wide: W, eight: H) {
        let Self(mut product) = self;
        let registers = Registers { wide, eight };
        let lanes = <W::Vector as Vector<T>>::LANES;
        for from in (0..product.rows).step_by(BLOCK) {
            let rows = from..product.rows.min(from + BLOCK);
            let mut first = 0;
            while first < product.columns {
                let left = product.columns - first;
                let vectors = strip_vectors(left.div_ceil(lanes), lanes);
                let half = vectors * lanes > left;
                let product = &mut product;
                let rows = rows.clone();
                // By name each, so that all are inlined and compiled for the processor's vectors. Rows of a tile: as many as
                // leave registers for a row of B and a factor, of sixteen (vectors of 8) or of thirty-two.
                if lanes == LANES {
                    match vectors {
                        2 => strip::<T, W, H, 2, 0, 6>(registers, rows, first, product),
                        _ => strip::<T, W, H, 1, 0, 12>(registers, rows, first, product),
                    }
                } else {
                    match (vectors, half) {
                        (4, false) => strip::<T, W, H, 4, 0, 6>(registers, rows, first, product),
                        (4, true) => strip::<T, W, H, 3, 1, 6>(registers, rows, first, product),
                        (3, false) => strip::<T, W, H, 3, 0, 8>(registers, rows, first, product),
                        (3, true) => strip::<T, W, H, 2, 1, 8>(registers, rows, first, product),
                        (2, false) => strip::<T, W, H, 2, 0, 12>(registers, rows, first, product),
                        (2, true) => strip::<T, W, H, 1, 1, 12>(registers, rows, first, product),
                        (_, false) => strip::<T, W, H, 1, 0, 12>(registers, rows, first, product),
                        (_, true) => strip::<T, W, H, 0, 1, 12>(registers, rows, first, product),
                    }
                }
                first += vectors * lanes;
            }
        }
    }
}

/// Vectors of the next strip when `left` remain: as many as the registers allow, because a tile then loads least for its
/// arithmetic, unless a single one would be left over, whose tiles load most.
#[inline(always)]
fn strip_vectors(left: usize, lanes: usize) -> usize {
    // Three of eight by four rows would fill all sixteen registers, and the compiler then keeps a sum in memory.
    if lanes == LANES {
        return left.min(2);
    }
    if left == 5 { 3 } else { left.min(4) }
}

/// Some rows in the columns from `first` on, in tiles of `R` rows and what is left over.
#[inline(always)]
fn strip<T: Scalar, W: Simd<T>, H: Simd<T>, const N: usize, const E: usize, const R: usize>(
    registers: Registers<W, H>,
    rows: std::ops::Range<usize>,
    first: usize,
    product: &mut Product<'_, T>,
) {
    let mut row = rows.start;
    while row < rows.end {
        let left = rows.end - row;
        if left >= R {
            tile::<T, W, H, N, E, R>(registers, row, first, product);
            row += R;
        } else if left >= 4 {
            tile::<T, W, H, N, E, 4>(registers, row, first, product);
            row += 4;
        } else if left >= 2 {
            tile::<T, W, H, N, E, 2>(registers, row, first, product);
            row += 2;
        } else {
            tile::<T, W, H, N, E, 1>(registers, row, first, product);
            row += 1;
        }
    }
}

#[inline(always)]
fn tile<T: Scalar, W: Simd<T>, H: Simd<T>, const N: usize, const E: usize, const R: usize>(
    registers: Registers<W, H>,
    row: usize,
    first: usize,
    product: &mut Product<'_, T>,
) {
    let Product {
        shared,
        a,
        b,
        b_stride,
        c_stride,
        epilogue,
        ..
    } = *product;
    let Registers { wide, eight } = registers;
    let lanes = <W::Vector as Vector<T>>::LANES;
    let (a, a_row, a_column) = a.strides();
    let mut sums = [[wide.splat(T::ZERO); N]; R];
    let mut sums_of_eight = [[eight.splat(T::ZERO); E]; R];
    if let Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) = epilogue {
        let bias = registers.load::<T, N, E>(&bias[first..]);
        sums = [bias.wide; R];
        sums_of_eight = [bias.eight; R];
    }
    for index in 0..shared {
        let mut vectors = [wide.splat(T::ZERO); N];
        let mut vectors_of_eight = [eight.splat(T::ZERO); E];
        // SAFETY: the product was checked, and rows and columns of the tile are there. (With bounds checks in this loop sums
        // leave the registers, and it takes twice as long.)
        unsafe {
            let b = b.get_unchecked(index * b_stride + first..);
            for (v, vector) in vectors.iter_mut().enumerate() {
                *vector = wide.load(b.get_unchecked(v * lanes..(v + 1) * lanes));
            }
            for (v, vector) in vectors_of_eight.iter_mut().enumerate() {
                let start = N * lanes + v * LANES;
                *vector = eight.load(b.get_unchecked(start..start + LANES));
            }
        }
        for (r, (sums, sums_of_eight)) in sums.iter_mut().zip(&mut sums_of_eight).enumerate() {
            // SAFETY: likewise.
            let factor = unsafe { *a.get_unchecked((row + r) * a_row + index * a_column) };
            let factors = wide.splat(factor);
            for (sum, vector) in sums.iter_mut().zip(vectors) {
                *sum = factors.mul_add(vector, *sum);
            }
            if E > 0 {
                let factors = eight.splat(factor);
                for (sum, vector) in sums_of_eight.iter_mut().zip(vectors_of_eight) {
                    *sum = factors.mul_add(vector, *sum);
                }
            }
        }
    }
    for (r, (wide, eight)) in sums.into_iter().zip(sums_of_eight).enumerate() {
        let mut sums = Columns { wide, eight };
        registers.finish(epilogue, row + r, first, &mut sums);
        registers.store(sums, &mut product.c[(row + r) * c_stride + first..]);
    }
}
