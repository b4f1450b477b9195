//! Matrix products that leave out the zeros of their left matrix.
//!
//! A rectifier passes on a third to two thirds of its units, and the derivative that comes back through it has the same
//! zeros. A [`Pattern`] marks what is not zero, a bit for each element, and [`multiply`] visits the marked elements
//! only. Since a product with 0 adds nothing to a sum and the others stay in order, the result has the same bits as that
//! of [`dense::multiply`] (as long as B is finite, and but for the sign of zeros).
//!
//! A row of sums stays in registers while the elements of the same row of A, 64 at a time, each bring their row of B: one
//! load for a multiply-add, against seven for twelve in the dense kernel. So this one pays where it has a fifth less
//! to do, and hands over to the dense one where it has not.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::dense::{self, Epilogue, Product};
use crate::lanes::{LANES, Lanes};
use crate::real::{Real, wide};

#[cfg(target_arch = "x86_64")]
mod avx512;

/// Elements that a word marks.
const WORD: usize = u64::BITS as usize;
/// Vectors of sums in a row at most; with a factor they leave two of sixteen registers free.
const MOST: usize = 13;
/// Above this share of marked elements the dense kernel is faster.
const CROWDED: f64 = 0.78;

/// Marks of a matrix's elements that are not zero.
#[derive(Clone, Debug)]
pub struct Pattern {
    rows: usize,
    columns: usize,
    /// Row by row; the lowest bit of a row's first word is its first element.
    words: Vec<u64>,
}

impl Pattern {
    /// With memory for matrices of up to `rows` × `columns`, and for their transposes.
    pub fn new(rows: usize, columns: usize) -> Self {
        let words = (rows * columns.div_ceil(WORD)).max(columns * rows.div_ceil(WORD));
        Self {
            rows: 0,
            columns: 0,
            words: vec![0; words],
        }
    }

    /// Words of a row.
    fn width(&self) -> usize {
        self.columns.div_ceil(WORD)
    }

