//! Contract: a change of gait is described by the steady motion before and after the ramp and by the
//! number of the touchdown from which on every step belongs to the new gait; the correlations named
//! without a phase are those in which each gait shows.

use crate::common;
use crate::common::{Frame, Gait, PERIOD_S, close, record};
use gaitshift_analysis::recording::{COLUMNS, Recording, column};
use gaitshift_analysis::{
    GaitClass, REST_S, TransitionOptions, TransitionSummary, changes_of_gait, command_changes,
    summarise_transition,
};

/// Walks until 11 s, then runs; the right foot lands at 11 s.
fn walk_to_run(time_s: f64) -> Frame {
    if time_s < 11.0 {
        return Gait::WALK.frame(time_s);
    }
    let mut frame = Gait::RUN.frame(time_s - 11.0);
    frame.x_m += 11.0 * Gait::WALK.speed_m_per_s;
    frame
}

/// Runs until 10.5 s, then walks; the right foot lands at 10.5 s.
fn run_to_walk(time_s: f64) -> Frame {
    if time_s < 10.5 {
        return Gait::RUN.frame(time_s);
    }
    let mut frame = Gait::WALK.frame(time_s - 10.5);
    // The walk's first double support has no foot behind it: that one swings.
    if time_s < 10.6 {
        frame.contact = [true, false];
    }
    frame.x_m += 10.5 * Gait::RUN.speed_m_per_s;
    frame
}

fn transition(recording: &Recording) -> TransitionSummary {
    summarise_transition(recording, 10.2, 10.6, &TransitionOptions::default())
}

#[test]
fn from_walking_to_running() {
    let summary = transition(&record(20.0, walk_to_run));
    assert!(summary.survived);
    assert_eq!(
        (summary.gait_before, summary.gait_after),
        (Some(GaitClass::Walking), Some(GaitClass::Running))
    );
    // Touchdowns since 10.2 s: left at 10.5 (a walking step), right at 11.0 (the first running step).
    assert_eq!(summary.steps_to_change, Some(2));
    close(summary.speed_before_m_per_s, 0.8);
    close(summary.speed_after_m_per_s, 2.0);
    close(summary.kinetic_potential_correlation_before, -1.0);
    close(summary.kinetic_potential_correlation_after, 1.0);
    close(summary.elastic_kinetic_correlation_after, -1.0);
    close(summary.elastic_potential_correlation_after, -1.0);
    assert_eq!(summary.elastic_kinetic_correlation_before, None);
    // The window from 5 to 10.2 s holds 10 double supports of 0.1 s and one more.
    close(summary.double_support_before, 1.1 / 5.2);
    close(summary.flight_before, 0.0);
    close(summary.double_support_after, 0.0);
    close(summary.before.unwrap().window_start_s, 5.0);
    close(summary.after.unwrap().window_start_s, 10.6 + 0.5 * 9.4);
}

#[test]
fn from_running_to_walking() {
    let summary = transition(&record(20.0, run_to_walk));
    assert_eq!(
        (summary.gait_before, summary.gait_after),
        (Some(GaitClass::Running), Some(GaitClass::Walking))
    );
    // Touchdowns since 10.2 s: right at 10.5 (no double support yet), left at 11.0 (walking).
    assert_eq!(summary.steps_to_change, Some(2));
    close(summary.kinetic_potential_correlation_before, 1.0);
    close(summary.kinetic_potential_correlation_after, -1.0);
}

#[test]
fn a_relapse_starts_the_count_again() {
    let relapsing = record(20.0, |time_s| {
        let mut frame = walk_to_run(time_s);
        // The step that begins at 11.7 s (the fourth touchdown) has no flight.
        if (11.9..12.05).contains(&time_s) {
            frame.contact = [true, false];
        }
        frame
    });
    let summary = transition(&relapsing);
    assert_eq!(summary.gait_after, Some(GaitClass::Running));
    assert_eq!(summary.steps_to_change, Some(5));
}

#[test]
fn without_a_change_there_are_no_steps_to_it() {
    let walking = transition(&Gait::WALK.record(20.0));
    assert_eq!(
        (walking.gait_before, walking.gait_after),
        (Some(GaitClass::Walking), Some(GaitClass::Walking))
    );
    assert_eq!(walking.steps_to_change, None);
    let stopping = record(20.0, |time_s| {
        let mut frame = Gait::WALK.frame(time_s.min(11.0));
        frame.contact = if time_s > 11.0 {
            [true; 2]
        } else {
            frame.contact
        };
        frame
    });
    assert_eq!(transition(&stopping).gait_after, Some(GaitClass::Standing));
    assert_eq!(transition(&stopping).steps_to_change, None);
}

