//! Contract: whatever moment a run is killed at, its folder holds a whole state to go on from, and going on gives what
//! an uninterrupted run gives; no file that can be replaced is written in place; an edit of `config.toml` between two parts of a run is
//! applied and told, or refused; a state of another version is refused; a folder may have any name.

use crate::common::{Until, file, text, tiny, unevaluated};
use gaitshift_experiment::{
    Controller, Experiment, Judgement, Observer, Progress, RunReport, Training,
};
use std::fs;
use std::path::{Path, PathBuf};

/// Begins a run without evaluations and stops it at a step.
fn stopped_at(step: u64, folder: &Path) {
    let mut observer = Until::step(step);
    let report = Training::new(unevaluated(), folder, "test")
        .unwrap()
        .run(&mut observer)
        .unwrap();
    assert!(!report.finished);
    assert_eq!(
        (report.best_step, report.best_met, report.criteria),
        (None, None, None)
    );
}

fn go_on(folder: &Path) -> Until {
    let mut observer = Until::default();
    let report = Training::resume(folder)
        .unwrap()
        .run(&mut observer)
        .unwrap();
    assert!(report.finished);
    observer
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

/// A run that is whole, to compare with.
fn whole(root: &Path) -> PathBuf {
    let folder = root.join("whole");
    Training::new(unevaluated(), &folder, "test")
        .unwrap()
        .run(&mut Until::default())
        .unwrap();
    folder
}

fn assert_same_run(a: &Path, b: &Path) {
    for name in ["controller-last.safetensors", "episodes.csv"] {
        assert!(file(a, name) == file(b, name), "{name} differs");
    }
}

#[test]
fn a_run_killed_between_the_two_renames_of_a_checkpoint_can_be_resumed() {
    // What went wrong: a checkpoint takes its place by two renames. A run killed between them has no `checkpoint`, and
    // --resume failed although `checkpoint.old` and `checkpoint.new` were both whole.
    let root = tempfile::tempdir().unwrap();
    let whole = whole(root.path());
    let at = |name: &str| root.path().join(name);
    let checkpoint = |folder: &Path, name: &str| folder.join(name);

    let both = at("both");
    stopped_at(2500, &both);
    copy_folder(
        &checkpoint(&both, "checkpoint"),
        &checkpoint(&both, "checkpoint.new"),
    );
    fs::rename(
        checkpoint(&both, "checkpoint"),
        checkpoint(&both, "checkpoint.old"),
    )
    .unwrap();
    go_on(&both);
    assert_same_run(&whole, &both);

    // The newer one is damaged: the state, which is written last, is not there.
    let older = at("older");
    stopped_at(2500, &older);
    copy_folder(
        &checkpoint(&older, "checkpoint"),
        &checkpoint(&older, "checkpoint.new"),
    );
    fs::remove_file(older.join("checkpoint.new/state.json")).unwrap();
    fs::rename(
        checkpoint(&older, "checkpoint"),
        checkpoint(&older, "checkpoint.old"),
    )
    .unwrap();
    go_on(&older);
    assert_same_run(&whole, &older);

    // Killed before the first rename: the newer one counts.
    let newer = at("newer");
    stopped_at(2500, &newer);
    fs::rename(
        checkpoint(&newer, "checkpoint"),
        checkpoint(&newer, "checkpoint.new"),
    )
    .unwrap();
    go_on(&newer);
    assert_same_run(&whole, &newer);
    for folder in [&both, &older, &newer] {
        let left = |name: &str| folder.join(name).exists();
        assert!(left("checkpoint") && !left("checkpoint.old") && !left("checkpoint.new"));
    }
}

#[test]
fn a_run_killed_before_its_first_checkpoint_can_be_resumed() {
    // What went wrong: a run killed before its first checkpoint could neither be resumed nor begun anew.
    let root = tempfile::tempdir().unwrap();
    let whole = whole(root.path());
    let folder = root.path().join("run");
    // Everything that `new` leaves, and logs of a start that was lost.
    drop(Training::new(unevaluated(), &folder, "test").unwrap());
    fs::write(
        folder.join("episodes.csv"),
        "step,omega_v,total_reward,periods,ended,distance_m\n12,0,1,",
    )
    .unwrap();
    go_on(&folder);
    assert_same_run(&whole, &folder);
}

#[test]
fn no_file_that_a_run_keeps_is_written_in_place() {
    // What went wrong: controllers and the report were written over the old ones, so that a kill in the middle left
    // neither. A second name of a file shows it: it must keep the old content when the file gets a new one.
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    Training::new(tiny(), &folder, "test")
        .unwrap()
        .run(&mut Until::step(4000))
        .unwrap();
    let kept = ["controller-last.safetensors", "report.json"].map(|name| {
        let second = root.path().join(name);
        fs::hard_link(folder.join(name), &second).unwrap();
        (second, file(&folder, name))
    });
    go_on(&folder);
    for (second, content) in &kept {
        let name = second.file_name().unwrap();
        assert!(
            &fs::read(second).unwrap() == content,
            "{name:?} was written in place"
        );
        assert!(&fs::read(folder.join(name)).unwrap() != content);
    }
    let mut left: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    let expected = [
        "checkpoint",
        "config.toml",
        "controller-last.safetensors",
        "controller-walk.safetensors",
        "controller.safetensors",
        "controllers",
        "episodes.csv",
        "evaluations.jsonl",
        "events.out.tfevents.gaitshift",
        "lock",
        "metrics.csv",
        "report.json",
    ];
    assert_eq!(left, expected);
}

#[test]
fn what_was_logged_after_the_checkpoint_is_not_there_twice() {
    // What went wrong: an episode is logged with the step that its last period began at. Episodes that ended in the
    // first period after a checkpoint carry the checkpoint's own step; a run that was killed later and resumed kept
    // them and wrote them again. TensorBoard's events were never cut.
    let root = tempfile::tempdir().unwrap();
    let whole = whole(root.path());
    // A checkpoint at the step of an episode's end, which the run then logs.
    let episodes = text(&whole, "episodes.csv");
    let step = |line: &str| line.split(',').next()?.parse::<u64>().ok();
    let end = episodes
        .lines()
        .filter_map(step)
        .find(|s| *s > 2000)
        .unwrap();
    let mut experiment = unevaluated();
    experiment.training.checkpoint_interval_steps = end;
    let folder = root.path().join("run");
    Training::new(experiment, &folder, "test")
        .unwrap()
        .run(&mut Until::step(end))
        .unwrap();
    // Back to the state of a run killed after it: the checkpoint of that step beside longer logs.
    let back = root.path().join("back");
    copy_folder(&folder.join("checkpoint"), &back);
    let state = text(&back, "state.json");
    let at = |state: &str| {
        let value: serde_json::Value = serde_json::from_str(state).unwrap();
        value["counters"]["step"].as_u64().unwrap()
    };
    assert!(at(&state) >= end);
    go_on(&folder);
    fs::remove_dir_all(folder.join("checkpoint")).unwrap();
    fs::rename(&back, folder.join("checkpoint")).unwrap();
    let events = file(&folder, "events.out.tfevents.gaitshift").len();
    go_on(&folder);
    assert_eq!(text(&folder, "episodes.csv"), episodes);
    assert_eq!(file(&folder, "events.out.tfevents.gaitshift").len(), events);
}

#[test]
fn the_best_controller_is_the_best_up_to_the_checkpoint() {
    // What went wrong: after a kill the best controller was one of the evaluations after the checkpoint, which a run that
    // goes on with an edited configuration may never see; its report and its logs knew nothing of it.
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let mut experiment = tiny();
    experiment.training.checkpoint_interval_steps = 1_000_000;
    Training::new(experiment, &folder, "test")
        .unwrap()
        .run(&mut Until::step(2001))
        .unwrap();
    let best = file(&folder, "controller.safetensors");
    let back = root.path().join("back");
    copy_folder(&folder.join("checkpoint"), &back);
    go_on(&folder);
    // Killed before the checkpoint at the end: a better controller, and one that was accepted, from after the checkpoint.
    fs::write(folder.join("controller.safetensors"), "better").unwrap();
    fs::write(folder.join("controller-accepted.safetensors"), "accepted").unwrap();
    fs::remove_dir_all(folder.join("checkpoint")).unwrap();
    fs::rename(&back, folder.join("checkpoint")).unwrap();
    fs::write(folder.join("controllers/mine.safetensors"), "the user's").unwrap();
    drop(Training::resume(&folder).unwrap());
    let mut kept: Vec<_> = fs::read_dir(folder.join("controllers"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    kept.sort();
    assert_eq!(kept, ["mine.safetensors", "step-0000002000.safetensors"]);
    assert!(file(&folder, "controller.safetensors") == best);
    assert!(!folder.join("controller-accepted.safetensors").exists());
}

/// Resumes a stopped run after an edit of its configuration.
fn edited(folder: &Path, from: &str, to: &str) -> Result<Training, String> {
    let config = text(folder, "config.toml");
    assert!(config.contains(from), "{from} is not in {config}");
    fs::write(folder.join("config.toml"), config.replacen(from, to, 1)).unwrap();
    let outcome = Training::resume(folder).map_err(|e| e.to_string());
    if outcome.is_err() {
        fs::write(folder.join("config.toml"), config).unwrap();
    }
    outcome
}

#[test]
fn an_edit_that_the_checkpoint_decides_is_refused_with_its_key() {
    // What went wrong: edits of gamma, tau or learning_rate were ignored without a word, because the learner of the
    // checkpoint brings its own.
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    stopped_at(2500, &folder);
    for (from, to, key) in [
        ("gamma = 0.99", "gamma = 0.9", "`learner.gamma`"),
        ("tau = 0.005", "tau = 0.01", "`learner.tau`"),
        ("n_step = ", "n_step = 1", "`learner.n_step`"),
        (
            "actor_hidden = [16, 16]",
            "actor_hidden = [8, 16]",
            "`learner.actor_hidden`",
        ),
        ("seed = 1", "seed = 2", "`seed`"),
        (
            "environments = 4",
            "environments = 8",
            "`training.environments`",
        ),
        (
            "replay_capacity = 4000",
            "replay_capacity = 8000",
            "`training.replay_capacity`",
        ),
        ("friction = 1.0", "friction = 0.5", "`body.friction`"),
        (
            "control_period_s = 0.01",
            "control_period_s = 0.005",
            "`task.control_period_s`",
        ),
    ] {
        let error = edited(&folder, from, to).unwrap_err();
        assert!(
            error.contains(key) && error.contains("config.toml") && error.contains("new run"),
            "{key}: {error}"
        );
    }
    // Nothing was lost over it.
    go_on(&folder);
}

#[test]
fn every_other_edit_is_applied_and_told() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    stopped_at(2500, &folder);
    let edits = [
        ("omega_e = ", "omega_e = 1"),
        ("threads = 1", "threads = 2"),
        ("alpha = 0.05", "alpha = 0.01"),
        (
            "checkpoint_interval_steps = 3000",
            "checkpoint_interval_steps = 500",
        ),
    ];
    let mut config = text(&folder, "config.toml");
    for (from, to) in edits {
        assert!(config.contains(from), "{from}");
        config = config.replacen(from, to, 1);
    }
    fs::write(folder.join("config.toml"), config).unwrap();
    let notes = go_on(&folder).notes;
    let note = notes.iter().find(|n| n.contains("config.toml")).unwrap();
    for key in [
        "task.reward.omega_e",
        "learner.threads",
        "curriculum.phases[1].learner_end.alpha",
        "training.checkpoint_interval_steps",
    ] {
        assert!(note.contains(key), "{key}: {note}");
    }
    // The controllers made from there on say so: their command alone does not make them again.
    let controller = Controller::read(&folder.join("controller-last.safetensors")).unwrap();
    let edits = &controller.provenance.edits;
    assert!(
        edits.iter().any(|e| e.contains("task.reward.omega_e")),
        "{edits:?}"
    );
    // Resumed once more, nothing has been edited since.
    let notes = go_on(&folder).notes;
    assert!(
        notes.iter().all(|note| !note.contains("edited")),
        "{notes:?}"
    );
}

// What went wrong: with fewer steps per update than had been saved up, a stop at once left counters that could not be.
#[test]
fn a_run_edited_to_more_updates_can_be_stopped_at_once_and_resumed() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let mut experiment = unevaluated();
    experiment.training.steps_per_update = 1003;
    Training::new(experiment, &folder, "test")
        .unwrap()
        .run(&mut Until::step(2500))
        .unwrap();
    let mut resumed = edited(&folder, "steps_per_update = 1003", "steps_per_update = 1").unwrap();
    resumed.run(&mut Until::step(1)).unwrap();
    drop(resumed);
    Training::resume(&folder).unwrap();
}

// What went wrong: the first controller was written before the configuration; a kill between them left a folder that could
// neither go on nor begin again.
#[test]
fn a_run_killed_before_its_configuration_was_written_can_be_begun_again() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    // In the way of the configuration, which is written beside its place first.
    let in_the_way = folder.join("config.toml.new");
    fs::create_dir_all(&in_the_way).unwrap();
    Training::new(unevaluated(), &folder, "test").unwrap_err();
    assert!(!folder.join("controller-last.safetensors").exists());
    fs::remove_dir(&in_the_way).unwrap();
    Training::new(unevaluated(), &folder, "test").unwrap();
}

