//! Contract: a new learner's targets are copies of its critics, which differ from each other, and its average one of the actor;
//! sizes are those asked for; a setting that needs a mirror is refused without one; the number of threads
//! can be changed within its range, and no other setting with it. Networks that commute with a mirror do so from the start on
//! and after any updates, their targets and average with them.

use gaitshift_nn::Mlp;
use gaitshift_sac::{
    Batch, Learner, Mirror, Noise, SacConfig, SacError, Temperature, reflect, streams,
};

fn learner(config: SacConfig, mirror: Option<Mirror>) -> Result<Learner<f64>, SacError> {
    let [mut init] = streams(5);
    Learner::new(config, 4, 2, mirror, &mut init)
}

fn small() -> SacConfig {
    SacConfig {
        actor_hidden: vec![8, 6],
        critic_hidden: vec![7],
        batch_size: 16,
        ..SacConfig::default()
    }
}

fn numbers(network: &Mlp<f64>) -> Vec<f64> {
    network
        .tensors()
        .into_iter()
        .flat_map(|tensor| tensor.values)
        .collect()
}

#[test]
fn targets_and_average_begin_as_copies() {
    let learner = learner(
        SacConfig {
            actor_average_decay: 0.9,
            temperature: Temperature::Fixed { alpha: 0.2 },
            ..small()
        },
        None,
    )
    .unwrap();
    let critics = [0, 1].map(|i| numbers(&learner.critics[i].network));
    assert_ne!(critics[0], critics[1]);
    for (critic, target) in critics.iter().zip(&learner.targets) {
        assert_eq!(*critic, numbers(target));
    }
    let average = learner.average.as_ref().unwrap();
    assert_eq!(numbers(&learner.actor.network), numbers(average));
    assert_eq!((learner.updates(), learner.temperature().alpha), (0, 0.2));
}

#[test]
fn networks_have_the_sizes_asked_for() {
    let learner = learner(small(), None).unwrap();
    let count = |sizes: &[usize]| -> usize { sizes.windows(2).map(|s| (s[0] + 1) * s[1]).sum() };
    assert_eq!(numbers(&learner.actor.network).len(), count(&[4, 8, 6, 4]));
    assert_eq!(
        numbers(&learner.critics[0].network).len(),
        count(&[6, 7, 1])
    );
    assert!(learner.average.is_none());
}

#[test]
fn a_mirror_of_other_sizes_is_refused() {
    let mirror = |size: usize| Mirror {
        observation: (0..size).map(|i| (i, 1.0)).collect(),
        action: vec![(1, 1.0), (0, 1.0)],
        networks: false,
    };
    assert!(learner(small(), Some(mirror(4))).is_ok());
    assert!(learner(small(), Some(mirror(3))).is_err());
}

#[test]
fn threads_change_alone_and_within_their_range() {
    let mut learner = learner(small(), None).unwrap();
    learner.set_threads(3).unwrap();
    let expected = SacConfig {
        threads: 3,
        ..small()
    };
    assert_eq!(*learner.config(), expected);
    for threads in [0, 257] {
        let error = learner.set_threads(threads).unwrap_err().to_string();
        assert!(error.contains("threads"), "{error}");
        assert_eq!(learner.config().threads, 3);
    }
}

#[test]
fn networks_commute_with_their_mirror() {
    let mirror = Mirror {
        observation: vec![(1, 1.0), (0, 1.0), (2, -1.0), (3, 1.0)],
        action: vec![(1, 1.0), (0, 1.0)],
        networks: true,
    };
    let config = SacConfig {
        critic_layer_norm: true,
        actor_average_decay: 0.5,
        actor_hidden: vec![16, 11],
        learning_rate: 1e-3,
        tau: 0.1,
        ..small()
    };
    let mut learner = learner(config, Some(mirror.clone())).unwrap();
    let some = |count: usize, seed: usize| -> Vec<f64> {
        (0..count).map(|i| ((i * 17 + seed) as f64).sin()).collect()
    };
    for seed in 0..10 {
        let mut batch = Batch::zeros(16, 4, 2);
        batch.observations = some(16 * 4, seed);
        batch.next_observations = some(16 * 4, seed + 100);
        batch.actions = some(16 * 2, seed + 200);
        batch.rewards = some(16, seed + 300);
        batch.discounts.fill(0.9);
        batch.entropy_scales.fill(1.0);
        batch.next_entropy_scales.fill(1.0);
        let (next, current) = (some(32, seed + 400), some(32, seed + 500));
        let noise = Noise {
            next: &next,
            current: &current,
        };
        learner.update(&batch, noise).unwrap();
    }

    let of = |network: &Mlp<f64>, x: &[f64]| {
        let mut activations = network.activations(1);
        network.forward(1, x, x.len(), &mut activations);
        activations.out.to_vec()
    };
    let (state, action) = (some(4, 1), some(2, 2));
    let (mut state_image, mut action_image) = (vec![0.0; 4], vec![0.0; 2]);
    reflect(&mirror.observation, &state, &mut state_image);
    reflect(&mirror.action, &action, &mut action_image);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    for actor in [&learner.actor.network, learner.average.as_ref().unwrap()] {
        let (own, image) = (of(actor, &state), of(actor, &state_image));
        // Means and ln σ of the two actions.
        for (index, source) in [1, 0, 3, 2].into_iter().enumerate() {
            close(image[index], own[source]);
        }
        assert!((own[0] - own[1]).abs() > 1e-3);
    }
    let networks = learner.critics.iter().map(|critic| &critic.network);
    for critic in networks.chain(&learner.targets) {
        let value = of(critic, &[state.clone(), action.clone()].concat());
        let image = of(
            critic,
            &[state_image.clone(), action_image.clone()].concat(),
        );
        close(value[0], image[0]);
    }
}
