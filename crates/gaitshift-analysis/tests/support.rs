//! Contract: a foot is on the ground while it bears more than the stated fraction of body weight; gaps and
//! contacts shorter than stated are chatter, except at the recording's ends; the phases cover the
//! recording without gaps, and touchdowns and lift-offs stand where contacts begin and end.

use crate::common::{Frame, Gait, PERIOD_S, WEIGHT_N, metadata, record};
use gaitshift_analysis::recording::{COLUMNS, Recording, Side, Window, column};
use gaitshift_analysis::support::{ContactRule, FootEventKind, Support, SupportPhase};

/// A recording whose right foot carries these forces, one per control period.
fn right_forces(forces_n: &[f64]) -> Recording {
    let mut recording = Recording::new(metadata());
    for row_index in 0..=forces_n.len() {
        let mut row = vec![0.0; COLUMNS.len()];
        row[column::TIME_S.index()] = row_index as f64 * PERIOD_S;
        // The first row's force belongs to no period and must not be read.
        let force_n = row_index
            .checked_sub(1)
            .map_or(WEIGHT_N, |period| forces_n[period]);
        row[column::RIGHT_NORMAL_FORCE_N.index()] = force_n;
        recording.push_row(&row).expect("valid");
    }
    recording
}

/// The right foot's contacts as (first row, last row); `pattern` has a letter per control period.
fn contacts(pattern: &str) -> Vec<(usize, usize)> {
    rows(support(pattern).contacts(Side::Right))
}

/// The right foot's contacts that were too short, likewise.
fn scuffs(pattern: &str) -> Vec<(usize, usize)> {
    rows(support(pattern).scuffs(Side::Right))
}

fn rows(contacts: &[Window]) -> Vec<(usize, usize)> {
    contacts
        .iter()
        .map(|contact| (contact.start_row(), contact.end_row()))
        .collect()
}

fn support(pattern: &str) -> Support {
    let forces: Vec<f64> = pattern
        .chars()
        .map(|letter| if letter == '#' { WEIGHT_N } else { 0.0 })
        .collect();
    Support::find(&right_forces(&forces), &ContactRule::default())
}

#[test]
fn contact_begins_above_the_stated_fraction_of_body_weight() {
    let threshold_n = 0.05 * WEIGHT_N;
    let mut forces = vec![0.0; 8];
    forces.extend([threshold_n; 8]);
    forces.extend([threshold_n + 1e-9; 16]);
    forces.extend([-WEIGHT_N; 8]);
    let support = Support::find(&right_forces(&forces), &ContactRule::default());
    let [contact] = support.contacts(Side::Right) else {
        panic!("one contact, not {:?}", support.contacts(Side::Right));
    };
    assert_eq!((contact.start_row(), contact.end_row()), (16, 32));
}

#[test]
fn a_trailing_foot_stays_down_until_its_force_falls_to_the_release_fraction() {
    let [touch_n, trail_n, gone_n] = [0.5, 0.03, 0.01].map(|fraction| fraction * WEIGHT_N);
    let mut forces = vec![0.0; 8];
    forces.extend([touch_n; 8]);
    // Wavering about the threshold of touchdown neither lifts the foot nor sets it down anew.
    forces.extend([trail_n; 8]);
    forces.extend([0.08 * WEIGHT_N; 6]);
    forces.extend([trail_n; 8]);
    forces.extend([gone_n; 8]);
    forces.extend([trail_n; 8]);
    let support = Support::find(&right_forces(&forces), &ContactRule::default());
    let [contact] = support.contacts(Side::Right) else {
        panic!("one contact, not {:?}", support.contacts(Side::Right));
    };
    assert_eq!((contact.start_row(), contact.end_row()), (8, 38));
}

#[test]
fn gaps_shorter_than_20_ms_are_filled() {
    let stance = "#".repeat(16);
    assert_eq!(contacts(&format!("____{stance}___{stance}__")), [(4, 39)]);
    assert_eq!(
        contacts(&format!("____{stance}____{stance}__")),
        [(4, 20), (24, 40)]
    );
}

#[test]
fn contacts_shorter_than_80_ms_are_scuffs() {
    let stance = "#".repeat(20);
    for (duration, is_scuff) in [(3, true), (15, true), (16, false)] {
        let brief = "#".repeat(duration);
        let pattern = format!("____{stance}______{brief}______");
        let found = contacts(&pattern);
        assert_eq!(found[0], (4, 24));
        assert_eq!(found.len(), if is_scuff { 1 } else { 2 }, "{duration}");
        let scuffs = scuffs(&pattern);
        assert_eq!(scuffs.len(), usize::from(is_scuff));
        assert!(scuffs.iter().all(|&scuff| scuff == (30, 30 + duration)));
    }
}

