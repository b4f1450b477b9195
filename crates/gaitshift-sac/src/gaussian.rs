//! The squashed Gaussian: a = tanh(u), u = mean + deviation · ε, ε standard normal.
//!
//! A policy network gives `2 × actions` numbers per row: the means, then the logarithms of the deviations, clamped
//! to [`LOG_DEVIATION_MIN`], [`LOG_DEVIATION_MAX`] with zero gradient outside.

use gaitshift_nn::simd::{LANES, Loop, run_loop};
use gaitshift_nn::{Real, Scalar};

/// Least logarithm of a deviation (0.0067 before the tanh): exploration never quite ends and the
/// log-probability stays bounded.
pub const LOG_DEVIATION_MIN: f64 = -5.0;
/// Greatest logarithm of a deviation.
pub const LOG_DEVIATION_MAX: f64 = 2.0;

const HALF_LOG_TWO_PI: f64 = 0.918_938_533_204_672_8;

#[inline(always)]
fn clamp<T: Real>(value: T) -> T {
    let (low, high) = (
        T::from_f64(LOG_DEVIATION_MIN),
        T::from_f64(LOG_DEVIATION_MAX),
    );
    // Comparisons that leave NaN as it is, so that it is noticed.
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// The next number of a matrix of `size` columns.
#[inline(always)]
fn advance(size: usize, row: &mut usize, index: &mut usize) {
    *index += 1;
    if *index == size {
        (*row, *index) = (*row + 1, 0);
    }
}

/// Draws actions (rows × `size`) and their log-probabilities (rows) for the outputs `out`
/// (rows × 2 `size`) of a policy network and the standard normal numbers `noise` (rows × `size`).
///
/// ln π = Σ [ −ε²/2 − ln σ − ln √(2π) − ln(1 − tanh² u) ], with
/// ln(1 − tanh² u) = 2 (ln 2 − u − softplus(−2u)), which is exact for large |u| too.
pub fn sample<T: Scalar>(
    size: usize,
    out: &[T],
    noise: &[T],
    actions: &mut [T],
    log_probs: &mut [T],
) {
    run_loop(Sample {
        size,
        out,
        noise,
        actions,
        log_probs,
    });
}

struct Sample<'a, T> {
    size: usize,
    out: &'a [T],
    noise: &'a [T],
    actions: &'a mut [T],
    log_probs: &'a mut [T],
}

impl<T: Scalar> Loop for Sample<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self {
            size,
            out,
            noise,
            actions,
            log_probs,
        } = self;
        let two = T::from_f64(2.0);
        let half = T::from_f64(0.5);
        let constant = T::from_f64(HALF_LOG_TWO_PI);
        let ln_2 = T::from_f64(std::f64::consts::LN_2);
        // Numbers of several rows are gathered side by side: a row has too few for the vector units.
        let rows = noise.len() / size;
        log_probs[..rows].fill(T::ZERO);
        let (mut row, mut index) = (0, 0);
        for first in (0..rows * size).step_by(LANES) {
            let count = LANES.min(rows * size - first);
            let (mut means, mut deviations, mut draws) =
                ([T::ZERO; LANES], [T::ZERO; LANES], [T::ZERO; LANES]);
            let (first_row, first_index) = (row, index);
            for lane in 0..count {
                means[lane] = out[row * 2 * size + index];
                deviations[lane] = out[row * 2 * size + size + index];
                draws[lane] = noise[first + lane];
                advance(size, &mut row, &mut index);
            }
            let (mut squashed, mut terms) = ([T::ZERO; LANES], [T::ZERO; LANES]);
            for lane in 0..LANES {
                let log_deviation = clamp(deviations[lane]);
                let u = means[lane] + log_deviation.exp() * draws[lane];
                squashed[lane] = u.tanh();
                let softplus = (if u < T::ZERO { -(two * u) } else { T::ZERO })
                    + (-(two * u.abs())).exp().ln_1p_unit();
                let log_slope = two * (ln_2 - u - softplus);
                terms[lane] =
                    -(half * draws[lane] * draws[lane]) - log_deviation - constant - log_slope;
            }
            actions[first..first + count].copy_from_slice(&squashed[..count]);
            (row, index) = (first_row, first_index);
            for &term in &terms[..count] {
                log_probs[row] += term;
                advance(size, &mut row, &mut index);
            }
        }
    }
}

/// Actions tanh(mean) (rows × `size`) for the outputs `out` (rows × 2 `size`).
pub fn mean_action<T: Scalar>(size: usize, out: &[T], actions: &mut [T]) {
    run_loop(MeanAction { size, out, actions });
}

struct MeanAction<'a, T> {
    size: usize,
    out: &'a [T],
    actions: &'a mut [T],
}

impl<T: Scalar> Loop for MeanAction<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { size, out, actions } = self;
        for (out, actions) in out
            .chunks_exact(2 * size)
            .zip(actions.chunks_exact_mut(size))
        {
            for (action, &mean) in actions.iter_mut().zip(out) {
                *action = mean.tanh();
            }
        }
    }
}

/// Derivative in the outputs `out` of a loss whose derivatives in the actions and log-probabilities are given.
///
/// With ε held: d ln π / d u = 2 tanh u, d ln π / d ln σ = −1 directly, d u / d ln σ = σ ε,
/// d a / d u = 1 − a². `d_log_prob` has one number per row, `d_action` one per action.
pub fn sample_back<T: Scalar>(
    size: usize,
    out: &[T],
    noise: &[T],
    actions: &[T],
    d_log_prob: &[T],
    d_action: &[T],
    d_out: &mut [T],
) {
    run_loop(SampleBack {
        size,
        out,
        noise,
        actions,
        d_log_prob,
        d_action,
        d_out,
    });
}

struct SampleBack<'a, T> {
    size: usize,
    out: &'a [T],
    noise: &'a [T],
    actions: &'a [T],
    d_log_prob: &'a [T],
    d_action: &'a [T],
    d_out: &'a mut [T],
}

impl<T: Scalar> Loop for SampleBack<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self {
            size,
            out,
            noise,
            actions,
            d_log_prob,
            d_action,
            d_out,
        } = self;
        let two = T::from_f64(2.0);
        let (low, high) = (
            T::from_f64(LOG_DEVIATION_MIN),
            T::from_f64(LOG_DEVIATION_MAX),
        );
        for (row, (out, d_out)) in out
            .chunks_exact(2 * size)
            .zip(d_out.chunks_exact_mut(2 * size))
            .enumerate()
        {
            let d_log_prob = d_log_prob[row];
            for index in 0..size {
                let place = row * size + index;
                let action = actions[place];
                let d_u = d_log_prob * two * action + d_action[place] * (T::ONE - action * action);
                d_out[index] = d_u;
                let raw = out[size + index];
                let inside = raw >= low && raw <= high;
                let d_log_deviation = d_u * clamp(raw).exp() * noise[place] - d_log_prob;
                d_out[size + index] = if inside { d_log_deviation } else { T::ZERO };
            }
        }
    }
}
