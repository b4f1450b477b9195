//! Contract: a sweep's file names its trials, each with its own folder, seed and settings; a mistake in it is named
//! with its variant; a sweep that is stopped and gone on with ends in the same bits as one that is not; what is
//! finished is not run again; its table counts seeds.

use gaitshift_experiment::{Judgement, Observer, Progress, Sweep, SweepReport};
use std::cell::Cell;
use std::path::Path;

const FILE: &str = r#"
name = "tiny sweep"
experiment = "fast"
seeds = [1, 2]

[set.learner]
actor_hidden = [8]
critic_hidden = [8]
batch_size = 32
threads = 1

[set.training]
environments = 4
steps_per_update = 8
learning_starts = 200
evaluation_interval_steps = 800
checkpoint_interval_steps = 400
replay_capacity = 6000

[[set.curriculum.phases]]
name = "only"
steps = 1600
omega_v = [-0.2, 0.2]

[[variants]]
name = "as it is"

[[variants]]
name = "on ice/snow"
reason = "feet slip"
set.body = { friction = 0.3 }
"#;

/// Stops after so many control periods.
struct StopAfter(Cell<u64>);

impl Observer for StopAfter {
    fn progress(&mut self, _: &Progress) {}
    fn evaluated(&mut self, _: &Progress, _: &Judgement, _: bool) {}
    fn note(&mut self, _: &str) {}
    fn stop_requested(&self) -> bool {
        self.0.set(self.0.get().saturating_sub(1));
        self.0.get() == 0
    }
}

fn run(sweep: &Sweep, folder: &Path, jobs: usize, periods: u64) -> SweepReport {
    sweep
        .run(folder, jobs, "gaitshift sweep", |_| {
            StopAfter(Cell::new(periods))
        })
        .unwrap()
}

fn controllers(sweep: &Sweep, folder: &Path) -> Vec<Vec<u8>> {
    let read = |name| {
        let files = sweep.trials.iter().map(move |t| t.folder.join(name));
        files.map(|file| std::fs::read(folder.join(file)).unwrap())
    };
    read("controller-last.safetensors")
        .chain(read("controller.safetensors"))
        .collect()
}

#[test]
fn trials_are_every_variant_with_every_seed() {
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    let trials: Vec<_> = sweep
        .trials
        .iter()
        .map(|t| {
            let e = &t.experiment;
            (
                t.folder.to_str().unwrap(),
                e.seed,
                e.body.friction,
                e.learner.n_step,
            )
        })
        .collect();
    assert_eq!(
        trials,
        [
            ("as-it-is/seed-1", 1, 1.0, 3),
            ("on-ice-snow/seed-1", 1, 0.3, 3),
            ("as-it-is/seed-2", 2, 1.0, 3),
            ("on-ice-snow/seed-2", 2, 0.3, 3),
        ]
    );
    assert_eq!(sweep.variants[1].reason, "feet slip");
}

#[test]
fn a_mistake_is_named_with_its_variant() {
    for (from, to, expected) in [
        ("friction = 0.3", "fricton = 0.3", "variant `on ice/snow`"),
        ("friction = 0.3", "friction = -1.0", "friction"),
        ("seeds = [1, 2]", "seeds = [2, 2]", "`seeds` holds 2 twice"),
        ("seeds = [1, 2]", "seeds = []", "at least one entry"),
        (
            "on ice/snow",
            "as-it-is",
            "two variants have the folder name `as-it-is`",
        ),
        (
            "experiment = \"fast\"",
            "experiment = \"quick\"",
            "no recipe `quick`",
        ),
        ("reason =", "because =", "because"),
        (
            "[set.learner]",
            "[set]\nseed = 3\n[set.learner]",
            "`set` may not hold `seed`",
        ),
    ] {
        let text = FILE.replace(from, to);
        assert_ne!(text, FILE);
        let error = Sweep::parse(&text, "tiny.toml").unwrap_err().to_string();
        assert!(
            error.contains("tiny.toml") && error.contains(expected),
            "{error}"
        );
    }
}

#[test]
fn stopped_and_gone_on_with_it_ends_in_the_same_bits_and_nothing_is_run_twice() {
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let all = SweepReport {
        finished: 4,
        skipped: 0,
    };
    assert_eq!(run(&sweep, whole.path(), 2, u64::MAX), all);

    // A trial has 400 control periods; the first call stops the first trial after 150, the second in the next one.
    let mut reports = Vec::new();
    while reports
        .last()
        .is_none_or(|r: &SweepReport| r.finished + r.skipped < 4)
    {
        assert!(reports.len() < 20, "{reports:?}");
        reports.push(run(&sweep, parts.path(), 1, 250));
    }
    assert_eq!(reports[0].finished, 0);
    assert!(reports.len() > 4, "{reports:?}");
    assert_eq!(reports.iter().map(|r| r.finished).sum::<usize>(), 4);
    assert_eq!(
        controllers(&sweep, whole.path()),
        controllers(&sweep, parts.path())
    );

    let nothing_left = SweepReport {
        finished: 0,
        skipped: 4,
    };
    assert_eq!(run(&sweep, whole.path(), 2, u64::MAX), nothing_left);
}

#[test]
fn a_folder_with_a_run_of_other_settings_is_not_taken_for_a_trial() {
    let folder = tempfile::tempdir().unwrap();
    run(
        &Sweep::parse(FILE, "tiny.toml").unwrap(),
        folder.path(),
        1,
        50,
    );
    let other = FILE.replace("batch_size = 32", "batch_size = 16");
    let other = Sweep::parse(&other, "tiny.toml").unwrap();
    let error = other
        .run(folder.path(), 1, "", |_| StopAfter(Cell::new(u64::MAX)))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("as-it-is") && error.contains("other settings"),
        "{error}"
    );
}

#[test]
fn the_table_has_what_there_is_so_far() {
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    assert!(sweep.table(folder.path()).unwrap().trials.is_empty());
    // Three whole trials; the fourth stops before its first evaluation.
    let begun = Cell::new(0);
    let counted = std::sync::Mutex::new(begun);
    sweep
        .run(folder.path(), 1, "", |_| {
            let begun = counted.lock().unwrap();
            begun.set(begun.get() + 1);
            StopAfter(Cell::new(if begun.get() < 4 { u64::MAX } else { 100 }))
        })
        .unwrap();
    let table = sweep.table(folder.path()).unwrap();
    assert_eq!(table.trials.len(), 3);
    assert!(
        table
            .trials
            .iter()
            .all(|t| t.finished && t.evaluations == 2)
    );
    let [reference, ice] = &table.variants[..] else {
        panic!("{table:?}");
    };
    assert_eq!((reference.seeds, reference.finished), (2, 2));
    assert_eq!((ice.seeds, ice.walk, ice.run, ice.all), (1, 0, 0, 0));
    assert!(reference.effect.is_none() && ice.effect.is_some());
    let best = reference.best_met.unwrap();
    assert!(best.interval[0] <= best.value && best.value <= best.interval[1]);
    let text = table.to_markdown();
    assert!(text.contains("| on ice/snow | 1 | 1 |"), "{text}");
}
