//! Several scalars side by side in one register of the processor, for the loops that the compiler does not vectorise well
//! on its own (products of matrices and sums along a row, above all).
//!
//! A [`Simd`] is the permission to use some kind of registers. [`Portable`] needs none; `Avx2` and `Avx512` can only be had by
//! asking the processor, so that safe code cannot reach an instruction that is not there.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::real::Real;

#[cfg(target_arch = "x86_64")]
mod x86;
#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512};

/// Scalars in a vector of the code that runs everywhere; matrices are padded to a multiple of it.
pub const LANES: usize = 8;

/// Scalars on which arithmetic acts element by element.
pub trait Vector<T>: Copy {
    /// How many.
    const LANES: usize;
    /// To the first scalars of a slice.
    fn store(self, to: &mut [T]);
    /// self · factor + addend, rounded once or twice.
    fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// The larger of `self` and 0; NaN stays NaN.
    fn rectify(self) -> Self;
    /// `self` where `condition` is positive, else 0.
    fn where_positive(self, condition: Self) -> Self;
}

/// What else can be done with eight of them.
pub trait Vector8<T>: Vector<T> {
    /// Sum.
    fn add(self, other: Self) -> Self;
    /// Difference.
    fn sub(self, other: Self) -> Self;
    /// Product.
    fn mul(self, other: Self) -> Self;
    /// A bit for each lane that is not 0, the lowest for the first lane; NaN is not 0.
    fn not_zero(self) -> u8;
    /// Sum of all eight.
    fn sum(self) -> T;
    /// Rows of a square to its columns.
    fn transpose(square: [Self; LANES]) -> [Self; LANES];
}

/// Permission to make vectors of one kind.
pub trait Simd<T>: Copy + Send + Sync {
    /// The vectors.
    type Vector: Vector<T>;
    /// The same scalar in every lane.
    fn splat(self, value: T) -> Self::Vector;
    /// The first scalars of a slice.
    fn load(self, from: &[T]) -> Self::Vector;
}

/// [`Simd`] with vectors of eight.
pub trait Simd8<T>: Simd<T, Vector: Vector8<T>> {}
impl<T, S: Simd<T, Vector: Vector8<T>>> Simd8<T> for S {}

/// A scalar of the networks: `f32` in use, `f64` to check gradients.
pub trait Scalar: Real {
    /// Vectors of eight in code compiled for AVX2.
    #[cfg(target_arch = "x86_64")]
    type Avx2: Simd8<Self> + From<Avx2>;
    /// Vectors in code compiled for AVX-512.
    #[cfg(target_arch = "x86_64")]
    type Avx512: Simd<Self> + From<Avx512>;
}

impl Scalar for f32 {
    #[cfg(target_arch = "x86_64")]
    type Avx2 = Avx2;
    #[cfg(target_arch = "x86_64")]
    type Avx512 = Avx512;
}

impl Scalar for f64 {
    #[cfg(target_arch = "x86_64")]
    type Avx2 = Portable;
    #[cfg(target_arch = "x86_64")]
    type Avx512 = Portable;
}

/// Instructions that the code has versions for, each level with those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Level {
    /// Those of any processor.
    Portable = 1,
    /// AVX2 and FMA.
    Avx2 = 2,
    /// AVX-512 (F), used for products of matrices.
    Avx512 = 3,
}

/// The level in use; 0 before the processor was asked.
static LEVEL: AtomicU8 = AtomicU8::new(0);

/// The highest level that this processor has, or what [`limit`] lowered it to.
#[inline(always)]
pub fn level() -> Level {
    match LEVEL.load(Ordering::Relaxed) {
        0 => ask(),
        1 => Level::Portable,
        2 => Level::Avx2,
        _ => Level::Avx512,
    }
}

#[cold]
fn ask() -> Level {
    let level = highest();
    LEVEL.store(level as u8, Ordering::Relaxed);
    level
}