#[test]
fn a_walk_a_run_and_a_walk_are_two_changes() {
    // From up and down again as one change came no number of steps at all: it leads from the walk to the walk.
    let motion = |time_s: f64| {
        if time_s < 20.0 {
            return walk_to_run(time_s);
        }
        // Runs on to 20.1 s, where the right foot would land after 13 strides.
        let mut frame = run_to_walk(time_s - 9.6);
        frame.x_m += 100.0;
        frame
    };
    let ramps = [(10.2, 10.6), (19.8, 20.2)];
    let options = TransitionOptions::default();
    let recording = record(30.0, motion);
    let whole = summarise_transition(&recording, 10.2, 20.2, &options);
    assert_eq!(whole.steps_to_change, None);
    let changes = changes_of_gait(&recording, &ramps, &options);
    let gaits: Vec<_> = changes
        .iter()
        .map(|c| (c.gait_before.unwrap(), c.gait_after.unwrap()))
        .collect();
    use GaitClass::{Running, Walking};
    assert_eq!(gaits, [(Walking, Running), (Running, Walking)]);
    assert_eq!((changes[0].start_s, changes[1].end_s), (10.2, 20.2));
    assert_eq!(changes[0].steps_to_change, Some(2));
    assert!((1..=3).contains(&changes[1].steps_to_change.unwrap()));

    // A fall belongs to the change before it, and to no other.
    let mut fallen = record(25.0, motion);
    fallen.metadata.fell = true;
    let changes = changes_of_gait(&fallen, &ramps, &options);
    assert_eq!(changes[0].steps_to_change, Some(2));
    assert_eq!(changes[1].gait_after, Some(GaitClass::Fallen));
    assert_eq!(changes[1].steps_to_change, None);
    // What the motion does not live to see is left out.
    assert_eq!(
        changes_of_gait(&record(15.0, motion), &ramps, &options).len(),
        1
    );
}

#[test]
fn a_fall_during_the_change_is_reported() {
    let mut recording = record(12.0, walk_to_run);
    recording.metadata.fell = true;
    let summary = transition(&recording);
    assert!(!summary.survived);
    assert_eq!(
        (summary.gait_before, summary.gait_after),
        (Some(GaitClass::Walking), Some(GaitClass::Fallen))
    );
    assert_eq!(summary.steps_to_change, None);
    close(Some(summary.survived_s), 12.0);
}

#[test]
fn a_fall_before_the_ramp_leaves_nothing_after_it() {
    let mut recording = record(4.0, walk_to_run);
    recording.metadata.fell = true;
    let summary = transition(&recording);
    assert_eq!(summary.gait_after, Some(GaitClass::Fallen));
    assert_eq!(summary.speed_after_m_per_s, None);
    assert_eq!(summary.steps_to_change, None);
}

// A command that changes from the start on had a gait "before", mixed, though nothing was before.
#[test]
fn without_time_before_or_after_there_is_no_gait_there() {
    let recording = record(20.0, walk_to_run);
    let options = TransitionOptions::default();
    let from_the_start = summarise_transition(&recording, 0.0, 10.6, &options);
    assert_eq!(from_the_start.gait_before, None);
    assert_eq!(from_the_start.before, None);
    assert_eq!(from_the_start.gait_after, Some(GaitClass::Running));
    let to_the_end = summarise_transition(&recording, 10.2, 20.0, &options);
    assert_eq!(to_the_end.gait_before, Some(GaitClass::Walking));
    assert_eq!((to_the_end.gait_after, to_the_end.after), (None, None));
    let json = serde_json::to_value(&from_the_start).expect("json");
    assert!(json["gait_before"].is_null() && json["before"].is_null());
}

#[test]
fn json_has_the_promised_names() {
    let json = serde_json::to_value(transition(&record(20.0, walk_to_run))).expect("json");
    for name in [
        "survived",
        "gait_before",
        "gait_after",
        "speed_before_m_per_s",
        "speed_after_m_per_s",
        "steps_to_change",
        "kinetic_potential_correlation_before",
        "kinetic_potential_correlation_after",
    ] {
        assert!(!json[name].is_null(), "{name}");
    }
    assert_eq!(json["gait_after"], "running");
    assert_eq!(json["before"]["gait"], "walking");
}

// Of 160 such starts 46 made one change of the two: the times of rows are not those of the profile to the last bit.
#[test]
fn changes_a_rest_apart_are_told_apart_wherever_they_begin() {
    for tenth in 10..170 {
        let start_s = f64::from(tenth) / 10.0;
        let back_s = start_s + 0.4 + REST_S;
        let mut recording = Recording::new(common::metadata());
        let mut row = vec![0.0; COLUMNS.len()];
        for period in 0..=(25.0 / PERIOD_S).round() as usize {
            // The command of the period that ends here, as the recorder adds it up.
            let begin_s = period.saturating_sub(1) as f64 * PERIOD_S;
            let up = ((begin_s - start_s) / 0.4).clamp(0.0, 1.0);
            let down = ((begin_s - back_s) / 0.4).clamp(0.0, 1.0);
            row[column::TIME_S.index()] = period as f64 * PERIOD_S;
            row[column::OMEGA_V.index()] = 3.0 * (up - down);
            recording.push_row(&row).expect("valid");
        }
        let changes = command_changes(&recording);
        assert_eq!(changes.len(), 2, "from {start_s} s: {changes:?}");
        assert!((changes[1].0 - back_s).abs() < 1.5 * PERIOD_S);
    }
}
