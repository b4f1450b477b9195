//! Settings come from a user's file: unknown ones are refused, defaults fill the rest, and every value out of range is
//! named together with what it must be.

use gaitshift_sac::{Agent, SacConfig, SacError, Temperature};

#[test]
fn defaults_are_valid_and_fill_what_is_missing() {
    SacConfig::default().validate().unwrap();
    let config: SacConfig = serde_json::from_str(r#"{"gamma": 0.98}"#).unwrap();
    assert_eq!(
        config,
        SacConfig {
            gamma: 0.98,
            ..SacConfig::default()
        }
    );
}

#[test]
fn temperature_has_two_kinds() {
    let fixed: SacConfig =
        serde_json::from_str(r#"{"temperature": {"kind": "fixed", "alpha": 0.1}}"#).unwrap();
    assert_eq!(fixed.temperature, Temperature::Fixed { alpha: 0.1 });
    let auto: SacConfig =
        serde_json::from_str(r#"{"temperature": {"kind": "auto", "initial": 0.3}}"#).unwrap();
    let expected = Temperature::Auto {
        initial: 0.3,
        target_entropy: None,
        learning_rate: 3e-4,
    };
    assert_eq!(auto.temperature, expected);
    for bad in [
        r#"{"temperature": {"kind": "fixed", "alpha": 0.1, "initial": 1}}"#,
        r#"{"temperature": {"kind": "fixd", "alpha": 0.1}}"#,
        r#"{"temperature": {"kind": "fixed"}}"#,
        r#"{"temprature": 1}"#,
    ] {
        assert!(serde_json::from_str::<SacConfig>(bad).is_err(), "{bad}");
    }
}

type Change = fn(&mut SacConfig);

#[test]
fn values_out_of_range_are_named() {
    let cases: [(&str, Change); 14] = [
        ("actor_hidden", |config| config.actor_hidden = vec![]),
        ("critic_hidden", |config| config.critic_hidden = vec![64, 0]),
        ("critic_hidden", |config| {
            config.critic_hidden = vec![8, 65_536, 65_536];
        }),
        ("learning_rate", |config| config.learning_rate = 0.0),
        ("learning_rate", |config| config.learning_rate = f64::NAN),
        ("gamma", |config| config.gamma = 1.01),
        ("tau", |config| config.tau = 0.0),
        ("batch_size", |config| config.batch_size = 0),
        ("n_step", |config| config.n_step = 0),
        ("temperature.alpha", |config| {
            config.temperature = Temperature::Fixed { alpha: -0.1 }
        }),
        ("temperature.initial", |config| {
            config.temperature = Temperature::Auto {
                initial: 0.0,
                target_entropy: None,
                learning_rate: 1e-3,
            };
        }),
        ("temperature.target_entropy", |config| {
            config.temperature = Temperature::Auto {
                initial: 0.1,
                target_entropy: Some(f64::NAN),
                learning_rate: 1e-3,
            };
        }),
        ("temperature.learning_rate", |config| {
            config.temperature = Temperature::Auto {
                initial: 0.1,
                target_entropy: None,
                learning_rate: -1e-3,
            };
        }),
        ("threads", |config| config.threads = 0),
    ];
    for (expected, change) in cases {
        let mut config = SacConfig::default();
        change(&mut config);
        match config.validate() {
            Err(SacError::Setting { key, .. }) => assert_eq!(key, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
}

#[test]
fn networks_that_would_exhaust_the_memory_are_refused_before_it_is_taken() {
    // What went wrong: weights were counted between hidden layers only, so that one wide layer counted for nothing, and the
    // program was aborted when it took the memory.
    let refused = |result: Result<(), SacError>, expected: &str| match result {
        Err(SacError::Setting { key, .. }) => assert_eq!(key, expected),
        other => panic!("{expected}: {other:?}"),
    };
    let wide = |units, batch_size| SacConfig {
        critic_hidden: vec![units],
        batch_size,
        ..SacConfig::default()
    };
    refused(wide(65_536, 65_536).validate(), "batch_size");
    // The values of a chunk's units for each of its rows count, however few weights there are.
    refused(wide(20_000, 65_536).validate(), "batch_size");
    wide(10_000, 65_536).validate().unwrap();
    // Weights of the inputs count as soon as their number is known.
    let new = |config: SacConfig, observation_size, action_size| {
        Agent::new(config, observation_size, action_size, None, 0).map(|_| ())
    };
    wide(65_536, 256).validate().unwrap();
    refused(new(wide(65_536, 256), 8_000, 1), "critic_hidden");
    refused(new(wide(10_000, 65_536), 200, 2), "batch_size");
    // So do observations themselves, and the outputs of the actor.
    let small = SacConfig {
        actor_hidden: vec![1],
        critic_hidden: vec![1],
        batch_size: 65_536,
        ..SacConfig::default()
    };
    refused(new(small.clone(), 65_536, 1), "batch_size");
    refused(new(small, 1, 65_536), "batch_size");
}
