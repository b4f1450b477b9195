//! The replay buffer against a model that keeps every step ever made in plain lists.
//!
//! - The ring holds the newest transitions of every environment, whatever its capacity and however often it wrapped.
//! - n-step windows sum discounted rewards, stop at termination, truncation, gaps and the newest step, subtract the
//!   entropy of the steps within, and end in the right observation.
//! - TRUNCATION BOOTSTRAPS: a time limit leaves the discount on the next value as it is; termination sets it to 0.
//! - Gaps (invalid steps) are never drawn and their numbers never seen.
//! - Drawing is uniform and reproducible; mirrored rows are the mirror images of what they would have been.
//! - Wrong lengths and numbers that are not finite are refused, and nothing is stored.

use gaitshift_sac::{Batch, Mirror, ReplayBuffer, SacError, Sampling, Transitions, streams};
use proptest::prelude::*;

#[derive(Clone, Copy, Debug)]
struct Step {
    terminated: bool,
    truncated: bool,
    valid: bool,
    reward: f32,
    log_prob: f32,
}

const GAMMA: f64 = 0.9;
const ALPHA: f64 = 0.3;

/// The observation that names a step: time, environment.
fn observation(time: usize, environment: usize) -> [f32; 2] {
    [time as f32, environment as f32]
}

fn filled(capacity: usize, steps: &[Vec<Step>]) -> ReplayBuffer {
    let environments = steps[0].len();
    let mut buffer = ReplayBuffer::new(capacity, environments, 2, 1).unwrap();
    for (time, row) in steps.iter().enumerate() {
        let numbers = |of: fn(&Step) -> f32| row.iter().map(of).collect::<Vec<_>>();
        let flags = |of: fn(&Step) -> bool| row.iter().map(of).collect::<Vec<_>>();
        let spoil = |values: Vec<f32>, size: usize| -> Vec<f32> {
            let valid = |index: usize| row[index / size].valid;
            values
                .iter()
                .enumerate()
                .map(|(index, &value)| if valid(index) { value } else { f32::NAN })
                .collect()
        };
        let observations = (0..environments)
            .flat_map(|environment| observation(time, environment))
            .collect();
        let next = (0..environments)
            .flat_map(|environment| observation(time + 1, environment))
            .collect();
        let actions = (0..environments)
            .map(|environment| (time * 10 + environment) as f32)
            .collect();
        buffer
            .push(Transitions {
                observations: &spoil(observations, 2),
                actions: &spoil(actions, 1),
                log_probs: &spoil(numbers(|step| step.log_prob), 1),
                rewards: &spoil(numbers(|step| step.reward), 1),
                next_observations: &spoil(next, 2),
                terminated: &flags(|step| step.terminated),
                truncated: &flags(|step| step.truncated),
                valid: &flags(|step| step.valid),
            })
            .unwrap();
    }
    buffer
}

/// Reward sum, discount and last time of the window that starts at `time`, by the definition.
fn window(
    steps: &[Vec<Step>],
    environment: usize,
    time: usize,
    n_step: usize,
) -> (f64, f64, usize) {
    let mut sum = 0.0;
    let mut discount = 1.0;
    for k in 0.. {
        let step = steps[time + k][environment];
        let gain = f64::from(step.reward)
            - if k > 0 {
                ALPHA * f64::from(step.log_prob)
            } else {
                0.0
            };
        sum += discount * gain;
        discount *= GAMMA;
        let follower = steps.get(time + k + 1).map(|row| row[environment]);
        let goes_on = follower.is_some_and(|step| step.valid);
        if step.terminated || step.truncated || k + 1 == n_step || !goes_on {
            let discount = if step.terminated { 0.0 } else { discount };
            return (sum, discount, time + k);
        }
    }
    unreachable!()
}

fn step() -> impl Strategy<Value = Step> {
    let flag = |one_in: u32| (0..one_in).prop_map(|number| number == 0);
    (flag(6), flag(6), flag(7), -2.0f32..2.0, -3.0f32..1.0).prop_map(
        |(terminated, truncated, invalid, reward, log_prob)| Step {
            terminated,
            truncated,
            valid: !invalid,
            reward,
            log_prob,
        },
    )
}

