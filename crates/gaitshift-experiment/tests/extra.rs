//! Contract: an experiment may have reward terms and rules of its own; what they are made of is what the recording says;
//! they are logged by name, learned from, resumed to the same bits and recorded; what a run's files depend on cannot be
//! edited; one that tells left from right is warned of where batches are mirrored.

use crate::common::{Until, file, text, tiny};
use gaitshift_analysis::Recording;
use gaitshift_analysis::recording::{COLUMNS, is_extra};
use gaitshift_body::{Body, BodyParameters};
use gaitshift_experiment::{
    CommandProfile, Control, Controller, Deterministic, Experiment, Rollout, Training,
    did_you_mean, set_body_and_task,
};
use gaitshift_task::{Environment, QUANTITIES, TaskParameters};
use std::path::{Path, PathBuf};

const EXAMPLE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../experiments/own_reward.toml"
);

/// The example on a learner that takes a second.
fn own() -> Experiment {
    let example = Experiment::read(Path::new(EXAMPLE)).unwrap();
    Experiment {
        task: example.task,
        ..tiny()
    }
}

/// A row of `metrics.csv` by its names.
fn column(folder: &Path, name: &str) -> Vec<f64> {
    let text = text(folder, "metrics.csv");
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|n| n == name);
    let value = |line: &str| line.split(',').nth(place.unwrap()).unwrap().parse();
    lines.map(|line| value(line).unwrap()).collect()
}

#[test]
fn the_example_trains_logs_and_resumes_to_the_same_bits() {
    let root = tempfile::tempdir().unwrap();
    let (whole, broken): (PathBuf, PathBuf) = (root.path().join("a"), root.path().join("b"));
    let train = |folder: &Path| {
        let mut training = Training::new(own(), folder, "test").unwrap();
        training.run(&mut Until::default()).unwrap()
    };
    assert!(train(&whole).finished);
    let smooth = column(&whole, "reward/smooth");
    let upright = column(&whole, "reward/upright");
    assert!(
        smooth.len() == 6 && smooth.iter().all(|v| *v < 0.0),
        "{smooth:?}"
    );
    assert!(upright.iter().all(|v| *v <= 0.0) && upright[3] < 0.0);
    let events = file(&whole, "events.out.tfevents.gaitshift");
    assert!(events.windows(13).any(|w| w == b"reward/smooth"));

    Training::new(own(), &broken, "test")
        .unwrap()
        .run(&mut Until::step(2500))
        .unwrap();
    let resumed = Training::resume(&broken)
        .unwrap()
        .run(&mut Until::default());
    assert!(resumed.unwrap().finished);
    for name in ["controller-last.safetensors", "episodes.csv"] {
        assert_eq!(file(&whole, name), file(&broken, name), "{name}");
    }
    assert_eq!(
        column(&whole, "reward/smooth"),
        column(&broken, "reward/smooth")
    );

    // The term is learned from: without it the run is another.
    let without = root.path().join("c");
    let mut plain = own();
    plain.task.reward.extra = Default::default();
    Training::new(plain, &without, "test")
        .unwrap()
        .run(&mut Until::default())
        .unwrap();
    let name = "controller-last.safetensors";
    assert_ne!(file(&whole, name), file(&without, name));

    // A run goes on with another weight, but not with other terms, whose columns its log does not have.
    let config = text(&broken, "config.toml");
    let edited = config.replace("weight = 0.05", "weight = 0.1");
    assert_ne!(config, edited);
    std::fs::write(broken.join("config.toml"), edited).unwrap();
    Training::resume(&broken).unwrap();
    let edited = config.replace("name = \"smooth\"", "name = \"calm\"");
    std::fs::write(broken.join("config.toml"), edited).unwrap();
    let error = Training::resume(&broken).unwrap_err().to_string();
    assert!(error.contains("task.reward.extra[0].name"), "{error}");

    // The controller brings its terms along, and what it does is recorded with them.
    let mut controller = Controller::read(&whole.join(name)).unwrap();
    assert_eq!(controller.task, own().task);
    let task = controller.task.clone();
    let recording = record(&task, &mut Deterministic(&mut controller.policy));
    let path = root.path().join("recording.csv");
    recording.write_csv(&path).unwrap();
    assert_eq!(Recording::read_csv(&path).unwrap(), recording);
    let names: Vec<&str> = recording.every_column().map(|(name, _)| name).collect();
    assert!(
        names.ends_with(&["reward_smooth", "reward_upright"]),
        "{names:?}"
    );
}

/// A task with these tables.
fn parsed(tables: &str) -> TaskParameters {
    let tables = tables.replace("[[", "[[task.");
    Experiment::parse(&tables, "test").unwrap().task
}

fn record(task: &TaskParameters, control: &mut impl Control) -> Recording {
    let body = Body::new(BodyParameters::default()).unwrap();
    let rollout = Rollout {
        body: &body,
        task,
        start: Environment::default_start(&body, task),
        profile: &CommandProfile::constant(1.0),
        duration_s: 0.3,
        seed: 0,
        disturbance: None,
        controller: "test",
    };
    rollout.record(control).unwrap()
}

