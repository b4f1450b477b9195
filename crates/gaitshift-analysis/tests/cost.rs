//! Contract: cost of transport is (8) of the paper, the Froude number is the paper's `v / √(g l)`, and both
//! are undefined where they mean nothing.

use crate::common::{Frame, GRAVITY, Gait, LEG_M, close, metadata, record};
use gaitshift_analysis::cost::{
    absolute_cost_of_transport, classic_froude_number, cost_of_transport, froude_number,
    speed_m_per_s, squared_force_n2_s_per_m,
};
use gaitshift_analysis::recording::{COLUMNS, DETAILS, Recording, column, detail};

#[test]
fn cost_is_positive_work_over_weight_and_way() {
    let recording = Gait::WALK.record(10.0);
    close(
        cost_of_transport(&recording, recording.window(3.0, 9.0).expect("rows")),
        0.2,
    );
    // 40 kg over 2 m with 100 J from 5 s on: 100 / (40 * 9.81 * 2).
    let worked = record(10.0, |time_s| Frame {
        x_m: 0.2 * time_s,
        positive_work_j: if time_s > 5.0 { 100.0 } else { 0.0 },
        ..Frame::default()
    });
    close(
        cost_of_transport(&worked, worked.whole().expect("rows")),
        100.0 / (40.0 * 9.81 * 2.0),
    );
    close(
        cost_of_transport(&worked, worked.window(5.5, 10.0).expect("rows")),
        0.0,
    );
}

#[test]
fn going_nowhere_or_backwards_has_no_cost_of_transport() {
    for speed in [0.0, 0.007, -1.0] {
        let recording = record(10.0, |time_s| Frame {
            x_m: speed * time_s,
            positive_work_j: time_s,
            ..Frame::default()
        });
        assert_eq!(
            cost_of_transport(&recording, recording.whole().expect("rows")),
            None,
            "{speed}"
        );
    }
}

#[test]
fn froude_numbers() {
    let recording = Gait::RUN.record(2.0);
    let speed = speed_m_per_s(&recording, recording.whole().expect("rows"));
    close(speed, 2.0);
    close(
        froude_number(&recording, 2.0),
        2.0 / (GRAVITY * LEG_M).sqrt(),
    );
    close(
        classic_froude_number(&recording, 2.0),
        4.0 / (GRAVITY * LEG_M),
    );
    close(
        froude_number(&recording, -2.0),
        -2.0 / (GRAVITY * LEG_M).sqrt(),
    );
    let mut weightless = Recording::new(metadata());
    weightless.metadata.gravity_m_per_s2 = 0.0;
    assert_eq!(froude_number(&weightless, 1.0), None);
}

#[test]
fn costs_beside_8_count_what_is_braked_and_what_is_held() {
    // In 10 s over 2 m: 100 J of positive work and 60 J net, so 40 J negative; 300 N and 200 N held all the time.
    let mut recording = Recording::new(metadata());
    for time_s in [0.0, 5.0, 10.0] {
        let mut row = vec![0.0; COLUMNS.len() + DETAILS.len()];
        row[column::TIME_S.index()] = time_s;
        row[column::X_M.index()] = 0.2 * time_s;
        row[column::ACTUATOR_POSITIVE_WORK_J.index()] = 10.0 * time_s;
        row[column::ACTUATOR_WORK_J.index()] = 6.0 * time_s;
        for (pair, force_n) in detail::ACTUATOR_SQUARED_FORCE_N2_S
            .iter()
            .zip([300.0, 200.0])
        {
            row[COLUMNS.len() + pair.index()] = force_n * force_n * time_s;
        }
        recording.push_row(&row).expect("valid");
    }
    let window = recording.whole().expect("rows");
    let weight_way = 40.0 * 9.81 * 2.0;
    close(cost_of_transport(&recording, window), 100.0 / weight_way);
    close(
        absolute_cost_of_transport(&recording, window),
        140.0 / weight_way,
    );
    close(
        squared_force_n2_s_per_m(&recording, window),
        (300.0 * 300.0 + 200.0 * 200.0) * 10.0 / 2.0,
    );
    let plain = Gait::WALK.record(10.0);
    assert_eq!(
        squared_force_n2_s_per_m(&plain, plain.whole().expect("rows")),
        None
    );
}
