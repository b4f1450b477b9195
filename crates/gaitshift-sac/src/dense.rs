//! Matrix products of the small dense layers, the nine tenths of an update.
//!
//! Weights live in *panels*: a matrix of `k` rows and `n` columns (`n` a multiple of 8) is cut into
//! panels of 8 columns, and each is stored row after row. A register tile of a few rows by up to three panels
//! then reads its weights as contiguous streams, and no packing is ever needed because the optimiser, which works
//! element by element, does not care about the layout.
//!
//! Every output element is one sum in the order of the shared index, whatever the tile it falls in, so the
//! result for a row does not depend on how many rows are computed with it.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::lanes::LANES;
use crate::real::{LINE, Real, wide};

#[cfg(target_arch = "x86_64")]
mod avx2;

/// Columns of a panel, as many as a vector has; the columns of a stored matrix are padded to a multiple of it.
pub const PANEL: usize = LANES;

/// Columns of a matrix as stored: `columns` rounded up to a multiple of [`PANEL`].
pub fn padded(columns: usize) -> usize {
    columns.next_multiple_of(PANEL)
}

/// Distance between rows of an activation matrix of `columns` columns: an odd number of cache lines, so that
/// a column walk visits every set of the first-level cache.
pub fn row_stride(columns: usize) -> usize {
    (columns.div_ceil(LINE) | 1) * LINE
}

/// Index of element (`row`, `column`) in a panelled matrix of `rows` rows.
#[inline(always)]
pub fn panel_index(rows: usize, row: usize, column: usize) -> usize {
    (column / PANEL * rows + row) * PANEL + column % PANEL
}

/// What becomes of a tile of sums before it is stored.
#[derive(Clone, Copy, Debug)]
pub enum Epilogue<'a, T> {
    /// Stored as it is.
    None,
    /// The sum starts at the bias of its column.
    Bias(&'a [T]),
    /// The sum starts at the bias of its column; negative results become 0.
    BiasRelu(&'a [T]),
    /// The result becomes 0 where the matrix (same rows, given row stride) is not positive: the
    /// derivative of the rectifier.
    Mask(&'a [T], usize),
}

/// Y = X P: `rows` × `k` times `k` × `columns`.
#[derive(Debug)]
pub struct MatMul<'a, T> {
    /// Rows of X and Y.
    pub rows: usize,
    /// Columns of X, rows of P.
    pub k: usize,
    /// X, row-major.
    pub x: &'a [T],
    /// Distance between rows of X.
    pub x_stride: usize,
    /// P in panels.
    pub panels: &'a [T],
    /// Columns of P and Y, a multiple of [`PANEL`].
    pub columns: usize,
    /// Y, row-major.
    pub y: &'a mut [T],
    /// Distance between rows of Y.
    pub y_stride: usize,
    /// What becomes of the sums.
    pub epilogue: Epilogue<'a, T>,
}

impl<T> MatMul<'_, T> {
    /// Every index the kernels form lies inside the slices.
    fn check(&self) {
        let Self {
            rows, k, columns, ..
        } = *self;
        assert!(columns % PANEL == 0 && self.panels.len() >= k * columns);
        assert!(self.x_stride >= k && self.y_stride >= columns);
        if rows > 0 {
            assert!(self.x.len() >= (rows - 1) * self.x_stride + k);
            assert!(self.y.len() >= (rows - 1) * self.y_stride + columns);
            match self.epilogue {
                Epilogue::None => {}
                Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) => assert!(bias.len() >= columns),
                Epilogue::Mask(mask, stride) => {
                    assert!(mask.len() >= (rows - 1) * stride + columns)
                }
            }
        }
    }
}

/// P = Xᵀ Y: the gradient of weights, `k` × `columns` in panels, summed over `rows`.
#[derive(Debug)]
pub struct Outer<'a, T> {
    /// Rows of X and Y, the summed index.
    pub rows: usize,
    /// Columns of X, rows of P.
    pub k: usize,
    /// X, row-major.
    pub x: &'a [T],
    /// Distance between rows of X.
    pub x_stride: usize,
    /// Columns of Y and P, a multiple of [`PANEL`].
    pub columns: usize,
    /// Y, row-major.
    pub y: &'a [T],
    /// Distance between rows of Y.
    pub y_stride: usize,
    /// P in panels, overwritten.
    pub panels: &'a mut [T],
}

