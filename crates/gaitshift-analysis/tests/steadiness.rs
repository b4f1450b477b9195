//! Contract: steps all alike vary by nothing, whatever the rows; the phase between the hips is π for legs that alternate, 0 for
//! legs that swing together, and its deviation is that of a circular sample.

use crate::common;
use std::f64::consts::{PI, TAU};

use crate::common::{Gait, PERIOD_S, close, record};
use gaitshift_analysis::recording::{Recording, Side, detail};
use gaitshift_analysis::steadiness::{HipPhase, StepVariation};
use gaitshift_analysis::steps::{Step, find_steps};
use gaitshift_analysis::support::{ContactRule, Support};

fn steps(recording: &Recording) -> Vec<Step> {
    let support = Support::find(recording, &ContactRule::default());
    find_steps(
        recording,
        &support,
        recording.window(1.0, 19.0).expect("rows"),
    )
}

fn hip_phase(recording: &Recording) -> Option<HipPhase> {
    HipPhase::find(recording, recording.window(1.0, 19.0).expect("rows"))
}

/// A run whose strides are no whole number of rows.
const UNEVEN: Gait = Gait {
    step_s: 0.3517,
    stance_s: 0.2503,
    ..Gait::RUN
};

#[test]
fn touchdowns_within_a_period_are_timed() {
    // Steps all alike seemed to vary by half a percent, since touchdowns were those of the rows.
    let mut recording = UNEVEN.record(20.0);
    let coarse = StepVariation::find(&recording, &steps(&recording), Side::Right);
    assert!(coarse.time.expect("steps") > 3e-3, "{coarse:?}");

    for side in Side::BOTH {
        let phase_s = UNEVEN.step_s * f64::from(u8::from(side == Side::Left));
        let shares: Vec<f64> = (0..recording.len())
            .map(|row| {
                // Of the period that ends at the row, in fine steps.
                let touching = (0..1000).filter(|k| {
                    let time_s = PERIOD_S * (row as f64 - 1.0 + (f64::from(*k) + 0.5) / 1000.0);
                    (time_s - phase_s).rem_euclid(2.0 * UNEVEN.step_s) < UNEVEN.stance_s
                });
                touching.count() as f64 / 1000.0
            })
            .collect();
        recording
            .set_detail(detail::CONTACT_SHARE[side.index()], shares)
            .expect("a share for each row");
    }
    for side in Side::BOTH {
        let fine = StepVariation::find(&recording, &steps(&recording), side);
        assert!(fine.time.expect("steps") < 1e-4, "{side:?} {fine:?}");
        assert!(fine.length.expect("steps") < 1e-4, "{side:?} {fine:?}");
    }
}

#[test]
fn variation_is_deviation_over_mean_foot_by_foot() {
    let recording = Gait::WALK.record(20.0);
    // Steps onto the right foot of 0.45, 0.5 and 0.55 s, onto the left of 0.5 s each, at 0.8 m/s.
    let mut row = 100;
    let mut made = Vec::new();
    for (to, rows) in [
        (Side::Left, 100),
        (Side::Right, 90),
        (Side::Left, 100),
        (Side::Right, 100),
        (Side::Left, 100),
        (Side::Right, 110),
    ] {
        made.push(Step {
            from: to.other(),
            to,
            start_row: row,
            end_row: row + rows,
            start_s: 0.0,
            duration_s: 0.0,
            length_m: 0.0,
            double_support_periods: 0,
            flight_periods: 0,
        });
        row += rows;
    }
    let right = StepVariation::find(&recording, &made, Side::Right);
    close(right.time, 0.1);
    close(right.length, 0.1);
    let left = StepVariation::find(&recording, &made, Side::Left);
    assert!(left.time.expect("steps") < 1e-9);
    // Two steps have no spread.
    let few = StepVariation::find(&recording, &made[..5], Side::Right);
    assert_eq!((few.time, few.length), (None, None));
}

#[test]
fn hips_that_alternate_or_swing_together() {
    for (left_phase, expected) in [(0.5, PI), (0.4, 0.8 * PI), (0.0, 0.0)] {
        for gait in [Gait::WALK, Gait::RUN] {
            let gait = Gait { left_phase, ..gait };
            let phase = hip_phase(&gait.record(20.0)).expect("strides");
            assert!((phase.mean_rad - expected).abs() < 1e-6, "{phase:?}");
            assert!(phase.deviation_rad < 1e-6, "{phase:?}");
            assert!(phase.strides > 15);
        }
    }
}

#[test]
fn a_left_leg_that_is_early_and_late_by_turns_has_a_deviation() {
    let stride_s = 2.0 * Gait::WALK.step_s;
    let recording = record(20.0, |time_s| {
        let mut frame = Gait::WALK.frame(time_s);
        let shift = 0.05 * (PI * (time_s / stride_s - 0.5)).cos();
        let left = Gait::WALK.frame(time_s + shift * stride_s);
        (frame.psi_rad[1], frame.contact[1]) = (left.psi_rad[1], left.contact[1]);
        frame
    });
    // The shift at the time at which it is taken.
    let mut shift = 0.05_f64;
    for _ in 0..50 {
        shift = 0.05 * (PI * shift).cos();
    }
    let phase = hip_phase(&recording).expect("strides");
    let expected = (-2.0 * (TAU * shift).cos().ln()).sqrt();
    assert!((phase.mean_rad - PI).abs() < 0.05, "{phase:?}");
    assert!(
        (phase.deviation_rad / expected - 1.0).abs() < 0.03,
        "{phase:?} {expected}"
    );
}

#[test]
fn without_strides_there_is_no_phase() {
    let standing = record(20.0, |_| common::Frame {
        contact: [true; 2],
        ..common::Frame::default()
    });
    assert_eq!(hip_phase(&standing), None);
    // One leg that swings alone.
    let hobbling = record(20.0, |time_s| {
        let mut frame = Gait::WALK.frame(time_s);
        (frame.psi_rad[1], frame.contact[1]) = (0.0, true);
        frame
    });
    assert_eq!(hip_phase(&hobbling), None);
}

#[test]
fn legs_that_never_touch_the_ground_have_a_phase() {
    // Strides were those between lift-offs: where a foot dragged there was none, just where legs coordinate worst.
    let dragging = record(20.0, |time_s| common::Frame {
        contact: [true; 2],
        ..Gait::WALK.frame(time_s)
    });
    let phase = hip_phase(&dragging).expect("strides");
    assert!((phase.mean_rad - PI).abs() < 1e-6, "{phase:?}");
    // A trembling on the way is no swing of its own.
    let trembling = record(20.0, |time_s| {
        let mut frame = Gait::WALK.frame(time_s);
        frame.psi_rad[0] += 0.01 * (40.0 * PI * time_s).sin();
        frame
    });
    let phase = hip_phase(&trembling).expect("strides");
    assert!((phase.mean_rad - PI).abs() < 0.1, "{phase:?}");
}
