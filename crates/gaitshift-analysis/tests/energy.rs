//! Contract: a pendulum's kinetic and gravitational energy correlate with -1 and are recovered whole; a
//! spring-mass runner's correlate with +1 in single support, its elastic energy with -1 to both. Recovery is that of the centre
//! of mass: what segments do about it does not count.

use std::f64::consts::PI;

use crate::common::{Frame, GRAVITY, Gait, MASS_KG, PERIOD_S, close, metadata, record};
use gaitshift_analysis::energy::{
    correlation_in_single_support, correlation_over, energy_recovery,
};
use gaitshift_analysis::recording::{COLUMNS, Column, DETAILS, Recording, Side, column, detail};
use gaitshift_analysis::support::{ContactRule, Support};

const KINETIC: Column = column::KINETIC_ENERGY_J;
const POTENTIAL: Column = column::GRAVITATIONAL_ENERGY_J;
const ELASTIC: Column = column::ELASTIC_ENERGY_J;

fn in_single_support(recording: &Recording, first: Column, second: Column) -> Option<f64> {
    let support = Support::find(recording, &ContactRule::default());
    let window = recording.window(1.0, 9.0).expect("rows");
    correlation_in_single_support(recording, &support, window, first, second)
}

#[test]
fn a_pendulum_exchanges_all_its_energy() {
    let recording = Gait::WALK.record(10.0);
    let window = recording.window(1.0, 9.0).expect("rows");
    close(
        correlation_over(&recording, window, KINETIC, POTENTIAL),
        -1.0,
    );
    close(in_single_support(&recording, KINETIC, POTENTIAL), -1.0);
    // There is no elastic energy in this walk.
    assert_eq!(in_single_support(&recording, ELASTIC, KINETIC), None);
}

#[test]
fn a_runner_stores_energy_in_springs() {
    let recording = Gait::RUN.record(10.0);
    close(in_single_support(&recording, KINETIC, POTENTIAL), 1.0);
    close(in_single_support(&recording, ELASTIC, KINETIC), -1.0);
    close(in_single_support(&recording, ELASTIC, POTENTIAL), -1.0);
}

#[test]
fn single_support_leaves_the_rest_out() {
    // In phase on one foot, in antiphase in flight, and by more.
    let recording = record(10.0, |time_s| {
        let mut frame = Gait::RUN.frame(time_s);
        let since_s = time_s.rem_euclid(0.35);
        if since_s > 0.25 {
            let exchange_j = 500.0 * (PI * (since_s - 0.25) / 0.1).sin();
            frame.kinetic_j += exchange_j;
            frame.gravitational_j -= exchange_j;
        }
        frame
    });
    close(in_single_support(&recording, KINETIC, POTENTIAL), 1.0);
    let window = recording.window(1.0, 9.0).expect("rows");
    let overall = correlation_over(&recording, window, KINETIC, POTENTIAL).expect("defined");
    assert!(overall < -0.9, "{overall}");
}

#[test]
fn the_rows_around_a_touchdown_within_a_period_are_not_single_support() {
    // The row before a landing and the row after a take-off counted as single support, although the foot was in the air in both:
    // a tenth of the rows of a run's single support were of its flight.
    let recording = record(10.0, |time_s| {
        let time_s = time_s + 0.3 * PERIOD_S;
        let mut frame = Gait::RUN.frame(time_s);
        if time_s.rem_euclid(0.35) > 0.25 {
            frame.kinetic_j += 500.0;
            frame.gravitational_j -= 500.0;
        }
        frame
    });
    close(in_single_support(&recording, KINETIC, POTENTIAL), 1.0);
}

#[test]
fn a_foot_that_touches_all_of_a_period_counts_at_both_its_ends() {
    // Energies that are in phase but at the very touchdown and lift-off.
    let recording = |share: f64| {
        let mut recording = record(10.0, |time_s| {
            let mut frame = Gait::RUN.frame(time_s);
            let since_s = (time_s + 1e-6).rem_euclid(0.35);
            if since_s < 2e-6 || (0.25..0.25 + 2e-6).contains(&since_s) {
                frame.kinetic_j -= 500.0;
            }
            frame
        });
        for side in Side::BOTH {
            let share = vec![share; recording.len()];
            recording
                .set_detail(detail::CONTACT_SHARE[side.index()], share)
                .expect("a share for each row");
        }
        recording
    };
    close(in_single_support(&recording(0.5), KINETIC, POTENTIAL), 1.0);
    let whole = in_single_support(&recording(1.0), KINETIC, POTENTIAL).expect("defined");
    assert!(whole < 0.9, "{whole}");
}

