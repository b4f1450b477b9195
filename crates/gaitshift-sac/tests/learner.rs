//! Contract: a new learner's targets are copies of its critics, which differ from each other;
//! sizes are those asked for; a mirror of other sizes is refused; the number of threads
//! can be changed within its range, and no other setting with it.

use gaitshift_nn::Mlp;
use gaitshift_sac::{Learner, Mirror, SacConfig, SacError, Temperature, streams};

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
fn targets_begin_as_copies() {
    let learner = learner(
        SacConfig {
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
}

#[test]
fn a_mirror_of_other_sizes_is_refused() {
    let mirror = |size: usize| Mirror {
        observation: (0..size).map(|i| (i, 1.0)).collect(),
        action: vec![(1, 1.0), (0, 1.0)],
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
