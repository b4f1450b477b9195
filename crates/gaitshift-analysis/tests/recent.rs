//! Contract: the present gait is the analysis' verdict on the latest steps: it follows a change of gait within the steps
//! that the verdict needs, a stop within the longest step, and what comes later does not change it.

use crate::common;
use crate::common::{Frame, record};
use gaitshift_analysis::support::Support;
use gaitshift_analysis::{GaitClass, GaitRule, Recording, recent};

/// Walks for 6 s, runs for 4 s, then stands.
fn motion(time_s: f64) -> Frame {
    let (step_s, speed, share) = match time_s {
        t if t < 6.0 => (0.5, 0.8, 1.2),
        t if t < 10.0 => (0.4, 2.0, 0.6),
        _ => {
            return Frame {
                x_m: 12.8,
                contact: [true; 2],
                ..Frame::default()
            };
        }
    };
    // Each foot is down for `share` of a step out of two steps.
    let phase = (time_s / step_s).rem_euclid(2.0);
    let other = (phase + 1.0).rem_euclid(2.0);
    let x_m = if time_s < 6.0 {
        speed * time_s
    } else {
        4.8 + speed * (time_s - 6.0)
    };
    // A foot that is down stays where it is.
    let psi = |phase: f64| {
        let phase = if phase > 1.9 { phase - 2.0 } else { phase };
        let ahead_m = (0.5 * share - phase) * speed * step_s;
        if phase < share + 0.1 {
            (ahead_m / 0.8).asin()
        } else {
            0.0
        }
    };
    let psi_rad = [phase, other].map(psi);
    Frame {
        x_m,
        psi_rad,
        contact: [phase < share, other < share],
        positive_work_j: 80.0 * x_m,
        ..Frame::default()
    }
}

fn at(recording: &Recording, time_s: f64) -> gaitshift_analysis::Recent {
    let rule = GaitRule::default();
    let support = Support::find(recording, &rule.contact);
    let row = (time_s / common::PERIOD_S).round() as usize;
    recent(recording, &support, &rule, row)
}

#[test]
fn the_verdict_follows_the_motion() {
    let recording = record(16.0, motion);
    let walk = at(&recording, 5.9);
    assert_eq!(walk.gait, GaitClass::Walking);
    assert!((walk.speed_m_per_s.unwrap() - 0.8).abs() < 0.02);
    // 80 J/m over 40 kg in 9.81 m/s².
    assert!((walk.cost_of_transport.unwrap() - 80.0 / (40.0 * 9.81)).abs() < 0.01);
    assert!((walk.froude.unwrap() - 0.8 / (9.81_f64 * 0.8).sqrt()).abs() < 0.01);
    assert_eq!(at(&recording, 6.8).gait, GaitClass::Mixed);
    let run = at(&recording, 8.9);
    assert_eq!(run.gait, GaitClass::Running);
    assert!((run.speed_m_per_s.unwrap() - 2.0).abs() < 0.05);
    // It stood still for two seconds; before, what it had done was still taken for what it does.
    let stop = at(&recording, 12.5);
    assert_eq!(stop.gait, GaitClass::Standing);
    assert_eq!(stop.speed_m_per_s, Some(0.0));
}

#[test]
fn what_comes_later_does_not_change_it() {
    let whole = record(16.0, motion);
    let part = record(7.0, motion);
    assert_eq!(at(&whole, 5.0), at(&part, 5.0));
}

#[test]
fn nothing_and_little_are_no_gait() {
    let recording = record(0.1, motion);
    assert_eq!(at(&recording, 0.0).speed_m_per_s, None);
    assert_eq!(at(&recording, 99.0).gait, GaitClass::Standing);
    assert_eq!(at(&recording, 0.1).cost_of_transport, None);
}
