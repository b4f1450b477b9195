//! The numbers that the networks are made of.
//!
//! Networks run in `f32`. The same code runs in `f64` so that every gradient can be compared with
//! finite differences without the comparison drowning in rounding.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Kernels and buffers rely on what `f32` and `f64` are, so nobody else can be a [`Real`].
mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A real number, `f32` or `f64`, and its elementary functions.
pub trait Real:
    sealed::Sealed
    + Copy
    + Default
    + Debug
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Nearest value to `value`.
    fn from_f64(value: f64) -> Self;
    /// The value as `f64`, exactly.
    fn to_f64(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// e to the power of `self`.
    fn exp(self) -> Self;
    /// ln(1 + self) for `self` from 0 to 1.
    fn ln_1p_unit(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
}

macro_rules! real {
    ($float:ty { $($functions:tt)* }) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            $($functions)*
        }
    };
}

real!(f64 {
    #[inline(always)]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline(always)]
    fn ln_1p_unit(self) -> Self {
        f64::ln_1p(self)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        f64::tanh(self)
    }
});

/// Minimax polynomials of the Cephes library (S. L. Moshier), for e^r − 1 − r over r² on ±ln 2 / 2 and for
/// tanh x / x − 1 over x² below 0.625. Own code instead of the system's: it can be inlined into the loops over
/// rows, and gives the same bits on every system.
const EXP: [f32; 6] = [
    1.987_569_2e-4,
    1.398_2e-3,
    8.333_452e-3,
    4.166_579_6e-2,
    1.666_666_5e-1,
    0.5,
];
const TANH: [f32; 5] = [
    -5.704_988_7e-3,
    2.063_908_8e-2,
    -5.373_971_5e-2,
    1.333_144_2e-1,
    -3.333_328e-1,
];

/// e^x with an error below 2 units in the last place; saturates outside ±87.
#[inline(always)]
fn exponential(x: f32) -> f32 {
    // Adding and subtracting this rounds to a whole number and leaves that number in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    // ln 2 in two parts, the first exact in few bits.
    const LN_2_HIGH: f32 = 355.0 / 512.0;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    // Written so that NaN stays NaN.
    let x = if x < -87.0 { -87.0 } else { x };
    let x = if x > 87.0 { 87.0 } else { x };
    let rounded = x * std::f32::consts::LOG2_E + ROUND;
    let whole = rounded - ROUND;
    let rest = x - whole * LN_2_HIGH - whole * LN_2_LOW;
    let series = EXP
        .iter()
        .fold(0.0, |sum, &coefficient| sum * rest + coefficient);
    let power = f32::from_bits(
        (rounded.to_bits().wrapping_sub(ROUND.to_bits()) << 23).wrapping_add(0x3f80_0000),
    );
    (series * rest * rest + rest + 1.0) * power
}

real!(f32 {
    #[inline(always)]
    fn exp(self) -> Self {
        exponential(self)
    }
    #[inline(always)]
    fn ln_1p_unit(self) -> Self {
        // ln(1 + x) = 2 artanh(x / (2 + x)); the argument is at most 1/3, and eight terms of the series suffice.
        let s = self / (2.0 + self);
        let z = s * s;
        let mut series = 1.0 / 15.0;
        for denominator in [13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
            series = series * z + 1.0 / denominator;
        }
        2.0 * (s + s * z * series)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        let size = f32::abs(self);
        let z = size * size;
        let small = TANH.iter().fold(0.0, |sum, &coefficient| sum * z + coefficient) * z * size + size;
        let decay = exponential(-2.0 * size);
        let large = (1.0 - decay) / (1.0 + decay);
        f32::copysign(if size < 0.625 { small } else { large }, self)
    }
});
