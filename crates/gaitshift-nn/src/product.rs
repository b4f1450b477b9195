//! Products of matrices: how they are asked for, and the sums in registers that they are made of.
//!
//! Matrices are stored row by row, columns padded to a multiple of 8. No packing is ever needed: rows are [`row_stride`]
//! apart, so that the strips of columns that the kernels walk along stay in the cache, and the optimiser, which works
//! element by element, does not care.
//!
//! Every output element is one sum in the order of the shared index, whatever the kernel and the number of rows, so all
//! kernels with fused multiply-add give the same bits.

use crate::buffer::LINE;
use crate::simd::{LANES, Portable, Scalar, Simd, Vector};

#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};

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

/// The left matrix of a product.
#[derive(Clone, Copy, Debug)]
pub enum Left<'a, T> {
    /// X, row-major with rows the given distance apart.
    Rows(&'a [T], usize),
    /// Xᵀ of X, row-major with rows the given distance apart.
    Transposed(&'a [T], usize),
}

impl<'a, T> Left<'a, T> {
    /// X, and the distances in it between rows and between columns of A.
    #[inline(always)]
    pub(crate) fn strides(self) -> (&'a [T], usize, usize) {
        match self {
            Self::Rows(x, stride) => (x, stride, 1),
            Self::Transposed(x, stride) => (x, 1, stride),
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
    /// Every element of the matrices lies inside its slice: the inner loops rely on it.
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
        let left = match self.a {
            Left::Rows(x, stride) => reaches(x, rows, stride, shared),
            Left::Transposed(x, stride) => reaches(x, shared, stride, rows),
        };
        let epilogue = match self.epilogue {
            Epilogue::None => true,
            Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) => bias.len() >= columns,
            Epilogue::Mask(mask, stride) => reaches(mask, rows, stride, columns),
        };
        columns.is_multiple_of(LANES)
            && left
            && reaches(self.b, shared, self.b_stride, columns)
            && reaches(self.c, rows, self.c_stride, columns)
            && epilogue
    }
}

/// Whether a matrix lies inside `slice`, its rows `stride` apart without overlap. In arithmetic that does not wrap: nothing
/// else stands between a huge distance and the memory of others.
fn reaches<T>(slice: &[T], rows: usize, stride: usize, columns: usize) -> bool {
    let Some(before) = rows.checked_sub(1) else {
        return true;
    };
    let end = before
        .checked_mul(stride)
        .and_then(|start| start.checked_add(columns));
    stride >= columns && end.is_some_and(|end| end <= slice.len())
}

/// A way to compute a product, for any kind of vectors.
pub trait Kernel<T> {
    /// Computes it with vectors as long as may be and, for the columns that those leave over, vectors of eight.
    fn run<W: Simd<T>, H: Simd<T>>(self, wide: W, eight: H);
}

/// Runs a kernel with the longest vectors of this processor.
pub fn run<T: Scalar>(kernel: impl Kernel<T>) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f,avx2,fma,bmi1")]
        fn avx512<T: Scalar>(simd: Avx512, kernel: impl Kernel<T>) {
            kernel.run(T::Avx512::from(simd), T::Avx2::from(simd.into()));
        }
        #[target_feature(enable = "avx2,fma")]
        fn avx2<T: Scalar>(simd: Avx2, kernel: impl Kernel<T>) {
            let simd = T::Avx2::from(simd);
            kernel.run(simd, simd);
        }
        if let Some(simd) = Avx512::new() {
            // SAFETY: an `Avx512` exists, so the processor has the features the function was compiled for.
            return unsafe { avx512(simd, kernel) };
        }
        if let Some(simd) = Avx2::new() {
            // SAFETY: likewise.
            return unsafe { avx2(simd, kernel) };
        }
    }
    kernel.run(Portable, Portable);
}

/// Neighbouring columns of a row, in registers: `N` wide vectors and behind them `E` of eight.
#[derive(Clone, Copy)]
pub struct Columns<W, H, const N: usize, const E: usize> {
    /// The wide ones.
    pub wide: [W; N],
    /// Those behind.
    pub eight: [H; E],
}

/// Scalars in so many vectors.
#[inline(always)]
pub const fn width<T, W: Simd<T>>(wide: usize, eight: usize) -> usize {
    wide * <W::Vector as Vector<T>>::LANES + eight * LANES
}

/// Makes [`Columns`].
#[derive(Clone, Copy)]
pub struct Registers<W, H> {
    /// Longest vectors.
    pub wide: W,
    /// Vectors of eight.
    pub eight: H,
}

