//! Contract: a sphere on the ground is pressed on by k δⁿ (1 + c δ̇), never pulled, and held by smoothed Coulomb friction; a
//! foot that just touches feels nothing; power, stored energy and losses of a foot balance, and no loss is ever negative.

use gaitshift_body::{
    Body, BodyParameters, BodyState, FootContact, LEFT, RIGHT, Terrain, sphere_center,
};
use proptest::prelude::*;

/// Feet of one sphere each, so that a formula can be checked by itself.
fn one_sphere(exponent: f64) -> BodyParameters {
    BodyParameters {
        foot_sphere_count: 1,
        contact_exponent: exponent,
        ..BodyParameters::default()
    }
}

/// The contact of the right foot, `depth` in the ground and moving.
fn pressed(p: &BodyParameters, depth: f64, x_dot: f64, z_dot: f64) -> FootContact {
    let body = Body::new(p.clone()).unwrap();
    let mut state = BodyState::standing(&body);
    state.z -= depth;
    (state.x_dot, state.z_dot) = (x_dot, z_dot);
    body.foot_contact(&state, RIGHT)
}

fn assert_near(value: f64, expected: f64) {
    let scale = expected.abs().max(1e-9);
    assert!(
        (value - expected).abs() <= 1e-9 * scale,
        "{value} instead of {expected}"
    );
}

#[test]
fn the_normal_force_is_hunts_and_crossleys() {
    for exponent in [1.0, 1.5] {
        let p = one_sphere(exponent);
        let (depth, sinking) = (0.004, 0.3);
        let contact = pressed(&p, depth, 0.0, -sinking);
        let elastic = p.contact_stiffness * f64::powf(depth, exponent);
        let damping = elastic * p.contact_dissipation_s_per_m * sinking;
        assert_near(contact.normal_n, elastic + damping);
        assert_near(contact.elastic_j, elastic * depth / (exponent + 1.0));
        assert_near(contact.normal_loss_w, damping * sinking);
        assert_near(contact.tangential_n, 0.0);
    }
}

#[test]
fn the_ground_never_pulls() {
    let p = one_sphere(1.0);
    // Beyond a speed of 1/c the formula alone would be negative.
    let contact = pressed(&p, 0.004, 0.5, 2.0 / p.contact_dissipation_s_per_m);
    assert_eq!((contact.normal_n, contact.tangential_n.abs()), (0.0, 0.0));
    assert!(contact.normal_loss_w > 0.0, "what was stored is lost");
    assert_eq!(pressed(&p, -1e-9, 0.5, -0.5), FootContact::default());
}

#[test]
fn friction_is_coulombs_smoothed() {
    let p = BodyParameters {
        friction: 0.6,
        ..one_sphere(1.0)
    };
    for slip in [-2.0, -0.05, 0.01, 0.05, 5.0] {
        let contact = pressed(&p, 0.004, slip, 0.0);
        let share = slip / f64::hypot(slip, p.friction_smoothing_m_per_s);
        assert_near(contact.tangential_n, -0.6 * contact.normal_n * share);
        assert_near(contact.friction_loss_w, -contact.tangential_n * slip);
    }
}

#[test]
fn a_sphere_stands_where_its_centre_is_told() {
    let p = BodyParameters::default();
    let body = Body::new(p.clone()).unwrap();
    let mut state = BodyState::with_leg_angles(&body, [0.3, -0.1]);
    // Of all spheres of both feet the lowest one touches the ground.
    let lowest = |state: &BodyState| {
        let centres = (0..p.foot_sphere_count).flat_map(|sphere| {
            state
                .legs
                .map(|leg| sphere_center(&p, leg.psi, leg.foot, sphere).1)
        });
        state.z + centres.fold(f64::INFINITY, f64::min) - p.foot_sphere_radius_m
    };
    assert!(lowest(&state).abs() < 1e-12, "{}", lowest(&state));
    let heights = [RIGHT, LEFT].map(|leg| body.sole_height(&state, leg));
    assert!((heights[0].min(heights[1]) - lowest(&state)).abs() < 1e-12);
    assert!(heights[0].max(heights[1]) > 1e-3, "one foot is lifted");
    // A hill of 5 cm below the feet is that much nearer.
    let hill = Terrain::through(&[(0.0, 0.05)], 0.0, 0.0).unwrap();
    let near = Body::new(p.clone()).unwrap().on(hill);
    assert!((near.sole_height(&state, LEFT) - (heights[1] - 0.05)).abs() < 1e-12);
    state.legs[LEFT].foot = 0.02;
    assert!(lowest(&state) < -0.01);
    assert!(body.foot_contact(&state, LEFT).normal_n > 0.0);
}

proptest! {
    #[test]
    fn power_stored_energy_and_losses_balance(
        psi in -0.6..0.6f64, depth in 0.0..0.01f64, psi_dot in -3.0..3.0f64,
        x_dot in -2.0..2.0f64, z_dot in -0.3..0.3f64, exponent in prop::sample::select(vec![1.0, 1.5]),
    ) {
        let parameters = BodyParameters { contact_exponent: exponent, ..BodyParameters::default() };
        let body = Body::new(parameters).unwrap();
        let mut state = BodyState::with_leg_angles(&body, [psi, psi]);
        state.z -= depth;
        (state.x_dot, state.z_dot) = (x_dot, z_dot);
        state.legs[RIGHT].psi_dot = psi_dot;
        let contact = body.foot_contact(&state, RIGHT);
        prop_assert!(contact.normal_n >= 0.0 && contact.elastic_j >= 0.0);
        prop_assert!(contact.normal_loss_w >= 0.0 && contact.friction_loss_w >= 0.0);
        // What the foot gives to the ground is stored there or lost.
        let stored_at = |dt: f64| {
            let mut moved = state;
            moved.x += dt * x_dot;
            moved.z += dt * z_dot;
            moved.legs[RIGHT].psi += dt * psi_dot;
            body.foot_contact(&moved, RIGHT).elastic_j
        };
        let dt = 1e-7;
        let stored_w = (stored_at(dt) - stored_at(-dt)) / (2.0 * dt);
        let given_w = -(contact.tangential_n * x_dot + contact.normal_n * z_dot + contact.moment_nm * psi_dot);
        let taken_w = stored_w + contact.normal_loss_w + contact.friction_loss_w;
        let scale = 1.0 + given_w.abs() + contact.friction_loss_w;
        prop_assert!((given_w - taken_w).abs() < 1e-3 * scale, "{} given, {} taken", given_w, taken_w);
    }
}
