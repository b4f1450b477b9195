//! Settings come from a user's file: unknown ones are refused, defaults fill the rest, and every value out of range is
//! named together with what it must be.

use gaitshift_sac::{SacConfig, SacError, Temperature};

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