proptest! {
    #[test]
    fn windows_follow_the_definition(
        steps in (1usize..4, 1usize..40).prop_flat_map(|(environments, times)| {
            proptest::collection::vec(proptest::collection::vec(step(), environments), times)
        }),
        rows in 1usize..30,
        spare in 0usize..3,
        n_step in 1usize..6,
    ) {
        let environments = steps[0].len();
        let capacity = rows * environments + spare.min(environments - 1);
        let buffer = filled(capacity, &steps);
        let kept = rows.min(steps.len());
        let oldest = steps.len() - kept;
        let valid = steps[oldest..].iter().flatten().filter(|step| step.valid).count();
        prop_assert_eq!(buffer.len(), kept * environments);
        prop_assert_eq!(buffer.valid_len(), valid);
        prop_assert_eq!(buffer.capacity(), rows * environments);

        let [mut rng] = streams(5);
        let mut slots = [0; 64];
        let drawn = buffer.draw(&mut rng, &mut slots);
        if valid == 0 {
            prop_assert!(matches!(drawn, Err(SacError::EmptyReplay)));
            return Ok(());
        }
        prop_assert!(drawn.is_ok());
        let mut batch = Batch::zeros(slots.len(), 2, 1);
        let sampling = Sampling { n_step, gamma: GAMMA, alpha: ALPHA, mirrored: None };
        buffer.gather(&slots, &sampling, &mut batch).unwrap();
        for row in 0..slots.len() {
            let [time, environment] = [batch.observations[2 * row] as usize, batch.observations[2 * row + 1] as usize];
            prop_assert!(time >= oldest && steps[time][environment].valid);
            prop_assert_eq!(batch.actions[row], (time * 10 + environment) as f32);
            let (sum, discount, last) = window(&steps, environment, time, n_step);
            prop_assert!((f64::from(batch.rewards[row]) - sum).abs() < 1e-5);
            prop_assert!((f64::from(batch.discounts[row]) - discount).abs() < 1e-7);
            prop_assert_eq!(&batch.next_observations[2 * row..2 * row + 2], &observation(last + 1, environment));
        }
    }
}

fn plain(reward: f32) -> Step {
    Step {
        terminated: false,
        truncated: false,
        valid: true,
        reward,
        log_prob: 0.0,
    }
}

/// The rule that is wrong in so many learners, by hand.
#[test]
fn truncation_bootstraps_and_termination_does_not() {
    let truncated = Step {
        truncated: true,
        ..plain(1.0)
    };
    let terminated = Step {
        terminated: true,
        ..plain(1.0)
    };
    let both = Step {
        terminated: true,
        ..truncated
    };
    for (last, discount) in [(truncated, 0.9f32.powi(2)), (terminated, 0.0), (both, 0.0)] {
        let buffer = filled(10, &[vec![plain(1.0)], vec![last], vec![plain(100.0)]]);
        let sampling = Sampling {
            n_step: 5,
            gamma: GAMMA,
            alpha: 0.0,
            mirrored: None,
        };
        let mut batch = Batch::zeros(1, 2, 1);
        buffer.gather(&[0], &sampling, &mut batch).unwrap();
        assert_eq!(batch.rewards, [1.9]);
        assert!((batch.discounts[0] - discount).abs() < 1e-7);
        assert_eq!(
            batch.next_observations,
            [2.0, 0.0],
            "what the ended episode led to, not the next one's start"
        );
    }
}

