//! Contract: the evaluations of a run can be read while it goes on, also by who knows less of them than was written; a
//! damaged line is named.

use crate::common::EVALUATION;
use gaitshift_analysis::GaitClass;
use gaitshift_experiment::{Evaluation, RunName};

fn read(content: &str) -> Result<Vec<Evaluation>, String> {
    let run = tempfile::tempdir().unwrap();
    std::fs::write(run.path().join("evaluations.jsonl"), content).unwrap();
    Evaluation::read_all(run.path()).map_err(|e| e.to_string())
}

fn line(score: f64) -> String {
    EVALUATION
        .replace('\n', "")
        .replace("3.25", &score.to_string())
        + "\n"
}

/// A sweep's table failed with "is damaged" when a trial was just writing an evaluation.
#[test]
fn a_line_that_is_being_written_is_left_out() {
    let half = &line(2.0)[..100];
    let read = read(&format!("{}{half}", line(1.0))).unwrap();
    assert_eq!(read.iter().map(|e| e.score).collect::<Vec<_>>(), [1.0]);
}

#[test]
fn a_damaged_line_is_named() {
    let error = read(&format!("{}{{}}\n", line(1.0))).unwrap_err();
    assert!(
        error.contains("evaluations.jsonl") && error.contains("line 2"),
        "{error}"
    );
}

#[test]
fn the_best_has_the_highest_score_and_of_equal_ones_the_most_even_steps_and_a_new_run_has_none() {
    let mut evaluations = read(&(line(1.0) + &line(3.5) + &line(3.5) + &line(2.0))).unwrap();
    for (step, evaluation) in evaluations.iter_mut().enumerate() {
        evaluation.step = step as u64;
    }
    let best = |evaluations: &[Evaluation]| Evaluation::best(evaluations).unwrap().step;
    assert_eq!(best(&evaluations), 1);
    // Of equally good ones the steps of which are most even; a better one may limp.
    evaluations[1].rows[0].step_time_asymmetry = Some(0.2);
    evaluations[2].rows[0].step_time_asymmetry = Some(0.1);
    assert_eq!(best(&evaluations), 2);
    evaluations[1].score += 0.01;
    assert_eq!(best(&evaluations), 1);
    let walk = evaluations[0].motion(GaitClass::Walking).unwrap();
    assert_eq!((walk.omega_v, walk.froude), (0.0, Some(0.2)));
    assert!(evaluations[0].motion(GaitClass::Running).is_none());
    let empty = tempfile::tempdir().unwrap();
    assert_eq!(Evaluation::read_all(empty.path()).unwrap(), []);
}

// Runs of an earlier version could no longer be compared once a key of their configuration was no more.
#[test]
fn name_and_seed_of_a_run_are_read_whatever_its_other_keys() {
    let run = tempfile::tempdir().unwrap();
    let config = |text: &str| std::fs::write(run.path().join("config.toml"), text).unwrap();
    config("name = \"old\"\nseed = 7\n[training.schedule]\nhorizon = []\n");
    let RunName { name, seed, .. } = RunName::read(run.path()).unwrap();
    assert_eq!((name.as_str(), seed), ("old", 7));
    config("seed = 7\n");
    let error = RunName::read(run.path()).unwrap_err().to_string();
    assert!(
        error.contains("config.toml") && error.contains("`name`"),
        "{error}"
    );
}