#[test]
fn a_state_of_another_version_is_refused() {
    // What went wrong: state.json had no version, though every format promises one.
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    stopped_at(2500, &folder);
    let path = folder.join("checkpoint/state.json");
    let state = fs::read_to_string(&path).unwrap();
    // What went wrong since: the configuration was read first, so that a run of an earlier version was answered by a key of
    // its configuration that is no more.
    let config = text(&folder, "config.toml");
    let old = format!("{config}\n[training.schedule]\nhorizon = []\n");
    fs::write(folder.join("config.toml"), &old).unwrap();
    fs::write(folder.join("checkpoint/config.toml"), &old).unwrap();
    for other in [
        state.replacen("gaitshift-run 5", "gaitshift-run 1", 1),
        state.replacen("\"format\": \"gaitshift-run 5\",", "", 1),
    ] {
        assert_ne!(other, state);
        fs::write(&path, other).unwrap();
        let error = Training::resume(&folder).unwrap_err().to_string();
        assert!(
            error.contains("state.json")
                && error.contains("gaitshift-run 5")
                && error.contains("new run"),
            "{error}"
        );
    }
}

#[test]
fn a_state_with_a_body_that_the_task_cannot_run_on_is_refused() {
    // What went wrong: found among damaged files. The body that an episode has drawn was not checked against the task; with
    // a tiny time step one control period takes billions of steps, and the resumed run hung.
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    stopped_at(4000, &folder);
    let path = folder.join("checkpoint/state.json");
    let state = fs::read_to_string(&path).unwrap();
    let from = "\"time_step_s\": 0.0002";
    assert!(state.contains(from));
    fs::write(&path, state.replacen(from, "\"time_step_s\": 1e-300", 1)).unwrap();
    let error = Training::resume(&folder).unwrap_err().to_string();
    assert!(error.contains("state.json"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_whose_name_is_no_text_can_be_resumed() {
    // What went wrong: the name was turned into text on the way, and the file of that name is another.
    use std::os::unix::ffi::OsStrExt;
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join(std::ffi::OsStr::from_bytes(b"run-\xff"));
    stopped_at(2500, &folder);
    go_on(&folder);
}

/// A run whose reward has a term of its own.
fn with_term(expression: &str) -> Experiment {
    let term =
        format!("task.reward.extra=[{{name=\"own\", weight=0.001, expression=\"{expression}\"}}]");
    unevaluated().with_values(&[term]).unwrap()
}

/// `episode/diverged` of the last row of the metrics.
fn diverged(folder: &Path) -> f64 {
    let metrics = text(folder, "metrics.csv");
    let mut lines = metrics.lines();
    let column = lines.next().unwrap().split(',');
    let column = column
        .into_iter()
        .position(|name| name == "episode/diverged")
        .unwrap();
    let last = lines.next_back().unwrap();
    last.split(',').nth(column).unwrap().parse().unwrap()
}

/// A run of that experiment, once as a whole and once stopped and resumed; gives the folder and the report of the first.
fn whole_and_resumed(root: &Path, experiment: &Experiment) -> (PathBuf, RunReport) {
    let (whole, parted) = (root.join("whole"), root.join("parted"));
    let begin = |folder: &Path| Training::new(experiment.clone(), folder, "test").unwrap();
    let report = begin(&whole).run(&mut Until::default()).unwrap();
    begin(&parted).run(&mut Until::step(2500)).unwrap();
    go_on(&parted);
    assert_same_run(&whole, &parted);
    assert_eq!(diverged(&whole), diverged(&parted));
    (whole, report)
}

// Until then no training had a simulation that came to nothing.
#[test]
fn undefined_rewards_end_episodes_and_are_counted_and_not_learned_from() {
    let root = tempfile::tempdir().unwrap();
    let (whole, report) = whole_and_resumed(root.path(), &with_term("ln(0.1 - time_s)"));
    let episodes = text(&whole, "episodes.csv");
    let undefined = episodes.lines().filter(|l| l.contains(",undefined,"));
    let undefined = undefined.count() as u64;
    assert!(undefined > 0 && diverged(&whole) > 0.0);
    assert_eq!(undefined, report.diverged);
}

// A reward that 64 bits hold and the learner's 32 do not ended the run.
#[test]
fn rewards_beyond_32_bits_are_counted_and_not_learned_from() {
    let root = tempfile::tempdir().unwrap();
    let huge = "time_s > 0.095 && time_s < 0.115 ? exp(100) : 0";
    let (whole, report) = whole_and_resumed(root.path(), &with_term(huge));
    assert!(report.diverged > 0 && diverged(&whole) > 0.0);
    let metrics = text(&whole, "metrics.csv");
    let sums = metrics
        .lines()
        .skip(1)
        .map(|l| l.rsplit(',').next().unwrap());
    assert!(sums.into_iter().all(|sum| sum == "0"), "{metrics}");
}

// Two processes could train one run: each wrote its lines between those of the other.
#[test]
fn a_run_is_trained_by_one_process_at_a_time() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("run");
    let first = Training::new(unevaluated(), &folder, "test").unwrap();
    let second = Training::resume(&folder).unwrap_err().to_string();
    let own = format!("process {}", std::process::id());
    assert!(
        second.contains("trained by another") && second.contains(&own),
        "{second}"
    );
    drop(first);
    go_on(&folder);
}

// Its report was written anew with the shorter time of the checkpoint, and the shares of the time added up to more than all.
#[test]
fn a_run_that_has_taken_all_its_steps_stays_as_it_is() {
    let root = tempfile::tempdir().unwrap();
    let folder = whole(root.path());
    let before = ["report.json", "checkpoint/state.json"].map(|name| file(&folder, name));
    let mut observer = Until::default();
    let report = Training::resume(&folder)
        .unwrap()
        .run(&mut observer)
        .unwrap();
    assert!(report.finished);
    let parts: f64 = report.parts.named().map(|(_, part_s)| part_s).iter().sum();
    assert!(parts <= report.elapsed_s, "{report:?}");
    let after = ["report.json", "checkpoint/state.json"].map(|name| file(&folder, name));
    assert!(before == after);
    assert!(
        observer
            .notes
            .iter()
            .any(|note| note.contains("nothing is left to do")),
        "{:?}",
        observer.notes
    );
}

// A run that was given more steps and killed kept the report of its first part, and was taken for finished.
#[test]
fn a_run_that_goes_on_has_no_report_until_it_ends() {
    let root = tempfile::tempdir().unwrap();
    let folder = whole(root.path());
    let mut longer = unevaluated();
    longer.curriculum.phases[2].steps += 4000;
    fs::write(folder.join("config.toml"), longer.to_toml().unwrap()).unwrap();
    let report = folder.join("report.json");
    let mut looking = Looking {
        report: report.clone(),
        looked: 0,
    };
    Training::resume(&folder)
        .unwrap()
        .run(&mut looking)
        .unwrap();
    assert!(looking.looked > 1);
    assert!(report.exists());
}

/// Looks for the report while the run goes on.
struct Looking {
    report: PathBuf,
    looked: usize,
}

impl Observer for Looking {
    fn progress(&mut self, progress: &Progress) {
        assert!(!self.report.exists(), "at step {}", progress.step);
        self.looked += 1;
    }
    fn evaluated(&mut self, _: &Progress, _: &Judgement, _: bool) {}
    fn note(&mut self, _: &str) {}
    fn stop_requested(&self) -> bool {
        false
    }
}
