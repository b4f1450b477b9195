//! Contract: every shipped recipe is valid and round-trips through its resolved form; a file needs
//! only what differs; what is wrong in a file is reported with file, key and remedy.

use gaitshift_body::BodyParameters;
use gaitshift_experiment::{
    Controller, Criteria, Experiment, RECIPES, did_you_mean, load_body_overrides, load_disturbance,
    set_body_and_task,
};
use gaitshift_task::{ExtraTerm, TaskParameters};
use std::path::Path;
use toml::Value;

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
fn phases_and_own_terms_can_be_changed_by_name() {
    let text = r#"
        [[task.reward.extra]]
        name = "upright"
        weight = 0.2
        expression = "-theta_rad^2"
    "#;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.toml"), text).unwrap();
    let origin = folder.path().join("mine.toml").display().to_string();
    let changed = r#"
        base = "./base.toml"
        [task.reward.extra]
        upright.weight = 0.5
        [curriculum.phases.II]
        steps = 7
        reward = { omega_e = 0.1 }
        [curriculum.phases."I, relaxed"]
        reward = { omega_s = 0.1 }
    "#;
    let changed = Experiment::parse(changed, &origin).unwrap();
    let wanted = r#"
        [[curriculum.phases]]
        name = "I, relaxed"
        steps = 500_000
        omega_v = [-0.2, 0.2]
        reward = { omega_e = 0.06, omega_s = 0.1 } # beside what was there
        [[curriculum.phases]]
        name = "I"
        steps = 4_000_000
        omega_v = [-0.2, 0.2]
        [[curriculum.phases]]
        name = "II"
        steps = 7
        omega_v = [-0.5, 3.5]
        reward = { omega_e = 0.1 }
    "#;
    let wanted = Experiment::parse(wanted, "wanted.toml").unwrap();
    assert_eq!(changed.curriculum.phases, wanted.curriculum.phases);
    let terms: Vec<ExtraTerm> = changed.task.reward.extra.clone().into();
    assert_eq!(terms.len(), 1);
    assert_eq!((terms[0].name.as_str(), terms[0].weight), ("upright", 0.5));
    // The same by single values.
    let paper = Experiment::recipe("paper").unwrap();
    let one = ["curriculum.phases.I, relaxed.steps=9".to_owned()];
    let one = paper.with_values(&one).unwrap();
    assert_eq!(one.curriculum.phases[0].steps, 9);
    assert_eq!(one.curriculum.phases[1..], paper.curriculum.phases[1..]);
}