#[test]
fn a_quarter_of_a_cycle_apart_is_uncorrelated() {
    let recording = record(10.0, |time_s| Frame {
        kinetic_j: (2.0 * PI * time_s).sin(),
        gravitational_j: (2.0 * PI * time_s).cos(),
        ..Frame::default()
    });
    // 200 rows a cycle; the last row of the window repeats the first.
    let window = recording.window(1.0, 8.995).expect("rows");
    close(
        correlation_over(&recording, window, KINETIC, POTENTIAL),
        0.0,
    );
}

#[test]
fn a_body_at_rest_has_no_energy_relations() {
    let recording = record(10.0, |_| Frame {
        kinetic_j: 1.0,
        contact: [true, false],
        ..Frame::default()
    });
    let window = recording.whole().expect("rows");
    assert_eq!(
        correlation_over(&recording, window, KINETIC, POTENTIAL),
        None
    );
    assert_eq!(in_single_support(&recording, KINETIC, POTENTIAL), None);
}

#[test]
fn swaying_on_one_foot_is_not_single_support_of_a_step() {
    let recording = record(10.0, |time_s| Frame {
        kinetic_j: time_s.sin(),
        gravitational_j: -time_s.sin(),
        contact: [true, false],
        ..Frame::default()
    });
    assert_eq!(in_single_support(&recording, KINETIC, POTENTIAL), None);
}

/// A centre of mass whose forward kinetic energy and height energy are given, in J, as functions of time; the segments'
/// kinetic energy swings by 500 J beside it.
fn moving(forward_j: impl Fn(f64) -> f64, height_j: impl Fn(f64) -> f64) -> Recording {
    let mut recording = Recording::new(metadata());
    for k in 0..=2000 {
        let time_s = 0.005 * f64::from(k);
        let mut row = vec![0.0; COLUMNS.len() + DETAILS.len()];
        row[column::TIME_S.index()] = time_s;
        row[column::KINETIC_ENERGY_J.index()] = 500.0 * (7.0 * time_s).sin();
        let mut set = |detail: gaitshift_analysis::recording::Detail, value| {
            row[COLUMNS.len() + detail.index()] = value;
        };
        set(
            detail::COM_X_VELOCITY_M_PER_S,
            (2.0 * forward_j(time_s) / MASS_KG).sqrt(),
        );
        set(detail::COM_Z_M, height_j(time_s) / (MASS_KG * GRAVITY));
        recording.push_row(&row).expect("valid");
    }
    recording
}

#[test]
fn recovery_is_the_centre_of_mass_s() {
    let turn = |time_s: f64| 2.0 * PI * time_s;
    let recovered = |recording: &Recording| {
        energy_recovery(recording, recording.window(1.0, 9.0).expect("rows")).expect("defined")
    };
    let pendulum = moving(
        |t| 40.0 + 5.0 * turn(t).cos(),
        |t| 300.0 - 5.0 * turn(t).cos(),
    );
    assert!((recovered(&pendulum) - 1.0).abs() < 1e-9);
    let bouncing = moving(
        |t| 40.0 + 5.0 * turn(t).cos(),
        |t| 300.0 + 9.0 * turn(t).cos(),
    );
    assert!(recovered(&bouncing).abs() < 1e-9);
    // A quarter of a cycle apart: rises of sin, cos and sin + cos per cycle are 2, 2 and 2 √2.
    let quarter = moving(
        |t| 40.0 + 5.0 * turn(t).sin(),
        |t| 300.0 + 5.0 * turn(t).cos(),
    );
    assert!((recovered(&quarter) - (1.0 - 0.5_f64.sqrt())).abs() < 1e-3);
    // In antiphase, but of different size: of rises 5 and 3 the rise 2 is left.
    let uneven = moving(
        |t| 40.0 + 5.0 * turn(t).cos(),
        |t| 300.0 - 3.0 * turn(t).cos(),
    );
    assert!((recovered(&uneven) - 0.75).abs() < 1e-9);
    let still = moving(|_| 40.0, |_| 300.0);
    let window = still.whole().expect("rows");
    assert_eq!(energy_recovery(&still, window), None);
    // Without the centre of mass there is no recovery of it.
    let plain = Gait::WALK.record(10.0);
    assert_eq!(energy_recovery(&plain, plain.whole().expect("rows")), None);
}
