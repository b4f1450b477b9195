//! Contract: imitation fits the mean actions of a policy to remembered pairs, sets by their weights, with a mirror those of its mean
//! with its mirror image; its gradient is that of finite differences; the same seed gives the same bits; and what cannot be imitated is
//! refused by name.

use gaitshift_sac::{
    Agent, Imitation, Mirror, NamedTensor, Policy, Rehearsal, SacConfig, SacError,
};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

fn policy() -> Policy {
    let config = SacConfig {
        actor_hidden: vec![24, 16],
        critic_hidden: vec![8],
        batch_size: 32,
        ..SacConfig::default()
    };
    Agent::new(config, 2, 2, None, 5).unwrap().policy()
}

fn mirror() -> Mirror {
    Mirror {
        observation: vec![(1, 1.0), (0, 1.0)],
        action: vec![(1, 1.0), (0, 1.0)],
    }
}

/// Pairs on a grid with what is to be done there.
fn pairs(action: impl Fn([f32; 2]) -> [f32; 2]) -> Rehearsal {
    let grid = (0..100).map(|k| [(k % 10) as f32 / 5.0 - 0.9, (k / 10) as f32 / 5.0 - 0.9]);
    let observations: Vec<f32> = grid.clone().flatten().collect();
    let actions = grid.flat_map(action).collect();
    Rehearsal::new(2, 2, observations, actions).unwrap()
}

fn fitted(sets: &[(&Rehearsal, f64)], mirror: Option<Mirror>) -> (Policy, Vec<f64>) {
    let mut imitation = Imitation::new(&policy(), mirror, 40).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut losses = Vec::new();
    for _ in 0..1500 {
        losses = imitation.step(sets, 3e-3, &mut rng).unwrap();
    }
    (imitation.policy(), losses)
}

fn act(policy: &mut Policy, observation: [f32; 2]) -> [f32; 2] {
    let mut action = [0.0; 2];
    policy.mean_action(&observation, &mut action).unwrap();
    action
}

#[test]
fn it_does_what_was_remembered() {
    let wanted = |o: [f32; 2]| [0.5 * o[0] + 0.3 * o[1], -0.4 * o[0] * o[1]];
    let (mut policy, losses) = fitted(&[(&pairs(wanted), 1.0)], None);
    assert!(losses[0] < 1e-3, "{losses:?}");
    for observation in [[0.3, -0.5], [-0.7, 0.1], [0.6, 0.6]] {
        let (found, expected) = (act(&mut policy, observation), wanted(observation));
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 0.05,
                "{observation:?}: {found} {expected}"
            );
        }
    }
}

#[test]
fn sets_that_contradict_each_other_are_weighed() {
    let (up, down) = (pairs(|_| [0.6; 2]), pairs(|_| [-0.6; 2]));
    // The minimum of 3 (0.6 - a)² + (0.6 + a)² is at a = 0.3.
    let (mut policy, losses) = fitted(&[(&up, 3.0), (&down, 1.0)], None);
    let [found, _] = act(&mut policy, [0.1, 0.1]);
    assert!((found - 0.3).abs() < 0.03, "{found}");
    // Losses are those of both actions together, without the weights.
    assert!(
        (losses[0] - 2.0 * 0.09).abs() < 0.02 && (losses[1] - 2.0 * 0.81).abs() < 0.05,
        "{losses:?}"
    );
}

#[test]
fn with_a_mirror_the_mean_with_the_mirror_image_is_fitted() {
    // What is remembered is symmetric: the second action is the first one of the mirror image.
    let wanted = |o: [f32; 2]| [0.5 * o[0] - 0.2 * o[1], 0.5 * o[1] - 0.2 * o[0]];
    let (policy, losses) = fitted(&[(&pairs(wanted), 1.0)], Some(mirror()));
    assert!(losses[0] < 1e-3, "{losses:?}");
    let mut mean = policy.mean_with_mirror_image(&mirror());
    for observation in [[0.5, -0.3], [-0.2, 0.8]] {
        let (found, expected) = (act(&mut mean, observation), wanted(observation));
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 0.05,
                "{observation:?}: {found} {expected}"
            );
        }
    }
}

#[test]
fn the_first_step_of_adam_follows_the_signs_of_the_gradient() {
    let set = pairs(|o| [0.3 - 0.5 * o[1], o[0] * o[0]]);
    let before = policy();
    // All pairs, as far as so many draws meet them.
    let mut imitation = Imitation::new(&before, Some(mirror()), 20_000).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
    let rate = 1e-3;
    imitation.step(&[(&set, 1.0)], rate, &mut rng).unwrap();
    let after = imitation.policy().tensors();
    let loss = |tensors: &[NamedTensor<f32>]| {
        let policy = Policy::from_tensors(before.shape().clone(), tensors).unwrap();
        let mut mean = policy.mean_with_mirror_image(&mirror());
        let (observations, actions) = (set.observations(), set.actions());
        let rows = observations.chunks(2).zip(actions.chunks(2));
        let losses = rows.map(|(o, a)| {
            let found = act(&mut mean, [o[0], o[1]]);
            (f64::from(found[0] - a[0])).powi(2) + (f64::from(found[1] - a[1])).powi(2)
        });
        losses.sum::<f64>() / set.rows() as f64
    };
    let tensors = before.tensors();
    let (mut compared, mut agree) = (0, 0);
    for (t, tensor) in tensors.iter().enumerate() {
        for k in (0..tensor.values.len()).step_by(7) {
            let at = |shift: f32| {
                let mut moved = tensors.clone();
                moved[t].values[k] += shift;
                loss(&moved)
            };
            let slope = (at(1e-2) - at(-1e-2)) / 2e-2;
            if slope.abs() > 1e-2 {
                compared += 1;
                let moved = f64::from(after[t].values[k] - tensor.values[k]);
                agree += usize::from((moved + rate * slope.signum()).abs() < 0.1 * rate);
            }
        }
    }
    assert!(compared > 20 && agree == compared, "{agree} of {compared}");
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let set = pairs(|o| [o[0], -o[1]]);
    let tensors = || fitted(&[(&set, 1.0)], Some(mirror())).0.tensors();
    assert_eq!(tensors(), tensors());
}

#[test]
fn what_cannot_be_imitated_is_refused() {
    let set = pairs(|o| o);
    let other = Rehearsal::new(1, 1, vec![0.0], vec![0.0]).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    assert!(matches!(
        Imitation::new(&policy(), None, 0),
        Err(SacError::Setting {
            key: "imitation rows",
            ..
        })
    ));
    let foreign = Mirror {
        observation: vec![(0, 1.0)],
        action: vec![(0, 1.0)],
    };
    assert!(Imitation::new(&policy(), Some(foreign), 8).is_err());
    let mut imitation = Imitation::new(&policy(), None, 8).unwrap();
    assert!(matches!(
        imitation.step(&[(&other, 1.0)], 1e-3, &mut rng),
        Err(SacError::Length { .. })
    ));
    for (sets, rate, key) in [
        (&[][..], 1e-3, "imitation sets"),
        (&[(&set, -1.0)][..], 1e-3, "imitation weight"),
        (&[(&set, f64::NAN)][..], 1e-3, "imitation weight"),
        (&[(&set, 1.0)][..], 0.0, "learning_rate"),
    ] {
        let refused = imitation.step(sets, rate, &mut rng);
        assert!(
            matches!(refused, Err(SacError::Setting { key: named, .. }) if named == key),
            "{key}: {refused:?}"
        );
    }
}
