//! Matrix products of the small dense layers, the nine tenths of an update.
//!
//! Matrices are stored row by row, columns padded to a multiple of 8. No packing is ever needed: rows are [`row_stride`]
//! apart, so that the strips of columns that the kernels walk along stay in the cache, and the optimiser, which works
//! element by element, does not care.
//!
//! Every output element is one sum in the order of the shared index, whatever the tile it falls in, so the
//! result for a row does not depend on how many rows are computed with it. [`crate::sparse`] leaves out the terms of that
//! sum that are zero.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::lanes::LANES;
use crate::real::{LINE, Real, wide};

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

/// Columns of a matrix as stored: `columns` rounded up to a multiple of 8, the numbers of a vector.
pub fn padded(columns: usize) -> usize {
    columns.next_multiple_of(LANES)
}

/// Distance between the rows of a matrix of `columns` columns: an odd number of cache lines, so that
/// a column walk visits every set of the first-level cache.
pub fn row_stride(columns: usize) -> usize {
    (columns.div_ceil(LINE) | 1) * LINE
}

/// What the sums of a row start from, and what becomes of them before they are stored.
#[derive(Clone, Copy, Debug)]
pub enum Epilogue<'a, T> {
    /// From 0, stored as they are.
    None,
    /// From the biases of their columns.
    Bias(&'a [T]),
    /// From the biases of their columns; negative results become 0.
    BiasRelu(&'a [T]),
    /// From 0; the result becomes 0 where the matrix (same rows, given row stride) is not positive: the
    /// derivative of the rectifier.
    Mask(&'a [T], usize),
}

/// The left matrix of a product, read along its rows or, transposed, along its columns.
#[derive(Clone, Copy, Debug)]
pub struct Left<'a, T> {
    pub(crate) values: &'a [T],
    /// Distance between its rows.
    pub(crate) row: usize,
    /// Distance between the elements of a row.
    pub(crate) step: usize,
}

impl<'a, T> Left<'a, T> {
    /// X, row-major with rows `stride` apart.
    pub fn rows(x: &'a [T], stride: usize) -> Self {
        Self {
            values: x,
            row: stride,
            step: 1,
        }
    }

    /// Xᵀ of X, row-major with rows `stride` apart.
    pub fn transposed(x: &'a [T], stride: usize) -> Self {
        Self {
            values: x,
            row: 1,
            step: stride,
        }
    }
}

/// C = A B: `rows` × `shared` times `shared` × `columns`.
#[derive(Debug)]
pub struct Product<'a, T> {
    /// Rows of A and C.
    pub rows: usize,
    /// Columns of A, rows of B: the index that is summed over.
    pub shared: usize,
    /// Columns of B and C, a multiple of 8.
    pub columns: usize,
    /// A.
    pub a: Left<'a, T>,
    /// B, row-major.
    pub b: &'a [T],
    /// Distance between rows of B.
    pub b_stride: usize,
    /// C, row-major; what lies between its rows is left alone.
    pub c: &'a mut [T],
    /// Distance between rows of C.
    pub c_stride: usize,
    /// Start and end of the sums.
    pub epilogue: Epilogue<'a, T>,
}

impl<T> Product<'_, T> {
    /// Every index the kernels form lies inside the slices.
    pub(crate) fn check(&self) {
        assert!(self.fits(), "a product reaches outside its matrices");
    }

    fn fits(&self) -> bool {
        let Self {
            rows,
            shared,
            columns,
            ..
        } = *self;
        let matrix = |slice: &[T], rows: usize, stride: usize| {
            stride >= columns && reaches(slice, rows, stride, columns, 1)
        };
        let epilogue = match self.epilogue {
            Epilogue::None => true,
            Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) => bias.len() >= columns,
            Epilogue::Mask(mask, stride) => reaches(mask, rows, stride, columns, 1),
        };
        columns.is_multiple_of(LANES)
            && reaches(self.a.values, rows, self.a.row, shared, self.a.step)
            && matrix(self.b, shared, self.b_stride)
            && matrix(self.c, rows, self.c_stride)
            && epilogue
    }
}

/// Whether a matrix whose rows are `row` apart, and their elements `step`, lies inside `slice`.
fn reaches<T>(slice: &[T], rows: usize, row: usize, columns: usize, step: usize) -> bool {
    let (Some(rows), Some(columns)) = (rows.checked_sub(1), columns.checked_sub(1)) else {
        return true;
    };
    // In arithmetic that does not wrap: nothing else stands between a huge distance and memory of others.
    let last = rows
        .checked_mul(row)
        .zip(columns.checked_mul(step))
        .and_then(|(row, column)| row.checked_add(column));
    last.is_some_and(|last| last < slice.len())
}

