//! Matrix products of the small dense layers, the nine tenths of an update.
//!
//! Weights live in *panels*: a matrix of `k` rows and `n` columns (`n` a multiple of 8) is cut into
//! strips of 16 columns, the last perhaps of 8, and each strip is stored row after row. A register tile of
//! 6 rows by 16 columns then reads its weights as one contiguous stream, and no packing is ever
//! needed because the optimiser, which works element by element, does not care about the layout.
//!
//! Every output element is one sum in the order of the shared index, whatever the tile it falls in, so the
//! result for a row does not depend on how many rows are computed with it.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::real::{Real, wide};

/// Columns of a full panel.
pub const PANEL: usize = 16;
/// Columns are padded to a multiple of this.
pub const HALF_PANEL: usize = 8;
/// Rows of a full register tile.
const TILE: usize = 6;
/// Rows that go through all panels before the next ones do: their part of X stays in the first-level cache beside a
/// panel, and the panels stream past in the order they lie in memory.
const BLOCK: usize = 24;
/// Rows of a register tile of half a panel: as many sums as the multiply-add units keep in flight.
const HALF_TILE: usize = 8;

/// Columns of a matrix as stored: `columns` rounded up to a multiple of [`HALF_PANEL`].
pub fn padded(columns: usize) -> usize {
    columns.next_multiple_of(HALF_PANEL)
}

/// Distance between rows of an activation matrix of `columns` columns: an odd number of cache lines, so that
/// a column walk visits every set of the first-level cache.
pub fn row_stride(columns: usize) -> usize {
    let lines = padded(columns).div_ceil(PANEL);
    (lines | 1) * PANEL
}

