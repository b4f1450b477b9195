//! Contract: the episodes of a run are those of its log, while it is written too; a run without a log has none; a damaged log names
//! the file and the line.

use crate::common;
use gaitshift_report::{Episodes, ReportError};

#[test]
fn late_falls_are_those_of_the_last_fifth() {
    let folder = tempfile::tempdir().unwrap();
    let run = common::run(folder.path());
    let episodes = Episodes::read(&run).unwrap();
    assert_eq!(episodes.steps.len(), 10);
    assert_eq!(episodes.returns[9], 10.5);
    // Those of 8000, 9000 and 10000, of which the last fell.
    assert_eq!(episodes.late_falls(), Some(1.0 / 3.0));

    std::fs::remove_file(run.join("episodes.csv")).unwrap();
    let none = Episodes::read(&run).unwrap();
    assert_eq!((none.steps.len(), none.late_falls()), (0, None));
}

#[test]
fn tenths_hold_the_episodes_that_end_in_them() {
    let folder = tempfile::tempdir().unwrap();
    let run = common::run(folder.path());
    let tenths = Episodes::read(&run).unwrap().tenths();
    assert_eq!(tenths.len(), 10);
    assert_eq!((tenths[0].from_step, tenths[0].to_step), (0.0, 1000.0));
    assert_eq!((tenths[0].mean_return, tenths[0].falls), (1.5, 0.0));
    assert_eq!((tenths[9].mean_return, tenths[9].falls), (10.5, 1.0));
    assert!(Episodes::default().tenths().is_empty());
}

#[test]
fn the_course_of_a_training_is_in_stretches_of_100_000_steps() {
    let episodes = Episodes {
        steps: vec![50_000.0, 100_000.0, 100_001.0, 250_000.0],
        returns: vec![1.0, 3.0, 5.0, 7.0],
        omega_v: vec![0.0; 4],
        fell: vec![true, false, false, false],
    };
    let course: Vec<_> = episodes
        .course()
        .iter()
        .map(|s| (s.to_step, s.mean_return, s.falls))
        .collect();
    assert_eq!(course, [(1e5, 2.0, 0.5), (2e5, 5.0, 0.0), (3e5, 7.0, 0.0)]);
    assert!(Episodes::default().course().is_empty());
}

// There was no report of a run that was going on or had been killed.
#[test]
fn a_line_that_is_being_written_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let run = common::run(folder.path());
    let whole = Episodes::read(&run).unwrap();
    let log = std::fs::read_to_string(run.join("episodes.csv")).unwrap();
    assert!(log.ends_with('\n'));
    std::fs::write(run.join("episodes.csv"), log + "1000,0.5,1.5,10").unwrap();
    assert_eq!(Episodes::read(&run).unwrap(), whole);
    std::fs::write(run.join("episodes.csv"), "step,omega").unwrap();
    assert_eq!(Episodes::read(&run).unwrap(), Episodes::default());
}

#[test]
fn a_damaged_log_names_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = common::run(folder.path());
    let damaged = common::EPISODES.to_owned() + "1000,0.5,1.5,10\n";
    std::fs::write(run.join("episodes.csv"), damaged).unwrap();
    let error = Episodes::read(&run).unwrap_err();
    assert!(matches!(error, ReportError::Log { .. }));
    let message = error.to_string();
    assert!(
        message.contains("episodes.csv") && message.contains("line: 2"),
        "{message}"
    );
}
