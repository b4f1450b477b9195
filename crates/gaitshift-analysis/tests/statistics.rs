//! Contract: the statistics agree with values computed by hand or with NumPy and SciPy, are undefined
//! rather than NaN where they have no meaning, and are the same on every machine for the same seed.

use crate::common::close;
use gaitshift_analysis::statistics::{
    bootstrap_interval, correlation, interquartile_mean, mean, median, standard_deviation,
    wilson_interval,
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

#[test]
fn wilson_intervals_are_those_of_scipy() {
    // scipy 1.17.1: binomtest(k, n).proportion_ci(method="wilson")
    for (successes, trials, low, high) in [
        (0, 10, 0.0, 0.277_532_799_862_889_26),
        (1, 3, 0.061_491_944_720_396_26, 0.792_340_399_197_952_3),
        (3, 5, 0.230_724_281_276_012_97, 0.882_379_225_767_352_1),
        (7, 10, 0.396_778_147_461_145_26, 0.892_208_732_593_699),
        (7, 50, 0.069_508_334_270_162_92, 0.261_861_937_105_857_35),
        (20, 20, 0.838_874_841_947_180_8, 1.0),
    ] {
        let found = wilson_interval(successes, trials).expect("defined");
        assert!((found.0 - low).abs() < 1e-12, "{found:?} instead of {low}");
        assert!(
            (found.1 - high).abs() < 1e-12,
            "{found:?} instead of {high}"
        );
    }
    assert_eq!(wilson_interval(0, 0), None);
    assert_eq!(wilson_interval(3, 2), None);
}

#[test]
fn interquartile_means_and_their_intervals_are_those_of_scipy() {
    // scipy 1.17.1: stats.trim_mean(values, 0.25), as rliable takes it.
    for (values, expected) in [
        (&[0.5][..], 0.5),
        (&[1.0, 2.0, 3.0], 2.0),
        (&[3.0, 1.0, 4.0, 1.0, 5.0], 8.0 / 3.0),
        (&[2.7, 1.8, 2.8, 1.8, 2.8, 4.5, 9.0, 4.5], 3.2),
    ] {
        close(interquartile_mean(values), expected);
    }
    // numpy.quantile over all 5^5 resamples, each with trim_mean; and scipy.stats.bootstrap(method="percentile") with 200 000.
    for (values, low, high) in [
        ([3.0, 1.0, 4.0, 1.0, 5.0], 1.0, 14.0 / 3.0),
        ([36.0, 37.0, 35.0, 37.0, 33.0], 101.0 / 3.0, 37.0),
    ] {
        let found = bootstrap_interval(&values, interquartile_mean, 0.95, 10_000, 1);
        let found = found.expect("defined");
        assert!((found.0 - low).abs() < 1e-9, "{found:?} instead of {low}");
        assert!((found.1 - high).abs() < 1e-9, "{found:?} instead of {high}");
    }
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