#[test]
fn drawing_is_uniform_and_reproducible() {
    let steps: Vec<_> = (0..13)
        .map(|time| {
            vec![
                plain(0.0),
                Step {
                    valid: time % 4 != 1,
                    ..plain(0.0)
                },
            ]
        })
        .collect();
    let buffer = filled(20, &steps);
    let [mut rng] = streams(9);
    let mut slots = vec![0; 200_000];
    buffer.draw(&mut rng, &mut slots).unwrap();
    let mut counts = [0u32; 20];
    for &slot in &slots {
        counts[slot] += 1;
    }
    let expected = slots.len() as f64 / buffer.valid_len() as f64;
    let drawn = counts.iter().filter(|&&count| count > 0).count();
    assert_eq!(drawn, buffer.valid_len());
    // Five standard deviations of a binomial count.
    for count in counts.into_iter().filter(|&count| count > 0) {
        assert!(
            (f64::from(count) - expected).abs() < 5.0 * expected.sqrt(),
            "{count} of {expected}"
        );
    }
    let [mut again] = streams(9);
    let mut repeated = vec![0; slots.len()];
    buffer.draw(&mut again, &mut repeated).unwrap();
    assert_eq!(slots, repeated);
}

#[test]
fn mirrored_rows_are_mirror_images() {
    let steps: Vec<_> = (0..9).map(|time| vec![plain(time as f32)]).collect();
    let buffer = filled(9, &steps);
    let mirror = Mirror {
        observation: vec![(1, 1.0), (0, 1.0)],
        action: vec![(0, -1.0)],
    };
    let slots = [1, 2, 3, 4, 5];
    let (mut batch, mut image) = (Batch::zeros(5, 2, 1), Batch::zeros(5, 2, 1));
    let sampling = Sampling {
        n_step: 2,
        gamma: GAMMA,
        alpha: 0.0,
        mirrored: None,
    };
    buffer.gather(&slots, &sampling, &mut batch).unwrap();
    buffer
        .gather(
            &slots,
            &Sampling {
                mirrored: Some((&mirror, 2)),
                ..sampling
            },
            &mut image,
        )
        .unwrap();
    for row in 0..5 {
        let (pair, mut expected) = (
            2 * row..2 * row + 2,
            batch.observations[2 * row..2 * row + 2].to_vec(),
        );
        let mut next = batch.next_observations[pair.clone()].to_vec();
        let mut action = batch.actions[row];
        if row >= 3 {
            expected.reverse();
            next.reverse();
            action = -action;
        }
        assert_eq!(image.observations[pair.clone()], expected);
        assert_eq!(image.next_observations[pair], next);
        assert_eq!(image.actions[row], action);
        assert_eq!(image.rewards[row], batch.rewards[row]);
    }
}

#[test]
fn bad_steps_are_refused_and_leave_no_trace() {
    let mut buffer = ReplayBuffer::new(8, 2, 1, 1).unwrap();
    let good = Transitions {
        observations: &[0.0, 1.0],
        actions: &[0.0, 1.0],
        log_probs: &[0.0, 1.0],
        rewards: &[0.0, 1.0],
        next_observations: &[0.0, 1.0],
        terminated: &[false, true],
        truncated: &[false, false],
        valid: &[true, true],
    };
    let error = buffer
        .push(Transitions {
            rewards: &[0.0, f32::NAN],
            ..good
        })
        .unwrap_err();
    assert!(
        matches!(
            error,
            SacError::NotFinite {
                what: "rewards",
                row: 1
            }
        ),
        "{error}"
    );
    let error = buffer
        .push(Transitions {
            actions: &[0.0],
            ..good
        })
        .unwrap_err();
    assert!(
        matches!(
            error,
            SacError::Length {
                what: "actions",
                found: 1,
                expected: 2
            }
        ),
        "{error}"
    );
    assert!(buffer.is_empty() && buffer.valid_len() == 0);
    buffer.push(good).unwrap();
    assert_eq!((buffer.len(), buffer.valid_len()), (2, 2));
}

#[test]
fn impossible_sizes_are_errors() {
    assert!(matches!(
        ReplayBuffer::new(3, 4, 1, 1),
        Err(SacError::Setting {
            key: "replay_capacity",
            ..
        })
    ));
    assert!(matches!(
        ReplayBuffer::new(3, 0, 1, 1),
        Err(SacError::Setting {
            key: "environments",
            ..
        })
    ));
    assert!(matches!(
        ReplayBuffer::new(usize::MAX, 1, 1, 1),
        Err(SacError::Setting { .. })
    ));
    assert!(matches!(
        ReplayBuffer::new(1 << 58, 1, 100, 1),
        Err(SacError::Setting { .. })
    ));
}
