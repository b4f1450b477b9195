//! Contract: actions are tanh(μ + σ ε) and their log-probabilities those of the squashed Gaussian, written out here term by
//! term, for small numbers and where the tanh saturates; ln σ is held to its bounds, with no gradient outside;
//! the derivatives are those of that formula; what is not a number stays visible.

use gaitshift_sac::gaussian::{
    LOG_DEVIATION_MAX, LOG_DEVIATION_MIN, mean_action, sample, sample_back,
};

const SIZE: usize = 3;

/// Means, ln σ and ε of one row.
type Row = ([f64; SIZE], [f64; SIZE], [f64; SIZE]);

/// Rows that meet every branch.
const ROWS: [Row; 4] = [
    ([0.0, 0.3, -0.7], [-1.0, 0.0, 0.5], [0.2, -1.1, 0.0]),
    ([4.0, -5.0, 1.0], [0.2, -0.3, -2.0], [1.0, -2.0, 3.0]),
    ([0.1, 0.2, 0.3], [-9.0, 7.0, 1.9], [1.5, -0.1, 0.4]),
    ([-0.4, 0.0, 0.9], [-4.9, -5.1, 2.1], [-1.0, 2.0, -0.2]),
];

fn flat(part: fn(&Row) -> Vec<f64>) -> Vec<f64> {
    ROWS.iter().flat_map(part).collect()
}

fn outputs() -> Vec<f64> {
    flat(|(mean, log_deviation, _)| [*mean, *log_deviation].concat())
}

fn noise() -> Vec<f64> {
    flat(|(_, _, noise)| noise.to_vec())
}

fn drawn(out: &[f64], noise: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut actions = vec![0.0; noise.len()];
    let mut log_probs = vec![0.0; noise.len() / SIZE];
    sample(SIZE, out, noise, &mut actions, &mut log_probs);
    (actions, log_probs)
}

#[test]
fn actions_and_log_probabilities_are_those_of_the_formula() {
    let (actions, log_probs) = drawn(&outputs(), &noise());
    for (row, (mean, log_deviation, noise)) in ROWS.iter().enumerate() {
        let mut expected = 0.0;
        for index in 0..SIZE {
            let deviation = log_deviation[index]
                .clamp(LOG_DEVIATION_MIN, LOG_DEVIATION_MAX)
                .exp();
            let u = mean[index] + deviation * noise[index];
            let action = actions[row * SIZE + index];
            assert!((action - u.tanh()).abs() < 1e-12, "{action} {}", u.tanh());
            // 1 - tanh² = 1 / cosh², which keeps its digits where tanh is all but 1.
            expected += -0.5 * noise[index].powi(2)
                - deviation.ln()
                - 0.5 * (2.0 * std::f64::consts::PI).ln()
                + 2.0 * u.cosh().ln();
        }
        let found = log_probs[row];
        assert!((found - expected).abs() < 1e-10, "{found} {expected}");
    }
}

#[test]
fn a_mean_action_is_the_tanh_of_the_mean() {
    let mut actions = vec![0.0; ROWS.len() * SIZE];
    mean_action(SIZE, &outputs(), &mut actions);
    let means = flat(|(mean, _, _)| mean.to_vec());
    for (action, mean) in actions.iter().zip(means) {
        assert!((action - mean.tanh()).abs() < 1e-14);
    }
}

#[test]
fn derivatives_are_finite_differences() {
    const STEP: f64 = 1e-6;
    let (out, noise) = (outputs(), noise());
    // Any loss that is linear in both: Σ w·a + Σ v·ln π.
    let d_action: Vec<f64> = (0..noise.len()).map(|i| 0.3 - 0.1 * i as f64).collect();
    let d_log_prob: Vec<f64> = (0..ROWS.len()).map(|i| 0.5 + 0.2 * i as f64).collect();
    let loss = |out: &[f64]| -> f64 {
        let (actions, log_probs) = drawn(out, &noise);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        dot(&actions, &d_action) + dot(&log_probs, &d_log_prob)
    };
    let (actions, _) = drawn(&out, &noise);
    let mut d_out = vec![f64::NAN; out.len()];
    sample_back(
        SIZE,
        &out,
        &noise,
        &actions,
        &d_log_prob,
        &d_action,
        &mut d_out,
    );
    for index in 0..out.len() {
        let shifted = |by: f64| {
            let mut out = out.clone();
            out[index] += by;
            loss(&out)
        };
        let slope = (shifted(STEP) - shifted(-STEP)) / (2.0 * STEP);
        let found = d_out[index];
        assert!((found - slope).abs() < 1e-7, "{index}: {found} {slope}");
    }
    // Outside its bounds ln σ has no influence.
    for (row, (_, log_deviation, _)) in ROWS.iter().enumerate() {
        for (index, value) in log_deviation.iter().enumerate() {
            let outside = !(LOG_DEVIATION_MIN..=LOG_DEVIATION_MAX).contains(value);
            let d = d_out[row * 2 * SIZE + SIZE + index];
            assert_eq!(outside, d == 0.0, "row {row}, ln σ {value}: {d}");
        }
    }
}

#[test]
fn what_is_not_a_number_is_not_hidden() {
    let mut out = outputs();
    out[SIZE] = f64::NAN;
    let (actions, log_probs) = drawn(&out, &noise());
    assert!(actions[0].is_nan() && log_probs[0].is_nan());
    assert!(actions[1..].iter().all(|a| a.is_finite()));
}
