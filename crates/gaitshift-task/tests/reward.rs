//! Contract: every term of (2)-(7) has the value that the paper's formula gives by hand, carries its
//! weight, and the common factor divides by `1 + k max(ω_v, 0)`.

use gaitshift_body::{BodyState, LEFT, RIGHT};
use gaitshift_task::{LegTerm, RewardParameters, StepEnergies};

fn moving(x_dot: f64, right: f64, left: f64) -> BodyState {
    let mut s = BodyState {
        x_dot,
        theta_dot: 0.3,
        ..BodyState::default()
    };
    s.legs[RIGHT].psi_dot = right;
    s.legs[LEFT].psi_dot = left;
    s
}

fn energies(change_j: f64, friction_loss_j: f64) -> StepEnergies {
    StepEnergies {
        change_j,
        friction_loss_j,
        positive_work_j: 0.7,
    }
}

#[test]
fn terms_follow_the_paper() {
    let r = RewardParameters::default();
    let t = r.terms(&moving(1.5, 0.2, -0.1), &energies(-4.0, 0.0), 2.0);
    assert_eq!(t.energy, -0.2 * 4.0);
    assert_eq!(t.velocity, 2.0 * 1.5);
    assert_eq!(t.forward, 0.0);
    assert_eq!(t.alive, 1.0);
    assert!((t.leg - 0.2 * 0.3).abs() < 1e-15);
    assert!((t.sum() - (-0.8 + 3.0 + 1.0 + 0.06)).abs() < 1e-12);
}

#[test]
fn backward_motion_costs_c1_and_the_leg_term_is_capped() {
    let r = RewardParameters::default();
    let t = r.terms(&moving(-0.01, 3.0, -2.0), &energies(0.0, 0.0), 0.0);
    assert_eq!(t.forward, -1.0);
    assert_eq!(t.leg, 0.2 * 0.5);
}

#[test]
fn the_energy_term_of_a_step_can_be_bounded() {
    let r = RewardParameters {
        energy_cap: 0.9,
        ..RewardParameters::default()
    };
    let energy = |change_j, omega_v| {
        r.terms(&moving(0.0, 0.0, 0.0), &energies(change_j, 0.0), omega_v)
            .energy
    };
    assert!((energy(-4.0, 0.0) + 0.8).abs() < 1e-15);
    assert_eq!(energy(5.0, 0.0), -0.9);
    assert_eq!(energy(25.0, 1.0), -0.9 * 5.0);
}

#[test]
fn friction_and_work_have_prices() {
    let paper = RewardParameters::default();
    let t = paper.terms(&moving(4.0, 0.0, 0.0), &energies(0.0, 0.5), 3.0);
    assert_eq!((t.friction, t.velocity), (0.0, 12.0));
    let r = RewardParameters {
        omega_f: 2.0,
        ..paper
    };
    let t = r.terms(&moving(4.0, 0.0, 0.0), &energies(0.0, 0.5), 3.0);
    assert_eq!((t.friction, t.velocity), (-1.0, 12.0));
    let cheaper = RewardParameters {
        friction_command_divisor: 3.0,
        ..r.clone()
    };
    let t = cheaper.terms(&moving(4.0, 0.0, 0.0), &energies(0.0, 0.5), 1.0);
    assert_eq!(t.friction, -0.25);
    let worked = RewardParameters {
        omega_w: 0.2,
        ..r.clone()
    };
    let work = |omega_v| worked.terms(&moving(1.0, 0.0, 0.0), &energies(0.0, 0.0), omega_v);
    assert!((work(3.0).work + 0.2 * 3.0 * 0.7).abs() < 1e-15);
    assert_eq!(work(-0.5).work, 0.0);
    let capped = RewardParameters {
        energy_cap: 0.9,
        ..r.clone()
    };
    let t = capped.terms(&moving(0.0, 0.0, 0.0), &energies(-4.0, 0.5), 0.0);
    assert!((t.energy + 0.8).abs() < 1e-15 && t.friction == -0.9);
    let t = r.terms(&moving(2.0, 0.0, 0.0), &energies(0.0, 0.5), -0.5);
    assert_eq!(t.velocity, -1.0);
}

#[test]
fn symmetry_is_the_squared_difference_of_the_actions() {
    let r = RewardParameters::default();
    let s = r.symmetry_term(&[0.5, -0.25], &[0.0, 0.25]);
    assert!((s + 0.15 * (0.25 + 0.25)).abs() < 1e-7);
}

#[test]
fn the_factor_leaves_negative_commands_alone() {
    let r = RewardParameters {
        command_divisor: 2.0,
        ..RewardParameters::default()
    };
    assert_eq!(r.factor(-0.5), 1.0);
    assert_eq!(r.factor(2.0), 0.2);
}

#[test]
fn the_leg_term_can_be_read_with_and_without_the_dots() {
    let mut state = BodyState::default();
    (state.legs[0].psi, state.legs[1].psi) = (0.3, -0.1);
    (state.legs[0].psi_dot, state.legs[1].psi_dot) = (-0.05, 0.05);
    let leg = |leg_term| {
        let r = RewardParameters {
            leg_term,
            ..RewardParameters::default()
        };
        r.terms(&state, &StepEnergies::default(), 0.0).leg
    };
    assert!((leg(LegTerm::Rates) - 0.2 * 0.1).abs() < 1e-12);
    assert!((leg(LegTerm::Angles) - 0.2 * 0.4).abs() < 1e-12);
    state.legs[0].psi = 1.0;
    let capped = RewardParameters {
        leg_term: LegTerm::Angles,
        ..RewardParameters::default()
    };
    let terms = capped.terms(&state, &StepEnergies::default(), 0.0);
    assert_eq!(terms.leg, 0.2 * 0.5);
}
