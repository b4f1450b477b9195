//! Every gradient the learner computes by hand equals the central finite difference of the loss it belongs to,
//! in f64, for every single parameter: critics, actor (through the squashed Gaussian, the log-probability
//! and the critics' action input), layer normalisation, clamped deviations, rehearsal, temperature.
//!
//! The largest difference, relative to the largest gradient of the same tensor, must stay below 1e-6 (it is
//! dominated by the rounding of the difference quotient). Sizes are chosen so that layers need padding and the
//! batch needs two chunks, the second not full.

use gaitshift_nn::{Mlp, Trained};
use gaitshift_sac::{
    Batch, Learner, Mirror, NamedTensor, Noise, Rehearsed, SacConfig, Temperature, streams,
};
use rand::Rng;

const OBSERVATIONS: usize = 5;
const ACTIONS: usize = 3;
const ROWS: usize = 70;
const STEP: f64 = 1e-6;
const TOLERANCE: f64 = 1e-6;

struct Case {
    learner: Learner<f64>,
    batch: Batch<f64>,
    noise: [Vec<f64>; 2],
}

fn mirror() -> Mirror {
    Mirror {
        observation: vec![(0, 1.0), (2, 1.0), (1, 1.0), (3, -1.0), (4, 1.0)],
        action: vec![(1, 1.0), (0, 1.0), (2, -1.0)],
    }
}