    fn count(&self) -> usize {
        let words = &self.words[..self.rows * self.width()];
        words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// It is that of the product's left matrix, as far as sizes tell.
    fn check<T>(&self, product: &Product<'_, T>) {
        assert!(
            (self.rows, self.columns) == (product.rows, product.shared),
            "the pattern is of another matrix"
        );
    }

    /// Marks what is not zero in `rows` rows of `x`, `stride` apart and padded to a whole number of vectors.
    pub fn read<T: Real>(&mut self, rows: usize, columns: usize, x: &[T], stride: usize) {
        (self.rows, self.columns) = (rows, columns);
        let width = self.width();
        mark(columns, x, stride, &mut self.words[..rows * width]);
    }

    /// Becomes the transpose of `other`.
    pub fn transpose(&mut self, other: &Self) {
        (self.rows, self.columns) = (other.columns, other.rows);
        let (width, other_width) = (self.width(), other.width());
        for (word, others) in (0..other.rows).step_by(WORD).enumerate() {
            let others = others..other.rows.min(others + WORD);
            for other_word in 0..other_width {
                let mut square = [0; WORD];
                for (bits, row) in square.iter_mut().zip(others.clone()) {
                    *bits = other.words[row * other_width + other_word];
                }
                transpose(&mut square);
                let rows = other_word * WORD..self.rows.min((other_word + 1) * WORD);
                for (row, bits) in rows.zip(square) {
                    self.words[row * width + word] = bits;
                }
            }
        }
    }
}

/// Marks of `GROUPS` groups of lanes.
#[inline(always)]
fn marks<T: Real, V: Lanes<T>, const GROUPS: usize>(x: &[T]) -> u64 {
    let x = &x[..GROUPS * LANES];
    let mut word = 0;
    for group in 0..GROUPS {
        word |= u64::from(V::load(x, group * LANES).not_zero()) << (group * LANES);
    }
    word
}

wide! {
    fn mark<T, V>(columns: usize, x: &[T], stride: usize, words: &mut [u64]) {
        let width = columns.div_ceil(WORD);
        let padded = dense::padded(columns);
        // Padding is no element.
        let last = u64::MAX >> (width * WORD - columns);
        for (row, words) in words.chunks_exact_mut(width).enumerate() {
            let (whole, rest) = x[row * stride..][..padded].as_chunks::<WORD>();
            for (word, x) in words.iter_mut().zip(whole) {
                *word = marks::<T, V, { WORD / LANES }>(x);
            }
            if let Some(word) = words.get_mut(whole.len()) {
                *word = rest
                    .chunks_exact(LANES)
                    .rev()
                    .fold(0, |word, x| word << LANES | marks::<T, V, 1>(x));
            }
            words[width - 1] &= last;
        }
    }
}

/// Bit `c` of word `r` to bit `r` of word `c`: squares of bits change places across the diagonal, of 32 × 32 first.
fn transpose(square: &mut [u64; WORD]) {
    let mut half = WORD / 2;
    let mut low = u64::MAX >> half;
    while half > 0 {
        for pair in square.chunks_exact_mut(2 * half) {
            let (upper, lower) = pair.split_at_mut(half);
            for (upper, lower) in upper.iter_mut().zip(lower) {
                let change = ((*upper >> half) ^ *lower) & low;
                *upper ^= change << half;
                *lower ^= change;
            }
        }
        half /= 2;
        low ^= low << half;
    }
}

/// Whether every product is left to the dense kernel.
static DENSE_ONLY: AtomicBool = AtomicBool::new(false);

/// Makes the whole process multiply zeros like other numbers, with the same results: to compare the two.
pub fn count_zeros_too() {
    DENSE_ONLY.store(true, Ordering::Relaxed);
}

/// C = A B, given the pattern of A.
///
/// # Panics
/// When the pattern was read from a matrix of another size, or an index lies outside its slice.
pub fn multiply<T: Real>(product: Product<'_, T>, pattern: &Pattern) {
    pattern.check(&product);
    let elements = (product.rows * product.shared) as f64;
    let crowded = pattern.count() as f64 > CROWDED * elements;
    if crowded || DENSE_ONLY.load(Ordering::Relaxed) {
        dense::multiply(product);
    } else {
        T::multiply_marked(product, pattern);
    }
}

/// [`multiply`] of `f32`, not crowded, with the fastest kernel of this processor.
pub(crate) fn marked_f32(product: Product<'_, f32>, pattern: &Pattern) {
    #[cfg(target_arch = "x86_64")]
    if dense::has_avx512() {
        pattern.check(&product);
        product.check();
        // SAFETY: the processor has AVX-512, and both checks hold.
        unsafe { avx512::multiply(product, pattern) };
        return;
    }
    marked(product, pattern);
}

/// Columns from `first` on, `N` vectors of them.
#[inline(always)]
fn strip<T: Real, V: Lanes<T>, const N: usize>(
    first: usize,
    product: &mut Product<'_, T>,
    pattern: &Pattern,
) {
    let Product {
        rows, a, epilogue, ..
    } = *product;
    let width = pattern.width();
    for word in 0..width {
        // The part of B that all rows visit before the next, few enough to stay in the first-level cache.
        let b = &product.b[word * WORD * product.b_stride + first..];
        for row in 0..rows {
            let c = &mut product.c[row * product.c_stride + first..][..N * LANES];
            let mut sums: [V; N] = if word > 0 {
                std::array::from_fn(|v| V::load(c, v * LANES))
            } else if let Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) = epilogue {
                let bias = &bias[first..][..N * LANES];
                std::array::from_fn(|v| V::load(bias, v * LANES))
            } else {
                [V::splat(T::ZERO); N]
            };
            let factors = &a.values[row * a.row + word * WORD * a.step..];
            let mut left = pattern.words[row * width + word];
            while left != 0 {
                let index = left.trailing_zeros() as usize;
                left &= left - 1;
                let factor = V::splat(factors[index * a.step]);
                let vectors = &b[index * product.b_stride..][..N * LANES];
                for (v, sum) in sums.iter_mut().enumerate() {
                    *sum = factor.mul_add(V::load(vectors, v * LANES), *sum);
                }
            }
            if word + 1 == width {
                match epilogue {
                    Epilogue::None | Epilogue::Bias(_) => {}
                    Epilogue::BiasRelu(_) => sums = sums.map(V::rectify),
                    Epilogue::Mask(mask, stride) => {
                        let mask = &mask[row * stride + first..][..N * LANES];
                        for (v, sum) in sums.iter_mut().enumerate() {
                            *sum = sum.where_positive(V::load(mask, v * LANES));
                        }
                    }
                }
            }
            for (v, sum) in sums.into_iter().enumerate() {
                sum.store(c, v * LANES);
            }
        }
    }
}

wide! {
    /// [`multiply`], not crowded, for any processor and scalar.
    pub(crate) fn marked<T, V>(product: Product<'_, T>, pattern: &Pattern) {
        let mut product = product;
        let vectors = product.columns / LANES;
        let strips = vectors.div_ceil(MOST);
        for index in 0..strips {
            let (from, to) = (vectors * index / strips, vectors * (index + 1) / strips);
            let first = from * LANES;
            // By name each, so that all are inlined and compiled for the processor's vectors.
            match to - from {
                1 => strip::<T, V, 1>(first, &mut product, pattern),
                2 => strip::<T, V, 2>(first, &mut product, pattern),
                3 => strip::<T, V, 3>(first, &mut product, pattern),
                4 => strip::<T, V, 4>(first, &mut product, pattern),
                5 => strip::<T, V, 5>(first, &mut product, pattern),
                6 => strip::<T, V, 6>(first, &mut product, pattern),
                7 => strip::<T, V, 7>(first, &mut product, pattern),
                8 => strip::<T, V, 8>(first, &mut product, pattern),
                9 => strip::<T, V, 9>(first, &mut product, pattern),
                10 => strip::<T, V, 10>(first, &mut product, pattern),
                11 => strip::<T, V, 11>(first, &mut product, pattern),
                12 => strip::<T, V, 12>(first, &mut product, pattern),
                _ => strip::<T, V, MOST>(first, &mut product, pattern),
            }
        }
    }
}
