//! Contract: a pendulum's kinetic and gravitational energy correlate with -1 and are recovered whole; a
//! spring-mass runner's correlate with +1 in single support, its elastic energy with -1 to both.

mod common;

use std::f64::consts::PI;

use common::{Frame, Gait, close, record};
use gaitshift_analysis::energy::{
    correlation_in_single_support, correlation_over, energy_recovery,
};
use gaitshift_analysis::recording::{Column, Recording, column};
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
    close(energy_recovery(&recording, window), 1.0);
    close(in_single_support(&recording, KINETIC, POTENTIAL), -1.0);
    // There is no elastic energy in this walk.
    assert_eq!(in_single_support(&recording, ELASTIC, KINETIC), None);
}

#[test]
fn a_runner_stores_energy_in_springs() {
    let recording = Gait::RUN.record(10.0);
    let window = recording.window(1.0, 9.0).expect("rows");
    close(in_single_support(&recording, KINETIC, POTENTIAL), 1.0);
    close(in_single_support(&recording, ELASTIC, KINETIC), -1.0);
    close(in_single_support(&recording, ELASTIC, POTENTIAL), -1.0);
    close(energy_recovery(&recording, window), 0.0);
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
    // Rises of sin, cos and sin + cos per cycle: 2, 2 and 2 √2.
    let recovery =
        energy_recovery(&recording, recording.window(1.0, 9.0).expect("rows")).expect("defined");
    assert!(
        (recovery - (1.0 - 0.5_f64.sqrt())).abs() < 1e-3,
        "{recovery}"
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
    assert_eq!(energy_recovery(&recording, window), None);
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
