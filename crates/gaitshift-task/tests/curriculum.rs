//! Contract: the default curriculum is the paper's schedule; settings change exactly at the phases'
//! boundaries; a widening range and moving weights move linearly; bad values are named.

use gaitshift_body::BodyParameters;
use gaitshift_task::{Curriculum, LearnerSettings, Overrides, Phase, RewardParameters};

#[test]
fn the_default_is_the_papers_schedule() {
    let c = Curriculum::default();
    let r = RewardParameters::default();
    assert_eq!(c.total_steps(), 10_000_000);
    let at = |step| {
        let s = c.at(step, &r);
        (s.omega_v, s.reward.omega_e, s.reward.omega_s)
    };
    assert_eq!(at(0), ([-0.2, 0.2], 0.06, 0.0));
    assert_eq!(at(499_999), ([-0.2, 0.2], 0.06, 0.0));
    assert_eq!(at(500_000), ([-0.2, 0.2], 0.2, 0.15));
    assert_eq!(at(4_499_999), ([-0.2, 0.2], 0.2, 0.15));
    assert_eq!(at(4_500_000), ([-0.5, 3.5], 0.2, 0.15));
    assert_eq!(at(20_000_000), ([-0.5, 3.5], 0.2, 0.15));
}

fn widening() -> Curriculum {
    Curriculum {
        phases: vec![Phase {
            omega_v_end: Some([-0.5, 3.5]),
            steps: 100,
            ..Curriculum::default().phases[1].clone()
        }],
        ..Curriculum::default()
    }
}

#[test]
fn a_range_widens_linearly() {
    let s = widening().at(50, &RewardParameters::default());
    assert!((s.omega_v[0] + 0.35).abs() < 1e-12 && (s.omega_v[1] - 1.85).abs() < 1e-12);
}

#[test]
fn a_phase_has_its_own_weights_some_of_which_move_linearly() {
    let mut c = widening();
    c.phases[0].reward = Overrides::from([
        ("omega_e", 0.2),
        ("omega_l", 0.5),
        ("friction_command_divisor", 10.0),
    ]);
    c.phases[0].reward_end = Overrides::from([("omega_e", 0.6), ("c3", 1.5)]);
    let at = |step| c.at(step, &RewardParameters::default()).reward.omega_e;
    assert_eq!(at(0), 0.2);
    assert!((at(25) - 0.3).abs() < 1e-12);
    assert!((at(1000) - 0.6).abs() < 1e-12);
    let s = c.at(0, &RewardParameters::default());
    assert_eq!(s.reward.omega_l, 0.5);
    assert_eq!((s.reward.c3, s.reward.omega_s), (0.5, 0.15));
    assert_eq!(c.at(50, &RewardParameters::default()).reward.c3, 1.0);
    assert_eq!(s.reward.friction_command_divisor, 10.0);
    assert_eq!(s.command, c.command);
}

#[test]
fn a_phase_has_its_own_learner_whose_settings_move_linearly() {
    let own = LearnerSettings {
        learning_rate: 3e-4,
        alpha: 0.2,
        horizon: 100.0,
        rehearsal: 0.0,
    };
    let mut c = widening();
    c.phases.push(c.phases[0].clone());
    c.phases[1].learner = Overrides::from([("learning_rate", 4e-4), ("rehearsal", 5.0)]);
    c.phases[1].learner_end = Overrides::from([("learning_rate", 2e-4), ("horizon", 50.0)]);
    c.phases.push(c.phases[0].clone());
    for step in [0, 99, 200, 1000] {
        assert_eq!(c.learner_at(step, &own), own);
    }
    let expected = |learning_rate, horizon| LearnerSettings {
        learning_rate,
        horizon,
        rehearsal: 5.0,
        ..own
    };
    assert_eq!(c.learner_at(100, &own), expected(4e-4, 100.0));
    let half = c.learner_at(150, &own);
    assert!((half.learning_rate - 3e-4).abs() < 1e-18, "{half:?}");
    assert_eq!(half.horizon, 75.0);
    assert_eq!(c.rehearsal_start(), Some(100));
    c.phases[1].learner = Overrides::default();
    assert_eq!(c.rehearsal_start(), None);
    c.phases[2].learner_end = Overrides::from([("rehearsal", 5.0)]);
    assert_eq!(c.rehearsal_start(), Some(200));
    assert_eq!(c.learner_at(200, &own).rehearsal, 0.0);
    assert_eq!(c.learner_at(250, &own).rehearsal, 2.5);
}

#[test]
fn bad_values_are_named() {
    let mut c = widening();
    c.phases[0].omega_v = [1.0, -1.0];
    let error = c
        .validate(&BodyParameters::default(), &RewardParameters::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("curriculum.phases[0].omega_v"), "{error}");
    for bad in [[-101.0, 0.0], [0.0, 1e300], [f64::NAN, 0.0]] {
        for end in [false, true] {
            let mut c = widening();
            let name = if end {
                c.phases[0].omega_v_end = Some(bad);
                "omega_v_end"
            } else {
                c.phases[0].omega_v = bad;
                "omega_v"
            };
            let error = c
                .validate(&BodyParameters::default(), &RewardParameters::default())
                .unwrap_err();
            assert_eq!(error.key, format!("curriculum.phases[0].{name}"));
            assert!(error.accepted.contains("-100 <= low"), "{error}");
        }
    }
    c.phases[0].omega_v = [0.0, 1.0];
    c.phases[0].reward_end = Overrides::from([("omega_e", -1.0)]);
    let error = c
        .validate(&BodyParameters::default(), &RewardParameters::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("phases[0].reward_end.omega_e"), "{error}");
    c.phases[0].reward_end = Overrides::default();
    c.phases[0].learner = Overrides::from([("horizon", 0.0)]);
    let error = c
        .validate(&BodyParameters::default(), &RewardParameters::default())
        .unwrap_err();
    let error = error.to_string();
    assert!(error.contains("phases[0].learner.horizon"), "{error}");
    // Only the first of two phases of a name could be changed by it.
    c.phases[0].learner = Overrides::default();
    c.phases.push(c.phases[0].clone());
    let error = c
        .validate(&BodyParameters::default(), &RewardParameters::default())
        .unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("].name") && error.contains("of its own"),
        "{error}"
    );
    let error = toml::from_str::<Overrides<LearnerSettings>>("gamma = 0.9").unwrap_err();
    assert!(error.message().contains("`horizon`"), "{error}");
    let error = toml::from_str::<Overrides<RewardParameters>>("omega_x = 1.0").unwrap_err();
    assert!(error.message().contains("`omega_x`"), "{error}");
    assert!(error.message().contains("energy_cap"), "{error}");
    c.phases.clear();
    assert!(
        c.validate(&BodyParameters::default(), &RewardParameters::default())
            .unwrap_err()
            .to_string()
            .contains("phases")
    );
}
