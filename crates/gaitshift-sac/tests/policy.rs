//! A policy is the actor alone: rebuilt from its tensors it acts alike, rows do not influence each other, its
//! log-probabilities are those of the density its actions follow, and tensors that do not fit are refused by name. The mean
//! of a policy and its mirror image commutes with the mirror. A widened policy acts as before and has more to learn with.

use gaitshift_sac::{Agent, Mirror, MlpShape, Policy, PolicyError, SacConfig, reflect, streams};

fn agent() -> Agent {
    let config = SacConfig {
        actor_hidden: vec![30, 24],
        critic_hidden: vec![8],
        ..SacConfig::default()
    };
    Agent::new(config, 3, 2, None, 5).unwrap()
}

fn observations(rows: usize) -> Vec<f32> {
    (0..rows * 3)
        .map(|index| (index as f32 * 0.7).sin())
        .collect()
}

#[test]
fn tensors_carry_everything() {
    let mut agent = agent();
    let policy = agent.policy();
    let mut rebuilt = Policy::from_tensors(policy.shape().clone(), &policy.tensors()).unwrap();
    let (mut expected, mut found) = ([0.0; 10], [0.0; 10]);
    agent
        .act_deterministic(&observations(5), &mut expected)
        .unwrap();
    rebuilt.mean_action(&observations(5), &mut found).unwrap();
    assert_eq!(expected, found);
    assert!(
        found
            .iter()
            .all(|action| action.abs() < 1.0 && *action != 0.0)
    );
}

/// More rows than fit one chunk, too.
#[test]
fn rows_do_not_influence_each_other() {
    let mut policy = agent().policy();
    let all = observations(150);
    let mut together = vec![0.0; 300];
    policy.mean_action(&all, &mut together).unwrap();
    for (observation, expected) in all.chunks(3).zip(together.chunks(2)) {
        let mut alone = [0.0; 2];
        policy.mean_action(observation, &mut alone).unwrap();
        assert_eq!(alone, expected);
    }
}

/// The mean of 1 / density over samples is the volume of the action space, here 2² (the tanh covers it all).
#[test]
fn log_probabilities_normalise() {
    let mut policy = agent().policy();
    let [mut rng] = streams(1);
    let rows = 50_000;
    let all: Vec<f32> = observations(1).repeat(rows);
    let (mut actions, mut log_probs) = (vec![0.0; rows * 2], vec![0.0; rows]);
    policy
        .sample(&all, &mut rng, &mut actions, &mut log_probs)
        .unwrap();
    // Within half the range, away from the edges where 1 / density has no finite variance.
    let inside = |pair: &[f32]| pair.iter().all(|action| action.abs() < 0.5);
    let volume: f64 = actions
        .chunks(2)
        .zip(&log_probs)
        .filter(|(pair, _)| inside(pair))
        .map(|(_, &log_prob)| f64::from(-log_prob).exp())
        .sum::<f64>()
        / rows as f64;
    assert!((volume - 1.0).abs() < 0.03, "{volume}");
}

#[test]
fn tensors_that_do_not_fit_are_refused() {
    let policy = agent().policy();
    let (shape, tensors) = (policy.shape().clone(), policy.tensors());
    let without = |name: &str| {
        tensors
            .iter()
            .filter(|tensor| tensor.name != name)
            .cloned()
            .collect::<Vec<_>>()
    };
    let missing = Policy::from_tensors(shape.clone(), &without("layers.1.bias")).unwrap_err();
    assert!(
        matches!(&missing, PolicyError::Missing { name } if name == "layers.1.bias"),
        "{missing}"
    );

    let mut altered = tensors.clone();
    altered[0].shape.reverse();
    let wrong = Policy::from_tensors(shape.clone(), &altered).unwrap_err();
    assert!(
        matches!(&wrong, PolicyError::TensorShape { name, .. } if name == "layers.0.weight"),
        "{wrong}"
    );

    let mut altered = tensors.clone();
    altered[0].values.pop();
    assert!(matches!(
        Policy::from_tensors(shape.clone(), &altered),
        Err(PolicyError::TensorShape { .. })
    ));

    let mut altered = tensors.clone();
    altered[2].values[3] = f32::INFINITY;
    assert!(matches!(
        Policy::from_tensors(shape.clone(), &altered),
        Err(PolicyError::NotFinite { .. })
    ));

    for bad in [
        MlpShape {
            outputs: 3,
            ..shape.clone()
        },
        MlpShape {
            hidden: vec![],
            ..shape.clone()
        },
        MlpShape {
            layer_norm: true,
            ..shape.clone()
        },
        MlpShape {
            inputs: usize::MAX,
            ..shape
        },
    ] {
        assert!(matches!(
            Policy::from_tensors(bad, &tensors),
            Err(PolicyError::Shape { .. })
        ));
    }
}

