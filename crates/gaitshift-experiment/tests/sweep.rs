//! Contract: a sweep's file names its trials, each with its own folder, seed and settings: variants, combinations of values,
//! or settings drawn at random, the same from the same seed; a mistake in it is named with its variant; a sweep that is stopped and gone on with ends in the same bits as one that is not; what is
//! finished is not run again; its table counts seeds.

use gaitshift_experiment::{Judgement, Observer, Progress, Sweep, SweepReport, SweepTable};
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
    let range = FILE.replace("[1, 2]", "\"1-2\"");
    assert_eq!(Sweep::parse(&range, "tiny.toml").unwrap(), sweep);
}

#[test]
fn a_mistake_is_named_with_its_variant() {
    for (from, to, expected) in [
        ("friction = 0.3", "fricton = 0.3", "variant `on ice/snow`"),
        ("friction = 0.3", "friction = -1.0", "friction"),
        ("seeds = [1, 2]", "seeds = [2, 2]", "`seeds` holds 2 twice"),
        (
            "seeds = [1, 2]",
            "seeds = \"18446744073709551615\"",
            "must be at most 9223372036854775807",
        ),
        ("seeds = [1, 2]", "seeds = []", "at least one entry"),
        (
            "seeds = [1, 2]",
            "seeds = \"2-1\"",
            "from a lower to a higher",
        ),
        (
            "seeds = [1, 2]",
            "seeds = [1, -2]",
            "such as [1, 2, 3], or a range",
        ),
        (
            "on ice/snow",
            "as-it-is",
            "two variants have the folder name `as-it-is`",
        ),
        (
            "on ice/snow",
            "AS it is",
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

/// The file with something else that varies.
fn varied(above: &str, vary: &str) -> Result<Sweep, String> {
    let (head, _) = FILE.split_once("[[variants]]").unwrap();
    let text = head.replacen("seeds = [1, 2]", &format!("seeds = [1, 2]\n{above}"), 1) + vary;
    Sweep::parse(&text, "tiny.toml").map_err(|e| e.to_string())
}

fn folders(sweep: &Sweep) -> Vec<&str> {
    let folders = sweep.trials.iter().map(|t| t.folder.to_str().unwrap());
    folders.collect()
}

#[test]
fn values_are_run_in_every_combination() {
    let sweep = varied(
        "",
        "[vary]\nlearner.n_step = [1, 3]\n\"body.friction\" = [0.25, 1.0]",
    )
    .unwrap();
    let settings: Vec<_> = sweep.trials[..4]
        .iter()
        .map(|t| (t.experiment.body.friction, t.experiment.learner.n_step))
        .collect();
    assert_eq!(settings, [(0.25, 1), (0.25, 3), (1.0, 1), (1.0, 3)]);
    assert_eq!(sweep.trials.len(), 8);
    // What is set for all is set.
    assert!(
        sweep
            .trials
            .iter()
            .all(|t| t.experiment.learner.batch_size == 32)
    );
    assert_eq!(sweep.variants[1].name, "friction=0.25 n_step=3");
    let values = &sweep.variants[1].values;
    assert_eq!(values[0], ("body.friction".to_owned(), "0.25".to_owned()));
    assert_eq!(folders(&sweep)[1], "friction-0-25-n_step-3/seed-1");
    assert!(sweep.reference);
    // Criteria are set like everything else.
    let asked = varied(
        "set.criteria = { duration_s = 5 }\n",
        "[vary]\nbody.friction = [0.5]",
    )
    .unwrap();
    assert_eq!(asked.trials[0].experiment.criteria.duration_s, 5.0);
    assert_eq!(asked.trials[0].experiment.criteria.count(), 39);
    // A table with `kind` is a value, and keys with the same last word keep their paths.
    let kinds = "[vary]\nlearner.temperature = [{ kind = \"fixed\", alpha = 0.1 }, { kind = \"auto\", initial = 0.5 }]";
    let sweep = varied("", kinds).unwrap();
    assert_eq!(sweep.variants.len(), 2);
    let same = "[vary]\ntask.reward.omega_e = [0.1]\ntask.reward.omega_s = [0.1]";
    assert_eq!(
        varied("", same).unwrap().variants[0].name,
        "omega_e=0.1 omega_s=0.1"
    );
}

#[test]
fn settings_are_drawn_from_their_ranges_the_same_from_the_same_seed() {
    let vary = "[vary]\nlearner.learning_rate = { from = 1e-5, to = 1e-2, scale = \"log\" }\n\
                learner.n_step = { from = 2, to = 4 }\nbody.friction = [0.3, 1.0]";
    let drawn = |settings: usize, seed: u64| {
        let random = format!("random = {{ settings = {settings}, seed = {seed} }}");
        varied(&random, vary).unwrap()
    };
    let sweep = drawn(200, 7);
    assert_eq!((sweep.variants.len(), sweep.trials.len()), (200, 400));
    assert!(!sweep.reference);
    let experiments: Vec<_> = sweep.trials[..200].iter().map(|t| &t.experiment).collect();
    let rates: Vec<f64> = experiments
        .iter()
        .map(|e| e.learner.learning_rate)
        .collect();
    assert!(rates.iter().all(|r| (1e-5..=1e-2).contains(r)));
    // Every decade as often as another: of 200 some 67 each.
    for decade in [1e-5, 1e-4, 1e-3] {
        let within = rates.iter().filter(|&&r| r >= decade && r < 10.0 * decade);
        assert!((45..90).contains(&within.count()), "{decade}");
    }
    for n_step in 2..=4 {
        let count = experiments.iter().filter(|e| e.learner.n_step == n_step);
        assert!((45..90).contains(&count.count()), "{n_step}");
    }
    let slippery = experiments.iter().filter(|e| e.body.friction == 0.3);
    assert!((75..125).contains(&slippery.count()));
    assert_eq!(drawn(200, 7), sweep);
    assert_ne!(drawn(200, 8), sweep);
    // More settings begin with the same ones, so a sweep can be extended.
    assert_eq!(drawn(50, 7).variants, sweep.variants[..50]);
}

#[test]
fn a_mistake_in_what_varies_is_named() {
    let rates = "[vary]\nlearner.learning_rate = [1e-4, 1e-3]\n";
    let range = "[vary]\nlearner.learning_rate = { from = 1e-4, to = 1e-3 }\n";
    for (above, vary, expected) in [
        ("", "", "nothing varies"),
        ("", "[vary]\n", "`vary` names no key"),
        (
            "",
            "[vary]\nlearner.learning_rate = []\n",
            "`learner.learning_rate` has no values",
        ),
        (
            "",
            "[vary]\nbody.friction = [1.0, 1.0]\n",
            "`body.friction` has the value 1.0 twice",
        ),
        (
            "",
            "[vary]\nbody.friction = 1.0\n",
            "must be a list of values",
        ),
        (
            "",
            "[vary]\nbody.frictoin = [1.0]\n",
            "did you mean `friction`",
        ),
        (
            "",
            "[vary]\nbody.friction = [1.0, -1.0]\n",
            "variant `friction=-1.0`",
        ),
        ("", "[vary]\nseed = [1, 2]\n", "may not hold `seed`"),
        (
            "",
            "[vary]\nbody.friction = [1.0]\n\"body.friction\" = [0.5]\n",
            "friction",
        ),
        ("", range, "is a range, which has no end of values"),
        (
            "",
            "[vary]\nbody.friction = { from = 1.0, to = 0.5 }\n",
            "the lower one first",
        ),
        (
            "",
            "[vary]\nbody.friction = { from = \"a\", to = 0.5 }\n",
            "must be numbers",
        ),
        (
            "",
            "[vary]\nbody.friction = { from = 0.0, to = 0.5, scale = \"log\" }\n",
            "numbers above 0",
        ),
        (
            "",
            "[vary]\nbody.friction = { from = 0.1, to = 0.5, step = 0.1 }\n",
            "step",
        ),
        (
            "",
            &format!("{rates}[[variants]]\nname = \"a\"\n"),
            "`variants` and `vary`",
        ),
        (
            "random = { settings = 3 }",
            "",
            "`random` draws from `vary`",
        ),
        ("random = { settings = 0 }", rates, "`random.settings` is 0"),
        (
            "random = { settings = 3 }",
            rates,
            "hardly more than 2 different ones",
        ),
        ("random = { setings = 3 }", rates, "setings"),
    ] {
        let error = varied(above, vary).unwrap_err();
        assert!(
            error.contains("tiny.toml") && error.contains(expected),
            "{expected}: {error}"
        );
    }
}

/// A quoted key of some thousand parts exhausted the stack.
#[test]
fn a_key_of_very_many_parts_is_refused() {
    let key = vec!["body"; 100_000].join(".");
    let error = varied("", &format!("[vary]\n\"{key}\" = [0.3, 1.0]\n")).unwrap_err();
    assert!(
        error.contains("100000 parts") && error.len() < 200,
        "{error}"
    );
}

/// A base that was a path was looked for in the wrong folder when a variant's name had a `/`.
#[test]
fn a_base_is_found_from_the_sweeps_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("mine.toml"),
        "base = \"fast\"\n[learner]\nn_step = 2\n",
    )
    .unwrap();
    let file = folder.path().join("sweep.toml");
    std::fs::write(&file, FILE.replace("\"fast\"", "\"./mine.toml\"")).unwrap();
    let sweep = Sweep::load(&file).unwrap();
    assert!(
        sweep
            .trials
            .iter()
            .all(|t| t.experiment.learner.n_step == 2)
    );
}

#[test]
fn parts_have_every_trial_once() {
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    let parts: Vec<Sweep> = (1..=3).map(|k| sweep.part(k, 3)).collect();
    assert_eq!(
        parts.iter().map(|p| p.trials.len()).collect::<Vec<_>>(),
        [2, 1, 1]
    );
    let mut all: Vec<&str> = parts.iter().flat_map(folders).collect();
    let mut whole = folders(&sweep);
    all.sort_unstable();
    whole.sort_unstable();
    assert_eq!(all, whole);
}

#[test]
fn stopped_and_gone_on_with_it_ends_in_the_same_bits_and_nothing_is_run_twice() {
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let all = SweepReport {
        finished: 4,
        ..SweepReport::default()
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
        skipped: 4,
        ..SweepReport::default()
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

/// A run whose checkpoint somebody had removed to save space was deleted with all that it had written; then it kept every trial behind
/// it from being run, as a learner that diverges did.
#[test]
fn a_run_without_its_checkpoint_is_left_as_it_is_and_the_others_are_run() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    run(&sweep, folder.path(), 1, 150);
    let trial = folder.path().join(&sweep.trials[0].folder);
    std::fs::remove_dir_all(trial.join("checkpoint")).unwrap();
    let episodes = std::fs::read(trial.join("episodes.csv")).unwrap();
    let report = run(&sweep, folder.path(), 1, u64::MAX);
    assert_eq!((report.finished, report.failed.len()), (3, 1), "{report:?}");
    let failed = &report.failed[0];
    assert!(
        failed.contains("as-it-is") && failed.contains("checkpoint"),
        "{failed}"
    );
    assert_eq!(std::fs::read(trial.join("episodes.csv")).unwrap(), episodes);
}

/// It ended the whole sweep, and its table.
#[test]
fn a_damaged_report_is_that_of_a_failed_trial_and_the_others_are_run() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    run(&sweep, folder.path(), 2, u64::MAX);
    let report = folder
        .path()
        .join(&sweep.trials[0].folder)
        .join("report.json");
    let whole = std::fs::read(&report).unwrap();
    std::fs::write(&report, &whole[..20]).unwrap();
    std::fs::remove_dir_all(folder.path().join(&sweep.trials[1].folder)).unwrap();
    let told = run(&sweep, folder.path(), 1, u64::MAX);
    assert_eq!((told.finished, told.skipped), (1, 2), "{told:?}");
    assert_eq!(told.failed.len(), 1);
    let failed = &told.failed[0];
    assert!(
        failed.contains("report.json") && failed.contains("remove it"),
        "{failed}"
    );
    let finished = || sweep.table(folder.path()).unwrap().variants[0].finished;
    assert_eq!(finished(), 1);
    std::fs::remove_file(&report).unwrap();
    let told = run(&sweep, folder.path(), 1, u64::MAX);
    assert_eq!((told.finished, told.skipped), (1, 3), "{told:?}");
    assert_eq!(finished(), 2);
}

/// A kill between a new run's first checkpoint and its configuration left a folder that the sweep refused.
#[test]
fn a_trial_killed_before_its_configuration_was_written_begins_anew() {
    let (whole, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    run(&sweep, whole.path(), 1, u64::MAX);
    run(&sweep, folder.path(), 1, 150);
    let trial = folder.path().join(&sweep.trials[0].folder);
    for file in std::fs::read_dir(&trial).unwrap() {
        let file = file.unwrap().path();
        if file.is_file() {
            std::fs::remove_file(file).unwrap();
        }
    }
    // The checkpoint that a run begins with; a later one is not replaced.
    let state = trial.join("checkpoint/state.json");
    let text = std::fs::read_to_string(&state).unwrap();
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let refused = sweep.run(folder.path(), 1, "gaitshift sweep", |_| {
        StopAfter(Cell::new(1))
    });
    assert!(refused.unwrap().failed[0].contains("checkpoint"));
    value["counters"]["step"] = 0.into();
    std::fs::write(&state, value.to_string()).unwrap();
    run(&sweep, folder.path(), 1, u64::MAX);
    assert_eq!(
        controllers(&sweep, folder.path()),
        controllers(&sweep, whole.path())
    );
}

/// They were written once, after a new run was whole: a kill in between lost them for good.
#[test]
fn settings_for_tensorboard_are_written_whenever_they_are_missing() {
    let (whole, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let sweep = Sweep::parse(FILE, "tiny.toml").unwrap();
    let settings = |folder: &Path| {
        let trial = folder.join(&sweep.trials[0].folder);
        trial.join("events.out.tfevents.a-settings")
    };
    run(&sweep, whole.path(), 1, 150);
    run(&sweep, folder.path(), 1, 150);
    std::fs::remove_file(settings(folder.path())).unwrap();
    run(&sweep, folder.path(), 1, 150);
    let [expected, read] = [&whole, &folder].map(|f| std::fs::read(settings(f.path())).unwrap());
    assert!(expected == read);
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
    // A bar in a name would end its cell.
    let mut barred = table.clone();
    barred.variants[1].variant = "ice|snow".to_owned();
    let text = barred.to_markdown();
    assert!(text.contains(r"| ice\|snow | 1 | 1 |"), "{text}");
    // The same of the folders alone.
    let runs: Vec<_> = sweep
        .trials
        .iter()
        .map(|t| folder.path().join(&t.folder))
        .collect();
    let runs: Vec<&Path> = runs.iter().map(|run| run.as_path()).collect();
    let again = SweepTable::of_runs(&sweep.name, &runs).unwrap();
    assert_eq!(again.trials, table.trials);
    assert_eq!(again.variants[1].effect, table.variants[1].effect);
}

// The columns of the slowest and the fastest motion were those of the first and the last command, and a walk that nobody had asked for
// was counted.
#[test]
fn slow_and_fast_are_by_the_command_and_only_gaits_that_are_asked_for_are_counted() {
    let run = tempfile::tempdir().unwrap();
    let config = "name = \"e\"\nseed = 1\n";
    std::fs::write(run.path().join("config.toml"), config).unwrap();
    let rows = |asked: [&str; 2]| {
        let [running, walking] = asked.map(|gait| format!("\"asked\":{gait},"));
        let motions = format!(
            "\"rows\":[{{\"omega_v\":3.0,{running}\"gait\":\"running\",\"fell\":false,\"froude\":1.0}},\
             {{\"omega_v\":0.0,{walking}\"gait\":\"walking\",\"fell\":false,\"froude\":0.2}}]"
        );
        let line = format!(
            "{{\"step\":1,\"elapsed_s\":1.0,\"met\":2,\"score\":2.0,{motions},\"changes\":[],\"checks\":[]}}\n"
        );
        std::fs::write(run.path().join("evaluations.jsonl"), line).unwrap();
        SweepTable::of_runs("e", &[run.path()]).unwrap()
    };
    let table = rows(["null", "null"]);
    let best = &table.trials[0].best;
    assert_eq!(
        (best.slow_gait.as_str(), best.fast_gait.as_str()),
        ("walking", "running")
    );
    assert_eq!((best.slow_froude, best.fast_froude), (Some(0.2), Some(1.0)));
    assert_eq!((table.variants[0].walk, table.variants[0].run), (0, 0));
    let table = rows(["\"running\"", "\"walking\""]);
    assert_eq!((table.variants[0].walk, table.variants[0].run), (1, 1));
}