impl<W, H> Registers<W, H> {
    /// The same scalar everywhere.
    #[inline(always)]
    pub fn splat<T: Scalar, const N: usize, const E: usize>(
        self,
        value: T,
    ) -> Columns<W::Vector, H::Vector, N, E>
    where
        W: Simd<T>,
        H: Simd<T>,
    {
        Columns {
            wide: [self.wide.splat(value); N],
            eight: [self.eight.splat(value); E],
        }
    }

    /// The first scalars of a slice.
    #[inline(always)]
    pub fn load<T: Scalar, const N: usize, const E: usize>(
        self,
        from: &[T],
    ) -> Columns<W::Vector, H::Vector, N, E>
    where
        W: Simd<T>,
        H: Simd<T>,
    {
        let from = &from[..width::<T, W>(N, E)];
        // Loops instead of closures: what they call is inlined, and so compiled for the processor's vectors.
        let mut columns = self.splat(T::ZERO);
        for v in 0..N {
            columns.wide[v] = self.wide.load(&from[width::<T, W>(v, 0)..]);
        }
        for v in 0..E {
            columns.eight[v] = self.eight.load(&from[width::<T, W>(N, v)..]);
        }
        columns
    }

    /// The scalars of a slice from `start` on.
    ///
    /// # Safety
    /// The slice reaches that far.
    #[inline(always)]
    pub unsafe fn load_unchecked<T: Scalar, const N: usize, const E: usize>(
        self,
        from: &[T],
        start: usize,
    ) -> Columns<W::Vector, H::Vector, N, E>
    where
        W: Simd<T>,
        H: Simd<T>,
    {
        let end = start + width::<T, W>(N, E);
        // SAFETY: passed on from the caller.
        self.load(unsafe { from.get_unchecked(start..end) })
    }

    /// What the sums of a row of C start from, in the columns from `first` on.
    #[inline(always)]
    pub fn start<T: Scalar, const N: usize, const E: usize>(
        self,
        epilogue: Epilogue<'_, T>,
        first: usize,
    ) -> Columns<W::Vector, H::Vector, N, E>
    where
        W: Simd<T>,
        H: Simd<T>,
    {
        match epilogue {
            Epilogue::Bias(bias) | Epilogue::BiasRelu(bias) => self.load(&bias[first..]),
            Epilogue::None | Epilogue::Mask(..) => self.splat(T::ZERO),
        }
    }

    /// sums ← sums + factor · columns.
    #[inline(always)]
    pub fn add_product<T: Scalar, const N: usize, const E: usize>(
        self,
        factor: T,
        columns: Columns<W::Vector, H::Vector, N, E>,
        sums: &mut Columns<W::Vector, H::Vector, N, E>,
    ) where
        W: Simd<T>,
        H: Simd<T>,
    {
        let wide = self.wide.splat(factor);
        for v in 0..N {
            sums.wide[v] = wide.mul_add(columns.wide[v], sums.wide[v]);
        }
        if E > 0 {
            let eight = self.eight.splat(factor);
            for v in 0..E {
                sums.eight[v] = eight.mul_add(columns.eight[v], sums.eight[v]);
            }
        }
    }

    /// What becomes of the sums of row `row` in the columns from `first` on.
    #[inline(always)]
    pub fn finish<T: Scalar, const N: usize, const E: usize>(
        self,
        epilogue: Epilogue<'_, T>,
        row: usize,
        first: usize,
        sums: &mut Columns<W::Vector, H::Vector, N, E>,
    ) where
        W: Simd<T>,
        H: Simd<T>,
    {
        match epilogue {
            Epilogue::None | Epilogue::Bias(_) => {}
            Epilogue::BiasRelu(_) => {
                for v in 0..N {
                    sums.wide[v] = sums.wide[v].rectify();
                }
                for v in 0..E {
                    sums.eight[v] = sums.eight[v].rectify();
                }
            }
            Epilogue::Mask(mask, stride) => {
                let mask = self.load::<T, N, E>(&mask[row * stride + first..]);
                for v in 0..N {
                    sums.wide[v] = sums.wide[v].where_positive(mask.wide[v]);
                }
                for v in 0..E {
                    sums.eight[v] = sums.eight[v].where_positive(mask.eight[v]);
                }
            }
        }
    }

    /// To the first scalars of a slice.
    #[inline(always)]
    pub fn store<T: Scalar, const N: usize, const E: usize>(
        self,
        sums: Columns<W::Vector, H::Vector, N, E>,
        to: &mut [T],
    ) where
        W: Simd<T>,
        H: Simd<T>,
    {
        let to = &mut to[..width::<T, W>(N, E)];
        for v in 0..N {
            sums.wide[v].store(&mut to[width::<T, W>(v, 0)..]);
        }
        for v in 0..E {
            sums.eight[v].store(&mut to[width::<T, W>(N, v)..]);
        }
    }
}