#[test]
fn mean_with_the_mirror_image() {
    let mirror = Mirror {
        observation: vec![(1, 1.0), (0, 1.0), (2, -1.0)],
        action: vec![(1, 1.0), (0, 1.0)],
    };
    let mut policy = agent().policy();
    let mut mean = policy.mean_with_mirror_image(&mirror);
    assert_eq!(mean.shape().hidden, [60, 48]);
    let (mut furthest, mut asymmetry): (f32, f32) = (0.0, 0.0);
    for observation in observations(50).chunks(3) {
        let mut image = [0.0; 3];
        reflect(&mirror.observation, observation, &mut image);
        let act = |policy: &mut Policy, observation: &[f32]| {
            let mut action = [0.0; 2];
            policy.mean_action(observation, &mut action).unwrap();
            action
        };
        let own = act(&mut policy, observation);
        let of_image = act(&mut policy, &image);
        let found = act(&mut mean, observation);
        let found_of_image = act(&mut mean, &image);
        for (i, source) in [(0, 1), (1, 0)] {
            let expected = 0.5 * (own[i].atanh() + of_image[source].atanh());
            assert!((found[i].atanh() - expected).abs() < 1e-5);
            assert!((found_of_image[source] - found[i]).abs() < 1e-6);
            asymmetry = asymmetry.max((of_image[source] - own[i]).abs());
            furthest = furthest.max((found[i] - own[i]).abs());
        }
    }
    assert!(
        furthest > 0.01 && asymmetry > 0.01,
        "{furthest} {asymmetry}"
    );
}

#[test]
fn widened_it_is_the_same_function() {
    let mut policy = agent().policy();
    let [mut rng] = streams(7);
    let mut wide = policy.widened(40, &mut rng);
    assert_eq!(wide.shape().hidden, [40, 40]);
    let observations = observations(50);
    let (mut own, mut found) = ([0.0; 100], [0.0; 100]);
    policy.mean_action(&observations, &mut own).unwrap();
    wide.mean_action(&observations, &mut found).unwrap();
    for (found, own) in found.iter().zip(own) {
        assert!((found - own).abs() < 1e-6);
    }
    // New units have inputs, so that a step of learning has something to go by.
    let tensors = wide.tensors();
    let weight = tensors.iter().find(|t| t.name == "layers.1.weight");
    let weight = &weight.unwrap().values;
    assert!(weight[39 * 40..].iter().all(|w| *w != 0.0));
    // Layers as wide or wider stay.
    let same = policy.widened(24, &mut rng);
    assert_eq!(same.tensors(), policy.tensors());
}

#[test]
fn a_mean_with_the_mirror_image_gives_its_policy_back() {
    let mirror = Mirror {
        observation: vec![(1, 1.0), (0, 1.0), (2, -1.0)],
        action: vec![(1, 1.0), (0, 1.0)],
    };
    let policy = agent().policy();
    let mean = policy.mean_with_mirror_image(&mirror);
    let half = mean.without_mirror_image(&mirror).unwrap();
    assert_eq!(half.shape(), policy.shape());
    assert_eq!(
        half.mean_with_mirror_image(&mirror).tensors(),
        mean.tensors()
    );
    // A policy that is no such mean is nobody's, though its layers could be halved.
    assert!(policy.without_mirror_image(&mirror).is_none());
}