#[test]
fn mistakes_are_reported_with_file_and_key() {
    for (text, words) in [
        (
            "[curriculum.phases.III]\nsteps = 1",
            vec!["mine.toml", "`III`", "phases", "did you mean `II`"],
        ),
        (
            "[curriculum.phases]\nII = 3",
            vec!["mine.toml", "phases.\"II\"", "table"],
        ),
        (
            "[curriculum.phases.II]\nstep = 1",
            vec!["mine.toml", "step", "steps"],
        ),
        // Lists were taken for the values of a table's keys, in order.
        (
            "base = 'fast'\ntraining = []",
            vec!["mine.toml", "`training`", "[training]"],
        ),
        ("criteria = []", vec!["`criteria`", "table"]),
        ("body = [5]", vec!["`body`", "table"]),
        ("[[body]]\nfriction = 0.6", vec!["`body`", "`[body]`"]),
        (
            "[task]\nreward = { omega_e = 0.1, extra = [['a', 1, '1']] }",
            vec!["`task.reward.extra`", "[[task.reward.extra]]"],
        ),
        (
            "base = 'robust'\n[curriculum.phases.III.randomization]\nterrain = [0.05]",
            vec!["`curriculum.phases.randomization.terrain`", "table"],
        ),
        (
            "[task.reward.extra.smooth]\nweight = 1.0",
            vec!["mine.toml", "extra"],
        ),
        // It was written into the run's configuration, which could not be read again.
        ("seed = 9223372036854775808", vec!["mine.toml", "seed"]),
        // The horizon on the way from an infinite one was not a number, which only the first step said.
        (
            "[learner]\ngamma = 1.0\n[curriculum.phases.II]\nlearner_end = { horizon = 50.0 }",
            vec!["mine.toml", "phases[2].learner_end", "horizon", "gamma"],
        ),
        // It asked for more memory than there is, and was killed.
        (
            "[learner]\nbatch_size = 65536\ncritic_hidden = [2048, 2048]",
            vec!["mine.toml", "batch_size", "smaller"],
        ),
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
            "[training.rehearsal]\nomega_v = [0.0, 1e30]",
            vec!["training.rehearsal.omega_v", "<= 100"],
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
            "[training]\nreplay_capacity = 1_000_000_000_000",
            vec!["training.replay_capacity", "from 1000 to 1e9"],
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

    // What went wrong: `kind` was asked for where the base has it.
    let own = |table: &str| Experiment::parse(&format!("base = \"fast\"\n{table}\n"), "mine.toml");
    assert_eq!(
        own("[learner.temperature]\nalpha = 0.2").unwrap().learner,
        own("[learner]\ntemperature = { kind = \"fixed\", alpha = 0.2 }")
            .unwrap()
            .learner
    );
    let slip = own("[learner.temperature]\nalpah = 0.2").unwrap_err();
    let slip = slip.to_string();
    assert!(
        slip.contains("`alpah`") && slip.contains("`alpha`"),
        "{slip}"
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

// `base = "./mine.toml"` was refused with the advice to give a TOML file.
#[test]
fn a_base_can_be_a_file_beside_the_one_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    };
    write(
        "mine.toml",
        "base = \"fast\"\nseed = 9\n[body]\nfriction = 0.6\n",
    );
    let path = write(
        "sub/next.toml",
        "base = \"../mine.toml\"\n[body]\nhip_mass_kg = 25\n",
    );
    let experiment = Experiment::read(&path).unwrap();
    assert_eq!(
        (experiment.body.friction, experiment.body.hip_mass_kg),
        (0.6, 25.0)
    );
    assert_eq!(experiment.seed, 9);
    assert_eq!(
        experiment.curriculum,
        Experiment::recipe("fast").unwrap().curriculum
    );

    write("a.toml", "base = \"./b.toml\"");
    let circle = write("b.toml", "base = \"a.toml\"");
    let absent = write("c.toml", "base = \"./no.toml\"");
    let wrong = write("d.toml", "base = \"./e.toml\"");
    write("e.toml", "[body]\nfrction = 1");
    for (path, words) in [
        (circle, vec!["base", "based on itself"]),
        (
            absent,
            vec!["c.toml", "`base`", "no.toml", "name of a recipe"],
        ),
        (wrong, vec!["e.toml", "did you mean `friction`?"]),
    ] {
        let message = Experiment::read(&path).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{message}");
        }
    }
    let message = error("base = \"slow\"");
    assert!(
        message.contains("`slow`") && message.contains("`fast`"),
        "{message}"
    );
}

// An unknown key was answered by the names of all 36.
#[test]
fn a_slip_is_answered_by_the_name_that_was_meant() {
    for (text, meant) in [
        ("[body]\nfrction = 1.0", "friction"),
        ("[body]\nmass = 1.0", "mass"),
        ("[learner]\ngama = 0.9", "gamma"),
        ("[training]\nenvironment = 4", "environments"),
        ("[training]\nsymmetry = \"replai\"", "replay"),
    ] {
        let message = error(text);
        let near = message
            .split("did you mean `")
            .nth(1)
            .unwrap_or_else(|| panic!("{message}"));
        assert!(near.contains(meant), "{message}");
        assert!(
            message.contains("mine.toml") && message.contains("line 2"),
            "{message}"
        );
        assert!(!message.contains("expected one of"), "{message}");
    }
    // Where nothing is near the list is all there is to say.
    let message = error("[training]\nwalrus = 4");
    assert!(message.contains("expected one of"), "{message}");
    assert_eq!(did_you_mean("something else"), "something else");
}

