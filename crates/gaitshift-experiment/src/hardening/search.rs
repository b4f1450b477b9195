//! The search for a way to withstand a push or a step: offsets to the controller's commands, by the cross-entropy method.

use super::case::{Case, KNOTS, NO_OFFSETS, Offsets, Trial};
use gaitshift_sac::Policy;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Generations at most, samples of each, and how many of them the next is drawn around.
const GENERATIONS: usize = 12;
const SAMPLES: usize = 96;
const ELITE: usize = 12;
/// Deviation of the first samples and the least of later ones, as a share of the actuator's greatest force.
const DEVIATION: f64 = 0.3;
const LEAST_DEVIATION: f64 = 0.08;
/// How far the mean and the deviations follow the elite.
const MEAN_RATE: f64 = 0.7;
const DEVIATION_RATE: f64 = 0.5;
/// A way counts that still holds with noise of this deviation, this many times of so many.
const NOISE: f64 = 0.06;
const NOISY: usize = 6;
const NOISY_UP: usize = 4;
/// Times that a way is tried smaller.
const SHRINKS: usize = 12;

/// Offsets with which a case is withstood, if any are found, and how many motions were tried.
pub(super) fn search(
    case: &Case,
    policy: &mut Policy,
    rng: &mut Xoshiro256PlusPlus,
) -> (Option<Offsets>, usize) {
    let mut mean = NO_OFFSETS;
    let mut deviation = [[DEVIATION; 2]; KNOTS];
    let mut tried = 0;
    let mut found = false;
    for _ in 0..GENERATIONS {
        let mut generation: Vec<(f64, Offsets)> = (0..SAMPLES)
            .map(|_| {
                let sample = noisy(&mean, &deviation, rng);
                let share = case.share(policy, &sample, Trial::Sample);
                // Of those that hold the smallest are the best.
                let size = sample.as_flattened().iter().map(|v| v * v).sum::<f64>();
                let score = if share < 1.0 {
                    share - 1.0
                } else {
                    1.0 / (1.0 + size)
                };
                (score, sample)
            })
            .collect();
        generation.sort_by(|a, b| b.0.total_cmp(&a.0));
        generation.truncate(ELITE);
        follow(&generation, &mut mean, &mut deviation);
        tried += SAMPLES + 1 + NOISY;
        if holds(case, policy, &mean, rng) {
            found = true;
            break;
        }
    }
    if !found && !case.withstood(policy, &mean) {
        return (None, tried);
    }
    for _ in 0..SHRINKS {
        let smaller = smaller(&mean, rng);
        tried += 1 + NOISY;
        if holds(case, policy, &smaller, rng) {
            mean = smaller;
        }
    }
    (Some(mean), tried)
}

/// A way with as much noise as it has to bear.
pub(super) fn with_noise(offsets: &Offsets, rng: &mut Xoshiro256PlusPlus) -> Offsets {
    noisy(offsets, &[[NOISE; 2]; KNOTS], rng)
}

fn noisy(mean: &Offsets, deviation: &Offsets, rng: &mut Xoshiro256PlusPlus) -> Offsets {
    let mut sample = *mean;
    let values = sample.as_flattened_mut().iter_mut();
    for (value, deviation) in values.zip(deviation.as_flattened()) {
        let normal: f64 = StandardNormal.sample(rng);
        *value += deviation * normal;
    }
    sample
}

/// Moves the mean and the deviations towards those of the elite.
fn follow(elite: &[(f64, Offsets)], mean: &mut Offsets, deviation: &mut Offsets) {
    let count = elite.len() as f64;
    let places = mean
        .as_flattened_mut()
        .iter_mut()
        .zip(deviation.as_flattened_mut());
    for (place, (mean, deviation)) in places.enumerate() {
        let values = elite
            .iter()
            .map(|(_, offsets)| offsets.as_flattened()[place]);
        let middle = values.clone().sum::<f64>() / count;
        let variance = values.map(|v| (v - middle).powi(2)).sum::<f64>() / count;
        *mean += MEAN_RATE * (middle - *mean);
        *deviation += DEVIATION_RATE * (variance.sqrt().max(LEAST_DEVIATION) - *deviation);
    }
}

/// Whether a case is withstood with these offsets, and mostly with noise on them.
fn holds(
    case: &Case,
    policy: &mut Policy,
    offsets: &Offsets,
    rng: &mut Xoshiro256PlusPlus,
) -> bool {
    case.withstood(policy, offsets)
        && (0..NOISY)
            .filter(|_| {
                let sample = with_noise(offsets, rng);
                case.share(policy, &sample, Trial::Sample) >= 1.0
            })
            .count()
            >= NOISY_UP
}

/// All offsets, or those from some knot on, by 5 to 30 % smaller.
fn smaller(offsets: &Offsets, rng: &mut Xoshiro256PlusPlus) -> Offsets {
    let factor = 0.7 + 0.25 * rng.random::<f64>();
    let from = if rng.random::<bool>() {
        0
    } else {
        rng.random_range(0..KNOTS)
    };
    let mut smaller = *offsets;
    for value in smaller[from..].as_flattened_mut() {
        *value *= factor;
    }
    smaller
}
