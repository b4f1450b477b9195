//! Eight scalars side by side, for the loops over rows that the compiler does not vectorise well on its own
//! (sums along a row, above all).

use crate::real::Real;

/// Scalars in one [`Lanes`].
pub const LANES: usize = 8;

/// Eight scalars on which arithmetic acts element by element.
pub trait Lanes<T>: Copy {
    /// The same scalar eight times.
    fn splat(value: T) -> Self;
    /// The eight scalars of a slice that start at `place`.
    fn load(from: &[T], place: usize) -> Self;
    /// To the eight scalars of a slice that start at `place`.
    fn store(self, to: &mut [T], place: usize);
    /// Sum.
    fn add(self, other: Self) -> Self;
    /// Difference.
    fn sub(self, other: Self) -> Self;
    /// Product.
    fn mul(self, other: Self) -> Self;
    /// self · factor + addend, rounded once or twice.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// The larger of `self` and 0; NaN stays NaN.
    fn rectify(self) -> Self;
    /// `self` where `condition` is positive, else 0.
    fn where_positive(self, condition: Self) -> Self;
    /// A bit for each lane that is not 0, the lowest for the first lane; NaN is not 0.
    fn not_zero(self) -> u8;
    /// Sum of all eight.
    fn sum(self) -> T;
    /// Rows of a square to its columns.
    fn transpose(square: [Self; LANES]) -> [Self; LANES];
}

/// [`Lanes`] for any processor and scalar.
#[derive(Clone, Copy, Debug)]
pub struct Portable<T>([T; LANES]);

impl<T: Real> Portable<T> {
    #[inline(always)]
    fn zip(self, other: Self, operation: impl Fn(T, T) -> T) -> Self {
        Self(std::array::from_fn(|lane| {
            operation(self.0[lane], other.0[lane])
        }))
    }
}

impl<T: Real> Lanes<T> for Portable<T> {
    #[inline(always)]
    fn splat(value: T) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn load(from: &[T], place: usize) -> Self {
        let from = &from[place..place + LANES];
        Self(std::array::from_fn(|lane| from[lane]))
    }
    #[inline(always)]
    fn store(self, to: &mut [T], place: usize) {
        to[place..place + LANES].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self.mul(factor).add(addend)
    }
    #[inline(always)]
    fn rectify(self) -> Self {
        self.zip(
            self,
            |value, _| if value < T::ZERO { T::ZERO } else { value },
        )
    }
    #[inline(always)]
    fn where_positive(self, condition: Self) -> Self {
        self.zip(
            condition,
            |value, condition| if condition > T::ZERO { value } else { T::ZERO },
        )
    }
    #[inline(always)]
    fn not_zero(self) -> u8 {
        (0..LANES).fold(0, |bits, lane| {
            bits | u8::from(self.0[lane] != T::ZERO) << lane
        })
    }
    #[inline(always)]
    fn sum(self) -> T {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
    #[inline(always)]
    fn transpose(square: [Self; LANES]) -> [Self; LANES] {
        std::array::from_fn(|row| Self(std::array::from_fn(|column| square[column].0[row])))
    }
}

/// [`Lanes`] of `f32` in one AVX register. Only code compiled by [`crate::real::wide`] for AVX2 and FMA, which runs
/// after the processor was asked, may use it.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub struct Avx(std::arch::x86_64::__m256);

#[cfg(target_arch = "x86_64")]
mod avx {
    use std::arch::x86_64::*;

    use super::{Avx, LANES, Lanes};

    /// What follows from the contract of [`Avx`]; slices are checked to hold eight scalars before they are read or written.
    macro_rules! avx {
        ($($body:tt)*) => {{
            // SAFETY: AVX2 and FMA are present where an `Avx` is, and pointers are those of eight scalars.
            unsafe { $($body)* }
        }};
    }

    impl Lanes<f32> for Avx {
        #[inline(always)]
        fn splat(value: f32) -> Self {
            avx! { Self(_mm256_set1_ps(value)) }
        }
        #[inline(always)]
        fn load(from: &[f32], place: usize) -> Self {
            let from = &from[place..place + LANES];
            avx! { Self(_mm256_loadu_ps(from.as_ptr())) }
        }
        #[inline(always)]
        fn store(self, to: &mut [f32], place: usize) {
            let to = &mut to[place..place + LANES];
            avx! { _mm256_storeu_ps(to.as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            avx! { Self(_mm256_add_ps(self.0, other.0)) }
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            avx! { Self(_mm256_sub_ps(self.0, other.0)) }
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            avx! { Self(_mm256_mul_ps(self.0, other.0)) }
        }
        #[inline(always)]
        fn mul_add(self, factor: Self, addend: Self) -> Self {
            avx! { Self(_mm256_fmadd_ps(self.0, factor.0, addend.0)) }
        }
        #[inline(always)]
        fn rectify(self) -> Self {
            avx! { Self(_mm256_max_ps(_mm256_setzero_ps(), self.0)) }
        }
        #[inline(always)]
        fn where_positive(self, condition: Self) -> Self {
            avx! {
                let mask = _mm256_cmp_ps::<_CMP_GT_OQ>(condition.0, _mm256_setzero_ps());
                Self(_mm256_and_ps(self.0, mask))
            }
        }
        #[inline(always)]
        fn not_zero(self) -> u8 {
            avx! {
                let different = _mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, _mm256_setzero_ps());
                _mm256_movemask_ps(different) as u8
            }
        }
        #[inline(always)]
        fn sum(self) -> f32 {
            avx! {
                let four = _mm_add_ps(
                    _mm256_castps256_ps128(self.0),
                    _mm256_extractf128_ps::<1>(self.0),
                );
                let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)))
            }
        }
        #[inline(always)]
        fn transpose(square: [Self; LANES]) -> [Self; LANES] {
            avx! {
                // Within halves of four: pairs of rows, then fours; at last the halves change places.
                let [a, b, c, d, e, f, g, h] = square.map(|row| row.0);
                let four = |a, b, c, d| {
                    let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
                    let (ba, dc) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
                    [
                        _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
                        _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
                        _mm256_shuffle_ps::<0b01_00_01_00>(ba, dc),
                        _mm256_shuffle_ps::<0b11_10_11_10>(ba, dc),
                    ]
                };
                let (upper, lower) = (four(a, b, c, d), four(e, f, g, h));
                std::array::from_fn(|row| {
                    let (upper, lower) = (upper[row % 4], lower[row % 4]);
                    Self(if row < 4 {
                        _mm256_permute2f128_ps::<0x20>(upper, lower)
                    } else {
                        _mm256_permute2f128_ps::<0x31>(upper, lower)
                    })
                })
            }
        }
    }
}