// Four keys of the learner stood in every `config.toml` and were refused as soon as they were given another value.
#[test]
fn every_key_that_is_printed_can_be_changed() {
    fn each(value: &Value, path: &str, change: &mut dyn FnMut(&str, &Value)) {
        match value {
            Value::Table(table) => table
                .iter()
                .for_each(|(key, value)| each(value, &format!("{path}.{key}"), change)),
            Value::Array(list) => list
                .iter()
                .enumerate()
                .for_each(|(i, value)| each(value, &format!("{path}.{i}"), change)),
            value => change(path, value),
        }
    }
    fn at<'a>(value: &'a mut Value, path: &str) -> &'a mut Value {
        let steps = path.split('.').filter(|step| !step.is_empty());
        steps.fold(value, |value, step| match step.parse::<usize>() {
            Ok(index) => value.get_mut(index).unwrap(),
            Err(_) => value.get_mut(step).unwrap(),
        })
    }
    for (name, _) in RECIPES {
        let whole = Experiment::recipe(name).unwrap().to_toml().unwrap();
        let whole: Value = Value::Table(whole.parse().unwrap());
        let mut changed = 0;
        each(&whole.clone(), "", &mut |path, value| {
            let others: Vec<Value> = match value {
                Value::Integer(i) => vec![(2 * i).into(), (i + 1).into(), (i / 2).into()],
                Value::Float(x) => vec![(0.5 * x).into(), (2.0 * x).into(), (x + 0.01).into()],
                Value::Boolean(b) => vec![(!b).into()],
                Value::String(_) => ["none", "angles", "auto", "other", "theta_rad"]
                    .map(Value::from)
                    .to_vec(),
                _ => panic!("{path}"),
            };
            let accepted = others.into_iter().any(|other| {
                let mut whole = whole.clone();
                *at(&mut whole, path) = other;
                Experiment::parse(&toml::to_string(&whole).unwrap(), "e.toml").is_ok()
            });
            // α has another name where the entropy is learned; criteria refer to one another, phases to terms of one's own.
            let tie = |name: &str| ["from", "to", "omega_v", "gait"].contains(&name);
            let tied = path.ends_with("temperature.kind")
                || path.starts_with(".task.reward.extra") && path.ends_with(".name")
                || path.starts_with(".criteria") && path.split('.').any(tie);
            assert!(accepted || tied, "{name}: {path}");
            changed += 1;
        });
        assert!(changed > 100, "{changed}");
    }
}

#[test]
fn a_body_file_may_be_an_experiment() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let base = BodyParameters::default();
    for text in [
        "friction = 0.6\n",
        "[body]\nfriction = 0.6\n",
        "name = \"x\"\nbase = \"fast\"\n[body]\nfriction = 0.6\n",
        // Changes of what the base has were refused here, though an experiment may hold them.
        "[body]\nfriction = 0.6\n[curriculum.phases.II]\nsteps = 1000\n",
        "[body]\nfriction = 0.6\n[learner.temperature]\nalpha = 0.2\n",
    ] {
        std::fs::write(&path, text).unwrap();
        let body = load_body_overrides(&path, &base).unwrap();
        assert_eq!(
            body,
            BodyParameters {
                friction: 0.6,
                ..base.clone()
            }
        );
    }
    // The body of the file that it is based on was dropped without a word.
    let heavy = "base = \"fast\"\n[body]\nfriction = 0.5\nfoot_mass_kg = 2\n";
    std::fs::write(folder.path().join("heavy.toml"), heavy).unwrap();
    std::fs::write(&path, "base = \"./heavy.toml\"\n[body]\nfriction = 0.6\n").unwrap();
    let body = load_body_overrides(&path, &base).unwrap();
    assert_eq!((body.friction, body.foot_mass_kg), (0.6, 2.0));
    for text in [
        "base = \"fast\"\n",
        "base = \"./mine.toml\"\n[body]\nfriction = 0.6\n",
        "[body]\nfrction = 0.6\n",
        "[bodies]\nfriction = 0.6\n",
        "[body]\nfriction = -1\n",
        "body = [5]\n",
    ] {
        std::fs::write(&path, text).unwrap();
        let message = load_body_overrides(&path, &base).unwrap_err().to_string();
        assert!(message.contains("mine.toml"), "{message}");
    }
}

