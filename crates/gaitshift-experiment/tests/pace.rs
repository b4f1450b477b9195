//! Contract: the pace of a run is measured in a time that does not grow with its schedule; of a learner whose updates take
//! long a few of them are measured; nothing is left behind.

use gaitshift_experiment::{Experiment, steps_per_second};
use std::cell::Cell;
use std::time::{Duration, Instant};

const DURATION: Duration = Duration::from_millis(300);

fn pace(changes: &[&str]) -> (f64, Duration) {
    let changes: Vec<String> = changes.iter().map(|&text| text.to_owned()).collect();
    let experiment = Experiment::recipe("fast").unwrap();
    let experiment = experiment.with_values(&changes).unwrap();
    let from = Instant::now();
    let pace = steps_per_second(&experiment, DURATION, &|| false).unwrap();
    (pace, from.elapsed())
}

#[test]
fn a_pace_is_measured() {
    assert!(pace(&[]).0 > 0.0);
    // However seldom it learns.
    let (pace, taken) = pace(&["training.steps_per_update=1000000000"]);
    assert!(pace > 0.0);
    assert!(taken < Duration::from_secs(30), "{taken:?}");
}

// It made 256 updates before it began to measure, and wrote checkpoints of gigabytes.
#[test]
fn slow_updates_are_measured_by_a_few() {
    let large = [
        "learner.critic_hidden=[1500,1500]",
        "training.environments=1",
        "training.steps_per_update=1",
    ];
    let (pace, taken) = pace(&large);
    // Even where a step, with its update, takes seconds on a busy machine.
    assert!(pace > 0.0 && pace < 300.0, "{pace}");
    let steps = taken.as_secs_f64() * pace;
    assert!(steps < 250.0, "about {steps} steps in {taken:?}");
}

// An interrupted measurement went on, or left its folder.
#[test]
fn it_stops_when_it_is_told_to() {
    let experiment = Experiment::recipe("fast").unwrap();
    let asked = Cell::new(0);
    let stop = || {
        asked.set(asked.get() + 1);
        asked.get() == 3
    };
    steps_per_second(&experiment, Duration::from_secs(3600), &stop).unwrap();
    assert_eq!(asked.get(), 3);
}