#[test]
fn quantities_are_what_the_recording_says() {
    // Eight terms at a time over all quantities that a recording has a column of.
    let mut compared = 0;
    for names in QUANTITIES.chunks(8) {
        let terms: String = names
            .iter()
            .map(|name| {
                format!(
                    "[[reward.extra]]\nname = \"q_{name}\"\nweight = 1\nexpression = \"{name}\"\n"
                )
            })
            .collect();
        // A motion that ends late: any height of the hip will do.
        let task = parsed(
            &format!("{terms}[[termination]]\nmin_hip_height_m = 0\n")
                .replace("[[termination]]", "[task.termination]"),
        );
        let mut time = 0.0;
        let recording = record(&task, &mut |_: &[f32; 14], action: &mut [f32; 2]| {
            time += 1.0;
            *action = [0.2 * f32::sin(time), 0.2 * f32::cos(0.7 * time)];
        });
        let series = |name: &str| {
            let mut columns = recording.every_column();
            columns
                .find(|(known, _)| *known == name)
                .map(|c| c.1.to_vec())
        };
        for name in names {
            let own = series(&format!("reward_q_{name}")).unwrap();
            assert!(own.len() > 20, "{}", own.len());
            let Some(column) = series(name) else {
                continue;
            };
            compared += 1;
            // Row 0 has no control period, so no reward. Energies of springs are summed in another order.
            for (own, value) in own.iter().zip(&column).skip(1) {
                assert!((own - value).abs() <= 1e-12 * (1.0 + value.abs()), "{name}");
            }
        }
    }
    // All but the commands before, the ground and those of the period.
    assert_eq!(compared, QUANTITIES.len() - 6);
}

/// Two crates that do not know each other hold a rule: the task which names a term may have, the analysis which columns are
/// terms of one's own. A name that only the first accepts would make a recording that cannot be written.
#[test]
fn every_name_that_a_term_may_have_makes_a_column_of_its_own() {
    let term = |name: &str| {
        let term = "[[task.reward.extra]]\nweight = 1\nexpression = \"z_m\"\n";
        Experiment::parse(&format!("{term}name = \"{name}\"\n"), "test")
    };
    let longest = "a".repeat(40);
    for name in ["a", "z9_", "reward", &longest] {
        assert!(term(name).is_ok(), "{name}");
        assert!(is_extra(&format!("reward_{name}")), "{name}");
    }
    for column in COLUMNS.iter().filter_map(|c| c.strip_prefix("reward_")) {
        assert!(term(column).is_err(), "{column}");
    }
    for name in [
        "",
        "9a",
        "_a",
        "A",
        "a b",
        "a-b",
        "ä",
        &format!("{longest}a"),
    ] {
        assert!(term(name).is_err(), "{name}");
    }
}

#[test]
fn a_rule_ends_a_motion_by_its_name() {
    let rule = "[[termination.extra]]\nname = \"enough\"\nexpression = \"time_s > 0.1\"\n";
    let mut task = parsed(rule);
    task.control_period_s = 0.01;
    let recording = record(&task, &mut |_: &[f32; 14], action: &mut [f32; 2]| {
        *action = [0.0; 2];
    });
    assert!(recording.metadata.fell);
    assert_eq!(recording.metadata.ended_by, "enough");
    assert_eq!(recording.len(), 12);
}

#[test]
fn mistakes_are_answered_with_what_was_probably_meant() {
    let error = |text: &str| {
        Experiment::parse(text, "mine.toml")
            .unwrap_err()
            .to_string()
    };
    let term = |expression: &str| {
        format!(
            "[[task.reward.extra]]\nname = \"own\"\nweight = 1\nexpression = \"{expression}\"\n"
        )
    };
    let near = error(&term("-theta_rads^2"));
    assert!(
        near.contains("did you mean `theta_rad`?") && near.contains("line 4"),
        "{near}"
    );
    let listed = error(&term("flux_capacitor"));
    assert!(listed.contains("`right_normal_force_n`"), "{listed}");
    let function = error(&term("squirt(z_m)"));
    assert!(function.contains("did you mean `sqrt`?"), "{function}");
    let start = error(&term("1 / omega_v"));
    assert!(
        start.contains("mine.toml") && start.contains("default start"),
        "{start}"
    );
    assert!(did_you_mean(&near).contains("theta_rad"));
    let (body, task) = (BodyParameters::default(), TaskParameters::default());
    let set = |value: &str| set_body_and_task(&body, &task, &[value.to_owned()]);
    let ok = "task.reward.extra=[{name=\"own\", weight=1, expression=\"z_m > 0.9 ? 1 : 0\"}]";
    assert_eq!(set(ok).unwrap().1.reward.extra.terms()[0].name, "own");
    let wrong = set(&ok.replace("z_m", "zm")).unwrap_err().to_string();
    assert!(wrong.contains("did you mean `z_m`?"), "{wrong}");
}

#[test]
fn what_tells_left_from_right_is_warned_of_where_batches_are_mirrored() {
    let of = |symmetry: &str, expression: &str| {
        let text = format!(
            "base = \"fast\"\ntraining.symmetry = \"{symmetry}\"\n[[task.reward.extra]]\nname = \"own\"\nweight = 1\n\
             expression = \"{expression}\"\n"
        );
        Experiment::parse(&text, "mine.toml").unwrap().warnings()
    };
    let warnings = of("replay", "right_command");
    assert!(
        warnings.len() == 1 && warnings[0].contains("task.reward.extra[0]"),
        "{warnings:?}"
    );
    assert!(of("none", "right_command").is_empty());
    assert!(of("replay", "right_command + left_command").is_empty());
    assert!(
        Experiment::read(Path::new(EXAMPLE))
            .unwrap()
            .warnings()
            .is_empty()
    );
}