#[test]
fn single_values_can_be_set() {
    let (body, task) = (BodyParameters::default(), TaskParameters::default());
    let set = |texts: &[&str]| {
        let texts: Vec<String> = texts.iter().map(|&t| t.to_owned()).collect();
        set_body_and_task(&body, &task, &texts).map_err(|e| e.to_string())
    };
    let (b, t) = set(&[
        "friction=0.6",
        "body.hip_mass_kg = 25.0",
        "task.termination.pitch_limit_rad=1",
    ])
    .unwrap();
    assert_eq!(
        (b.friction, b.hip_mass_kg, t.termination.pitch_limit_rad),
        (0.6, 25.0, 1.0)
    );
    for (text, words) in [
        ("friction", vec!["friction", "KEY=VALUE"]),
        ("frction=1", vec!["`frction=1`", "did you mean `friction`?"]),
        // A slip in a name whose unit was left out had no nearest name.
        (
            "hip_stifness=1",
            vec!["did you mean `hip_stiffness_nm_per_rad`?"],
        ),
        ("task.reward.omga_e=1", vec!["did you mean `omega_e`?"]),
        (
            "time_limit_s=5",
            vec![
                "`time_limit_s`",
                "did you mean `task.termination.time_limit_s`?",
            ],
        ),
        ("friction=high", vec!["friction=high"]),
        ("friction=-1", vec!["friction", "0 or greater"]),
        ("=3", vec!["KEY=VALUE"]),
        ("body..friction=3", vec!["body..friction"]),
    ] {
        let message = set(&[text]).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{text}: {message}");
        }
    }
    let fast = Experiment::recipe("fast").unwrap();
    let changed = fast
        .with_values(&[
            "training.environments=8".to_owned(),
            "learner.gamma=0.9".to_owned(),
        ])
        .unwrap();
    assert_eq!(
        (changed.training.environments, changed.learner.gamma),
        (8, 0.9)
    );
    assert_eq!(fast.with_values(&[]).unwrap(), fast);
    // A name with spaces or dots may stand in quotes, as it must in a file.
    let steps = ["I, stepping", "\"I, stepping\"", "'I, stepping'"].map(|name| {
        let value = format!("curriculum.phases.{name}.steps=32000");
        fast.with_values(&[value]).unwrap().curriculum.total_steps()
    });
    assert!(
        steps
            .iter()
            .all(|s| *s == steps[0] && *s < fast.curriculum.total_steps())
    );
    let message = fast
        .with_values(&["trainig.environments=8".to_owned()])
        .unwrap_err()
        .to_string();
    assert!(message.contains("did you mean `training`?"), "{message}");
    // The tables were listed, not the one that has the key.
    for (text, meant) in [
        ("friction=0.5", "`body.friction`"),
        ("gamma=0.9", "`learner.gamma`"),
        ("learning_rat=0.1", "`learner.learning_rate`"),
    ] {
        let message = fast
            .with_values(&[text.to_owned()])
            .unwrap_err()
            .to_string();
        assert!(
            message.contains(&format!("did you mean {meant}?")),
            "{message}"
        );
    }
    let message = error("gamma = 0.9");
    assert!(
        message.contains("`learner.gamma`") && message.contains("line 1"),
        "{message}"
    );
}