/// Index of element (`row`, `column`) in a panelled matrix of `rows` rows and `padded` columns.
#[inline(always)]
pub fn panel_index(rows: usize, padded: usize, row: usize, column: usize) -> usize {
    let panel = column / PANEL;
    let width = PANEL.min(padded - panel * PANEL);
    panel * PANEL * rows + row * width + column % PANEL
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
    /// Columns of P and Y, a multiple of [`HALF_PANEL`].
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
        assert!(columns % HALF_PANEL == 0 && self.panels.len() >= k * columns);
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
    /// Columns of Y and P, a multiple of [`HALF_PANEL`].
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
        assert!(columns % HALF_PANEL == 0 && self.panels.len() >= k * columns);
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

/// Rows of the next tile of a full panel or of half of one when `left` remain; avoids a last tile too small to fill the
/// pipeline.
#[inline(always)]
fn tile_rows(left: usize, full: bool) -> usize {
    match left {
        _ if !full => left.min(HALF_TILE),
        7 | 8 => 4,
        _ => left.min(TILE),
    }
}

wide! {
    /// [`matmul`] in plain Rust for any processor and scalar.
    pub fn matmul_portable<T, V>(product: MatMul<'_, T>) {
        product.check();
        let MatMul { rows, k, x, x_stride, panels, columns, y, y_stride, epilogue } = product;
        for first in (0..columns).step_by(PANEL) {
            let width = PANEL.min(columns - first);
            let panel = &panels[first * k..][..k * width];
            let tile = |row: usize, count: usize, y: &mut [T]| {
                let mut sums = [[T::ZERO; PANEL]; 4];
                if let Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) = epilogue {
                    for sums in &mut sums[..count] {
                        sums[..width].copy_from_slice(&bias[first..first + width]);
                    }
                }
                for (index, weights) in panel.chunks_exact(width).enumerate() {
                    for (r, sums) in sums[..count].iter_mut().enumerate() {
                        let factor = x[(row + r) * x_stride + index];
                        for (sum, &weight) in sums.iter_mut().zip(weights) {
                            *sum += factor * weight;
                        }
                    }
                }
                for (r, sums) in sums[..count].iter().enumerate() {
                    let row = row + r;
                    let out = &mut y[row * y_stride + first..][..width];
                    out.copy_from_slice(&sums[..width]);
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
            let width = PANEL.min(columns - first);
            let panel = &mut panels[first * k..][..k * width];
            for (index, out) in panel.chunks_exact_mut(width).enumerate() {
                let mut sums = [T::ZERO; PANEL];
                for row in 0..rows {
                    let factor = x[row * x_stride + index];
                    for (sum, &value) in sums.iter_mut().zip(&y[row * y_stride + first..][..width]) {
                        *sum += factor * value;
                    }
                }
                out.copy_from_slice(&sums[..width]);
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

#[cfg(target_arch = "x86_64")]
mod avx2 {
    //! Register tiles of 6 rows by 2 vectors: twelve sums in flight cover the latency of the two fused
    //! multiply-add units, and sums, weights and one broadcast fill the sixteen registers.

    use std::arch::x86_64::*;

    use super::{BLOCK, Epilogue, HALF_PANEL, MatMul, Outer, PANEL, tile_rows};

    /// Calls `$step!` for 0 to `$count`, several calls between two jumps: the front end then keeps up with the
    /// arithmetic even where a neighbour on the same core has half of it. So many, and no more, that the sums stay in
    /// registers.
    macro_rules! unroll {
        ($step:ident, $count:expr, $first:tt $(, $further:tt)*) => {
            let count = $count;
            let mut index = 0;
            while index + $first <= count {
                unroll!(@block $step, index, $first);
                index += $first;
            }
            $(if index + $further <= count {
                unroll!(@block $step, index, $further);
                index += $further;
            })*
            while index < count {
                $step!(index);
                index += 1;
            }
        };
        (@block $step:ident, $index:ident, 8) => {
            unroll!(@block $step, $index, 4);
            unroll!(@calls $step, $index, 4 5 6 7);
        };
        (@block $step:ident, $index:ident, 4) => {
            unroll!(@calls $step, $index, 0 1 2 3);
        };
        (@calls $step:ident, $index:ident, $($offset:literal)*) => {
            $($step!($index + $offset);)*
        };
    }

    const NONE: u8 = 0;
    const BIAS: u8 = 1;
    const BIAS_RELU: u8 = 2;
    const MASK: u8 = 3;

    /// # Safety
    /// AVX2 and FMA present, `product.check()` passed.
    #[target_feature(enable = "avx2,fma")]
    pub unsafe fn matmul(product: MatMul<'_, f32>) {
        // SAFETY: passed on from the caller.
        unsafe {
            match product.epilogue {
                Epilogue::None => panels::<NONE>(product, std::ptr::null(), 0),
                Epilogue::Bias(bias) => panels::<BIAS>(product, bias.as_ptr(), 0),
                Epilogue::BiasRelu(bias) => panels::<BIAS_RELU>(product, bias.as_ptr(), 0),
                Epilogue::Mask(mask, stride) => panels::<MASK>(product, mask.as_ptr(), stride),
            }
        }
    }

    #[target_feature(enable = "avx2,fma")]
    unsafe fn panels<const E: u8>(
        product: MatMul<'_, f32>,
        extra: *const f32,
        extra_stride: usize,
    ) {
        let MatMul {
            rows,
            k,
            x,
            x_stride,
            panels,
            columns,
            y,
            y_stride,
            ..
        } = product;
        let (x, y) = (x.as_ptr(), y.as_mut_ptr());
        for block in (0..rows).step_by(BLOCK) {
            let end = rows.min(block + BLOCK);
            for first in (0..columns).step_by(PANEL) {
                // SAFETY: `first < columns`, so every pointer formed stays inside its slice by `check`.
                unsafe {
                    let panel = panels.as_ptr().add(first * k);
                    let full = columns - first >= PANEL;
                    let mut row = block;
                    while row < end {
                        let count = tile_rows(end - row, full);
                        let x = x.add(row * x_stride);
                        let y = y.add(row * y_stride + first);
                        let extra = if E == NONE {
                            extra
                        } else {
                            extra.add(row * extra_stride + first)
                        };
                        macro_rules! dispatch {
                            ($($count:literal)*) => {
                                match (count, full) {
                                    $(($count, true) => tile::<$count, 2, E>(k, x, x_stride, panel, y, y_stride, extra, extra_stride),)*
                                    $(($count, false) => tile::<$count, 1, E>(k, x, x_stride, panel, y, y_stride, extra, extra_stride),)*
                                    (7, false) => tile::<7, 1, E>(k, x, x_stride, panel, y, y_stride, extra, extra_stride),
                                    (8, false) => tile::<8, 1, E>(k, x, x_stride, panel, y, y_stride, extra, extra_stride),
                                    _ => unreachable!(),
                                }
                            };
                        }
                        dispatch!(1 2 3 4 5 6);
                        row += count;
                    }
                }
            }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    #[allow(clippy::too_many_arguments)]
    unsafe fn tile<const R: usize, const V: usize, const E: u8>(
        k: usize,
        x: *const f32,
        x_stride: usize,
        panel: *const f32,
        y: *mut f32,
        y_stride: usize,
        extra: *const f32,
        extra_stride: usize,
    ) {
        // SAFETY: the caller's tile lies inside the slices.
        unsafe {
            let mut sums = [[_mm256_setzero_ps(); V]; R];
            if E == BIAS || E == BIAS_RELU {
                for v in 0..V {
                    let bias = _mm256_loadu_ps(extra.add(v * 8));
                    for row in &mut sums {
                        row[v] = bias;
                    }
                }
            }
            macro_rules! step {
                ($index:expr) => {{
                    let index = $index;
                    let mut weights = [_mm256_setzero_ps(); V];
                    for (v, weights) in weights.iter_mut().enumerate() {
                        *weights = _mm256_loadu_ps(panel.add(index * V * HALF_PANEL + v * 8));
                    }
                    for (r, row) in sums.iter_mut().enumerate() {
                        let factor = _mm256_broadcast_ss(&*x.add(r * x_stride + index));
                        for v in 0..V {
                            row[v] = _mm256_fmadd_ps(factor, weights[v], row[v]);
                        }
                    }
                }};
            }
            unroll!(step, k, 8, 4);
            for (r, row) in sums.iter().enumerate() {
                for (v, &sum) in row.iter().enumerate() {
                    let value = match E {
                        // In this order of operands NaN stays NaN and is noticed.
                        BIAS_RELU => _mm256_max_ps(_mm256_setzero_ps(), sum),
                        MASK => {
                            let mask = _mm256_loadu_ps(extra.add(r * extra_stride + v * 8));
                            _mm256_and_ps(
                                sum,
                                _mm256_cmp_ps::<_CMP_GT_OQ>(mask, _mm256_setzero_ps()),
                            )
                        }
                        _ => sum,
                    };
                    _mm256_storeu_ps(y.add(r * y_stride + v * 8), value);
                }
            }
        }
    }

    /// # Safety
    /// AVX2 and FMA present, `product.check()` passed.
    #[target_feature(enable = "avx2,fma")]
    pub unsafe fn outer(product: Outer<'_, f32>) {
        let Outer {
            rows,
            k,
            x,
            x_stride,
            columns,
            y,
            y_stride,
            panels,
        } = product;
        for first in (0..columns).step_by(PANEL) {
            let full = columns - first >= PANEL;
            let width = if full { PANEL } else { HALF_PANEL };
            let mut index = 0;
            while index < k {
                let count = tile_rows(k - index, full);
                // SAFETY: `first < columns` and `index + count <= k`, inside the slices by `check`.
                unsafe {
                    let x = x.as_ptr().add(index);
                    let y = y.as_ptr().add(first);
                    let out = panels.as_mut_ptr().add(first * k + index * width);
                    macro_rules! dispatch {
                        ($($count:literal)*) => {
                            match (count, full) {
                                $(($count, true) => outer_tile::<$count, 2>(rows, x, x_stride, y, y_stride, out),)*
                                $(($count, false) => outer_tile::<$count, 1>(rows, x, x_stride, y, y_stride, out),)*
                                (7, false) => outer_tile::<7, 1>(rows, x, x_stride, y, y_stride, out),
                                (8, false) => outer_tile::<8, 1>(rows, x, x_stride, y, y_stride, out),
                                _ => unreachable!(),
                            }
                        };
                    }
                    dispatch!(1 2 3 4 5 6);
                }
                index += count;
            }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    unsafe fn outer_tile<const R: usize, const V: usize>(
        rows: usize,
        x: *const f32,
        x_stride: usize,
        y: *const f32,
        y_stride: usize,
        out: *mut f32,
    ) {
        // SAFETY: the caller's tile lies inside the slices.
        unsafe {
            let mut sums = [[_mm256_setzero_ps(); V]; R];
            macro_rules! step {
                ($row:expr) => {{
                    let row = $row;
                    let mut values = [_mm256_setzero_ps(); V];
                    for (v, values) in values.iter_mut().enumerate() {
                        *values = _mm256_loadu_ps(y.add(row * y_stride + v * 8));
                    }
                    for (r, sums) in sums.iter_mut().enumerate() {
                        let factor = _mm256_broadcast_ss(&*x.add(row * x_stride + r));
                        for v in 0..V {
                            sums[v] = _mm256_fmadd_ps(factor, values[v], sums[v]);
                        }
                    }
                }};
            }
            unroll!(step, rows, 4);
            for (r, sums) in sums.iter().enumerate() {
                for (v, &sum) in sums.iter().enumerate() {
                    _mm256_storeu_ps(out.add((r * V + v) * 8), sum);
                }
            }
        }
    }
}
