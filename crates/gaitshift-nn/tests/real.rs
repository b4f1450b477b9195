//! The networks' own exponential, logarithm and tangent in f32 against those of the standard library in f64, over all
//! arguments in use: at most 2 units in the last place apart, symmetric, NaN passed on.

use gaitshift_nn::Real;

/// Distance in units of the last place of the exact value.
fn units(found: f32, exact: f64) -> f64 {
    let spacing = f64::from(f32::EPSILON) * 2f64.powi(exact.abs().log2().floor() as i32);
    (f64::from(found) - exact).abs() / spacing
}

#[test]
fn exponential() {
    for index in -870_000..=870_000 {
        let x = index as f32 * 1e-4;
        let distance = units(Real::exp(x), f64::from(x).exp());
        assert!(distance < 2.0, "exp({x}): {distance} units");
    }
    assert_eq!(Real::exp(0.0f32), 1.0);
    assert_eq!(Real::exp(-1e30f32), Real::exp(-87.0f32));
    assert!(Real::exp(1e30f32).is_finite() && Real::exp(f32::NAN).is_nan());
}

#[test]
fn logarithm() {
    for index in 1..=1_000_000 {
        let x = index as f32 * 1e-6;
        let distance = units(Real::ln_1p_unit(x), f64::from(x).ln_1p());
        assert!(distance < 2.0, "ln_1p({x}): {distance} units");
    }
    assert_eq!(Real::ln_1p_unit(0.0f32), 0.0);
    assert!(Real::ln_1p_unit(f32::NAN).is_nan());
}

#[test]
fn hyperbolic_tangent() {
    for index in 1..=1_000_000 {
        let x = index as f32 * 1e-5;
        let found = Real::tanh(x);
        let distance = units(found, f64::from(x).tanh());
        assert!(
            distance < 2.0 && found <= 1.0,
            "tanh({x}): {distance} units"
        );
        assert_eq!(Real::tanh(-x), -found);
    }
    assert_eq!(Real::tanh(1e-20f32), 1e-20);
    assert_eq!(Real::tanh(-1e30f32), -1.0);
    assert!(Real::tanh(f32::NAN).is_nan());
}
