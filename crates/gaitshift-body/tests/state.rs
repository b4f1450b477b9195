//! Contract: coordinates and absolute state are the same state; a mirror image of a mirror image is the state itself; a
//! body that stands touches the ground and presses on nothing; a state with anything that is no number says so.

use gaitshift_body::{Body, BodyParameters, BodyState, LEFT, RIGHT};
use proptest::prelude::*;

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

#[test]
fn whatever_is_no_number_is_seen() {
    let sound = BodyState::default();
    assert!(sound.is_sound(1.0));
    for index in 0..22 {
        for wrong in [f64::NAN, f64::INFINITY] {
            let (mut positions, mut velocities) = ([0.0; 11], [0.0; 11]);
            if index < 11 {
                positions[index] = wrong;
            } else {
                velocities[index - 11] = wrong;
            }
            let state = BodyState::from_coordinates(&positions, &velocities);
            assert!(!state.is_sound(1e300), "{index}");
        }
    }
    let fast = BodyState {
        x_dot: 1.1,
        ..sound
    };
    assert!(!fast.is_sound(1.0) && fast.is_sound(1.1));
}

proptest! {
    #[test]
    fn coordinates_and_state_are_the_same(
        positions in prop::array::uniform11(-2.0..2.0f64), velocities in prop::array::uniform11(-9.0..9.0f64),
    ) {
        let state = BodyState::from_coordinates(&positions, &velocities);
        let pairs = state.positions().into_iter().zip(positions)
            .chain(state.velocities().into_iter().zip(velocities));
        for (again, value) in pairs {
            prop_assert!((again - value).abs() < 1e-14 * 10.0);
        }
        prop_assert_eq!(state.mirrored().mirrored(), state);
        prop_assert_eq!(state.mirrored().phi(RIGHT), state.phi(LEFT));
        prop_assert_eq!(state.mirrored().legs[LEFT].d(), state.legs[RIGHT].d());
    }
}