impl<T> Outer<'_, T> {
    fn check(&self) {
        let Self {
            rows, k, columns, ..
        } = *self;
        assert!(columns % PANEL == 0 && self.panels.len() >= k * columns);
        assert!(self.x_stride >= k && self.y_stride >= columns);
        if rows > 0 {
            assert!(self.x.len() >= (rows - 1) * self.x_stride + k);
            assert!(self.y.len() >= (rows - 1) * self.y_stride + columns);
        }
    }
}

/// Y = X P with the fastest kernel of this processor.
pub fn matmul<T: Real>(product: MatMul<'_, T>) {
    T::matmul(product);
}

/// P = Xᵀ Y with the fastest kernel of this processor.
pub fn outer<T: Real>(product: Outer<'_, T>) {
    T::outer(product);
}

/// What is known about the processor.
static KERNELS: AtomicU8 = AtomicU8::new(UNKNOWN);
const UNKNOWN: u8 = 0;
const AVX2_FMA: u8 = 1;
const PORTABLE: u8 = 2;

/// Whether the code for AVX2 and FMA runs.
#[inline(always)]
pub fn has_avx2_fma() -> bool {
    match KERNELS.load(Ordering::Relaxed) {
        UNKNOWN => detect(),
        kernels => kernels == AVX2_FMA,
    }
}

#[cold]
fn detect() -> bool {
    #[cfg(target_arch = "x86_64")]
    let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let found = false;
    KERNELS.store(if found { AVX2_FMA } else { PORTABLE }, Ordering::Relaxed);
    found
}

/// Makes the whole process use the code for any processor, slower and rounded differently: to compare the two. Call it
/// before the first network is used.
pub fn use_portable_kernels() {
    KERNELS.store(PORTABLE, Ordering::Relaxed);
}

wide! {
    /// [`matmul`] in plain Rust for any processor and scalar.
    pub fn matmul_portable<T, V>(product: MatMul<'_, T>) {
        product.check();
        let MatMul { rows, k, x, x_stride, panels, columns, y, y_stride, epilogue } = product;
        for first in (0..columns).step_by(PANEL) {
            let panel = &panels[first * k..][..k * PANEL];
            let tile = |row: usize, count: usize, y: &mut [T]| {
                let mut sums = [[T::ZERO; PANEL]; 4];
                if let Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) = epilogue {
                    for sums in &mut sums[..count] {
                        sums.copy_from_slice(&bias[first..first + PANEL]);
                    }
                }
                for (index, weights) in panel.chunks_exact(PANEL).enumerate() {
                    for (r, sums) in sums[..count].iter_mut().enumerate() {
                        let factor = x[(row + r) * x_stride + index];
                        for (sum, &weight) in sums.iter_mut().zip(weights) {
                            *sum += factor * weight;
                        }
                    }
                }
                for (r, sums) in sums[..count].iter().enumerate() {
                    let row = row + r;
                    let out = &mut y[row * y_stride + first..][..PANEL];
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
                tile(row, count, y);
                row += count;
            }
        }
    }
}

wide! {
    /// [`outer`] in plain Rust for any processor and scalar.
    pub fn outer_portable<T, V>(product: Outer<'_, T>) {
        product.check();
        let Outer { rows, k, x, x_stride, columns, y, y_stride, panels } = product;
        for first in (0..columns).step_by(PANEL) {
            let panel = &mut panels[first * k..][..k * PANEL];
            for (index, out) in panel.chunks_exact_mut(PANEL).enumerate() {
                let mut sums = [T::ZERO; PANEL];
                for row in 0..rows {
                    let factor = x[row * x_stride + index];
                    for (sum, &value) in sums.iter_mut().zip(&y[row * y_stride + first..][..PANEL]) {
                        *sum += factor * value;
                    }
                }
                out.copy_from_slice(&sums);
            }
        }
    }
}

pub(crate) fn matmul_f32(product: MatMul<'_, f32>) {
    #[cfg(target_arch = "x86_64")]
    if has_avx2_fma() {
        product.check();
        // SAFETY: the processor has AVX2 and FMA, and `check` holds.
        unsafe { avx2::matmul(product) };
        return;
    }
    matmul_portable(product);
}

pub(crate) fn outer_f32(product: Outer<'_, f32>) {
    #[cfg(target_arch = "x86_64")]
    if has_avx2_fma() {
        product.check();
        // SAFETY: the processor has AVX2 and FMA, and `check` holds.
        unsafe { avx2::outer(product) };
        return;
    }
    outer_portable(product);
}
