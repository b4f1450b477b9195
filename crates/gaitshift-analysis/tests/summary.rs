//! Contract: a summary holds the known figures of a motion after its settling time, under the names that
//! other programs rely on; what is undefined is null; and no recording, however odd, makes it panic or
//! yield a number that is not finite.

use crate::common::{Frame, GRAVITY, Gait, LEG_M, close, metadata, record};
use gaitshift_analysis::recording::{COLUMNS, Recording};
use gaitshift_analysis::{
    AnalysisOptions, GaitClass, GaitSummary, TransitionOptions, summarise, summarise_transition,
};
use proptest::prelude::*;
use serde_json::Value;

fn summary(recording: &Recording) -> GaitSummary {
    summarise(recording, &AnalysisOptions::default())
}

#[test]
fn figures_of_a_walk() {
    let summary = summary(&Gait::WALK.record(20.0));
    assert_eq!(summary.gait, GaitClass::Walking);
    assert!(!summary.fell);
    assert_eq!(summary.ended_by, "time limit");
    assert_eq!(summary.steps, 29); // Touchdowns at 5.0, 5.5, ... 19.5 s.
    for (actual, expected) in [
        (Some(summary.survived_s), 20.0),
        (summary.window_start_s, 5.0),
        (summary.window_end_s, 20.0),
        (summary.speed_m_per_s, 0.8),
        (summary.froude, 0.8 / (GRAVITY * LEG_M).sqrt()),
        (summary.classic_froude, 0.64 / (GRAVITY * LEG_M)),
        (summary.double_support, 0.2),
        (summary.single_support, 0.8),
        (summary.flight, 0.0),
        (summary.cost_of_transport, 0.2),
        (summary.step_frequency_hz, 2.0),
        (summary.step_length_m, 0.4),
        (summary.duty_factor_right, 0.6),
        (summary.duty_factor_left, 0.6),
        (summary.stance_time_right_s, 0.6),
        (summary.swing_time_left_s, 0.4),
        (summary.step_time_asymmetry, 0.0),
        (summary.foot_slide, 0.0),
        (summary.scuffs_per_step, 0.0),
        (summary.steps_alternating, 1.0),
        (summary.steps_with_double_support, 1.0),
        (summary.steps_with_flight, 0.0),
        (summary.kinetic_potential_correlation, -1.0),
        (summary.kinetic_potential_correlation_single_support, -1.0),
    ] {
        close(actual, expected);
    }
}

#[test]
fn figures_of_a_run() {
    let summary = summary(&Gait::RUN.record(20.0));
    assert_eq!(summary.gait, GaitClass::Running);
    for (actual, expected) in [
        (summary.speed_m_per_s, 2.0),
        (summary.double_support, 0.0),
        (summary.cost_of_transport, 0.3),
        (summary.step_length_m, 0.7),
        (summary.steps_with_double_support, 0.0),
        (summary.steps_with_flight, 1.0),
        (summary.kinetic_potential_correlation_single_support, 1.0),
        (summary.elastic_kinetic_correlation_single_support, -1.0),
        (summary.elastic_potential_correlation_single_support, -1.0),
    ] {
        close(actual, expected);
    }
    let flight = summary.flight.expect("defined");
    assert!((flight - 0.1 / 0.35).abs() < 0.01, "{flight}");
}

#[test]
fn the_settling_time_is_left_out_but_never_more_than_half() {
    let starting = record(20.0, |time_s| {
        if time_s < 5.0 {
            Frame {
                contact: [true; 2],
                x_m: 4.0,
                ..Gait::WALK.frame(0.0)
            }
        } else {
            Gait::WALK.frame(time_s)
        }
    });
    assert_eq!(summary(&starting).gait, GaitClass::Walking);
    let at_once = AnalysisOptions {
        settling_time_s: 0.0,
        ..AnalysisOptions::default()
    };
    assert_eq!(summarise(&starting, &at_once).gait, GaitClass::Mixed);
    close(summary(&Gait::WALK.record(6.0)).window_start_s, 3.0);
}

#[test]
fn a_fall_keeps_its_figures() {
    let mut recording = Gait::WALK.record(8.0);
    recording.metadata.fell = true;
    recording.metadata.ended_by = "pitch".to_owned();
    let summary = summary(&recording);
    assert_eq!(
        (summary.gait, summary.fell, summary.ended_by.as_str()),
        (GaitClass::Fallen, true, "pitch")
    );
    close(Some(summary.survived_s), 8.0);
    close(summary.speed_m_per_s, 0.8);
}

