//! Contract: work and losses per step are what a leg's elements were given, divided by the steps of either foot; peaks are the means of
//! the greatest force of each stance; a recording without details has none of it.

use crate::common;
use crate::common::{Gait, PERIOD_S, WEIGHT_N, close};
use gaitshift_analysis::flow::{
    EnergyFlow, losses_after_touchdown, peak_force_body_weights, share_at_stop, touching_shares,
};
use gaitshift_analysis::recording::{
    COLUMNS, Column, DETAILS, Detail, Recording, Side, column, detail,
};
use gaitshift_analysis::steps::whole_strides;
use gaitshift_analysis::support::{ContactRule, Support};
use gaitshift_analysis::{AnalysisOptions, summarise};

/// The walk of the common module with details: power in W of each sum, and impacts of one millisecond at touchdown.
fn detailed(power: impl Fn(Detail) -> f64, impact_n: [f64; 2]) -> Recording {
    let plain = Gait::WALK.record(20.0);
    let mut recording = Recording::new(plain.metadata.clone());
    let stride_s = 2.0 * Gait::WALK.step_s;
    for row in 0..plain.len() {
        let mut values: Vec<f64> = COLUMNS
            .iter()
            .map(|name| plain.column(Column::named(name).unwrap())[row])
            .collect();
        let time_s = plain.column(column::TIME_S)[row];
        // Losses fall in the first 20 ms after each touchdown of either foot, 3 J each.
        let since_s = (time_s + 1e-9).rem_euclid(Gait::WALK.step_s);
        let steps = ((time_s + 1e-9) / Gait::WALK.step_s).floor();
        values[column::DAMPER_DISSIPATION_J.index()] = 3.0 * (steps + (since_s / 0.02).min(1.0));
        let mut details: Vec<f64> = DETAILS
            .iter()
            .map(|name| power(Detail::named(name).unwrap()) * time_s)
            .collect();
        for side in Side::BOTH {
            let i = side.index();
            let force_n = plain.column(column::NORMAL_FORCE_N[i])[row];
            let phase = if side == Side::Right {
                0.0
            } else {
                0.5 * stride_s
            };
            // The period that ends at this row is the first of the stance.
            let first = (time_s - phase - 0.5 * PERIOD_S).rem_euclid(stride_s) < PERIOD_S;
            details[detail::PEAK_NORMAL_FORCE_N[i].index()] =
                if first { impact_n[i] } else { force_n };
            details[detail::CONTACT_SHARE[i].index()] = f64::from(u8::from(force_n > 0.0));
        }
        details[detail::FLIGHT_SHARE.index()] = 0.0;
        values.extend(details);
        recording.push_row(&values).expect("valid");
    }
    recording
}

/// A recording with details of which every sum grows with this power.
fn with_power(plain: &Recording, watts: f64) -> Recording {
    let mut recording = Recording::new(plain.metadata.clone());
    for row in 0..plain.len() {
        let mut values: Vec<f64> = plain
            .every_column()
            .map(|(_, series)| series[row])
            .collect();
        let time_s = plain.column(column::TIME_S)[row];
        values.extend(DETAILS.iter().map(|_| watts * time_s));
        recording.push_row(&values).expect("valid");
    }
    recording
}

#[test]
fn energy_per_step_is_power_times_the_steps_time() {
    let recording = detailed(|detail| 2.0 + detail.index() as f64, [900.0, 900.0]);
    let support = Support::find(&recording, &ContactRule::default());
    let window = recording.window(5.0, 20.0).unwrap();
    let strides = whole_strides(&support, window).unwrap();
    let flow = EnergyFlow::find(&recording, &support, strides).expect("details");
    // A step of the walk lasts 0.5 s, so the J of a step are half of the W given.
    let watts = |detail: Detail| 2.0 + detail.index() as f64;
    for (pair, of) in [
        (flow.actuators, detail::ACTUATOR_POSITIVE_WORK_J),
        (flow.leg_springs, detail::LEG_SPRING_RELEASE_J),
        (flow.contact, detail::CONTACT_RELEASE_J),
        (flow.c2_loss, detail::C2_DISSIPATION_J),
        (flow.friction_loss, detail::FRICTION_DISSIPATION_J),
    ] {
        close(Some(pair[0]), 0.5 * watts(of[0]));
        close(Some(pair[1]), 0.5 * watts(of[1]));
    }
    let net = 0.5 * watts(detail::ACTUATOR_WORK_J[0]);
    close(Some(flow.actuators_negative[0]), flow.actuators[0] - net);
    assert_eq!(
        flow.steps,
        (strides.duration_s(&recording) / 0.5).round() as usize
    );
    let [at_stop, all] = [
        detail::ACTUATOR_IMPULSE_AT_STOP_N_S,
        detail::ACTUATOR_IMPULSE_N_S,
    ]
    .map(|pair| watts(pair[0]) + watts(pair[1]));
    close(share_at_stop(&recording, window), at_stop / all);
}

