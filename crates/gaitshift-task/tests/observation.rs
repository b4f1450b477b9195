//! Contract: the observation is the paper's, in its order; mirroring twice gives the original; the
//! mirrored observation is the observation of the mirrored state.

use gaitshift_body::{BodyState, LEFT, RIGHT};
use gaitshift_task::{ACTION_MIRROR, OBSERVATION_MIRROR, OBSERVATION_NAMES, observe};

fn state() -> BodyState {
    let mut s = BodyState {
        x: 5.0,
        z: 0.8,
        theta: 0.1,
        x_dot: 1.1,
        z_dot: -0.2,
        theta_dot: 0.4,
        ..BodyState::default()
    };
    for (i, k) in [(RIGHT, 1.0), (LEFT, 2.0)] {
        let leg = &mut s.legs[i];
        leg.psi = 0.3 * k;
        leg.psi_dot = 0.7 * k;
        leg.thigh = 0.01 * k;
        leg.thigh_dot = 0.05 * k;
        leg.foot_dot = 0.02 * k;
    }
    s
}

#[test]
fn order_is_the_papers() {
    let o = observe(&state(), 2.5);
    let expected = [
        1.1, 0.1, 0.4, 0.01, 0.05, 0.02, 0.1, 0.2, 0.3, 0.5, 1.0, 0.03, 0.06, 2.5,
    ];
    for ((value, expected), name) in o.iter().zip(expected).zip(OBSERVATION_NAMES) {
        assert!(
            (value - expected).abs() < 1e-12,
            "{name}: {value} not {expected}"
        );
    }
}

#[test]
fn mirroring_agrees_with_the_mirrored_state_and_is_an_involution() {
    let (o, m) = (observe(&state(), 1.0), observe(&state().mirrored(), 1.0));
    for i in 0..o.len() {
        assert_eq!(m[i], o[OBSERVATION_MIRROR[i]]);
        assert_eq!(OBSERVATION_MIRROR[OBSERVATION_MIRROR[i]], i);
    }
    assert_eq!(ACTION_MIRROR.map(|i| ACTION_MIRROR[i]), [0, 1]);
}