/// C = A B with the fastest kernel of this processor.
///
/// # Panics
/// When a matrix does not lie inside its slice, its rows overlap, or the columns are no multiple of 8.
pub fn multiply<T: Real>(product: Product<'_, T>) {
    T::multiply(product);
}

/// The widest vectors that the code uses on this processor.
static KERNELS: AtomicU8 = AtomicU8::new(UNKNOWN);
const UNKNOWN: u8 = 0;
const PORTABLE: u8 = 1;
const AVX2_FMA: u8 = 2;
const AVX512: u8 = 3;

#[inline(always)]
fn kernels() -> u8 {
    match KERNELS.load(Ordering::Relaxed) {
        UNKNOWN => detect(),
        kernels => kernels,
    }
}

/// Whether the code for AVX2 and FMA runs.
#[inline(always)]
pub fn has_avx2_fma() -> bool {
    kernels() >= AVX2_FMA
}

/// Whether the code for AVX-512 runs, where there is some; that for AVX2 does then too.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn has_avx512() -> bool {
    kernels() == AVX512
}

#[cold]
fn detect() -> u8 {
    let widest = widest();
    KERNELS.store(widest, Ordering::Relaxed);
    widest
}

#[cfg(target_arch = "x86_64")]
fn widest() -> u8 {
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
        PORTABLE
    } else if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("bmi1") {
        AVX512
    } else {
        AVX2_FMA
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn widest() -> u8 {
    PORTABLE
}

/// Makes the whole process use the code for any processor, slower and rounded differently: to compare the two. Call it
/// before the first network is used.
pub fn use_portable_kernels() {
    KERNELS.store(PORTABLE, Ordering::Relaxed);
}

/// Keeps the whole process from using AVX-512, with the same results: to compare the two.
pub fn use_avx2_at_most() {
    if kernels() == AVX512 {
        KERNELS.store(AVX2_FMA, Ordering::Relaxed);
    }
}

wide! {
    /// [`multiply`] in plain Rust for any processor and scalar.
    pub fn multiply_portable<T, V>(product: Product<'_, T>) {
        product.check();
        let Product { rows, shared, columns, a, b, b_stride, c, c_stride, epilogue } = product;
        for first in (0..columns).step_by(LANES) {
            let tile = |row: usize, count: usize, c: &mut [T]| {
                let mut sums = [[T::ZERO; LANES]; 4];
                if let Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) = epilogue {
                    for sums in &mut sums[..count] {
                        sums.copy_from_slice(&bias[first..first + LANES]);
                    }
                }
                for index in 0..shared {
                    let vector = &b[index * b_stride + first..][..LANES];
                    for (r, sums) in sums[..count].iter_mut().enumerate() {
                        let factor = a.values[(row + r) * a.row + index * a.step];
                        for (sum, &value) in sums.iter_mut().zip(vector) {
                            *sum += factor * value;
                        }
                    }
                }
                for (r, sums) in sums[..count].iter().enumerate() {
                    let row = row + r;
                    let out = &mut c[row * c_stride + first..][..LANES];
                    out.copy_from_slice(sums);
                    match epilogue {
                        Epilogue::BiasRelu(_) => {
                            for value in out {
                                // Written so that NaN stays NaN and is noticed.
                                *value = if *value < T::ZERO { T::ZERO } else { *value };
                            }
                        }
                        Epilogue::Mask(mask, stride) => {
                            for (value, &mask) in out.iter_mut().zip(&mask[row * stride + first..]) {
                                *value = if mask > T::ZERO { *value } else { T::ZERO };
                            }
                        }
                        Epilogue::None | Epilogue::Bias(_) => {}
                    }
                }
            };
            let mut row = 0;
            while row < rows {
                let count = (rows - row).min(4);
                tile(row, count, c);
                row += count;
            }
        }
    }
}

pub(crate) fn multiply_f32(product: Product<'_, f32>) {
    #[cfg(target_arch = "x86_64")]
    if has_avx2_fma() {
        product.check();
        // SAFETY: the processor has AVX2 and FMA, AVX-512 where that is asked for, and `check` holds.
        unsafe {
            if has_avx512() {
                avx512::multiply(product);
            } else {
                avx2::multiply(product);
            }
        }
        return;
    }
    multiply_portable(product);
}