#[cfg(target_arch = "x86_64")]
fn highest() -> Level {
    if !(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")) {
        Level::Portable
    } else if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("bmi1") {
        Level::Avx512
    } else {
        Level::Avx2
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn highest() -> Level {
    Level::Portable
}

/// Keeps the whole process from using more than `most`: to compare the levels. AVX-512 changes nothing but the speed; the
/// portable code rounds differently, so lower to it before the first network is used.
pub fn limit(most: Level) {
    LEVEL.store(level().min(most) as u8, Ordering::Relaxed);
}

/// [`Simd`] for any processor and scalar: eight scalars in an array.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

#[cfg(target_arch = "x86_64")]
impl From<Avx2> for Portable {
    fn from(_: Avx2) -> Self {
        Self
    }
}

#[cfg(target_arch = "x86_64")]
impl From<Avx512> for Portable {
    fn from(_: Avx512) -> Self {
        Self
    }
}

impl<T: Real> Simd<T> for Portable {
    type Vector = [T; LANES];
    #[inline(always)]
    fn splat(self, value: T) -> [T; LANES] {
        [value; LANES]
    }
    #[inline(always)]
    fn load(self, from: &[T]) -> [T; LANES] {
        let from = &from[..LANES];
        std::array::from_fn(|lane| from[lane])
    }
}

/// `operation` lane by lane.
#[inline(always)]
fn zip<T: Real>(a: [T; LANES], b: [T; LANES], operation: impl Fn(T, T) -> T) -> [T; LANES] {
    std::array::from_fn(|lane| operation(a[lane], b[lane]))
}

impl<T: Real> Vector<T> for [T; LANES] {
    const LANES: usize = LANES;
    #[inline(always)]
    fn store(self, to: &mut [T]) {
        to[..LANES].copy_from_slice(&self);
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self.mul(factor).add(addend)
    }
    #[inline(always)]
    fn rectify(self) -> Self {
        self.map(|value| if value < T::ZERO { T::ZERO } else { value })
    }
    #[inline(always)]
    fn where_positive(self, condition: Self) -> Self {
        zip(self, condition, |value, condition| {
            if condition > T::ZERO { value } else { T::ZERO }
        })
    }
}

impl<T: Real> Vector8<T> for [T; LANES] {
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        zip(self, other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        zip(self, other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        zip(self, other, |a, b| a * b)
    }
    #[inline(always)]
    fn not_zero(self) -> u8 {
        (0..LANES).fold(0, |bits, lane| {
            bits | u8::from(self[lane] != T::ZERO) << lane
        })
    }
    #[inline(always)]
    fn sum(self) -> T {
        let [a, b, c, d, e, f, g, h] = self;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
    #[inline(always)]
    fn transpose(square: [Self; LANES]) -> [Self; LANES] {
        std::array::from_fn(|row| std::array::from_fn(|column| square[column][row]))
    }
}

/// A loop that the compiler vectorises on its own.
pub trait Loop {
    /// Runs it; inlined, so that it is compiled for the processor's vectors.
    fn run(self);
}

/// Runs a loop compiled for AVX2 and FMA where the processor has them.
pub fn run_loop(body: impl Loop) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2,fma")]
        fn avx2(_: Avx2, body: impl Loop) {
            body.run();
        }
        if let Some(simd) = Avx2::new() {
            // SAFETY: an `Avx2` exists, so the processor has the features the function was compiled for.
            return unsafe { avx2(simd, body) };
        }
    }
    body.run();
}

/// Compiles a function twice, once for any processor and once for AVX2 and FMA, and picks at run time. The first
/// parameter is the [`Simd8`] that it was compiled for; loops that do not use it are left to the compiler's own vectoriser.
macro_rules! vectorised {
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident<$scalar:ident>(
            $simd:ident, $($argument:ident: $kind:ty),* $(,)?
        ) $(-> $result:ty)? $body:block
    ) => {
        $(#[$attribute])*
        #[allow(clippy::too_many_arguments)]
        $visibility fn $name<$scalar: $crate::simd::Scalar>($($argument: $kind),*) $(-> $result)? {
            #[inline(always)]
            #[allow(clippy::too_many_arguments)]
            fn any<$scalar: $crate::simd::Scalar>(
                $simd: impl $crate::simd::Simd8<$scalar>,
                $($argument: $kind),*
            ) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,fma")]
                #[allow(clippy::too_many_arguments)]
                fn avx2<$scalar: $crate::simd::Scalar>(
                    simd: $crate::simd::Avx2,
                    $($argument: $kind),*
                ) $(-> $result)? {
                    any::<$scalar>(<$scalar as $crate::simd::Scalar>::Avx2::from(simd), $($argument),*)
                }
                if let Some(simd) = $crate::simd::Avx2::new() {
                    // SAFETY: an `Avx2` exists, so the processor has the features the function was compiled for.
                    return unsafe { avx2(simd, $($argument),*) };
                }
            }
            any::<$scalar>($crate::simd::Portable, $($argument),*)
        }
    };
}
pub(crate) use vectorised;