/// Before criteria could be chosen a line had its changes under two names, and the commands of the gaits were known.
#[test]
fn a_line_of_before_says_the_same() {
    let asked = "\"omega_v\":0.0,\"asked\":\"walking\",";
    let changes = "\"changes\":[{\"from\":0.0,\"to\":3.0,\"gaits\":[\"walking\",\"running\"],\"tries\":[{\"survived\":true,\
        \"gait_before\":\"walking\",\"gait_after\":\"running\"}]},{\"from\":3.0,\"to\":0.0,\"gaits\":[\"running\",\"walking\"],\
        \"tries\":[]}]";
    let old = line(1.0);
    let (start, end) = (
        old.find("\"to_running\"").unwrap(),
        old.find(",\"checks\"").unwrap(),
    );
    let new = format!("{}{changes}{}", &old[..start], &old[end..]);
    let new = new.replace("\"omega_v\":0.0,", asked);
    let evaluations = read(&(old + &new)).unwrap();
    assert_eq!(evaluations[0], evaluations[1]);
    assert_eq!(evaluations[0].changes[0].made(), 1);
    assert_eq!(evaluations[0].changes[1].made(), 0);
    let without = new.replace(changes, "\"more\":1");
    let error = read(&without).unwrap_err();
    assert!(error.contains("`changes`"), "{error}");
}

// With changes that leave no time after them the program could not read what it had written.
#[test]
fn a_change_after_which_nothing_is_recorded_is_read_and_not_made() {
    let without = line(1.0).replace("\"gait_after\":\"running\"", "\"gait_after\":null");
    let evaluations = read(&without).unwrap();
    assert_eq!(evaluations[0].changes[0].tries[0].gait_after, None);
    assert_eq!(evaluations[0].changes[0].made(), 0);
}

// Runs with other settings, and one run twice, were taken for seeds of one experiment; seeds that were evaluated more or less
// often were not.
#[test]
fn only_seeds_of_one_experiment_share_its_name() {
    let root = tempfile::tempdir().unwrap();
    let run = |folder: &str, seed: u64, friction: f64| {
        let path = root.path().join(folder);
        std::fs::create_dir(&path).unwrap();
        let config = format!("name = \"e\"\nseed = {seed}\n[body]\nfriction = {friction}\n");
        std::fs::write(path.join("config.toml"), config).unwrap();
        path
    };
    let seldom_evaluated = |path: std::path::PathBuf| {
        let mut config = std::fs::read_to_string(path.join("config.toml")).unwrap();
        config += "[training]\nevaluation_interval_steps = 500000\n";
        std::fs::write(path.join("config.toml"), config).unwrap();
        path
    };
    let runs = [
        run("a", 1, 1.0),
        seldom_evaluated(run("b", 2, 1.0)),
        run("slippery-1", 1, 0.3),
        run("slippery-2", 2, 0.3),
        run("copy", 1, 1.0),
    ];
    let paths: Vec<&std::path::Path> = runs.iter().map(std::path::PathBuf::as_path).collect();
    let names: Vec<String> = RunName::read_all(&paths)
        .unwrap()
        .into_iter()
        .map(|run| run.name)
        .collect();
    assert_eq!(names[0], "e");
    assert_eq!(names[1], "e");
    assert!(
        names[2].starts_with("e (") && names[2].contains("slippery-1"),
        "{names:?}"
    );
    assert_eq!(names[2], names[3]);
    assert!(
        names[4].starts_with("e (") && names[4].contains("copy"),
        "{names:?}"
    );
}

// Of folders whose last names are the same, the later experiments got one name and one mean.
#[test]
fn experiments_in_folders_of_the_same_name_keep_apart() {
    let root = tempfile::tempdir().unwrap();
    let runs: Vec<_> = ["a", "b", "c", "c"]
        .iter()
        .zip([1.0, 0.5, 0.3, 0.3])
        .map(|(folder, friction)| {
            let path = root.path().join(folder).join("seed-1");
            std::fs::create_dir_all(&path).unwrap();
            let config = format!("name = \"e\"\nseed = 1\n[body]\nfriction = {friction}\n");
            std::fs::write(path.join("config.toml"), config).unwrap();
            path
        })
        .collect();
    let paths: Vec<&std::path::Path> = runs.iter().map(std::path::PathBuf::as_path).collect();
    let told = RunName::read_all(&paths).unwrap();
    let names: Vec<&str> = told.iter().map(|run| run.name.as_str()).collect();
    assert_eq!(names[..3], ["e", "e (seed-1)", "e (c/seed-1)"]);
    assert!(!names[..3].contains(&names[3]), "{names:?}");
}
