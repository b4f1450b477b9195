//! Contract: coordinates and absolute state are the same state; a mirror image of a mirror image is the state itself; a
//! state with anything that is no number says so.

use gaitshift_body::{BodyState, LEFT, RIGHT};
use proptest::prelude::*;

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