// The energy of a window was divided by the touchdowns of whichever foot lands first in it. Of a limp that lands the right foot
// twice and the left once, the energy of a "stride" was twice as much in a window that begins with the left as in one that begins
// with the right.
#[test]
fn the_energy_of_a_limps_step_does_not_depend_on_the_foot_that_lands_first() {
    let step_s = 0.3;
    let plain = common::record(20.0, |time_s| {
        let since_s = time_s.rem_euclid(3.0 * step_s);
        let down = |touchdown_s: f64| (touchdown_s..touchdown_s + 0.2).contains(&since_s);
        common::Frame {
            x_m: time_s,
            contact: [down(0.0) || down(step_s), down(2.0 * step_s)],
            ..common::Frame::default()
        }
    });
    let watts = 7.0;
    let recording = with_power(&plain, watts);
    let support = Support::find(&recording, &ContactRule::default());
    // The first touchdown of each window: of the right foot, of the right again, of the left.
    for (from_s, side) in [(8.9, Side::Right), (9.2, Side::Right), (9.5, Side::Left)] {
        let window = recording.window(from_s, 20.0).unwrap();
        assert_eq!(support.touchdowns(window).next().unwrap().side, side);
        let strides = whole_strides(&support, window).unwrap();
        let flow = EnergyFlow::find(&recording, &support, strides).expect("details");
        for pair in [flow.actuators, flow.leg_springs, flow.friction_loss] {
            for joules in pair {
                let expected = watts * step_s;
                assert!(
                    (joules - expected).abs() < 0.01,
                    "{joules} is not {expected}"
                );
            }
        }
    }
}

// Both feet of a hop land in the row at which the window ends: neither of these steps is in it.
#[test]
fn a_touchdown_of_both_feet_at_the_windows_end_is_no_step_of_it() {
    let hop_s = 0.5;
    let plain = common::record(20.0, |time_s| {
        let down = time_s.rem_euclid(hop_s) < 0.3;
        common::Frame {
            x_m: time_s,
            contact: [down; 2],
            ..common::Frame::default()
        }
    });
    let watts = 7.0;
    let recording = with_power(&plain, watts);
    let support = Support::find(&recording, &ContactRule::default());
    let strides = whole_strides(&support, recording.window(5.0, 20.0).unwrap()).unwrap();
    let flow = EnergyFlow::find(&recording, &support, strides).expect("details");
    let hops = (strides.duration_s(&recording) / hop_s).round() as usize;
    assert_eq!(flow.steps, 2 * hops);
    close(Some(flow.actuators[0]), 0.5 * watts * hop_s);
}

#[test]
fn what_is_given_is_what_is_taken_where_the_account_balances() {
    // 100 W net are given, 60 more are taken back by the actuators themselves, and six losses take the rest.
    let recording = detailed(
        |detail| match detail {
            d if detail::ACTUATOR_POSITIVE_WORK_J.contains(&d) => 160.0,
            d if detail::ACTUATOR_WORK_J.contains(&d) => 100.0,
            d if [
                detail::HIP_DAMPER_DISSIPATION_J,
                detail::C1_DISSIPATION_J,
                detail::C2_DISSIPATION_J,
                detail::STOP_DISSIPATION_J,
                detail::NORMAL_CONTACT_DISSIPATION_J,
            ]
            .concat()
            .contains(&d) =>
            {
                15.0
            }
            d if detail::FRICTION_DISSIPATION_J.contains(&d) => 25.0,
            _ => 3.0,
        },
        [0.0, 0.0],
    );
    let support = Support::find(&recording, &ContactRule::default());
    let strides = whole_strides(&support, recording.window(5.0, 20.0).unwrap()).unwrap();
    let flow = EnergyFlow::find(&recording, &support, strides).expect("details");
    let sum = |parts: &[(&str, [f64; 2])]| parts.iter().map(|(_, pair)| pair[0] + pair[1]).sum();
    close(Some(sum(&flow.given())), 160.0);
    close(Some(sum(&flow.taken())), 160.0);
    // What goes in and out of the springs is no part of it.
    close(Some(sum(&flow.returned())), 4.0 * 3.0);
}

#[test]
fn a_peak_within_a_period_is_seen() {
    // The mean force of the period of touchdown stays what it was: means hide the impact.
    let recording = detailed(|_| 0.0, [5.0 * WEIGHT_N, 6.0 * WEIGHT_N]);
    let support = Support::find(&recording, &ContactRule::default());
    let window = recording.window(5.0, 20.0).unwrap();
    for (side, expected) in [(Side::Right, 5.0), (Side::Left, 6.0)] {
        close(
            peak_force_body_weights(&recording, &support, side, window),
            expected,
        );
        let means = recording.column(column::NORMAL_FORCE_N[side.index()]);
        assert!(means.iter().all(|&force| force <= WEIGHT_N));
    }
    let (both, none) = touching_shares(&recording, window).expect("details");
    close(Some(none), 0.0);
    // Double support for 0.1 s of each step of 0.5 s.
    assert!((both - 0.2).abs() < 0.005, "{both}");
}

#[test]
fn losses_soon_after_touchdown_are_told_apart() {
    let recording = detailed(|_| 0.0, [0.0, 0.0]);
    let support = Support::find(&recording, &ContactRule::default());
    let window = recording.window(5.0, 20.0).unwrap();
    let strides = whole_strides(&support, window).unwrap();
    let within = |seconds| losses_after_touchdown(&recording, &support, strides, seconds);
    for (seconds, share) in [(0.02, 1.0), (0.01, 0.5), (0.0, 0.0)] {
        let found = within(seconds).expect("losses");
        assert!((found - share).abs() < 1e-6, "{found} instead of {share}");
    }
}

#[test]
fn without_details_there_is_none_of_it() {
    let summary = summarise(&Gait::WALK.record(20.0), &AnalysisOptions::default());
    assert_eq!(summary.energy_per_step, None);
    assert_eq!(summary.energy_recovery, None);
    assert_eq!(summary.peak_force_left_body_weights, None);
    assert_eq!(summary.both_feet_touching, None);
    assert_eq!(summary.squared_force_n2_s_per_m, None);
    // What needs no details is there all the same; nothing in this walk works backwards, of which the column tells nothing.
    assert!(summary.absolute_cost_of_transport.is_some());
}
