//! Reports of a plan that takes seconds, and the folder of a run.
#![allow(dead_code, reason = "each test file uses a part")]

pub mod studies;

use gaitshift_report::{Plan, RecordedExperiment, Subject, Work, write_report};
use std::collections::BTreeMap;
use std::path::Path;

/// The least plan that has something of everything.
pub fn tiny() -> Plan {
    Plan {
        range: [0.0, 3.5, 0.5],
        steady_s: 12.0,
        stairs: [0.6, 0.3, 15.0],
        starts: 2,
        starts_step: 0.3,
        trials: 2,
        phases: 2,
        step_heights_m: [0.002, 0.004, 0.002],
        noise_levels: vec![0.5],
        followed: vec![0.0, 3.0],
        ..Plan::quick()
    }
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                all.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    all
}

/// Measuring that says nothing and is not stopped.
pub fn quiet(threads: usize) -> Work<'static> {
    Work {
        threads,
        say: &|_| {},
        stop: &|| false,
    }
}

/// Every file of a report by its path.
pub fn written(subjects: &mut [Subject]) -> BTreeMap<String, Vec<u8>> {
    written_with(subjects, &[])
}

/// The same beside what is recorded.
pub fn written_with(
    subjects: &mut [Subject],
    recorded: &[RecordedExperiment],
) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    written_into(folder.path(), subjects, recorded)
}

/// The same, in a folder that may hold an earlier report.
pub fn written_into(
    folder: &Path,
    subjects: &mut [Subject],
    recorded: &[RecordedExperiment],
) -> BTreeMap<String, Vec<u8>> {
    let paths = write_report(subjects, recorded, &tiny(), folder, &quiet(2)).unwrap();
    assert_eq!(paths[0], folder.join("report.html"));
    let all = files(folder);
    assert_eq!(paths.len(), all.len());
    all
}

pub fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// The header of a log of episodes.
pub const EPISODES: &str = "step,omega_v,total_reward,periods,ended,distance_m\n";

/// A run's folder within `folder`: the shipped controller, a configuration and ten episodes, of which the last ended in a fall.
pub fn run(folder: &Path) -> std::path::PathBuf {
    let run = folder.join("run");
    std::fs::create_dir(&run).unwrap();
    gaitshift_experiment::Controller::shipped()
        .unwrap()
        .write(&run.join("controller.safetensors"))
        .unwrap();
    std::fs::write(run.join("config.toml"), "name = \"paper\"\nseed = 7\n").unwrap();
    let episodes: String = (1..=10)
        .map(|k| {
            let ended = if k == 10 { "pitch" } else { "time limit" };
            format!("{},0.5,{k}.5,1000,{ended},3.5\n", 1000 * k)
        })
        .collect();
    std::fs::write(run.join("episodes.csv"), EPISODES.to_owned() + &episodes).unwrap();
    run
}
