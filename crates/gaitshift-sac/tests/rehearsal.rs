//! Rehearsal keeps what was remembered where it was remembered, against the reward, and leaves the rest to
//! the reward; what cannot be rehearsed is refused by name. (Its gradient is checked in `gradients.rs`, that it
//! keeps a run deterministic and resumable in `agent.rs`.)

use gaitshift_sac::{
    Agent, Mirror, Rehearsal, ReplayBuffer, SacConfig, SacError, Temperature, Transitions,
};

/// One step per episode, two contexts, reward -(a - 0.5)² in both.
fn learn(weight: f64, rehearsal: Option<Rehearsal>, mirror: Option<Mirror>) -> [f32; 2] {
    let config = SacConfig {
        actor_hidden: vec![16, 16],
        critic_hidden: vec![16, 16],
        learning_rate: 5e-3,
        batch_size: 64,
        temperature: Temperature::Fixed { alpha: 0.01 },
        ..SacConfig::default()
    };
    let mut agent = Agent::new(config, 1, 1, mirror, 3).unwrap();
    let mut replay = ReplayBuffer::new(2000, 2, 1, 1).unwrap();
    if let Some(rehearsal) = rehearsal {
        agent.rehearse(rehearsal, 64).unwrap();
        agent.set_rehearsal_weight(weight).unwrap();
    }
    let contexts = [-1.0, 1.0];
    let (mut actions, mut log_probs) = ([0.0; 2], [0.0; 2]);
    for step in 0..1200 {
        agent.act(&contexts, &mut actions, &mut log_probs).unwrap();
        replay
            .push(Transitions {
                observations: &contexts,
                actions: &actions,
                log_probs: &log_probs,
                rewards: &actions.map(|a| -(a - 0.5) * (a - 0.5)),
                next_observations: &contexts,
                terminated: &[true; 2],
                truncated: &[false; 2],
                valid: &[true; 2],
            })
            .unwrap();
        if step >= 100 {
            agent.update(&replay).unwrap();
        }
    }
    agent.act_deterministic(&contexts, &mut actions).unwrap();
    actions
}

#[test]
fn what_is_rehearsed_stays_and_the_rest_follows_the_reward() {
    let remembered = || Some(Rehearsal::new(1, 1, vec![1.0], vec![-0.5]).unwrap());
    let [free, also_free] = learn(0.0, None, None);
    assert!(
        (free - 0.5).abs() < 0.1 && (also_free - 0.5).abs() < 0.1,
        "{free} {also_free}"
    );
    let [free, kept] = learn(100.0, remembered(), None);
    assert!((free - 0.5).abs() < 0.15, "{free}");
    assert!((kept + 0.5).abs() < 0.05, "{kept}");
    // With the weight 0 what is remembered is as if it were not there.
    assert_eq!(learn(0.0, remembered(), None), learn(0.0, None, None));
}

/// Where batches are mirrored, so is what is rehearsed: the mirror image of what was remembered stays too.
#[test]
fn it_is_mirrored_where_batches_are() {
    let mirror = Mirror {
        observation: vec![(0, -1.0)],
        action: vec![(0, -1.0)],
    };
    let remembered = Rehearsal::new(1, 1, vec![1.0], vec![-0.7]).unwrap();
    let [image, kept] = learn(100.0, Some(remembered), Some(mirror));
    assert!((kept + 0.7).abs() < 0.05, "{kept}");
    assert!((image - 0.7).abs() < 0.05, "{image}");
}

#[test]
fn what_cannot_be_rehearsed_is_refused() {
    let pairs = |size: usize| Rehearsal::new(size, 1, vec![0.0; size], vec![0.0]).unwrap();
    let mut agent = Agent::new(SacConfig::default(), 2, 1, None, 1).unwrap();
    assert!(matches!(
        agent.rehearse(pairs(3), 64),
        Err(SacError::Length { .. })
    ));
    agent.rehearse(pairs(2), 64).unwrap();
    let error = agent.rehearse(pairs(2), 0).unwrap_err().to_string();
    assert!(error.contains("rehearsal rows"), "{error}");
    for weight in [-1.0, f64::NAN] {
        let error = agent.set_rehearsal_weight(weight).unwrap_err().to_string();
        assert!(error.contains("rehearsal weight"), "{error}");
    }
    for (observations, actions, cause) in [
        (vec![], vec![], "rehearsal rows"),
        (vec![0.0; 3], vec![0.0], "rehearsal observations"),
        (vec![f32::NAN, 0.0], vec![0.0], "rehearsal observations"),
        (vec![0.0; 2], vec![1.5], "rehearsal action"),
        (vec![0.0; 2], vec![f32::NAN], "rehearsal action"),
    ] {
        let error = Rehearsal::new(2, 1, observations, actions)
            .unwrap_err()
            .to_string();
        assert!(error.contains(cause), "{error}");
    }
}
