//! Small, deterministic statistics: of one series, of two, and of a handful of training runs.
//!
//! Every function returns `None` where its quantity is undefined (too few values, no spread) or not a
//! finite number.

use crate::{finite, ratio};

/// Arithmetic mean of at least one value.
pub fn mean(values: &[f64]) -> Option<f64> {
    ratio(values.iter().sum(), values.len() as f64)
}

/// Sample standard deviation (divisor `n - 1`) of at least two values.
pub fn standard_deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let mean = mean(values)?;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    finite((squares / (values.len() - 1) as f64).sqrt())
}

/// Median of at least one value.
pub fn median(values: &[f64]) -> Option<f64> {
    quantile(&sorted(values), 0.5)
}

/// Interquartile mean: the mean of what is left when the lowest and the highest quarter of the values
/// (each rounded down to whole values) are set aside.
///
/// Robust like the median, yet it uses half of the data; recommended for comparing a few training runs
/// by Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", 2021.
pub fn interquartile_mean(values: &[f64]) -> Option<f64> {
    let sorted = sorted(values);
    let trimmed = sorted.len() / 4;
    mean(&sorted[trimmed..sorted.len() - trimmed])
}

/// Percentile bootstrap interval of `statistic`, as `(low, high)`.
///
/// Draws `resamples` samples with replacement from `values`, seeded, so that the same input gives the
/// same interval on every machine. `confidence` lies in (0, 1), for example 0.95. With one value the
/// interval has no width; it is `None` without values, without resamples, for another confidence, or if
/// `statistic` is undefined for some resample.
pub fn bootstrap_interval(
    values: &[f64],
    statistic: impl Fn(&[f64]) -> Option<f64>,
    confidence: f64,
    resamples: usize,
    seed: u64,
) -> Option<(f64, f64)> {
    if values.is_empty() || !(confidence > 0.0 && confidence < 1.0) {
        return None;
    }
    let mut random = SplitMix64(seed);
    let mut resample = vec![0.0; values.len()];
    let mut estimates = Vec::with_capacity(resamples);
    for _ in 0..resamples {
        for value in &mut resample {
            *value = values[random.below(values.len())];
        }
        estimates.push(statistic(&resample)?);
    }
    let estimates = sorted(&estimates);
    let tail = 0.5 * (1.0 - confidence);
    Some((
        quantile(&estimates, tail)?,
        quantile(&estimates, 1.0 - tail)?,
    ))
}

/// Wilson's interval at 95 % of a share of which `successes` of `trials` were seen, as `(low, high)`.
///
/// E. B. Wilson, J. Am. Stat. Assoc. 22, 1927: unlike the share plus and minus its standard error it is meaningful for a handful
/// of trials, and for none or all of them. `None` without trials, or with more successes than trials.
pub fn wilson_interval(successes: usize, trials: usize) -> Option<(f64, f64)> {
    /// Quantile of the normal distribution at 97.5 %.
    const Z: f64 = 1.959_963_984_540_054;
    if successes > trials || trials == 0 {
        return None;
    }
    let n = trials as f64;
    let share = successes as f64 / n;
    let scale = 1.0 + Z * Z / n;
    let middle = (share + Z * Z / (2.0 * n)) / scale;
    let half = Z / scale * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    // At the ends the interval closes exactly; rounding must not open it.
    let low = if successes == 0 { 0.0 } else { middle - half };
    let high = if successes == trials {
        1.0
    } else {
        middle + half
    };
    Some((low, high))
}

/// Pearson's correlation of two series of equal length, in [-1, 1].
///
/// `None` if a series does not vary (by more than rounding) or the lengths differ.
pub fn correlation(first: &[f64], second: &[f64]) -> Option<f64> {
    if first.len() != second.len() {
        return None;
    }
    let first = deviations(first)?;
    let second = deviations(second)?;
    let products: f64 = first.iter().zip(&second).map(|(a, b)| a * b).sum();
    finite(products).map(|correlation| correlation.clamp(-1.0, 1.0))
}

/// Deviations from the mean, scaled to unit length; `None` if there are none but rounding errors.
fn deviations(values: &[f64]) -> Option<Vec<f64>> {
    let mean = mean(values)?;
    let largest = values
        .iter()
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let mut deviations: Vec<f64> = values.iter().map(|value| value - mean).collect();
    let spread = deviations
        .iter()
        .fold(0.0_f64, |spread, value| spread.max(value.abs()));
    if spread <= 1e-12 * largest {
        return None;
    }
    // Scaled by the spread first, so that no square over- or underflows.
    deviations.iter_mut().for_each(|value| *value /= spread);
    let length = deviations
        .iter()
        .map(|value| value * value)
        .sum::<f64>()
        .sqrt();
    deviations.iter_mut().for_each(|value| *value /= length);
    Some(deviations)
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The quantile of sorted values, linear between neighbours; `fraction` in [0, 1].
fn quantile(sorted: &[f64], fraction: f64) -> Option<f64> {
    let position = fraction * sorted.len().checked_sub(1)? as f64;
    let below = sorted[position.floor() as usize];
    let above = sorted[position.ceil() as usize];
    finite(below + (above - below) * position.fract())
}

/// Steele, Lea and Flood's SplitMix64 (2014): tiny, and good enough to draw resamples.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// A number from 0 to `end - 1`; the bias of taking the high half of the product is below 2^-32.
    fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.next()) * end as u128) >> 64) as usize
    }
}