#[test]
fn names_of_recipes_controllers_and_noise_are_answered_likewise() {
    let message = Experiment::load("fst").unwrap_err().to_string();
    assert!(
        message.contains("did you mean `fast`? A file is named"),
        "{message}"
    );
    let message = error("base = \"fats\"");
    assert!(
        message.contains("`base`") && message.contains("did you mean `fast`?"),
        "{message}"
    );
    let message = Experiment::load("walrus").unwrap_err().to_string();
    assert!(
        message.contains("`robust`; a file is named by a path"),
        "{message}"
    );
    let message = Controller::read(Path::new("shiped"))
        .unwrap_err()
        .to_string();
    assert!(message.contains("did you mean `shipped`?"), "{message}");
    // No command has an option of this name for every controller that it takes.
    assert!(!message.contains("--controller"), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noise.toml");
    std::fs::write(&path, "[noise]\ntheta_velocity = 0.1\n").unwrap();
    let message = load_disturbance(&path).unwrap_err().to_string();
    assert!(
        message.contains("did you mean `theta_velocity_rad_per_s`?"),
        "{message}"
    );
}

// A slip in a phase changed by its name had neither line nor path; a wrong type the path without the name.
#[test]
fn slips_in_what_is_changed_by_name_have_their_line() {
    for (text, words) in [
        (
            "base = \"fast\"\n[curriculum.phases.II.randomization]\nshar = 0.5",
            ["line 3", "did you mean `share`?"],
        ),
        (
            "base = \"fast\"\n[curriculum.phases.\"I, stepping\"]\nsteps = \"many\"",
            ["line 3", "expected a whole number"],
        ),
        (
            "base = \"fast\"\n[curriculum.phases.\"I, stepping\"]\nsteps = 1e6",
            ["line 3", "a whole number, without a point or an exponent"],
        ),
        (
            "base = \"fast\"\n[curriculum.phases.II]\nrandomization.latency_s = 20",
            ["line 3", "expected two numbers in brackets, such as [0, 1]"],
        ),
        (
            "base = \"fast\"\n[curriculum]\nphases.II.learner = { gama = 1 }",
            ["line 3", "gama"],
        ),
        (
            "[task.reward.extra.upright]\nwieght = 2",
            ["line 2", "did you mean `weight`?"],
        ),
        (
            "[task.termination.extra.leap]\nexpression = \"z_mm > 1\"",
            ["line 2", "did you mean `z_m`?"],
        ),
    ] {
        let message = error(text);
        for word in words {
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}

#[test]
fn a_file_without_a_name_has_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let read = |file: &str, text: &str| {
        let path = folder.path().join(file);
        std::fs::write(&path, text).unwrap();
        Experiment::read(&path).unwrap().name
    };
    // It was named as its base, and trained into runs/fast-1.
    assert_eq!(read("mine.toml", "base = \"fast\""), "mine");
    assert_eq!(read("my.v2.toml", ""), "my.v2");
    assert_eq!(read("named.toml", "name = \"other\""), "other");
    assert_eq!(read("on.toml", "base = \"./named.toml\""), "on");
}

#[test]
fn lists_in_the_place_of_tables_are_refused_in_every_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    for text in [
        "noise = [0.1]",
        "terrain = [0.05]",
        "pushes = [[100, 0, 2]]",
    ] {
        std::fs::write(&path, text).unwrap();
        let message = load_disturbance(&path).unwrap_err().to_string();
        assert!(
            message.contains("mine.toml") && message.contains("table"),
            "{message}"
        );
    }
    std::fs::write(&path, "gaits = [[0, 'walking']]").unwrap();
    let message = Criteria::load(&path).unwrap_err().to_string();
    assert!(
        message.contains("mine.toml") && message.contains("[[gaits]]"),
        "{message}"
    );
    let set = |text: &str| {
        Experiment::recipe("fast")
            .unwrap()
            .with_values(&[text.to_owned()])
    };
    let message = set("body=[5]").unwrap_err().to_string();
    assert!(
        message.contains("`body`") && message.contains("table"),
        "{message}"
    );
    assert!(set("curriculum.phases.II.omega_v=[0, 2]").is_ok());
}
