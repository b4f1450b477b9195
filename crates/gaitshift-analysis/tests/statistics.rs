//! Contract: the statistics agree with values computed by hand or with NumPy and SciPy, are undefined
//! rather than NaN where they have no meaning, and are the same on every machine for the same seed.

mod common;

use common::close;
use gaitshift_analysis::statistics::{
    bootstrap_interval, correlation, interquartile_mean, mean, median, standard_deviation,
};
use proptest::prelude::*;

#[test]
fn location_and_spread_of_known_values() {
    let values = [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0];
    close(mean(&values), 5.0);
    close(standard_deviation(&values), (32.0_f64 / 7.0).sqrt());
    close(median(&values), 4.5);
    close(median(&[3.0, 1.0, 2.0]), 2.0);
}

#[test]
fn the_interquartile_mean_sets_the_outer_quarters_aside() {
    // scipy.stats.trim_mean([...], 0.25)
    close(interquartile_mean(&[100.0, 1.0, 2.0, -100.0]), 1.5);
    close(
        interquartile_mean(&[5.0, 1.0, 2.0, 3.0, 1000.0]),
        10.0 / 3.0,
    );
    close(interquartile_mean(&[1.0, 2.0, 6.0]), 3.0);
}

#[test]
fn what_has_no_meaning_is_undefined() {
    assert_eq!(mean(&[]), None);
    assert_eq!(median(&[]), None);
    assert_eq!(interquartile_mean(&[]), None);
    assert_eq!(standard_deviation(&[1.0]), None);
    assert_eq!(mean(&[f64::MAX, f64::MAX]), None);
    assert_eq!(correlation(&[], &[]), None);
    assert_eq!(correlation(&[1.0, 2.0], &[1.0]), None);
    assert_eq!(correlation(&[1.0, 2.0], &[3.0, 3.0]), None);
    // Rounding is not variation.
    assert_eq!(correlation(&[1.0, 2.0, 3.0], &[0.1 + 0.2, 0.3, 0.3]), None);
    assert_eq!(bootstrap_interval(&[], mean, 0.95, 100, 1), None);
    assert_eq!(bootstrap_interval(&[1.0], mean, 0.95, 0, 1), None);
    assert_eq!(bootstrap_interval(&[1.0], mean, 1.0, 100, 1), None);
    assert_eq!(
        bootstrap_interval(&[1.0, 2.0], |_| None, 0.95, 100, 1),
        None
    );
}

#[test]
fn correlation_of_known_series() {
    close(correlation(&[1.0, 2.0, 3.0], &[10.0, 20.0, 30.0]), 1.0);
    close(correlation(&[1.0, 2.0, 3.0], &[7.0, 5.0, 3.0]), -1.0);
    // By hand: covariance 7, variances 10 and 10.
    close(
        correlation(&[1.0, 2.0, 3.0, 4.0, 5.0], &[2.0, 1.0, 4.0, 3.0, 5.0]),
        0.8,
    );
    close(correlation(&[-1.0, 0.0, 1.0], &[1.0, 0.0, 1.0]), 0.0);
}

#[test]
fn bootstrap_interval_of_a_mean_is_as_wide_as_theory_says() {
    let values: Vec<f64> = (0..100).map(f64::from).collect();
    let (low, high) = bootstrap_interval(&values, mean, 0.95, 4000, 7).expect("defined");
    // Standard error of the mean of 0..100 with divisor n: 28.866 / 10; 1.96 of them each way.
    assert!((low - (49.5 - 5.66)).abs() < 0.4, "{low}");
    assert!((high - (49.5 + 5.66)).abs() < 0.4, "{high}");
}

#[test]
fn bootstrap_is_seeded() {
    let values = [1.0, 5.0, 2.0, 8.0, 3.0];
    let interval = |seed| bootstrap_interval(&values, interquartile_mean, 0.9, 50, seed);
    assert_eq!(interval(3), interval(3));
    assert_ne!(interval(3), interval(4));
    assert_eq!(
        bootstrap_interval(&[4.0], mean, 0.95, 10, 0),
        Some((4.0, 4.0))
    );
}

proptest! {
    #[test]
    fn order_and_scale_do_not_matter(
        values in prop::collection::vec(-1e3..1e3_f64, 2..40),
        scale in 0.1..10.0_f64,
    ) {
        let reversed: Vec<f64> = values.iter().rev().copied().collect();
        prop_assert_eq!(median(&values), median(&reversed));
        let scaled: Vec<f64> = values.iter().map(|value| scale * value + 3.0).collect();
        if let Some(correlation) = correlation(&values, &scaled) {
            prop_assert!((correlation - 1.0).abs() < 1e-9);
        }
        let (low, high) = bootstrap_interval(&values, mean, 0.95, 30, 1).expect("defined");
        let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        prop_assert!(smallest - 1e-9 <= low && low <= high && high <= largest + 1e-9);
    }
}
