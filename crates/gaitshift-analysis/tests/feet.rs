//! Contract: clearance is the sole's height where a leg swings past the other one; friction of standing feet is slip, that of
//! all others drag; a recording without details has neither.

use crate::common;
use crate::common::{Gait, close, record};
use gaitshift_analysis::feet::{Rubbing, clearance_m};
use gaitshift_analysis::recording::{Recording, Side, column, detail};
use gaitshift_analysis::support::{ContactRule, Support};
use gaitshift_analysis::{AnalysisOptions, summarise};

fn support(recording: &Recording) -> Support {
    Support::find(recording, &ContactRule::default())
}

#[test]
fn clearance_is_the_height_where_the_legs_pass() {
    let mut recording = Gait::WALK.record(20.0);
    let apart: Vec<f64> = {
        let [right, left] = column::PHI_RAD.map(|phi| recording.column(phi));
        right.iter().zip(left).map(|(r, l)| (r - l).abs()).collect()
    };
    for (side, clearance) in [(Side::Right, 0.02), (Side::Left, 0.03)] {
        let heights = apart.iter().map(|apart| clearance + 0.1 * apart).collect();
        recording
            .set_detail(detail::SOLE_HEIGHT_M[side.index()], heights)
            .expect("a height for each row");
    }
    let window = recording.window(5.0, 20.0).expect("rows");
    for (side, clearance) in [(Side::Right, 0.02), (Side::Left, 0.03)] {
        let found = clearance_m(&recording, &support(&recording), side, window).expect("swings");
        // Between two rows the height is taken for straight, which cuts the corner off.
        assert!((found - clearance).abs() < 1e-3, "{side:?} {found}");
    }

    // Walked backward, film in reverse, the legs pass at the same height.
    let mut backward = record(20.0, |time_s| Gait::WALK.frame(20.0 - time_s));
    for side in Side::BOTH {
        let heights = recording.detail(detail::SOLE_HEIGHT_M[side.index()]);
        let reversed = heights.expect("given above").iter().rev().copied();
        backward
            .set_detail(detail::SOLE_HEIGHT_M[side.index()], reversed.collect())
            .expect("a height for each row");
    }
    for (side, clearance) in [(Side::Right, 0.02), (Side::Left, 0.03)] {
        let found = clearance_m(&backward, &support(&backward), side, window).expect("swings");
        assert!((found - clearance).abs() < 1e-3, "{side:?} {found}");
    }

    // Legs that swing together do not pass each other.
    let mut hop = Gait {
        left_phase: 0.0,
        ..Gait::RUN
    }
    .record(20.0);
    for heights in detail::SOLE_HEIGHT_M {
        hop.set_detail(heights, vec![0.05; hop.len()])
            .expect("a height for each row");
    }
    let none = clearance_m(&hop, &support(&hop), Side::Right, window);
    assert_eq!(none, None);
}

#[test]
fn friction_is_slip_in_stance_and_drag_between() {
    let mut recording = Gait::WALK.record(20.0);
    for side in Side::BOTH {
        // 2 W in stance, 0.5 W in swing, summed over the periods.
        let forces = recording.column(column::NORMAL_FORCE_N[side.index()]);
        let mut sum_j = 0.0;
        let lost: Vec<f64> = forces
            .iter()
            .map(|&force| {
                sum_j += common::PERIOD_S * if force > 0.0 { 2.0 } else { 0.5 };
                sum_j
            })
            .collect();
        recording
            .set_detail(detail::FRICTION_DISSIPATION_J[side.index()], lost)
            .expect("a sum for each row");
    }
    let window = recording.window(5.0, 15.0).expect("rows");
    let rubbing = Rubbing::find(&recording, &support(&recording), window).expect("way");
    // A stride of 1 s and 0.8 m: each foot stands for 0.6 s and swings for 0.4 s of it.
    close(Some(rubbing.slip_j_per_m), 2.0 * 0.6 * 2.0 / 0.8);
    close(Some(rubbing.drag_j_per_m), 2.0 * 0.4 * 0.5 / 0.8);

    let mut in_place = recording.clone();
    in_place.metadata.leg_length_m = 1000.0;
    assert_eq!(Rubbing::find(&in_place, &support(&in_place), window), None);
}

#[test]
fn without_details_there_is_neither() {
    let summary = summarise(&Gait::WALK.record(20.0), &AnalysisOptions::default());
    assert_eq!(summary.clearance_right_m, None);
    assert_eq!(
        (summary.slip_work_j_per_m, summary.drag_work_j_per_m),
        (None, None)
    );
    // What needs none is there.
    assert!(summary.hip_phase_rad.is_some() && summary.step_time_variation_left.is_some());
}