#[test]
fn json_has_the_promised_names_and_null_for_undefined() {
    let standing = record(10.0, |_| Frame {
        contact: [true; 2],
        ..Frame::default()
    });
    let json = serde_json::to_value(summary(&standing)).expect("json");
    let fields = json.as_object().expect("object");
    for name in [
        "survived_s",
        "fell",
        "gait",
        "speed_m_per_s",
        "froude",
        "double_support",
        "single_support",
        "flight",
        "cost_of_transport",
        "step_frequency_hz",
        "step_length_m",
    ] {
        assert!(fields.contains_key(name), "{name}");
    }
    assert_eq!(json["gait"], "standing");
    assert_eq!(json["double_support"], 1.0);
    assert_eq!(json["step_length_m"], Value::Null);
    assert_eq!(json["cost_of_transport"], Value::Null);
}

#[test]
fn recordings_without_a_period_have_undefined_figures() {
    let mut recording = Recording::new(metadata());
    for rows in [0, 1] {
        let summary = summary(&recording);
        assert_eq!(
            (summary.gait, summary.steps, summary.survived_s),
            (GaitClass::Mixed, 0, 0.0),
            "{rows} rows"
        );
        assert_eq!(summary.speed_m_per_s, None);
        assert_eq!(summary.flight, None);
        recording
            .push_row(&vec![f64::from(rows); COLUMNS.len()])
            .expect("valid");
    }
}

/// Rows of finite numbers, from plausible to absurd, some columns of them constant.
fn any_recording() -> impl Strategy<Value = Recording> {
    let value = prop_oneof![
        4 => -500.0..500.0_f64,
        1 => Just(0.0),
        1 => prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL,
    ];
    let row = (1e-6..1.0_f64, prop::collection::vec(value, COLUMNS.len()));
    (prop::collection::vec(row, 0..80), any::<bool>()).prop_map(|(rows, fell)| {
        let mut recording = Recording::new(metadata());
        recording.metadata.fell = fell;
        let mut time_s = -3.0;
        for (period_s, mut row) in rows {
            time_s += period_s;
            row[0] = time_s;
            recording.push_row(&row).expect("valid");
        }
        recording
    })
}

proptest! {
    #[test]
    fn no_finite_recording_makes_it_panic_or_yield_nonsense(
        recording in any_recording(),
        settling_time_s in -1.0..40.0_f64,
        ramp_start_s in -10.0..50.0_f64,
        ramp_s in -1.0..10.0_f64,
    ) {
        let options = AnalysisOptions { settling_time_s, ..AnalysisOptions::default() };
        let summary = summarise(&recording, &options);
        prop_assert_eq!(summary.gait == GaitClass::Fallen, recording.metadata.fell);
        let transition = summarise_transition(
            &recording,
            ramp_start_s,
            ramp_start_s + ramp_s,
            &TransitionOptions::default(),
        );
        prop_assert_eq!(transition.survived, !recording.metadata.fell);
        for figures in [Some(&summary), transition.before.as_ref(), transition.after.as_ref()].into_iter().flatten() {
            for share in [figures.double_support, figures.single_support, figures.flight,
                figures.duty_factor_left, figures.steps_alternating, figures.steps_with_flight,
                figures.energy_recovery].into_iter().flatten() {
                prop_assert!((0.0..=1.0 + 1e-9).contains(&share), "{share}");
            }
            for correlation in [figures.kinetic_potential_correlation,
                figures.kinetic_potential_correlation_single_support,
                figures.elastic_kinetic_correlation_single_support].into_iter().flatten() {
                prop_assert!((-1.0..=1.0).contains(&correlation));
            }
            for number in [figures.speed_m_per_s, figures.froude, figures.classic_froude,
                figures.cost_of_transport, figures.step_frequency_hz, figures.step_length_m,
                figures.foot_slide, figures.step_time_asymmetry].into_iter().flatten() {
                prop_assert!(number.is_finite());
            }
            if let (Some(double), Some(single), Some(flight)) =
                (figures.double_support, figures.single_support, figures.flight) {
                prop_assert!((double + single + flight - 1.0).abs() < 1e-9);
            }
        }
    }
}
