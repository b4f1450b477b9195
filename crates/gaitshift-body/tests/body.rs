//! Contract: a body that stands touches the ground and presses on nothing.

use gaitshift_body::{Body, BodyParameters, BodyState, LEFT, RIGHT};

// What went wrong: on soles with an even number of spheres, which have none in the middle, the body stood in the air.
#[test]
fn a_body_that_stands_touches_without_pressing() {
    for foot_sphere_count in [1, 2, 3, 4, BodyParameters::default().foot_sphere_count] {
        let body = Body::new(BodyParameters {
            foot_sphere_count,
            ..BodyParameters::default()
        })
        .unwrap();
        for state in [
            BodyState::standing(&body),
            BodyState::with_leg_angles(&body, [0.3, -0.25]),
        ] {
            for leg in [RIGHT, LEFT] {
                assert!(body.foot_contact(&state, leg).normal_n < 1e-6);
            }
            let mut lower = state;
            lower.z -= 1e-4;
            let normal_n = [RIGHT, LEFT].map(|leg| body.foot_contact(&lower, leg).normal_n);
            let sum_n = normal_n.iter().sum::<f64>();
            assert!(sum_n > 0.1, "{foot_sphere_count} spheres: {normal_n:?}");
        }
    }
}
