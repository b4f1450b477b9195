//! Contract: every shipped recipe is valid and round-trips through its resolved form; a file needs
//! only what differs; what is wrong in a file is reported with file, key and remedy.

use gaitshift_experiment::{Experiment, RECIPES, load_body_overrides};

#[test]
fn every_recipe_is_valid_and_round_trips() {
    for (name, _) in RECIPES {
        let recipe = Experiment::recipe(name).unwrap();
        assert_eq!(recipe.name, name);
        let again = Experiment::parse(&recipe.to_toml().unwrap(), "resolved").unwrap();
        assert_eq!(again, recipe);
    }
}

#[test]
fn the_paper_recipe_has_the_papers_values() {
    let e = Experiment::recipe("paper").unwrap();
    assert_eq!(e.curriculum.total_steps(), 10_000_000);
    assert_eq!(
        (
            e.task.reward.omega_e,
            e.task.reward.omega_l,
            e.task.reward.omega_s
        ),
        (0.2, 0.2, 0.15)
    );
    assert_eq!(
        (e.task.reward.c1, e.task.reward.c2, e.task.reward.c3),
        (1.0, 1.0, 0.5)
    );
    assert_eq!(e.task.termination.pitch_limit_rad, 1.4);
    assert_eq!(e.learner.gamma, 0.99);
    assert_eq!(e.body.total_mass_kg(), 40.0);
}

#[test]
fn a_file_needs_only_what_differs() {
    let e = Experiment::parse("base = \"fast\"\n[body]\nfriction = 0.6\n", "mine.toml").unwrap();
    let fast = Experiment::recipe("fast").unwrap();
    assert_eq!(e.body.friction, 0.6);
    assert_eq!(e.curriculum, fast.curriculum);
    let without_base = Experiment::parse("seed = 5", "mine.toml").unwrap();
    assert_eq!(
        without_base.curriculum,
        Experiment::recipe("paper").unwrap().curriculum
    );
    assert_eq!(without_base.seed, 5);
}

fn error(text: &str) -> String {
    Experiment::parse(text, "mine.toml")
        .unwrap_err()
        .to_string()
}

#[test]
fn mistakes_are_reported_with_file_and_key() {
    for (text, words) in [
        (
            "[body]\nfrikction = 1.0",
            vec!["mine.toml", "frikction", "friction"],
        ),
        (
            "[body]\nfriction = \"high\"",
            vec!["mine.toml", "friction", "line 2"],
        ),
        (
            "[[curriculum.phases]]\nname = \"a\"\nsteps = 1\nomega_v = [0, 1]\nrandomization = { body = { frikction = [1, 2] } }",
            vec!["mine.toml", "frikction", "friction"],
        ),
        (
            "[[curriculum.phases]]\nname = \"a\"\nsteps = 1\nomega_v = [0, 1]\nrandomization = { body = { foot_mass_kg = [0, 2] } }",
            vec![
                "mine.toml",
                "curriculum.phases[0].randomization.body.foot_mass_kg",
                "greater than 0",
            ],
        ),
        (
            "[body]\nhip_mass_kg = -1.0",
            vec!["mine.toml", "hip_mass_kg", "greater than 0"],
        ),
        (
            "[body]\ntime_step_s = 0.0",
            vec!["mine.toml", "time_step_s", "greater than 0"],
        ),
        (
            "[task]\ncontrol_period_s = 0.0051",
            vec!["control_period_s", "multiple"],
        ),
        (
            "[task.reward]\nomega_e = nan",
            vec!["omega_e", "0 or greater"],
        ),
        ("base = \"quick\"", vec!["quick", "fast"]),
        ("[learner]\ngamma = 1.5", vec!["mine.toml", "gamma"]),
        (
            "[learner]\nmirrored_fraction = 0.5",
            vec!["mirrored_fraction", "symmetry"],
        ),
        (
            "[learner]\nrehearsal_weight = 1.0",
            vec!["rehearsal_weight", "training.rehearsal"],
        ),
        (
            "[training.rehearsal]\nweight = 0.0",
            vec!["mine.toml", "training.rehearsal.weight", "greater than 0"],
        ),
        (
            "[training.rehearsal]\nrows = 0",
            vec!["training.rehearsal.rows"],
        ),
        (
            "[training.rehearsal]\nstates = 10",
            vec!["training.rehearsal.states", "1000"],
        ),
        (
            "[training.rehearsal]\nomega_v = [0.2, -0.2]",
            vec!["training.rehearsal.omega_v", "low <= high"],
        ),
        (
            "[training]\nmetrics_interval_steps = 0",
            vec!["training.metrics_interval_steps"],
        ),
        (
            "[training]\nenvironments = 0",
            vec!["training.environments"],
        ),
        (
            "[training]\nsymmetry = \"sideways\"",
            vec!["sideways", "replay"],
        ),
        (
            "[[curriculum.phases]]\nname = \"x\"\nsteps = 0\nomega_v = [0, 1]",
            vec!["phases[0].steps"],
        ),
        ("seed = ", vec!["mine.toml", "line 1"]),
    ] {
        let message = error(text);
        for word in words {
            assert!(
                message.contains(word),
                "{text:?} gave {message:?}, without {word:?}"
            );
        }
    }
}

#[test]
fn the_temperature_can_be_switched_and_resolved() {
    let text = "[learner]\ntemperature = { kind = \"auto\", initial = 0.1 }\n";
    let e = Experiment::parse(text, "mine.toml").unwrap();
    let again = Experiment::parse(&e.to_toml().unwrap(), "resolved").unwrap();
    assert_eq!(again, e);
    assert_ne!(
        e.learner.temperature,
        Experiment::recipe("paper").unwrap().learner.temperature
    );
}

#[test]
fn body_overrides_change_what_they_name_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("body.toml");
    let base = Experiment::recipe("paper").unwrap().body;
    std::fs::write(&file, "friction = 0.7\n").unwrap();
    let body = load_body_overrides(&file, &base).unwrap();
    assert_eq!(body.friction, 0.7);
    assert_eq!(
        gaitshift_body::BodyParameters {
            friction: base.friction,
            ..body
        },
        base
    );
    for (text, word) in [
        ("mass = 1", "mass"),
        ("friction = -1", "friction"),
        ("friction = [", "line"),
    ] {
        std::fs::write(&file, text).unwrap();
        let message = load_body_overrides(&file, &base).unwrap_err().to_string();
        assert!(
            message.contains(word) && message.contains("body.toml"),
            "{message}"
        );
    }
    let missing = load_body_overrides(&folder.path().join("none.toml"), &base).unwrap_err();
    assert!(missing.to_string().contains("none.toml"));
}
