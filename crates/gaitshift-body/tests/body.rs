//! Contract: a body that stands touches the ground and presses on nothing.

use gaitshift_body::{Body, BodyParameters, BodyState, LEFT, RIGHT};

#[test]
fn a_body_that_stands_touches_without_pressing() {
    let body = Body::new(BodyParameters::default()).unwrap();
    for state in [
        BodyState::standing(&body),
        BodyState::with_leg_angles(&body, [0.3, -0.25]),
    ] {
        for leg in [RIGHT, LEFT] {
            assert!(body.foot_contact(&state, leg).normal_n < 1e-6);
        }
        // Between two spheres of a sole is 0.2 mm of air.
        let mut lower = state;
        lower.z -= 1e-3;
        let normal_n = [RIGHT, LEFT].map(|leg| body.foot_contact(&lower, leg).normal_n);
        assert!(normal_n.iter().sum::<f64>() > 1.0, "{normal_n:?}");
    }
}