fn case(change: impl FnOnce(&mut SacConfig)) -> Case {
    let mut config = SacConfig {
        actor_hidden: vec![13, 24],
        critic_hidden: vec![20, 9],
        batch_size: ROWS,
        ..SacConfig::default()
    };
    change(&mut config);
    let [mut init, mut draw] = streams(11);
    let learner = Learner::new(config, OBSERVATIONS, ACTIONS, Some(mirror()), &mut init).unwrap();
    let mut numbers = |count: usize, scale: f64| -> Vec<f64> {
        (0..count)
            .map(|_| scale * (f64::from(draw.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0))
            .collect()
    };
    let mut batch = Batch {
        observations: numbers(ROWS * OBSERVATIONS, 1.5),
        actions: numbers(ROWS * ACTIONS, 1.0),
        rewards: numbers(ROWS, 2.0),
        discounts: vec![0.99; ROWS],
        next_observations: numbers(ROWS * OBSERVATIONS, 1.5),
    };
    batch.discounts[3] = 0.0;
    let noise = [numbers(ROWS * ACTIONS, 2.0), numbers(ROWS * ACTIONS, 2.0)];
    Case {
        learner,
        batch,
        noise,
    }
}

/// Compares all gradients of one network; returns the largest relative difference.
fn compare(
    case: &mut Case,
    network: impl Fn(&mut Learner<f64>) -> &mut Trained<f64>,
    loss: impl Fn(&mut Case) -> f64,
) -> f64 {
    loss(case);
    let trained = network(&mut case.learner);
    let analytic: Vec<NamedTensor<f64>> = trained.gradient();
    let original = trained.network.tensors();
    let mut worst: f64 = 0.0;
    for (tensor, gradient) in analytic.iter().enumerate() {
        let scale = gradient
            .values
            .iter()
            .fold(0.0f64, |scale, value| scale.max(value.abs()));
        assert!(scale > 1e-6, "{} has no gradient to compare", gradient.name);
        for element in 0..gradient.values.len() {
            let mut at = |offset: f64| {
                let mut tensors = original.clone();
                tensors[tensor].values[element] += offset;
                set(network(&mut case.learner), &tensors);
                loss(case)
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            let error = (difference - gradient.values[element]).abs() / scale;
            assert!(
                error < TOLERANCE,
                "{}[{element}]: by hand {}, by difference {difference}",
                gradient.name,
                gradient.values[element]
            );
            worst = worst.max(error);
        }
    }
    set(network(&mut case.learner), &original);
    worst
}

fn set(trained: &mut Trained<f64>, tensors: &[NamedTensor<f64>]) {
    trained.network.load_tensors(tensors);
    trained.refresh();
}

fn critic_loss(index: usize) -> impl Fn(&mut Case) -> f64 {
    move |case| {
        case.learner.critic_gradients(&case.batch, &case.noise[0]);
        case.learner.stats().critic_loss[index]
    }
}

fn actor_loss(case: &mut Case) -> f64 {
    case.learner.actor_gradient(&case.batch, &case.noise[1]);
    let stats = case.learner.stats();
    stats.actor_loss + case.learner.rehearsal_weight * stats.rehearsal_loss
}

/// Gains and shifts away from their start at 1 and 0, so that none hides.
fn roughen(network: &mut Mlp<f64>) {
    let mut tensors = network.tensors();
    for tensor in tensors
        .iter_mut()
        .filter(|tensor| tensor.name.contains("norm"))
    {
        for (index, value) in tensor.values.iter_mut().enumerate() {
            *value += 0.3 * (index as f64 + 1.0).sin();
        }
    }
    network.load_tensors(&tensors);
}

/// Shifts one critic so that each is the smaller one for some rows, or half of the code is not exercised.
fn balance(case: &mut Case) {
    let originals = [0, 1].map(|index| case.learner.critics[index].network.tensors());
    let only = |case: &mut Case, keep: usize| {
        set(&mut case.learner.critics[1 - keep], &originals[keep]);
        let loss = actor_loss(case);
        set(&mut case.learner.critics[1 - keep], &originals[1 - keep]);
        loss
    };
    let difference = only(case, 0) - only(case, 1);
    let mut shifted = originals[0].clone();
    shifted.last_mut().unwrap().values[0] += difference;
    set(&mut case.learner.critics[0], &shifted);
    let balanced = only(case, 1);
    set(&mut case.learner.critics[0], &shifted);
    assert!(
        actor_loss(case) > balanced + 1e-4,
        "one critic is the smaller one everywhere"
    );
}

#[test]
fn critics() {
    for layer_norm in [false, true] {
        let mut case = case(|config| config.critic_layer_norm = layer_norm);
        for index in 0..2 {
            roughen(&mut case.learner.critics[index].network);
            case.learner.critics[index].refresh();
            let worst = compare(
                &mut case,
                |learner| &mut learner.critics[index],
                critic_loss(index),
            );
            println!("critic {index}, layer norm {layer_norm}: {worst:.1e}");
        }
    }
}

#[test]
fn one_and_three_hidden_layers() {
    for hidden in [vec![11], vec![7, 18, 10]] {
        let mut case = case(|config| {
            config.critic_hidden = hidden.clone();
            config.actor_hidden = hidden;
            config.critic_layer_norm = true;
        });
        compare(&mut case, |learner| &mut learner.critics[0], critic_loss(0));
        compare(&mut case, |learner| &mut learner.actor, actor_loss);
    }
}

#[test]
fn actor() {
    for critic_layer_norm in [false, true] {
        let mut case = case(|config| config.critic_layer_norm = critic_layer_norm);
        roughen(&mut case.learner.actor.network);
        case.learner.actor.refresh();
        for critic in &mut case.learner.critics {
            roughen(&mut critic.network);
            critic.refresh();
        }
        balance(&mut case);
        let worst = compare(&mut case, |learner| &mut learner.actor, actor_loss);
        println!("actor, layer norm {critic_layer_norm}: {worst:.1e}");
    }
}

#[test]
fn actor_with_rehearsal() {
    let mut case = case(|_| ());
    let numbers = |count: usize| (0..count).map(|k| (1.0 + k as f64).sin()).collect();
    case.learner.set_rehearsed(Rehearsed {
        observations: numbers(67 * OBSERVATIONS),
        actions: numbers(67 * ACTIONS),
    });
    case.learner.rehearsal_weight = 2.3;
    let worst = compare(&mut case, |learner| &mut learner.actor, actor_loss);
    assert!(case.learner.stats().rehearsal_loss > 0.1);
    println!("actor with rehearsal: {worst:.1e}");
}

/// Outside its range the logarithm of the deviation passes no derivative on.
#[test]
fn clamped_deviations() {
    let mut case = case(|_| {});
    let mut tensors = case.learner.actor.network.tensors();
    let bias = tensors.last_mut().unwrap();
    bias.values[ACTIONS] = 5.0;
    bias.values[ACTIONS + 1] = -9.0;
    set(&mut case.learner.actor, &tensors);
    actor_loss(&mut case);
    let gradient = case.learner.actor.gradient();
    let bias = &gradient.last().unwrap().values;
    assert_eq!(bias[ACTIONS], 0.0);
    assert_eq!(bias[ACTIONS + 1], 0.0);
    assert!(bias[ACTIONS + 2] != 0.0);
    compare_where(&mut case, |value| value != 0.0);
}

fn compare_where(case: &mut Case, include: impl Fn(f64) -> bool) {
    let analytic = case.learner.actor.gradient();
    let original = case.learner.actor.network.tensors();
    for (tensor, gradient) in analytic.iter().enumerate() {
        let scale = gradient
            .values
            .iter()
            .fold(0.0f64, |scale, value| scale.max(value.abs()));
        for (element, &value) in gradient
            .values
            .iter()
            .enumerate()
            .filter(|&(_, &value)| include(value))
        {
            let mut at = |offset: f64| {
                let mut tensors = original.clone();
                tensors[tensor].values[element] += offset;
                set(&mut case.learner.actor, &tensors);
                actor_loss(case)
            };
            let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            assert!(
                (difference - value).abs() / scale < TOLERANCE,
                "{}[{element}]",
                gradient.name
            );
        }
    }
}

/// The loss is -ln α (mean ln π + target); its derivative in ln α is minus the bracket.
#[test]
fn temperature() {
    let target = -1.3;
    let mut case = case(|config| {
        config.temperature = Temperature::Auto {
            initial: 0.3,
            target_entropy: Some(target),
            learning_rate: 1e-3,
        };
    });
    let before = case.learner.temperature();
    assert!((before.log_alpha - 0.3f64.ln()).abs() < 1e-15);
    let Case {
        learner,
        batch,
        noise,
    } = &mut case;
    let stats = learner
        .update(
            batch,
            Noise {
                next: &noise[0],
                current: &noise[1],
            },
        )
        .unwrap();
    let loss = |log_alpha: f64| -log_alpha * (-stats.entropy + target);
    let difference = (loss(before.log_alpha + STEP) - loss(before.log_alpha - STEP)) / (2.0 * STEP);
    let gradient = learner.temperature_gradient().unwrap();
    assert!((gradient - difference).abs() < 1e-8 * gradient.abs());
    // Adam's first step is the learning rate against the sign of the gradient.
    let step = learner.temperature().log_alpha - before.log_alpha;
    assert!((step + 1e-3 * gradient.signum()).abs() < 1e-9);
    assert_eq!(
        stats.alpha, before.alpha,
        "the update itself uses the temperature it started with"
    );
}