#[test]
fn a_bouncing_landing_is_one_contact() {
    // Filled first, dropped afterwards: the other way round nothing would remain.
    let bounces = "######__######__##";
    assert_eq!(contacts(&format!("______{bounces}______")), [(6, 24)]);
}

#[test]
fn what_reaches_the_ends_is_kept_because_its_duration_is_unknown() {
    assert_eq!(contacts("##________##"), [(0, 2), (10, 12)]);
    assert_eq!(contacts(&format!("__{}__", "#".repeat(16))), [(2, 18)]);
}

#[test]
fn thresholds_are_the_rules() {
    let mut forces = [0.0; 30];
    forces[10..13].fill(0.2 * WEIGHT_N);
    let find = |rule: ContactRule| {
        Support::find(&right_forces(&forces), &rule)
            .contacts(Side::Right)
            .len()
    };
    let brief = ContactRule {
        min_contact_s: 0.015,
        ..ContactRule::default()
    };
    assert_eq!(find(ContactRule::default()), 0);
    assert_eq!(find(brief), 1);
    assert_eq!(
        find(ContactRule {
            min_force_fraction: 0.3,
            ..brief
        }),
        0
    );
}

#[test]
fn phases_of_a_walk() {
    let recording = Gait::WALK.record(2.0);
    let support = Support::find(&recording, &ContactRule::default());
    let phases: Vec<(SupportPhase, usize, usize)> = support
        .phases()
        .iter()
        .map(|interval| {
            (
                interval.phase,
                interval.window.start_row(),
                interval.window.end_row(),
            )
        })
        .collect();
    use SupportPhase::{Double, SingleLeft, SingleRight};
    assert_eq!(
        phases,
        [
            (Double, 0, 20), // The left foot's stance from before.
            (SingleRight, 20, 100),
            (Double, 100, 120),
            (SingleLeft, 120, 200),
            (Double, 200, 220),
            (SingleRight, 220, 300),
            (Double, 300, 320),
            (SingleLeft, 320, 400),
        ]
    );
    let events: Vec<(Side, FootEventKind, usize)> = support
        .events()
        .iter()
        .map(|event| (event.side, event.kind, event.row))
        .collect();
    use FootEventKind::{LiftOff, Touchdown};
    assert_eq!(
        events,
        [
            (Side::Left, LiftOff, 20),
            (Side::Left, Touchdown, 100),
            (Side::Right, LiftOff, 120),
            (Side::Right, Touchdown, 200),
            (Side::Left, LiftOff, 220),
            (Side::Left, Touchdown, 300),
            (Side::Right, LiftOff, 320),
        ]
    );
    let window = recording.window(0.5, 1.5).expect("rows");
    let fractions = support.fractions(&recording, window).expect("defined");
    assert!((fractions.double_support - 0.2).abs() < 1e-9);
    assert!((fractions.single_support - 0.8).abs() < 1e-9);
    assert_eq!(fractions.flight, 0.0);
}

#[test]
fn phases_of_a_run_cover_it_without_gaps() {
    let recording = Gait::RUN.record(3.5);
    let support = Support::find(&recording, &ContactRule::default());
    for pair in support.phases().windows(2) {
        assert_eq!(pair[0].window.end_row(), pair[1].window.start_row());
        assert_eq!(pair[0].end_s, pair[1].start_s);
        assert_ne!(pair[0].phase, pair[1].phase);
        assert_ne!(pair[0].phase.is_single(), pair[1].phase.is_single());
    }
    let flight = support.periods(recording.whole().expect("rows"), |phase| {
        phase == SupportPhase::Flight
    });
    assert_eq!(flight, 10 * 20);
}

#[test]
fn simultaneous_events_are_ordered_right_first() {
    let recording = record(1.0, |time_s| Frame {
        contact: [time_s.rem_euclid(0.4) < 0.2; 2],
        ..Frame::default()
    });
    let support = Support::find(&recording, &ContactRule::default());
    let touchdowns: Vec<Side> = support
        .touchdowns(recording.whole().expect("rows"))
        .map(|touchdown| touchdown.side)
        .collect();
    assert_eq!(
        touchdowns,
        [Side::Right, Side::Left, Side::Right, Side::Left]
    );
}

#[test]
fn too_short_recordings_have_no_phases() {
    for rows in [0, 1] {
        let mut recording = Recording::new(metadata());
        for _ in 0..rows {
            recording
                .push_row(&vec![1e3; COLUMNS.len()])
                .expect("valid");
        }
        let support = Support::find(&recording, &ContactRule::default());
        assert!(support.phases().is_empty() && support.events().is_empty());
    }
}
