//! Studies of which every number is known.

use gaitshift_analysis::{GaitClass, GaitSummary};
use gaitshift_report::{Change, Steady, StepHeight, Study};

pub fn motion(omega_v: f64, gait: GaitClass, froude: f64, cost: f64) -> Steady {
    Steady {
        omega_v,
        energy_change_j: None,
        summary: GaitSummary {
            gait,
            froude: Some(froude),
            speed_m_per_s: Some(froude * (9.81_f64 * 0.8).sqrt()),
            cost_of_transport: Some(cost),
            kinetic_potential_correlation: Some(-0.4),
            kinetic_potential_correlation_single_support: Some(0.7),
            elastic_kinetic_correlation_single_support: Some(0.2),
            ..GaitSummary::default()
        },
    }
}

fn change(leads: bool, steps: usize) -> Change {
    Change {
        survived: true,
        before: Some(GaitClass::Walking),
        after: Some(if leads {
            GaitClass::Running
        } else {
            GaitClass::Mixed
        }),
        steps: leads.then_some(steps),
    }
}

/// A seed whose walk at 0 and run at 3 have these Froude numbers.
pub fn study(walk: f64, run: f64) -> Study {
    Study {
        name: "a".to_owned(),
        group: "g".to_owned(),
        seed: 1,
        gaits: [0.0, 3.0],
        time_step_s: 2e-4,
        steady: vec![
            motion(0.0, GaitClass::Walking, walk, 0.3),
            motion(3.0, GaitClass::Running, run, 1.0),
        ],
        to_running: vec![
            change(true, 1),
            change(true, 3),
            change(false, 0),
            change(true, 1),
        ],
        // On the slower ramp they take longer.
        journal_changes: [vec![change(true, 2), change(true, 3)], Vec::new()],
        // A row of steps by turns is no single step.
        step_heights: [
            (0.01, 10, false),
            (0.02, 10, false),
            (0.03, 9, false),
            (0.04, 10, false),
            (0.01, 0, true),
        ]
        .map(|(height_m, successes, by_turns)| StepHeight {
            omega_v: 0.0,
            height_m,
            by_turns,
            successes,
            trials: 10,
        })
        .to_vec(),
        ..Study::default()
    }
}
