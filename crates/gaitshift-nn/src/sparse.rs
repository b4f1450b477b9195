//! Products of matrices that leave out the zeros of their left matrix.
//!
//! A rectifier passes on a third to two thirds of its units, and the derivative that comes back through it has the same
//! zeros. A [`Pattern`] marks what is not zero, and [`multiply`] visits the marked elements only. Since a product with 0
//! adds nothing to a sum and the others stay in order, the result has the same bits as that of [`dense::multiply`] (as long
//! as B is finite, and but for the sign of zeros).
//!
//! A row of sums stays in registers while the elements of the same row of A, 64 at a time, each bring their row of B: one
//! load for a multiply-add, against seven for twelve in the dense kernel. So this one pays where it has a fifth less
//! to do, and hands over to the dense one where it has not.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::dense;
use crate::pattern::{Pattern, WORD};
use crate::product::{Columns, Kernel, Product, Registers, run, width};
use crate::simd::{LANES, Scalar, Simd, Vector};

/// Above this share of elements that are not zero the dense kernel is faster.
const NEARLY_DENSE: f64 = 0.78;

/// Whether every product is left to the dense kernel.
static DENSE_ONLY: AtomicBool = AtomicBool::new(false);

/// Makes the whole process multiply zeros like other numbers, with the same results: to compare the two.
pub fn count_zeros_too() {
    DENSE_ONLY.store(true, Ordering::Relaxed);
}

/// C = A B, given the pattern of A.
///
/// # Panics
/// When the pattern is of a matrix of another size, or as [`dense::multiply`].
pub fn multiply<T: Scalar>(product: Product<'_, T>, pattern: &Pattern) {
    assert!(
        pattern.sizes() == (product.rows, product.shared),
        "the pattern is of another matrix"
    );
    let dense = product.shared == 0 || product.columns == 0 || pattern.share() > NEARLY_DENSE;
    if dense || DENSE_ONLY.load(Ordering::Relaxed) {
        dense::multiply(product);
    } else {
        product.check();
        run(Sparse { product, pattern });
    }
}

struct Sparse<'a, T> {
    product: Product<'a, T>,
    pattern: &'a Pattern,
}

impl<T: Scalar> Kernel<T> for Sparse<'_, T> {
    #[inline(always)]
    fn run<W: Simd<T>, H: Simd<T>>(self, wide: W, eight: H) {
        let registers = Registers { wide, eight };
        let Self {
            mut product,
            pattern,
        } = self;
        let lanes = <W::Vector as Vector<T>>::LANES;
        // Vectors of sums in a row at most: of eight with a factor they leave two of sixteen registers free; with more of
        // sixteen, the rows of B that a word of marks visits outgrow the first-level cache.
        let most = if lanes == LANES { 13 } else { 8 };
        let vectors = product.columns / lanes;
        let half = !product.columns.is_multiple_of(lanes);
        let strips = vectors.div_ceil(most).max(1);
        for index in 0..strips {
            let (from, to) = (vectors * index / strips, vectors * (index + 1) / strips);
            let (first, half) = (from * lanes, half && index + 1 == strips);
            let product = &mut product;
            // By name each, so that all are inlined and compiled for the processor's vectors.
            macro_rules! strips {
                ($($count:literal)+; $($of_eight:literal)+) => {
                    match (to - from, half) {
                        $(
                            ($count, false) => {
                                strip::<T, W, H, $count, 0>(registers, first, product, pattern);
                            }
                            ($count, true) if lanes > LANES => {
                                strip::<T, W, H, $count, 1>(registers, first, product, pattern);
                            }
                        )+
                        $(
                            ($of_eight, _) if lanes == LANES => {
                                strip::<T, W, H, $of_eight, 0>(registers, first, product, pattern);
                            }
                        )+
                        (count, _) => unreachable!("{count} vectors in a strip"),
                    }
                };
            }
            strips!(0 1 2 3 4 5 6 7 8; 9 10 11 12 13);
        }
    }
}

/// The columns from `first` on: `N` vectors, and `E` of eight.
#[inline(always)]
fn strip<T: Scalar, W: Simd<T>, H: Simd<T>, const N: usize, const E: usize>(
    registers: Registers<W, H>,
    first: usize,
    product: &mut Product<'_, T>,
    pattern: &Pattern,
) {
    let Product { rows, epilogue, .. } = *product;
    let (a, a_row, a_column) = product.a.strides();
    let words = product.shared.div_ceil(WORD);
    let start: Columns<W::Vector, H::Vector, N, E> = registers.start(epilogue, first);
    for word in 0..words {
        // All rows visit this part of B before the next: it is small enough to stay in the first-level cache.
        let b = &product.b[word * WORD * product.b_stride + first..];
        let a = &a[word * WORD * a_column..];
        let rows_of_c = product.c.chunks_mut(product.c_stride).take(rows);
        let mut marks = pattern.column(word);
        let mut next = marks.next().unwrap_or(0);
        for (row, c) in rows_of_c.enumerate() {
            // The next marks are read early: the end of the loop below is hard to predict, and all that follows it waits.
            let mut left = std::mem::replace(&mut next, marks.next().unwrap_or(0));
            let c = &mut c[first..][..width::<T, W>(N, E)];
            let mut sums: Columns<W::Vector, H::Vector, N, E> =
                if word > 0 { registers.load(c) } else { start };
            let a = &a[row * a_row..];
            while left != 0 {
                let index = left.trailing_zeros() as usize;
                left &= left - 1;
                // SAFETY: the product was checked, its pattern has its sizes and marks no element outside them.
                let (factor, columns) = unsafe {
                    let factor = *a.get_unchecked(index * a_column);
                    (
                        factor,
                        registers.load_unchecked(b, index * product.b_stride),
                    )
                };
                registers.add_product(factor, columns, &mut sums);
            }
            if word + 1 == words {
                registers.finish(epilogue, row, first, &mut sums);
            }
            registers.store(sums, c);
        }
    }
}
