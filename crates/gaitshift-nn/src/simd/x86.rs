//! Vectors of `f32` in the registers of AVX2 and AVX-512.

use std::arch::x86_64::*;

use super::{LANES, Level, Simd, Vector, Vector8, level};

/// Scalars in a register of AVX-512.
const LANES_512: usize = 16;

/// The processor has AVX2 and FMA.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

impl Avx2 {
    /// If the processor has them, and [`super::limit`] allows them.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        (level() >= Level::Avx2).then_some(Self(()))
    }
}

/// The processor has AVX-512 (F), AVX2, FMA and BMI1.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

impl Avx512 {
    /// If the processor has them, and [`super::limit`] allows them.
    #[inline(always)]
    pub fn new() -> Option<Self> {
        (level() >= Level::Avx512).then_some(Self(()))
    }
}

impl From<Avx512> for Avx2 {
    fn from(_: Avx512) -> Self {
        Self(())
    }
}

/// A vector that only an [`Avx2`] makes.
#[derive(Clone, Copy, Debug)]
pub struct F32x8(__m256);

/// A vector that only an [`Avx512`] makes.
#[derive(Clone, Copy, Debug)]
pub struct F32x16(__m512);

/// Instructions whose features are there.
macro_rules! instructions {
    ($($body:tt)*) => {{
        // SAFETY: each is called with the value, or on a vector made with the value, that exists only where the processor
        // has them; pointers are those of references to as many scalars.
        unsafe { $($body)* }
    }};
}

/// The first `N` scalars of a slice.
#[inline(always)]
fn first<const N: usize>(from: &[f32]) -> &[f32; N] {
    from[..N].first_chunk().unwrap_or(&[0.0; N])
}

/// Likewise, to write.
#[inline(always)]
fn first_mut<const N: usize>(to: &mut [f32]) -> &mut [f32; N] {
    match to.first_chunk_mut() {
        Some(to) => to,
        None => panic!("a vector is stored outside its slice"),
    }
}

impl Simd<f32> for Avx2 {
    type Vector = F32x8;
    #[inline(always)]
    fn splat(self, value: f32) -> F32x8 {
        instructions! { F32x8(_mm256_set1_ps(value)) }
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> F32x8 {
        instructions! { F32x8(_mm256_loadu_ps(first::<LANES>(from).as_ptr())) }
    }
}

impl Vector<f32> for F32x8 {
    const LANES: usize = LANES;
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        instructions! { _mm256_storeu_ps(first_mut::<LANES>(to).as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        instructions! { Self(_mm256_fmadd_ps(self.0, factor.0, addend.0)) }
    }
    #[inline(always)]
    fn rectify(self) -> Self {
        // In this order of operands NaN stays NaN and is noticed.
        instructions! { Self(_mm256_max_ps(_mm256_setzero_ps(), self.0)) }
    }
    #[inline(always)]
    fn where_positive(self, condition: Self) -> Self {
        instructions! {
            let positive = _mm256_cmp_ps::<_CMP_GT_OQ>(condition.0, _mm256_setzero_ps());
            Self(_mm256_and_ps(self.0, positive))
        }
    }
}

impl Vector8<f32> for F32x8 {
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        instructions! { Self(_mm256_add_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        instructions! { Self(_mm256_sub_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        instructions! { Self(_mm256_mul_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn not_zero(self) -> u8 {
        instructions! {
            let different = _mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, _mm256_setzero_ps());
            _mm256_movemask_ps(different) as u8
        }
    }
    #[inline(always)]
    fn sum(self) -> f32 {
        instructions! {
            let high = _mm256_extractf128_ps::<1>(self.0);
            let four = _mm_add_ps(_mm256_castps256_ps128(self.0), high);
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)))
        }
    }
    #[inline(always)]
    fn transpose(square: [Self; LANES]) -> [Self; LANES] {
        instructions! {
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

impl Simd<f32> for Avx512 {
    type Vector = F32x16;
    #[inline(always)]
    fn splat(self, value: f32) -> F32x16 {
        instructions! { F32x16(_mm512_set1_ps(value)) }
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> F32x16 {
        instructions! { F32x16(_mm512_loadu_ps(first::<LANES_512>(from).as_ptr())) }
    }
}

impl Vector<f32> for F32x16 {
    const LANES: usize = LANES_512;
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        instructions! { _mm512_storeu_ps(first_mut::<LANES_512>(to).as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        instructions! { Self(_mm512_fmadd_ps(self.0, factor.0, addend.0)) }
    }
    #[inline(always)]
    fn rectify(self) -> Self {
        instructions! { Self(_mm512_max_ps(_mm512_setzero_ps(), self.0)) }
    }
    #[inline(always)]
    fn where_positive(self, condition: Self) -> Self {
        instructions! {
            let positive = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(condition.0, _mm512_setzero_ps());
            Self(_mm512_maskz_mov_ps(positive, self.0))
        }
    }
}
